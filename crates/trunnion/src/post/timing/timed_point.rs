//! Axis point with its time.

use crate::post::axis_point::AxisPoint;

/// Axis point, and the time from the point before.
#[derive(Debug, Clone, Copy)]
pub(in crate::post) struct TimedPoint {
    pub(in crate::post) point: AxisPoint,
    /// Time from the point before \[s\].
    pub(in crate::post) seconds: f64,
}
