//! Reciprocal limits of one kind of motion.

use super::directional::DirectionalLimits;
use super::limits::Limits;
use super::options::{FeedOptions, SpeedOverrides};
use crate::types::Motion;
use nalgebra::SVector;

/// Reciprocal limits of one kind of motion: 0 is unlimited.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReciprocalLimits<const N: usize> {
    pub(super) velocity: DirectionalLimits<N>,
    pub(super) acceleration: DirectionalLimits<N>,
    pub(super) jerk: Option<SVector<f64, N>>,
    pub(super) feed: f64,
    pub(super) tip: f64,
}

impl<const N: usize> ReciprocalLimits<N> {
    /// Takes the limits of one kind of motion.
    pub(super) fn new(motion: Motion, limits: &Limits<N>, options: &FeedOptions) -> Self {
        let (velocity, feed) = match motion {
            Motion::Link | Motion::Hop => (limits.rapid, options.speeds.link_feed),
            _ => (limits.velocity, options.speeds.feed),
        };
        // The limits towards minus that go with this kind of motion.
        let minus = limits.minus.map(|minus| {
            (if motion.is_free() { minus.rapid } else { minus.velocity }, minus.acceleration)
        });
        Self {
            velocity: DirectionalLimits::of(velocity, minus.map(|(velocity, _)| velocity)),
            acceleration: DirectionalLimits::of(
                limits.acceleration,
                minus.map(|(_, acceleration)| acceleration),
            ),
            jerk: limits.jerk.map(|jerk| jerk.map(f64::recip)),
            feed: feed.map_or(0.0, f64::recip),
            tip: options.speeds.tip.map_or(0.0, f64::recip),
        }
    }

    /// Scales the limits by an override: below 1 all speeds, above 1 the feed alone.
    pub(super) fn at_override(&self, value: f64) -> Self {
        // All are reciprocals: a smaller limit is a larger number.
        let speeds = 1.0 / value.min(1.0);
        Self {
            velocity: self.velocity.scaled(speeds),
            tip: self.tip * speeds,
            feed: self.feed / value,
            ..*self
        }
    }

    /// Scales feed and tip speed; those of the axes stay.
    pub(super) fn at_speed_overrides(&self, overrides: SpeedOverrides) -> Self {
        Self { feed: self.feed / overrides.feed, tip: self.tip / overrides.tip, ..*self }
    }

    #[cfg(test)]
    pub(super) fn none() -> Self {
        let zero = DirectionalLimits::both(SVector::zeros());
        Self { velocity: zero, acceleration: zero, jerk: None, feed: 0.0, tip: 0.0 }
    }
}
