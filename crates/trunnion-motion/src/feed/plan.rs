//! A finished plan and its figures.

use crate::types::Schedule;

/// What keeps the path from being run faster at some place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
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
pub struct LimitRatios {
    /// Velocities, programmed feed and tip speed.
    pub velocity: f64,
    /// CellAccelerations.
    pub acceleration: f64,
    /// Jerks between rows; `None` without jerk limits. At rows of [`super::optimal`] accelerations step.
    pub jerk: Option<f64>,
}

impl LimitRatios {
    /// The larger of each.
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

/// A speed schedule and what is known about it.
#[derive(Debug, Clone, PartialEq)]
pub struct FeedPlan {
    /// When each row is passed; rows are the path's nodes and those inserted.
    pub schedule: Schedule,
    /// No schedule within the limits is faster than this \[s\].
    pub lower_bound: f64,
    /// Largest ratios found in a dense check.
    pub ratios: LimitRatios,
    /// Guaranteed upper bounds of the ratios, everywhere; [`super::optimal`] does not bound `jerk`.
    pub bounds: LimitRatios,
    /// Largest step of an axis acceleration at a row, over the axis limit: 0..=2.
    pub acceleration_step: f64,
    /// What binds from each row to the next, piece by piece; as many entries as rows.
    pub binding: Vec<Vec<BindingLimit>>,
    /// Inserted rows.
    pub inserted: usize,
}

impl FeedPlan {
    /// Calls what binds by its name on axes whose acceleration limit is that of a chord error.
    pub fn name_chords<const N: usize>(&mut self, lowered: [bool; N]) {
        for binding in self.binding.iter_mut().flatten() {
            if let BindingLimit::Acceleration(axis) = *binding
                && lowered.get(usize::from(axis)).is_some_and(|lowered| *lowered)
            {
                *binding = BindingLimit::Chord(axis);
            }
        }
    }
}
