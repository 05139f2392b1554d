//! What planners are told, and what they tell.

use super::lower;
use super::sides::Sides;
use crate::types::{Motion, Schedule};
use nalgebra::SVector;

/// What the axes can do. All finite and positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<const N: usize> {
    /// Axis velocities while cutting, leading in and leading out \[axis unit/s\].
    pub velocity: SVector<f64, N>,
    /// Axis velocities on links \[axis unit/s\].
    pub rapid: SVector<f64, N>,
    /// Axis accelerations \[axis unit/s²\].
    pub acceleration: SVector<f64, N>,
    /// Axis jerks \[axis unit/s³\]: kept by [`super::jerk()`]; measured, not kept, by [`super::optimal`].
    pub jerk: Option<SVector<f64, N>>,
    /// What differs towards minus; `None` for limits that are the same in both directions. Kept to the full by
    /// [`super::optimal`], [`super::Stream`] and [`super::given()`]; planners with jerk limits and [`super::blocks()`]
    /// keep the smaller of both directions.
    pub minus: Option<MinusLimits<N>>,
}

/// What the axes can do towards minus: a falling axis is braked by less than it is sped up with. All finite
/// and positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinusLimits<const N: usize> {
    /// As [`Limits::velocity`] \[axis unit/s\].
    pub velocity: SVector<f64, N>,
    /// As [`Limits::rapid`] \[axis unit/s\].
    pub rapid: SVector<f64, N>,
    /// As [`Limits::acceleration`] \[axis unit/s²\].
    pub acceleration: SVector<f64, N>,
}

impl<const N: usize> Limits<N> {
    /// The smaller of both directions, in both.
    #[must_use]
    pub fn smaller(&self) -> Self {
        let Some(minus) = self.minus else { return *self };
        Self {
            velocity: self.velocity.inf(&minus.velocity),
            rapid: self.rapid.inf(&minus.rapid),
            acceleration: self.acceleration.inf(&minus.acceleration),
            minus: None,
            ..*self
        }
    }
}

/// How a path is to be run. No `Default`: the caller knows the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedOptions {
    /// Speed of the programmed point on everything but links \[mm/s\]; `None` for as fast as the axes can.
    pub feed: Option<f64>,
    /// Speed of the programmed point on links \[mm/s\]; `None` for as fast as the axes can.
    pub link_feed: Option<f64>,
    /// Speed of the tool tip in the workpiece frame, on every motion \[mm/s\]; `None` for no limit.
    pub tip: Option<f64>,
    /// [`super::optimal`] inserts rows until the time still to gain is estimated below this fraction of the
    /// piece's time, [`super::jerk()`] goes on until a sweep gains less. Limits hold whatever the value; 1e-3
    /// is fine, 1 never goes on for speed.
    pub time_tolerance: f64,
    /// `ds/dt` at the start of the first piece and at the end of the last; pieces rest where they
    /// meet.
    pub ends: [f64; 2],
    /// Whether [`super::optimal`] keeps the limits everywhere. `false` looks at rows alone (TOPP-RA's
    /// interpolation scheme on the path's nodes) and may break limits in between, for comparison;
    /// [`Plan::bounds`] tells by how much. [`super::jerk()`] always keeps them.
    pub guarantee: bool,
}

/// What keeps the path from being run faster at some place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Binding {
    /// Velocity limit of this axis.
    Velocity(u8),
    /// Acceleration limit of this axis.
    Acceleration(u8),
    /// Chord error of this axis, see [`Plan::name_chords`].
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
pub struct Ratios {
    /// Velocities, programmed feed and tip speed.
    pub velocity: f64,
    /// Accelerations.
    pub acceleration: f64,
    /// Jerks between rows; `None` without jerk limits. At rows of [`super::optimal`] accelerations step.
    pub jerk: Option<f64>,
}

/// A speed schedule and what is known about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// When each row is passed; rows are the path's nodes and those inserted.
    pub schedule: Schedule,
    /// No schedule within the limits is faster than this \[s\].
    pub lower_bound: f64,
    /// Largest ratios found in a dense check.
    pub ratios: Ratios,
    /// Guaranteed upper bounds of the ratios, everywhere; [`super::optimal`] does not bound `jerk`.
    pub bounds: Ratios,
    /// Largest step of an axis acceleration at a row, over the axis limit: 0..=2.
    pub acceleration_step: f64,
    /// What binds from each row to the next, piece by piece; as many entries as rows.
    pub binding: Vec<Vec<Binding>>,
    /// Inserted rows.
    pub inserted: usize,
}

/// Largest `ds/dt` at one place, whatever happens elsewhere \[s per s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ceiling {
    /// From the axis velocities.
    pub velocity: f64,
    /// From the axis accelerations: above it no `d²s/dt²` satisfies all axes at once.
    pub acceleration: f64,
}

/// Feed ceiling of a place with `rate = dq/ds` and `curvature = d²q/ds²` while cutting.
///
/// `v <= min v_j / |rate_j|`, and the largest `v` for which some `A` satisfies
/// `|rate_j A + curvature_j v²| <= a_j` on every axis.
///
/// # Source
///
/// `docs/sources.md#001`: maximum velocity curve.
pub fn ceiling<const N: usize>(
    rate: &SVector<f64, N>,
    curvature: &SVector<f64, N>,
    limits: &Limits<N>,
) -> Ceiling {
    let options = FeedOptions {
        feed: None,
        link_feed: None,
        tip: None,
        time_tolerance: 1.0,
        ends: [0.0; 2],
        guarantee: true,
    };
    let limits = Reciprocals::new(Motion::Cut, limits, &options);
    Ceiling {
        velocity: (0..N)
            .map(|axis| limits.velocity.share(axis, rate[axis]))
            .fold(0.0, f64::max)
            .recip(),
        acceleration: lower::pair_cap([*rate, *curvature], &SVector::zeros(), &limits).sqrt(),
    }
}

/// Reciprocal limits of one kind of motion: 0 is unlimited.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reciprocals<const N: usize> {
    pub(super) velocity: Sides<N>,
    pub(super) acceleration: Sides<N>,
    pub(super) jerk: Option<SVector<f64, N>>,
    pub(super) feed: f64,
    pub(super) tip: f64,
}

impl<const N: usize> Reciprocals<N> {
    pub(super) fn new(motion: Motion, limits: &Limits<N>, options: &FeedOptions) -> Self {
        let (velocity, feed) = match motion {
            Motion::Link | Motion::Hop => (limits.rapid, options.link_feed),
            _ => (limits.velocity, options.feed),
        };
        let minus = limits.minus.map(|minus| {
            (if motion.is_free() { minus.rapid } else { minus.velocity }, minus.acceleration)
        });
        Self {
            velocity: Sides::of(velocity, minus.map(|(velocity, _)| velocity)),
            acceleration: Sides::of(
                limits.acceleration,
                minus.map(|(_, acceleration)| acceleration),
            ),
            jerk: limits.jerk.map(|jerk| jerk.map(f64::recip)),
            feed: feed.map_or(0.0, f64::recip),
            tip: options.tip.map_or(0.0, f64::recip),
        }
    }

    /// At an override: below 1 it scales all speeds, above 1 the feed alone.
    pub(super) fn at_override(&self, value: f64) -> Self {
        let speeds = 1.0 / value.min(1.0);
        Self {
            velocity: self.velocity.scaled(speeds),
            tip: self.tip * speeds,
            feed: self.feed / value,
            ..*self
        }
    }

    #[cfg(test)]
    pub(super) fn none() -> Self {
        let zero = Sides::both(SVector::zeros());
        Self { velocity: zero, acceleration: zero, jerk: None, feed: 0.0, tip: 0.0 }
    }
}

impl Ratios {
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
