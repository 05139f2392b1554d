//! Speed over one block: speed up, keep the feed, slow down.

/// A block's motion under constant acceleration and deceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRamp {
    /// Speeds at the start, at most, and at the end.
    pub speeds: [f64; 3],
    /// Times of speeding up, of constant speed, and of slowing down \[s\].
    pub times: [f64; 3],
    /// Distances of the same.
    pub distances: [f64; 3],
}

impl SpeedRamp {
    /// Plans the fastest motion over `length` at up to `feed`, with `[A, D]` to speed up and slow
    /// down.
    ///
    /// An end speed that cannot be reached is lowered to `sqrt(vs² + 2 A L)`, a start speed from
    /// which the end speed cannot be reached to `sqrt(ve² + 2 D L)`. The peak is `vp² = (2 A D L +
    /// D vs² + A ve²) / (A + D)` where that is below the feed.
    ///
    /// # Source
    ///
    /// `docs/sources.md#001`: trapezoid and triangle, (5)-(13).
    pub fn new(length: f64, ends: [f64; 2], feed: f64, [a, d]: [f64; 2]) -> Self {
        let [from, to] = ends.map(|speed| speed.min(feed));
        // Speeds that the length does not allow are lowered first, so that the peak is above both.
        let end = to.min((from * from + 2.0 * a * length).sqrt());
        let start = from.min((to * to + 2.0 * d * length).sqrt());
        let square = (2.0 * a * d * length + d * start * start + a * end * end) / (a + d);
        // Where one ramp takes the whole block, rounding must not put the peak below its end.
        let peak = square.sqrt().min(feed).max(start).max(end);
        let distance = |slow: f64, rate: f64| (peak - slow) * (peak + slow) / (2.0 * rate);
        let [up, down] = [distance(start, a), distance(end, d)];
        let even = if peak < feed { 0.0 } else { (length - up - down).max(0.0) };
        Self {
            speeds: [start, peak, end],
            times: [(peak - start) / a, even / peak, (peak - end) / d],
            distances: [up, even, down],
        }
    }

    /// Returns the time of the block \[s\].
    pub fn duration(&self) -> f64 {
        self.times.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_block_is_a_trapezoid_a_triangle_or_a_single_ramp() {
        let trapezoid = SpeedRamp::new(100.0, [0.0; 2], 50.0, [500.0; 2]);
        assert!((trapezoid.duration() - 2.1).abs() < 1e-12, "{trapezoid:?}");
        let triangle = SpeedRamp::new(2.0, [0.0; 2], 50.0, [500.0; 2]);
        assert!((triangle.speeds[1] - 1000.0_f64.sqrt()).abs() < 1e-12, "{triangle:?}");
        // From 10 mm/s, 1 mm at 500 mm/s²: 50 mm/s is out of reach.
        let up = SpeedRamp::new(1.0, [10.0, 50.0], 60.0, [500.0; 2]);
        assert!((up.speeds[2] - 1100.0_f64.sqrt()).abs() < 1e-12, "{up:?}");
        assert!(up.times[1].abs() + up.times[2].abs() < 1e-12, "{up:?}");
    }

    proptest! {
        #[test]
        fn distances_add_up_and_speeds_are_those_of_the_ramps(
            length in 1e-3..1e3f64,
            ends in [0.0..200.0f64, 0.0..200.0f64],
            feed in 1.0..300.0f64,
            rates in [1.0..5e3f64, 1.0..5e3f64],
        ) {
            let ramp = SpeedRamp::new(length, ends, feed, rates);
            let [vs, vp, ve] = ramp.speeds;
            prop_assert!(vs <= vp && ve <= vp && vp <= feed, "{ramp:?}");
            prop_assert!((ramp.distances.iter().sum::<f64>() - length).abs() < 1e-12 * (length + vp * vp / rates[0].min(rates[1])));
            prop_assert!((vs + rates[0] * ramp.times[0] - vp).abs() < 1e-9);
            prop_assert!((ve + rates[1] * ramp.times[2] - vp).abs() < 1e-9);
            prop_assert!(ramp.times.iter().all(|&time| time >= 0.0), "{ramp:?}");
        }
    }
}
