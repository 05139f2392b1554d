//! The calibration: checks readings, fits, and refuses what no machine is.

use super::calibration_error::CalibrationError;
use super::fit::{CalibrationOptions, Fit};
use super::reading::{ReadingKind, SphereReading};
use super::report::CalibrationReport;
use super::senses::other_senses;
use crate::machine::Machine;

/// Finds the deviations of a machine from readings of spheres.
///
/// Unknown centres of the spheres are found along. Combinations of deviations that the readings do not fix stay as
/// they are in `machine`.
///
/// # Errors
///
/// All of [`CalibrationError`].
pub fn calibrate(
    machine: &Machine,
    readings: &[SphereReading],
    options: CalibrationOptions,
) -> Result<CalibrationReport, CalibrationError> {
    check(readings)?;
    let fitted = Fit::run(machine, readings, options)?;
    let fault = fitted.implausible(options);
    if let Some(better) = other_senses(machine, readings, options, fitted.rms()) {
        return Err(better);
    }
    fault.map_or_else(|| Ok(fitted.report(options)), Err)
}

fn check(readings: &[SphereReading]) -> Result<(), CalibrationError> {
    for (index, reading) in readings.iter().enumerate() {
        let wrong = |what, value| Err(CalibrationError::Number { reading: index, what, value });
        let [dx, dy, dz] = match reading.kind {
            ReadingKind::Center { deviation } => deviation.into(),
            ReadingKind::Radius { radius } if radius > 0.0 => [radius, 0.0, 0.0],
            ReadingKind::Radius { radius } => return wrong("radius", radius),
        };
        let numbers = reading.q.iter().copied().chain([reading.tool_length, dx, dy, dz]);
        if let Some(value) = numbers.into_iter().find(|value| !value.is_finite()) {
            return wrong("a number", value);
        }
    }
    Ok(())
}
