//! Mean motion of the axes over blocks, with what the rounding of their words can have added.

use crate::machine::FIRST_ROTARY;
use crate::nc::write::AxisWords;
use crate::post::axis_point::PositionSource;
use crate::types::AxisVector;

/// Last digit of a feed, as a share of the feeds that blocks have \[mm/min or 1/min\].
const FEED_DIGIT: f64 = 1e-3;

/// Returns the largest error of each axis by the rounding of words \[mm, rad\]; `linear` is that of X, Y and Z by
/// tip words.
pub(in crate::post) fn position_error(
    words: &AxisWords,
    source: PositionSource,
    linear: f64,
) -> AxisVector {
    let mut error = words.rounding();
    match source {
        PositionSource::Exact => AxisVector::zeros(),
        PositionSource::Axes => error,
        PositionSource::Tip => {
            error.fixed_rows_mut::<FIRST_ROTARY>(0).fill(linear);
            error
        }
    }
}

/// Mean motion of the axes over one block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockMotion {
    /// Mean velocity \[mm/s, rad/s\].
    pub(crate) velocity: AxisVector,
    /// Velocity that rounding can have added \[mm/s, rad/s\].
    pub(crate) slack: AxisVector,
    /// Time \[s\]; 0 at a standstill.
    pub(crate) seconds: f64,
}

/// Mean acceleration from one block to the next, or its change over three blocks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeanChange {
    pub(crate) value: AxisVector,
    /// Part of it that rounding can have added.
    pub(crate) slack: AxisVector,
}

impl BlockMotion {
    /// Returns the motion of axes that stand.
    pub(crate) fn rest() -> Self {
        Self { velocity: AxisVector::zeros(), slack: AxisVector::zeros(), seconds: 0.0 }
    }

    /// Returns the motion by `travel` in a time, each end of which may be off by `error`.
    pub(crate) fn new(travel: &AxisVector, error: &AxisVector, seconds: f64) -> Self {
        let velocity = travel / seconds;
        // The last digit of the feed changes the time of rounded words only.
        let rounded = error.amax() > 0.0;
        let feed = if rounded { (2.0 * FEED_DIGIT * seconds / 60.0).min(1.0) } else { 0.0 };
        // Both ends may be off in opposite directions.
        let slack = error * (2.0 / seconds) + velocity.abs() * feed;
        Self { velocity, slack, seconds }
    }

    /// Returns the largest ratio of the mean velocities to the limits that rounding does not explain.
    pub(crate) fn over(&self, limits: &AxisVector) -> f64 {
        sure(&self.velocity, &self.slack).component_div(limits).amax()
    }

    /// Returns the mean acceleration from this block to the next.
    ///
    /// Mean velocities belong to the middles of their blocks. Their divided difference is a mean of the acceleration
    /// over both blocks, so it cannot exceed a limit that is kept.
    pub(crate) fn to(&self, next: &Self) -> MeanChange {
        let time = 0.5 * (self.seconds + next.seconds);
        MeanChange {
            value: (next.velocity - self.velocity) / time,
            slack: (self.slack + next.slack) / time,
        }
    }
}

impl MeanChange {
    /// Returns the mean jerk from this acceleration to the next, over blocks that take so long together \[s\].
    pub(crate) fn to(&self, next: &Self, seconds: f64) -> Self {
        let third = seconds / 3.0;
        Self { value: (next.value - self.value) / third, slack: (self.slack + next.slack) / third }
    }

    /// Returns the largest ratio to the limits that rounding does not explain.
    pub(crate) fn over(&self, limits: &AxisVector) -> f64 {
        sure(&self.value, &self.slack).component_div(limits).amax()
    }
}

/// Returns the sizes of values less what rounding can have added.
fn sure(value: &AxisVector, slack: &AxisVector) -> AxisVector {
    (value.abs() - slack).sup(&AxisVector::zeros())
}
