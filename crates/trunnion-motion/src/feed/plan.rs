//! Plans and their figures.

use crate::types::Schedule;

/// Limit that keeps the path from being run faster at one point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum BindingLimit {
    /// Velocity limit of this axis.
    Velocity(u8),
    /// Acceleration limit of this axis.
    Acceleration(u8),
    /// Chord error of this axis, see [`FeedPlan::name_chords`].
    Chord(u8),
    /// Jerk limit of this axis.
    Jerk(u8),
    /// Programmed feed.
    Feed,
    /// Speed limit of the tool tip.
    Tip,
    /// Nothing: neither an axis nor the programmed point moves.
    Still,
}

/// Largest axis velocity, acceleration and jerk over their limits: 1 is full use.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct LimitRatios {
    /// Velocities, programmed feed and tip speed.
    pub velocity: f64,
    /// Accelerations.
    pub acceleration: f64,
    /// Jerks between rows; `None` without jerk limits. In a plan of [`optimal()`](crate::feed::optimal())
    /// accelerations step at rows, which does not count here.
    pub jerk: Option<f64>,
}

impl LimitRatios {
    /// Returns the larger ratio of each kind.
    pub(super) fn max(self, other: Self) -> Self {
        let jerk = match (self.jerk, other.jerk) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        Self {
            velocity: self.velocity.max(other.velocity),
            acceleration: self.acceleration.max(other.acceleration),
            jerk,
        }
    }
}

/// A speed schedule, its certified bounds and its measured ratios.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FeedPlan {
    /// Times and speeds at the rows: the nodes of the path, and rows that the planner inserted.
    pub schedule: Schedule,
    /// No schedule within the limits is faster than this \[s\].
    pub lower_bound: f64,
    /// Largest ratios found in a dense check.
    pub ratios: LimitRatios,
    /// Guaranteed upper bounds of the ratios, everywhere; [`optimal()`](crate::feed::optimal()) does not bound
    /// `jerk`.
    pub bounds: LimitRatios,
    /// Largest step of an axis acceleration at a row, over the axis limit: 0..=2.
    pub acceleration_step: f64,
    /// Limits that bind from each row to the next, piece by piece; as many entries as rows.
    pub binding: Vec<Vec<BindingLimit>>,
    /// Inserted rows.
    pub inserted: usize,
}

impl FeedPlan {
    /// Turns acceleration limits into [`BindingLimit::Chord`] on axes whose acceleration limit is
    /// that of a chord error.
    pub fn name_chords<const N: usize>(&mut self, lowered: [bool; N]) {
        for binding in self.binding.iter_mut().flatten() {
            // The lower limit is the chord error's, so what binds is that.
            if let BindingLimit::Acceleration(axis) = *binding
                && lowered.get(usize::from(axis)).is_some_and(|lowered| *lowered)
            {
                *binding = BindingLimit::Chord(axis);
            }
        }
    }
}
