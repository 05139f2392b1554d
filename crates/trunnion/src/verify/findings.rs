//! Findings: broken tolerances and limits.

use super::options::CheckOptions;
use crate::verify::report::{Audit, Deviation, FaceMap, Finding};

/// Findings of broken tolerances. A gouge is judged with the ray tolerance against it.
pub(super) fn broken_tolerances(
    maps: &[FaceMap],
    deviation: &Deviation,
    options: &CheckOptions,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if let Some(low) = deviation.lowest
        && low.height - options.ray_tolerance < -options.gouge
    {
        findings.push(Finding::Gouge(low));
    }
    if let Some(high) = deviation.highest
        && high.height > options.total
    {
        findings.push(Finding::Excess(high));
    }
    if let Some(higher) = deviation.higher {
        findings.push(Finding::Length { higher });
    }
    // One example suffices; numbers and area are those of all.
    let mut uncut = maps.iter().flat_map(|map| &map.samples).flatten();
    if let Some(sample) = uncut.find(|sample| sample.height.is_none() && !sample.rest) {
        let (points, area) = (deviation.uncut, deviation.uncut_area);
        findings.push(Finding::Uncut { points, area, point: sample.point });
    }
    findings.extend(deviation.rapid.map(|line| Finding::Rapid { line }));
    if deviation.unmeasured > 0 {
        findings.push(Finding::Unmeasured { points: deviation.unmeasured });
    }
    findings
}

/// Findings of broken axis limits.
pub(super) fn broken_limits(audit: &Audit) -> Vec<Finding> {
    let mut findings = Vec::new();
    for axis in &audit.axes {
        let name = || axis.name.clone();
        if let Some(worst) = axis.travel {
            findings.push(Finding::Travel { axis: name(), worst });
        }
        if axis.velocity.broken > 0 {
            findings.push(Finding::Velocity { axis: name(), worst: axis.velocity });
        }
        if axis.acceleration.broken > 0 {
            findings.push(Finding::Acceleration { axis: name(), worst: axis.acceleration });
        }
    }
    findings
}
