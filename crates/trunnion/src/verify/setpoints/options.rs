//! Options of the audit of setpoints, and units of its reports.

use crate::machine::AxisKind;
use crate::types::AxisVector;

/// Content and accuracy of a table of setpoints. Begin with [`MotionOptions::positions`] and change the rest by struct
/// update.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionOptions {
    /// Time from row to row \[s\]; the last row may come sooner.
    pub period: f64,
    /// Number of derivatives by time that the rows hold: 0 (positions alone) to 3 (jerk).
    pub derivatives: usize,
    /// Largest rounding error of the times in the table \[s\].
    pub time_rounding: f64,
    /// Largest rounding error of positions and their derivatives, by axis \[mm, rad and s\].
    pub rounding: [AxisVector; 4],
    /// Jerk is judged. Set `false` if the motion was planned without a limit of jerk.
    pub jerk: bool,
}

impl MotionOptions {
    /// Takes positions alone, exact ones, with `period` \[s\] from row to row, and judges jerk as well.
    pub fn positions(period: f64) -> Self {
        Self {
            period,
            derivatives: 0,
            time_rounding: 0.0,
            rounding: [AxisVector::zeros(); 4],
            jerk: true,
        }
    }
}

/// Converts a value to the units of reports: mm or degrees.
pub(super) fn shown(kind: AxisKind, value: f64) -> f64 {
    if kind == AxisKind::Rotary { value.to_degrees() } else { value }
}
