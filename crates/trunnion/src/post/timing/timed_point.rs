//! Axis point with its time.

use crate::post::axis_point::AxisPoint;

/// Axis point, and the time from the point before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TimedPoint {
    pub(crate) point: AxisPoint,
    /// Time from the point before \[s\].
    pub(crate) seconds: f64,
}
