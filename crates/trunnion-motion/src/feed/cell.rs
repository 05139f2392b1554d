//! One stretch of path between two rows: its rates as Bernstein coefficients, and the linear
//! constraints they put on the squared speeds at both ends.
//!
//! With `x = (ds/dt)²` linear between the rows, an axis acceleration `q' u + q'' x` is a quartic in
//! `s` whose Bernstein coefficients are linear in the two end values of `x`. A polynomial stays
//! inside the hull of its Bernstein coefficients, so limits on all five coefficients are limits
//! *everywhere* between the rows. The first and the last are the interpolation scheme of TOPP-RA.

use super::numeric::{largest, scaled, tangent};
use super::reciprocal::ReciprocalLimits;
use crate::types::AxisNode;
use nalgebra::SVector;

/// A stretch of path between two rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct FeedCell<const N: usize> {
    /// Length in `s`.
    pub(super) h: f64,
    /// Bernstein coefficients of the quartic `q'`.
    pub(super) rates: [SVector<f64, N>; 5],
    /// Bound on the rounding of the rates.
    pub(super) doubt: SVector<f64, N>,
    /// Speed of the programmed point per unit of `s` at both ends; linear in between.
    pub(super) feed_rate: [f64; 2],
    /// The same of the tool tip.
    pub(super) tip_rate: [f64; 2],
}

/// Weights of the Bernstein coefficients of a quartic in its middle; the last two repeat the first
/// two.
pub(super) const MIDDLE: [f64; 3] = [0.0625, 0.25, 0.375];

/// Roundings of the largest rate in the coefficients of a cell: a few in forming the quintic, and
/// one in each average of up to a dozen cuts.
const ROUNDINGS: f64 = 64.0;

impl<const N: usize> FeedCell<N> {
    /// Builds the cell of the quintic between two nodes.
    pub(super) fn between(from: &AxisNode<N>, to: &AxisNode<N>) -> Self {
        let h = to.s - from.s;
        let [[p0, p1, p2, _], [r0, r1, r2, _]] = [from.q, to.q];
        // Coefficients of the quartic q' from position, rate and curvature at both ends.
        let chord = (r0 - p0) / h;
        let middle = (chord - (p1 + r1) * 0.4 + (r2 - p2) * (0.05 * h)) * 5.0;
        let rates = [p1, p1 + p2 * (0.25 * h), middle, r1 - r2 * (0.25 * h), r1];
        // Rounding: relative to the largest rate, and the cancellation in the chord.
        let largest = rates.iter().fold(SVector::zeros(), |most: SVector<f64, N>, rate| {
            most.zip_map(rate, |a, b| a.max(b.abs()))
        });
        // Positions are right to a rounding each, and the one coefficient takes 5 / h of their difference.
        let positions = (p0.abs() + r0.abs()) * (5.0 / h);
        Self {
            h,
            rates,
            doubt: (positions + largest * ROUNDINGS) * f64::EPSILON,
            feed_rate: [from.feed_rate, to.feed_rate],
            tip_rate: [from.tip_rate, to.tip_rate],
        }
    }

    /// Cuts the cell at fraction `t` (de Casteljau): both parts are the same curve exactly.
    pub(super) fn split(&self, t: f64) -> [Self; 2] {
        let mut rest = self.rates;
        let [mut left, mut right] = [self.rates; 2];
        for level in 0..5 {
            left[level] = rest[0];
            right[4 - level] = rest[4 - level];
            for k in 0..4 - level {
                rest[k] = rest[k].lerp(&rest[k + 1], t);
            }
        }
        let at = |ends: [f64; 2]| ends[0] + t * (ends[1] - ends[0]);
        let [feed, tip] = [at(self.feed_rate), at(self.tip_rate)];
        [
            Self {
                h: self.h * t,
                rates: left,
                doubt: self.doubt,
                feed_rate: [self.feed_rate[0], feed],
                tip_rate: [self.tip_rate[0], tip],
            },
            Self {
                h: self.h * (1.0 - t),
                rates: right,
                doubt: self.doubt,
                feed_rate: [feed, self.feed_rate[1]],
                tip_rate: [tip, self.tip_rate[1]],
            },
        ]
    }

    /// Returns the largest `x` at both ends by the speed limits there alone.
    #[inline]
    pub(super) fn end_caps(&self, limits: &ReciprocalLimits<N>) -> [f64; 2] {
        let cap = |rates: &SVector<f64, N>, end: usize| {
            let mut most =
                largest(self.feed_rate[end] * limits.feed, self.tip_rate[end] * limits.tip);
            for axis in 0..N {
                most = largest(most, limits.velocity.share(axis, rates[axis]));
            }
            1.0 / (most * most)
        };
        [cap(&self.rates[0], 0), cap(&self.rates[4], 1)]
    }

    /// Returns the largest `x` at both ends such that a linear `x` below keeps every speed limit
    /// in between.
    #[inline]
    pub(super) fn caps(&self, limits: &ReciprocalLimits<N>) -> [f64; 2] {
        // Every limit is a line above |rate| / limit; x must stay below 1 / line².
        let lines = self.speed_lines(limits);
        let points = [scaled(self.feed_rate, limits.feed), scaled(self.tip_rate, limits.tip)];
        let mut above = [0.0; 2];
        let mut dominant = true;
        for line in lines.iter().chain(&points) {
            let higher = line[0] >= above[0] && line[1] >= above[1];
            dominant = higher || (dominant && line[0] <= above[0] && line[1] <= above[1]);
            above = [largest(line[0], above[0]), largest(line[1], above[1])];
        }
        // A line that is above the others at both ends is above them everywhere.
        if dominant {
            return tangent(above);
        }
        lines
            .iter()
            .chain(&points)
            .map(|line| tangent(*line))
            .fold([f64::INFINITY; 2], |caps, [c0, c1]| [caps[0].min(c0), caps[1].min(c1)])
    }

    /// Returns for each axis a line, by its values at both ends, above `|q'|` over the velocity
    /// limit.
    #[inline]
    pub(super) fn speed_lines(&self, limits: &ReciprocalLimits<N>) -> [[f64; 2]; N] {
        std::array::from_fn(|axis| {
            let rate = |k: usize| limits.velocity.share(axis, self.rates[k][axis]);
            let [first, last] = [rate(0), rate(4)];
            let quarter = 0.25 * (last - first);
            let above = |k: usize| rate(k) - (first + k as f64 * quarter);
            // Shift the chord of the first and last coefficient above the inner ones.
            let rise = largest(largest(above(1), above(2)), largest(above(3), 0.0));
            [first + rise, last + rise]
        })
    }

    /// Returns `q''` at the start.
    #[inline]
    pub(super) fn bend_at_start(&self) -> SVector<f64, N> {
        (self.rates[1] - self.rates[0]) * (4.0 / self.h)
    }

    /// Returns `q'` and `q''` in the middle.
    #[inline]
    pub(super) fn rates_in_the_middle(&self) -> [SVector<f64, N>; 2] {
        let r = &self.rates;
        let rate = (r[0] + r[4]) * MIDDLE[0] + (r[1] + r[3]) * MIDDLE[1] + r[2] * MIDDLE[2];
        // 4 times the quartic's differences, weighted 1 3 3 1, over 8.
        let bend = ((r[4] - r[0]) + (r[3] - r[1]) * 2.0) * (0.5 / self.h);
        [rate, bend]
    }
}

impl<const N: usize> FeedCell<N> {
    /// Returns the bound on the rounding of second derivatives, which are `4 / h` times
    /// differences of rates.
    pub(super) fn blur(&self) -> SVector<f64, N> {
        self.doubt * (8.0 / self.h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    impl<const N: usize> FeedCell<N> {
        /// Rates at fraction `t` by de Casteljau's scheme: `q'` and `q''`.
        fn rates_at(&self, t: f64) -> [SVector<f64, N>; 2] {
            let mut rest = self.rates;
            for level in 0..3 {
                for k in 0..4 - level {
                    rest[k] = rest[k].lerp(&rest[k + 1], t);
                }
            }
            [rest[0].lerp(&rest[1], t), (rest[1] - rest[0]) * (4.0 / self.h)]
        }
    }

    fn cell(rates: [f64; 5], h: f64) -> FeedCell<1> {
        FeedCell {
            h,
            rates: rates.map(Vector1::new),
            doubt: Vector1::zeros(),
            feed_rate: [1.0, 2.0],
            tip_rate: [1.0, 3.0],
        }
    }

    /// Nodes so close that the difference of their positions is rounding say nothing of curvature.
    #[test]
    fn rounding_of_close_nodes_stays_inside_its_bound() {
        let node = |s: f64, off: f64| AxisNode {
            s,
            q: [
                Vector1::new(300.0 + s + off),
                Vector1::new(1.0),
                Vector1::zeros(),
                Vector1::zeros(),
            ],
            feed_rate: 1.0,
            tip_rate: 1.0,
        };
        let (ulp, h) = (300.0 * f64::EPSILON, 1e-7);
        let cell = FeedCell::between(&node(0.0, 0.0), &node(h, ulp));
        let mut largest = 0.0f64;
        for part in cell.split(0.5).iter().flat_map(|half| half.split(0.5)) {
            for t in [0.0, 0.3, 1.0] {
                let [_, bend] = part.rates_at(t);
                largest = largest.max(bend[0].abs());
                assert!(bend[0].abs() <= part.blur()[0], "{bend} {}", part.blur());
            }
        }
        assert!(largest > 1.0, "the case has no rounding to speak of: {largest}");
    }

    #[test]
    fn both_parts_of_a_split_are_the_same_curve() {
        let whole = cell([1.0, -2.0, 0.5, 3.0, 1.5], 2.0);
        let [left, right] = whole.split(0.3);
        assert!((left.h - 0.6).abs() < 1e-15 && (right.h - 1.4).abs() < 1e-15);
        assert!((left.feed_rate[1] - 1.3).abs() < 1e-15);
        for t in [0.0, 0.25, 0.8, 1.0] {
            for (part, at) in [(left, 0.3 * t), (right, 0.3 + 0.7 * t)] {
                let [got, want] = [part.rates_at(t), whole.rates_at(at)];
                assert!((got[0] - want[0]).norm() < 1e-14 && (got[1] - want[1]).norm() < 1e-13);
            }
        }
    }

    #[test]
    fn a_linear_square_speed_below_the_caps_keeps_the_limit_in_between() {
        for rate in [[1.0, 1.15], [2.0, 0.1], [1.0, 0.0], [0.3, 0.3]] {
            let caps = tangent(rate);
            for k in 0..=100 {
                let t = f64::from(k) / 100.0;
                let [x, r] = [caps, rate].map(|[from, to]| from + t * (to - from));
                assert!(x * r * r <= 1.0 + 1e-14, "{rate:?} at {t}");
            }
        }
    }
}
