//! Mean acceleration between blocks, from which the mean jerk is differenced.

use crate::types::AxisVector;

/// Mean acceleration over two consecutive blocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeanAcceleration {
    /// Divided difference of both mean velocities \[mm/s², rad/s²\].
    pub(crate) acceleration: AxisVector,
    /// Acceleration that the rounding of the words can have added \[mm/s², rad/s²\].
    pub(crate) slack: AxisVector,
    /// Time of the first of both blocks \[s\].
    pub(crate) first: f64,
}

impl MeanAcceleration {
    /// Acceleration of a machine that stands still.
    pub(crate) const STANDSTILL: Self = Self {
        acceleration: AxisVector::new(0.0, 0.0, 0.0, 0.0, 0.0),
        slack: AxisVector::new(0.0, 0.0, 0.0, 0.0, 0.0),
        first: 0.0,
    };
}
