//! Senses of rotation that fit the readings better.

use super::calibration_error::CalibrationError;
use super::fit::{CalibrationOptions, Fit};
use super::reading::SphereReading;
use crate::machine::{FIRST_ROTARY, Machine, SECOND_ROTARY};

/// Residual \[mm\] from which the senses are in doubt: readings of the right machine are below by far.
const DOUBT: f64 = 0.1;

/// Factor by which another sense must be better.
const BETTER: f64 = 10.0;

/// Returns the error that names the axes, if the readings fit far better while these count the other way.
pub(super) fn other_senses(
    machine: &Machine,
    readings: &[SphereReading],
    options: CalibrationOptions,
    rms: f64,
) -> Option<CalibrationError> {
    // Written so that NaN is in doubt.
    if rms <= DOUBT {
        return None;
    }
    let choices: [&[usize]; 3] =
        [&[FIRST_ROTARY], &[SECOND_ROTARY], &[FIRST_ROTARY, SECOND_ROTARY]];
    choices.into_iter().find_map(|turned| {
        let mut other = machine.clone();
        for axis in other.axes.iter_mut().enumerate().filter(|(at, _)| turned.contains(at)) {
            axis.1.sense = -axis.1.sense;
        }
        let better = Fit::run(&other, readings, options).ok()?.rms();
        let names = turned.iter().filter_map(|&at| Some(machine.axes.get(at)?.name.clone()));
        (better * BETTER < rms).then(|| CalibrationError::OtherSense {
            axes: names.collect(),
            rms,
            other: better,
        })
    })
}
