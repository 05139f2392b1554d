//! Rate at which a plan is played: override, hold and stops without a jump.

/// Bounds on the change of the rate. The planner promises that the axes keep their limits while the rate is between 0
/// and 1 and changes within them: with a plan `q(t)`, rate `r` and its derivatives,
///
/// ```text
/// velocity q' r,   acceleration q'' r^2 + q' r',   jerk q''' r^3 + 3 q'' r r' + q' r''
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateBounds {
    /// Largest change of the rate \[1/s\].
    pub change: f64,
    /// Largest change of that change \[1/s²\].
    pub bend: f64,
}

/// Reason why a rate cannot be kept within bounds.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RateError {
    /// A bound or the servo period is not a positive finite number.
    #[error("{what} is {value}; it needs a positive finite number")]
    NotPositive {
        /// Name of the number.
        what: &'static str,
        /// The number \[s, 1/s or 1/s²\].
        value: f64,
    },
    /// The rate would bend within a servo cycle more than the cycle resolves.
    #[error(
        "the bend of {bend} 1/s2 changes the rate by {step} in a servo cycle; at most {MOST_STEP} can be followed: lower the bend"
    )]
    TooFast {
        /// The bound \[1/s²\].
        bend: f64,
        /// Its share of the full rate in a cycle.
        step: f64,
    },
}

/// Largest part of the full rate that the bend may make in a servo cycle: the last cycle of a change arrives within an
/// eighth of it.
const MOST_STEP: f64 = 0.05;

impl RateBounds {
    /// Returns a bound on the plan time of a stop from any rate within the bounds \[s\].
    ///
    /// A rising rate bends down within `change / bend`, falls from 1 within `1 / change`, and bends again; at no time is it
    /// above 1. Whole cycles add less than one cycle to each of the three.
    pub fn longest_stop(&self, period: f64) -> f64 {
        let Self { change, bend } = *self;
        2.0 * change / bend + 1.0 / change + 3.0 * period
    }

    /// Checks the bounds for a servo period \[s\].
    pub(super) fn check(&self, period: f64) -> Result<(), RateError> {
        let Self { change, bend } = *self;
        for (what, value) in [("change", change), ("bend", bend), ("servo period", period)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(RateError::NotPositive { what, value });
            }
        }
        let step = bend * period * period;
        if step > MOST_STEP { Err(RateError::TooFast { bend, step }) } else { Ok(()) }
    }
}

/// Rate of a plan at one servo cycle: plan time per time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanRate {
    /// Rate, from 0 to 1.
    pub rate: f64,
    /// Its change \[1/s\].
    pub change: f64,
}

/// Steps over which a stop is followed cycle by cycle. A stop that takes longer is taken to need all of the plan.
const LONGEST_STOP: usize = 20_000;

impl PlanRate {
    /// The plan stands.
    pub const REST: Self = Self { rate: 0.0, change: 0.0 };

    /// True at rest.
    pub fn is_rest(&self) -> bool {
        self.rate <= 0.0 && self.change.abs() <= 0.0
    }

    /// Returns the rate one cycle of `period` \[s\] later, on its way to `wanted`, as fast as the bounds allow.
    ///
    /// A rate that decreases can always come to rest without going below zero: it keeps `rate >= change^2 / (2 bend)`.
    #[must_use]
    pub fn toward(self, wanted: f64, bounds: RateBounds, period: f64) -> Self {
        let Self { rate, change } = self;
        // Above the wanted rate it falls; below, the same rule rises with the signs turned.
        let sign = if rate >= wanted { 1.0 } else { -1.0 };
        let (distance, away) = (sign * (rate - wanted), sign * change);
        let next = sign * falling(distance, away, bounds, period);
        let reached = rate + 0.5 * (change + next) * period;
        // Whole cycles miss the wanted rate by at most an eighth of what one cycle of the bounds makes: the last one arrives.
        let grain = 0.125 * bounds.bend * period * period * (1.0 + 1e-9);
        if next.abs() <= f64::MIN_POSITIVE && (reached - wanted).abs() <= grain {
            return Self { rate: wanted, change: 0.0 };
        }
        Self { rate: reached.max(0.0), change: next }
    }

    /// Returns the plan time that passes in a cycle from this rate to `next` \[s\].
    pub fn passed(self, next: Self, period: f64) -> f64 {
        // The rate is a parabola with these ends and slopes; Simpson's rule is exact for it.
        let middle = 0.5 * (self.rate + next.rate) + 0.125 * (self.change - next.change) * period;
        (self.rate + 4.0 * middle + next.rate) * period / 6.0
    }

    /// Returns the plan time until rest, with the stop begun now \[s\]: the stop itself is followed cycle by cycle, so that the
    /// figure is that of the stop that is made. Infinite for a stop that takes too many cycles.
    pub fn stopping_time(self, bounds: RateBounds, period: f64) -> f64 {
        let (mut at, mut passed) = (self, 0.0);
        for _ in 0..LONGEST_STOP {
            if at.is_rest() {
                return passed;
            }
            let next = at.toward(0.0, bounds, period);
            passed += at.passed(next, period);
            at = next;
        }
        f64::INFINITY
    }
}

/// Returns the next change of a quantity `distance` above its goal that changes by `change`: down as fast as `bounds` allow, but
/// so that the change can end at the goal.
fn falling(distance: f64, change: f64, bounds: RateBounds, period: f64) -> f64 {
    let RateBounds { change: most, bend } = bounds;
    // Behind this cycle the distance d + (c + c') T / 2 must be at least c'^2 / (2 bend), what the change still takes to end.
    // The smallest such c' is the root of a quadratic.
    let ahead = (distance + 0.5 * change * period).max(0.0);
    let half = 0.5 * period;
    let least = bend * (half - (half * half + 2.0 * ahead / bend).sqrt());
    let step = bend * period;
    least.max(-most).clamp(change - step, change + step)
}
