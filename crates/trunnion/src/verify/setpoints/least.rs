//! Least acceleration and jerk of any motion through two rows.
//!
//! Both are norms of the moments that the rows fix (the least bound of a function with given moments), so that
//! errors of the rows add up as in any norm. The function that reaches the bound takes only its largest values,
//! with one switch for two moments and two switches for three (bang-bang principle; L. S. Pontryagin et al.,
//! *The Mathematical Theory of Optimal Processes*, ch. III).

use crate::math;
/// Rate with its uncertainty.
#[derive(Debug, Clone, Copy)]
pub(super) struct RateBound {
    /// Rate by the written values \[mm, rad and s\].
    pub(super) value: f64,
    /// Part of it that errors of the values may have added, in the same unit.
    pub(super) slack: f64,
}

/// Halvings of the search over bounds: to rounding.
const HALVINGS: usize = 56;

/// Returns the least bound of `|a|` over 0..1 with `∫a = n0` and `∫(1 - x) a = n1`.
///
/// `a = ±L`, switched at `x`: `n0 = L (2 x - 1)` and `n1 = L (2 x - x² - 1/2)`; without `x`,
/// `L² + 2 (n0 - 2 n1) L = n0²` for either sign of `L`.
fn two_moments(n0: f64, n1: f64) -> f64 {
    // Of both roots L, whose product is -n0², the larger counts: the switch is in 0..1 only for |L| >= |n0|.
    let lag = n0 - 2.0 * n1;
    lag.abs() + math::hypot(lag, n0)
}

/// Returns the least bound of `|j|` over 0..1 with `∫j = m0`, `∫(1 - x) j = m1` and `∫(1 - x)²/2 j = m2`.
fn three_moments([m0, m1, m2]: [f64; 3]) -> f64 {
    // A bound is feasible if m2 is in the range that functions within it and with the other two moments reach.
    let holds = |bound: f64| m2 <= most([m0, m1], bound) && -m2 <= most([-m0, -m1], bound);
    // Step 1: two of the moments are a lower bound, which is often sharp already.
    let mut low = two_moments(m0, m1);
    if low > 0.0 && holds(low) {
        return low;
    }
    // Step 2: double until the bound is feasible.
    // The norm of m2 alone is 32.
    let mut high = low.max(32.0 * m2.abs());
    while high.is_finite() && high > 0.0 && !holds(high) {
        (low, high) = (high, 2.0 * high);
    }
    // Step 3: bisect. A larger bound allows all functions of a smaller one, so feasibility is monotone.
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { high = middle } else { low = middle }
    }
    high
}

/// Returns the largest `m2` of a function within `bound` and with the first two moments: `+bound`, but `-bound` on an
/// interval of length `d` around `c`, where `d (1 - c) = e`.
fn most([m0, m1]: [f64; 2], bound: f64) -> f64 {
    // m0 = bound (1 - 2 d) and m1 = bound (1/2 - 2 e) give length and middle of the interval with -bound.
    let d = 0.5 * (1.0 - m0 / bound);
    let e = 0.25 - 0.5 * m1 / bound;
    let shifted = if d > f64::MIN_POSITIVE { e * e / d } else { 0.0 };
    // (1 - x)²/2 has the integral 1/6 over 0..1, and (e²/d + d³/12) / 2 over the interval.
    bound * (1.0 / 6.0 - shifted - d.powi(3) / 12.0)
}

/// Returns the least bound of `|a|` of a motion from `[p, v]` to `[p, v]` within `h`; its slack is due to the errors of
/// position and velocity, summed over both ends.
pub(super) fn acceleration(
    [from, to]: [[f64; 2]; 2],
    h: f64,
    [position, velocity]: [f64; 2],
) -> RateBound {
    // v(h) - v(0) = h ∫a and p(h) - p(0) - v(0) h = h² ∫(1 - x) a, with x = t / h.
    let n0 = (to[1] - from[1]) / h;
    let n1 = (to[0] - from[0] - from[1] * h) / (h * h);
    let slack = two_moments(0.0, 1.0) * position / (h * h) + two_moments(1.0, 0.0) * velocity / h;
    RateBound { value: two_moments(n0, n1), slack }
}

/// Returns the least bound of `|j|` of a motion from `[p, v]` to `[p, v]` within `h` with any acceleration at both
/// ends: six times the divided difference with both ends twice, a weighted mean of the jerk.
pub(super) fn bend([from, to]: [[f64; 2]; 2], h: f64, [position, velocity]: [f64; 2]) -> RateBound {
    // The divided difference p[0, 0, h, h] is (v0 + v1 - 2 (p1 - p0) / h) / h²; j is 3! times a mean of it.
    let bend = (from[1] + to[1]) - 2.0 * (to[0] - from[0]) / h;
    RateBound {
        value: 6.0 * bend.abs() / (h * h),
        slack: 6.0 * (velocity + 2.0 * position / h) / (h * h),
    }
}

/// Largest part of the least jerk over a unit of time per error of position, velocity and acceleration at an end.
///
/// The same holds for either end: run backwards, the motion has them swapped.
#[derive(Debug, Clone, Copy)]
pub(super) struct JerkErrors([f64; 3]);

impl JerkErrors {
    pub(super) fn new() -> Self {
        Self([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]].map(three_moments))
    }

    /// Returns the jerk due to errors summed over both ends, within `h`.
    fn over(&self, h: f64, errors: [f64; 3]) -> f64 {
        let [position, velocity, acceleration] = self.0;
        position * errors[0] / h.powi(3)
            + velocity * errors[1] / (h * h)
            + acceleration * errors[2] / h
    }

    /// Returns the least bound of `|j|` of a motion from `[p, v, a]` to `[p, v, a]` within `h`; its slack is due to
    /// `errors` of them, summed over both ends. A bound of at most `known` may be returned too large, up to `known`.
    pub(super) fn jerk(
        &self,
        [from, to]: [[f64; 3]; 2],
        h: f64,
        errors: [f64; 3],
        known: f64,
    ) -> RateBound {
        // Taylor's formula with the remainder as an integral: over h, h² and h³ the moments of j by x = t / h.
        let [p, v, a] = from;
        let moments = [
            (to[2] - a) / h,
            (to[1] - v - a * h) / (h * h),
            (to[0] - p - v * h - 0.5 * a * h * h) / h.powi(3),
        ];
        let slack = self.over(h, errors);
        // The triangle inequality bounds the norm of the three moments by the norms of each alone.
        let [m0, m1, m2] = moments.map(f64::abs);
        let crude = self.over(1.0, [m2, m1, m0]);
        RateBound { value: if crude <= known { crude } else { three_moments(moments) }, slack }
    }
}

/// Returns the divided difference of `values` at increasing `times`; its slack is due to `errors` of the values.
pub(super) fn divided<const N: usize>(
    times: &[f64; N],
    values: &[f64; N],
    errors: &[f64; N],
) -> RateBound {
    // Newton's divided difference in Lagrange's form: weight k is the product of 1 / (t_k - t_i) over all i != k.
    let weight = |k: usize| -> f64 {
        let apart = times.iter().enumerate().filter(|(other, _)| *other != k);
        apart.map(|(_, t)| times[k] - t).product::<f64>().recip()
    };
    (0..N).fold(RateBound { value: 0.0, slack: 0.0 }, |sum, k| RateBound {
        value: sum.value + weight(k) * values[k],
        slack: sum.slack + weight(k).abs() * errors[k],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// From rest to rest over a unit of way and time: acceleration 4, jerk 32 (both by a pencil).
    #[test]
    fn from_rest_to_rest() {
        assert!((acceleration([[0.0, 0.0], [1.0, 0.0]], 1.0, [0.0; 2]).value - 4.0).abs() < 1e-12);
        let jerk = JerkErrors::new().jerk([[0.0; 3], [1.0, 0.0, 0.0]], 1.0, [0.0; 3], 0.0).value;
        assert!((jerk - 32.0).abs() < 1e-9, "{jerk}");
        // One velocity more, no way: a = -L up to x, then L, with x = 1/√2 and L = 1 + √2.
        let a = acceleration([[0.0, 0.0], [0.0, 1.0]], 1.0, [0.0; 2]).value;
        assert!((a - 1.0 - 2.0_f64.sqrt()).abs() < 1e-12, "{a}");
    }

    /// End of a motion from a state, jerk by jerk for a time each.
    fn run(mut state: [f64; 3], steps: &[[f64; 2]]) -> [f64; 3] {
        for &[jerk, t] in steps {
            let [p, v, a] = state;
            state = [
                p + v * t + a * t * t / 2.0 + jerk * t.powi(3) / 6.0,
                v + a * t + jerk * t * t / 2.0,
                a + jerk * t,
            ];
        }
        state
    }

    proptest! {
        /// No motion is accused of more than its largest jerk, and one that switches at most twice between its
        /// extremes of exactly that.
        #[test]
        fn no_motion_is_accused_and_the_sharpest_are_caught(
            start in [-3.0..3.0f64, -5.0..5.0f64, -7.0..7.0f64],
            jerks in proptest::collection::vec(-10.0..10.0f64, 1..9),
            switches in [0.02..1.0f64, 0.02..1.0f64, 0.02..1.0f64],
            h in 0.1..2.0f64,
        ) {
            let least = |end: [f64; 3], h: f64| JerkErrors::new().jerk([start, end], h, [0.0; 3], 0.0).value;
            let steps: Vec<[f64; 2]> = jerks.iter().map(|&j| [j, h / jerks.len() as f64]).collect();
            let sharpest = jerks.iter().fold(0.0_f64, |most, j| most.max(j.abs()));
            let found = least(run(start, &steps), h);
            prop_assert!(found <= sharpest * (1.0 + 1e-6) + 1e-6, "{found} > {sharpest}");
            let bang = [[4.0, switches[0]], [-4.0, switches[1]], [4.0, switches[2]]];
            let found = least(run(start, &bang), switches.iter().sum());
            prop_assert!((found - 4.0).abs() < 1e-4, "{found}");
        }

        /// The same for accelerations, and differences of cubics are their derivatives.
        #[test]
        fn accelerations_and_differences(
            [p, v, a, b] in [-3.0..3.0f64, -5.0..5.0f64, -7.0..7.0f64, -7.0..7.0f64],
            times in [0.1..2.0f64, 0.1..2.0f64, 0.1..2.0f64],
        ) {
            let [s, t, _] = times;
            let middle = run([p, v, a], &[[0.0, s]]);
            let end = run([middle[0], middle[1], b], &[[0.0, t]]);
            let least = acceleration([[p, v], [end[0], end[1]]], s + t, [0.0; 2]).value;
            prop_assert!(least <= a.abs().max(b.abs()) * (1.0 + 1e-9) + 1e-9);
            let bang = run([p, v, a], &[[0.0, s]]);
            let bang = run([bang[0], bang[1], -a], &[[0.0, t]]);
            let least = acceleration([[p, v], [bang[0], bang[1]]], s + t, [0.0; 2]).value;
            prop_assert!((least - a.abs()).abs() < 1e-6, "{least} for {a}");

            let at = |t: f64| p + v * t + a * t * t + b * t.powi(3);
            let nodes = [0.0, times[0], times[0] + times[1], times.iter().sum()];
            let RateBound { value: third, slack } = divided(&nodes, &nodes.map(at), &[1e-9; 4]);
            prop_assert!((third - b).abs() <= 1e-6 + slack, "{third} for {b}");
        }
    }
}
