//! Measures the faces that motion cuts, and audits the axes of a program.

use super::deviation::measure::{self, MeasureSubject, MeasuredHeights};
use super::error::VerifyError;
use super::findings::{broken_limits, broken_tolerances};
use super::input::CheckInput;
use super::options::{CHORD_SHARE, CheckOptions};
use crate::types::Progress;
use crate::verify::axes::audit::{self, ReplayAudit};
use crate::verify::replay::orient::Choices;
use crate::verify::report::{Deviation, FaceMap, Finding, Report};

/// Checks motion against the faces it cuts and, for a program, against the limits of the machine.
///
/// Heights are relative to the faces as given; smoothing by the control and the speed of rapids beyond their limit are not
/// modelled. Rapids are checked for gouges with all axes together and with each axis at its own speed: a control does
/// one or the other. A point that only a rapid finishes is [`Finding::Rapid`]. Where the program states a direction of the tool and
/// not the rotaries, they turn as [`Choice`](crate::verify::replay::orient::Choice) states. After a tool change nothing is measured until the
/// program has stated Z, and X and Y if the tool is inclined, see [`Changes`](crate::verify::Changes). A broken limit is a finding, not an error.
///
/// # Errors
///
/// [`VerifyError`].
///
/// # Source
///
/// `docs/sources.md`, verification.
pub fn check(
    input: &CheckInput<'_>,
    options: &CheckOptions,
    progress: &dyn Progress,
) -> Result<Report, VerifyError> {
    options.validated()?;
    let controls = input.controls()?;
    // Arcs run as chords that leave most of the ray tolerance to the measurement.
    let run = input.run(controls.as_ref(), CHORD_SHARE * options.ray_tolerance)?;
    let audited = match (&controls, input.source()) {
        (Some(controls), Some(program)) => Some(audit::audit(controls, &run, program)?),
        _ => None,
    };
    let cutters = input.cutters();
    let subject = MeasureSubject { faces: input.faces, cutters: &cutters, rest: input.rest };
    // Without faces the motion need not be cut into chunks for their rays.
    let heights = if input.faces.is_empty() {
        let deviation = Deviation::of(&std::iter::empty::<&FaceMap>());
        MeasuredHeights { maps: Vec::new(), deviation, between: Vec::new() }
    } else {
        measure::measure(&run, &subject, options, progress)?
    };
    let mut findings = broken_tolerances(&heights, options);
    let MeasuredHeights { maps, mut deviation, .. } = heights;
    let Some(ReplayAudit { audit, choices, changes }) = audited else {
        let choices = Choices::default();
        return Ok(Report { maps, deviation, audit: None, choices, changes: None, findings });
    };
    deviation.sensitivity.pivot = Some(measure::pivot(&audit));
    findings.extend(broken_limits(&audit).into_iter().filter(|finding| {
        // Between vectors the control plans its own speeds, on the axes it chose.
        choices.vectors == 0 || matches!(finding, Finding::Travel { .. })
    }));
    let changes = Some(changes).filter(|changes| changes.count > 0 || changes.unmeasured > 0);
    Ok(Report { maps, deviation, audit: Some(audit), choices, changes, findings })
}
