//! A step of the committed schedule.

use crate::feed::options::PathEnds;
use crate::types::{Interval, LinearSegment, PathState};

/// A step of the committed schedule: `d²s/dt²` is linear in `s` from its start to its end, and without jerk
/// limits constant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct StreamStep {
    /// Piece of the path, counted from 0.
    pub piece: usize,
    /// Interval between nodes of the piece, counted from 0.
    pub interval: usize,
    /// Path parameter from the start of the step to its end.
    pub s: Interval,
    /// Time at the start, since the stream began and without the time it was held \[s\].
    pub t: f64,
    /// Time it takes \[s\].
    pub duration: f64,
    /// `ds/dt` at both ends.
    pub speed: PathEnds,
    /// `d²s/dt²` at the start.
    pub acceleration: f64,
    /// `d²s/dt²` at the end.
    pub end_acceleration: f64,
}

impl StreamStep {
    /// Returns `true` unless the path is too large, too small or too fine to compute with.
    pub fn is_resolved(&self) -> bool {
        let Self { s, t, duration, speed, acceleration, end_acceleration, .. } = *self;
        let all =
            [s.low, s.high, t, duration, speed.start, speed.end, acceleration, end_acceleration];
        all.iter().all(|one| one.is_finite())
    }

    /// Returns position and speed a time after the start, clamped to the step.
    pub fn at(&self, dt: f64) -> PathState {
        let dt = dt.max(0.0).min(self.duration);
        let accelerations = [self.acceleration, self.end_acceleration];
        // Linear in s with jerk limits; constant otherwise, where the closed form is a parabola.
        if accelerations[0].to_bits() != accelerations[1].to_bits() {
            let length = self.s.width();
            let speed = [self.speed.start, self.speed.end];
            let segment = LinearSegment { length, speed, acceleration: accelerations };
            let [advance, speed, acceleration, jerk] = segment.at(dt);
            let s = (self.s.low + advance).clamp(self.s.low, self.s.high);
            return PathState { s, speed: speed.max(0.0), acceleration, jerk };
        }
        let s = self.s.low + dt * (self.speed.start + 0.5 * self.acceleration * dt);
        let speed = (self.speed.start + self.acceleration * dt).max(0.0);
        let s = s.clamp(self.s.low, self.s.high);
        PathState { s, speed, acceleration: self.acceleration, jerk: 0.0 }
    }
}
