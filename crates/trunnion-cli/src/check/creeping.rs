//! Cuts that creep, where no job states their feed.

use trunnion::verify::{Audit, Finding, FindingKind};

/// Mean speed of all cuts below which F hardly is as intended \[mm/s\]: 10 mm/min.
const CREEPING: f64 = 10.0 / 60.0;

/// Share of its velocity up to which no axis explains the speed.
const HARDLY_LOADED: f64 = 0.1;

/// Returns a warning of cuts that creep, unless a finding speaks of them.
pub(super) fn creeping(audit: &Audit, findings: &[Finding]) -> Option<String> {
    let known = findings.iter().any(|finding| finding.kind() == FindingKind::SlowCuts);
    let seconds = audit.duration - audit.rapid;
    let mean = audit.motion.cut_length / seconds;
    let loaded = audit.axes.iter().any(|axis| axis.velocity.worst > HARDLY_LOADED);
    if known || loaded || audit.motion.cut_length <= 0.0 || mean.is_nan() || mean >= CREEPING {
        return None;
    }
    Some(format!(
        "the cuts take {seconds:.0} s for {:.1} mm, {:.3} mm/min on average; is F as intended?",
        audit.motion.cut_length,
        60.0 * mean
    ))
}
