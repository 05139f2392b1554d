//! Speed of blocks with a time of their own.
//!
//! A block that begins or ends slowly takes its time only if it is faster than its mean speed in between. How much faster,
//! its time says: with ramps from the speeds `v` at its ends to a speed `c`, as short as the axes allow, it covers
//!
//! ```text
//! D(c) = c T - sum of t (c - v) / 2,    t = (c - v) / a + a / j, or 2 sqrt((c - v) / j) where that is short
//! ```
//!
//! in its time `T`. At the speed for which `D` is its length it takes its time, or longer where its ramps do.

use crate::feed::Limits;
use crate::types::{AXES, AxisVector};

/// Halvings of a range of speeds.
const HALVINGS: u32 = 24;

/// Limits of the axes to a change of speed along a leg, and to the speed at the corner where it begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pace {
    /// Largest acceleration and jerk by the length of the leg.
    acceleration: f64,
    jerk: f64,
    /// Largest speed at the corner.
    pub(super) enters: f64,
}

impl Pace {
    /// Nothing limits it.
    pub(super) const FREE: Self =
        Self { acceleration: f64::INFINITY, jerk: f64::INFINITY, enters: f64::INFINITY };

    /// Returns what the axes allow where they allow most, by their derivatives at places of the leg.
    pub(super) fn of(rates: &[AxisVector], limits: &Limits<AXES>) -> Self {
        let most =
            |limit: &AxisVector| rates.iter().map(|rate| least(limit, rate)).fold(0.0, f64::max);
        let jerk = limits.jerk.as_ref().map_or(f64::INFINITY, most);
        Self { acceleration: most(&limits.acceleration), jerk, enters: f64::INFINITY }
    }

    /// Time of a change of speed.
    fn ramp(&self, change: f64) -> f64 {
        let (a, j) = (self.acceleration, self.jerk);
        if change <= 0.0 {
            0.0
        } else if change * j < a * a {
            2.0 * (change / j).sqrt()
        } else {
            change / a + a / j
        }
    }

    /// Returns the largest speed of a leg that is to take `seconds`, by the speeds at its ends.
    pub(super) fn peak(&self, length: f64, seconds: f64, ends: [f64; 2]) -> f64 {
        let mean = length / seconds;
        let ramps = |speed: f64| ends.map(|end| [self.ramp(speed - end), (speed - end).max(0.0)]);
        let fits = |speed: f64| ramps(speed).iter().map(|[time, _]| time).sum::<f64>() <= seconds;
        let covers = |speed: f64| {
            let missed = ramps(speed).iter().map(|[time, change]| 0.5 * time * change).sum::<f64>();
            speed * seconds - missed >= length
        };
        // Without limits the whole leg is at its mean speed.
        if !(self.acceleration.is_finite() && self.jerk.is_finite()) || covers(mean) {
            return mean;
        }
        // A ramp to 3 times the mean and back takes all of the time where jerk alone limits it.
        let mut range = [mean, MOST * mean];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (range[0] + range[1]);
            let enough = !fits(middle) || covers(middle);
            range[usize::from(enough)] = middle;
        }
        range[1]
    }
}

/// Largest multiple of the mean speed: from rest at constant jerk, and on at the speed reached.
const MOST: f64 = 3.0;

/// Returns the smallest share of a limit over a rate.
pub(super) fn least(limits: &AxisVector, rates: &AxisVector) -> f64 {
    limits.zip_map(rates, |limit, rate| limit / rate.abs()).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace { acceleration: 2500.0, jerk: 40_000.0, enters: f64::INFINITY };

    /// From rest to rest over 24.9 mm: 183 mm/s and 0.2716 s by seven phases.
    #[test]
    fn a_leg_from_rest_to_rest_may_be_as_fast_as_its_phases() {
        let speed = 1250.0 * ((0.0625_f64.powi(2) + 4.0 * 24.9 / 2500.0).sqrt() - 0.0625);
        let seconds = 2.0 * (speed / 2500.0 + 0.0625);
        let peak = PACE.peak(24.9, seconds, [0.0; 2]);
        assert!((peak - speed).abs() < 1e-3 * speed, "{peak} {speed}");
    }

    #[test]
    fn a_leg_covers_its_length_in_its_time() {
        for (length, seconds, ends) in
            [(25.0, 0.4, [0.0, 0.0]), (5.0, 0.2, [0.0, 30.0]), (50.0, 1.0, [10.0, 80.0])]
        {
            let peak = PACE.peak(length, seconds, ends);
            let missed: f64 =
                ends.iter().map(|end| 0.5 * PACE.ramp(peak - end) * (peak - end).max(0.0)).sum();
            assert!((peak * seconds - missed - length).abs() < 1e-3 * length, "{peak}");
            assert!(peak > length / seconds && peak < 2.0 * length / seconds);
        }
    }

    #[test]
    fn a_leg_between_faster_ones_keeps_its_mean_speed() {
        let peak = PACE.peak(10.0, 0.2, [80.0, 90.0]);
        assert!((peak - 50.0).abs() < 1e-9);
    }
}
