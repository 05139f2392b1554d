//! Options of the audit of setpoints, and units of its reports.

use crate::machine::AxisKind;
use crate::types::AxisVector;

/// What a table of setpoints holds, and how exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionOptions {
    /// Time from row to row \[s\]; the last row may come sooner.
    pub period: f64,
    /// How many derivatives by time the rows hold: 0 (positions alone) to 3 (jerk).
    pub derivatives: usize,
    /// What the decimals of the table can have changed: times \[s\].
    pub time_rounding: f64,
    /// Likewise positions and their derivatives of every axis \[mm, rad and s\].
    pub rounding: [AxisVector; 4],
    /// Whether jerk is judged: not where it was never limited.
    pub jerk: bool,
}

/// In the units people read.
pub(super) fn shown(kind: AxisKind, value: f64) -> f64 {
    if kind == AxisKind::Rotary { value.to_degrees() } else { value }
}
