//! One stretch of path between two rows: its rates as Bernstein coefficients, and the linear
//! constraints they put on the squared speeds at both ends.
//!
//! With `x = (ds/dt)²` linear between the rows, an axis acceleration `q' u + q'' x` is a quartic in
//! `s` whose Bernstein coefficients are linear in the two end values of `x`. A polynomial stays
//! inside the hull of its Bernstein coefficients, so limits on all five coefficients are limits
//! *everywhere* between the rows. The first and the last are the interpolation scheme of TOPP-RA.

use super::Reciprocals;
use super::strip::Strips;
use crate::types::AxisNode;
use nalgebra::SVector;

/// A stretch of path between two rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell<const N: usize> {
    /// Length in `s`.
    pub(super) h: f64,
    /// Bernstein coefficients of the quartic `q'`.
    pub(super) rates: [SVector<f64, N>; 5],
    /// What rounding leaves open of the rates.
    pub(super) doubt: SVector<f64, N>,
    /// Speed of the programmed point per unit of `s` at both ends; linear in between.
    pub(super) feed_rate: [f64; 2],
    /// The same of the tool tip.
    pub(super) tip_rate: [f64; 2],
}

/// Weights of a quartic's Bernstein coefficients at the middle; those of the last two are the first two's.
pub(super) const MIDDLE: [f64; 3] = [0.0625, 0.25, 0.375];

impl<const N: usize> Cell<N> {
    /// The quintic between two nodes.
    pub(super) fn between(from: &AxisNode<N>, to: &AxisNode<N>) -> Self {
        let h = to.s - from.s;
        let [[p0, p1, p2, _], [r0, r1, r2, _]] = [from.q, to.q];
        let chord = (r0 - p0) / h;
        let middle = (chord - (p1 + r1) * 0.4 + (r2 - p2) * (0.05 * h)) * 5.0;
        let rates = [p1, p1 + p2 * (0.25 * h), middle, r1 - r2 * (0.25 * h), r1];
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

    /// Both parts of a cut at fraction `t` (de Casteljau's scheme): the same curve exactly.
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

    /// What the Bernstein coefficients of the axis accelerations over their limits are made of.
    #[inline]
    pub(super) fn accelerations(&self, limits: &Reciprocals<N>) -> Accelerations<N> {
        let per_length = 1.0 / self.h;
        let mut scaled = Accelerations::within(limits);
        for axis in 0..N {
            let scale = limits.acceleration.plus[axis] * per_length;
            for k in 0..5 {
                scaled.r[k][axis] = self.rates[k][axis] * scale;
            }
            for k in 0..4 {
                scaled.d[k][axis] = scaled.r[k + 1][axis] - scaled.r[k][axis];
            }
        }
        scaled
    }

    /// The same from one node to the next, with the coefficients at rows alone: all that limits at rows
    /// need.
    #[inline]
    pub(super) fn at_rows(
        from: &AxisNode<N>,
        to: &AxisNode<N>,
        limits: &Reciprocals<N>,
    ) -> Accelerations<N> {
        let per_length = 1.0 / (to.s - from.s);
        let mut scaled = Accelerations::within(limits);
        for axis in 0..N {
            let inverse = limits.acceleration.plus[axis];
            scaled.r[0][axis] = from.q[1][axis] * (inverse * per_length);
            scaled.r[4][axis] = to.q[1][axis] * (inverse * per_length);
            scaled.d[0][axis] = from.q[2][axis] * (0.25 * inverse);
            scaled.d[3][axis] = to.q[2][axis] * (0.25 * inverse);
        }
        scaled
    }

    /// Largest `x` at both ends by the speed limits there alone.
    #[inline]
    pub(super) fn end_caps(&self, limits: &Reciprocals<N>) -> [f64; 2] {
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

    /// Largest `x` at both ends such that a linear `x` below keeps every speed limit in between.
    #[inline]
    pub(super) fn caps(&self, limits: &Reciprocals<N>) -> [f64; 2] {
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

    /// For each axis a line (its values at both ends) above `|q'|` over the velocity limit.
    #[inline]
    pub(super) fn speed_lines(&self, limits: &Reciprocals<N>) -> [[f64; 2]; N] {
        std::array::from_fn(|axis| {
            let rate = |k: usize| limits.velocity.share(axis, self.rates[k][axis]);
            let [first, last] = [rate(0), rate(4)];
            let quarter = 0.25 * (last - first);
            let above = |k: usize| rate(k) - (first + k as f64 * quarter);
            let rise = largest(largest(above(1), above(2)), largest(above(3), 0.0));
            [first + rise, last + rise]
        })
    }

    /// `q''` at the start.
    #[inline]
    pub(super) fn bend_at_start(&self) -> SVector<f64, N> {
        (self.rates[1] - self.rates[0]) * (4.0 / self.h)
    }

    /// `q'` and `q''` in the middle.
    #[inline]
    pub(super) fn rates_in_the_middle(&self) -> [SVector<f64, N>; 2] {
        let r = &self.rates;
        let rate = (r[0] + r[4]) * MIDDLE[0] + (r[1] + r[3]) * MIDDLE[1] + r[2] * MIDDLE[2];
        // 4 times the quartic's differences, weighted 1 3 3 1, over 8.
        let bend = ((r[4] - r[0]) + (r[3] - r[1]) * 2.0) * (0.5 / self.h);
        [rate, bend]
    }
}

impl<const N: usize> Cell<N> {
    /// What rounding leaves open of second derivatives: `4 / h` of differences of rates is taken.
    pub(super) fn blur(&self) -> SVector<f64, N> {
        self.doubt * (8.0 / self.h)
    }
}

/// A line times a factor.
#[inline]
pub(super) fn scaled(line: [f64; 2], factor: f64) -> [f64; 2] {
    line.map(|end| end * factor)
}

/// The larger one; without the care for NaN that `f64::max` takes.
#[inline]
pub(super) fn largest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Smaller of two numbers, the second if they cannot be compared; see [`largest`].
#[inline]
pub(super) fn smallest(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Roundings of the largest rate in the coefficients of a cell: a few in forming the quintic, and one in each of
/// the averages of up to a dozen cuts.
const ROUNDINGS: f64 = 64.0;

/// Rates of a cell over the acceleration limits and the length, and their differences.
///
/// `q'` has the coefficients `r_k`, `q''` therefore `4 d_k`; the product of the latter with the linear
/// `x` is raised to the quartic, and `u = (x1 - x0) / 2h`. Coefficient `k` of the acceleration is
/// `r_k (x1 - x0) / 2 + (4 - k) d_k x0 + k d_(k-1) x1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accelerations<const N: usize> {
    r: [[f64; N]; 5],
    d: [[f64; N]; 4],
    /// Limit towards minus over the one towards plus.
    pub(super) minus: [f64; N],
    /// Its reciprocal.
    per_minus: [f64; N],
}

/// Which of `K` constraints an axis has: all Bernstein coefficients (5), or those at rows alone (2).
const fn coefficient(place: usize, of: usize) -> usize {
    if of == 2 { place * 4 } else { place }
}

impl<const N: usize> Accelerations<N> {
    /// Nothing that moves, within these limits.
    #[inline]
    fn within(limits: &Reciprocals<N>) -> Self {
        let sides = &limits.acceleration;
        let ratio = |over: &SVector<f64, N>, under: &SVector<f64, N>| {
            std::array::from_fn(|axis| over[axis] / under[axis])
        };
        Self {
            r: [[0.0; N]; 5],
            d: [[0.0; N]; 4],
            minus: ratio(&sides.plus, &sides.minus),
            per_minus: ratio(&sides.minus, &sides.plus),
        }
    }

    /// Limit of a constraint of this axis, by the sign of the side.
    #[inline]
    pub(super) fn limit(&self, axis: usize, sign: f64) -> f64 {
        if sign < 0.0 { self.minus[axis] } else { 1.0 }
    }

    /// Coefficient `k` of one axis as `a x0 + b x1`.
    #[inline]
    fn row(&self, k: usize, axis: usize) -> [f64; 2] {
        let half = 0.5 * self.r[k][axis];
        let ahead = if k < 4 { (4 - k) as f64 * self.d[k][axis] } else { 0.0 };
        let behind = if k > 0 { k as f64 * self.d[k - 1][axis] } else { 0.0 };
        [ahead - half, behind + half]
    }

    /// Constraint `place` of `K` of one axis as `a x0 + b x1`.
    #[inline]
    pub(super) fn constraint<const K: usize>(&self, [place, axis]: [usize; 2]) -> [f64; 2] {
        self.row(coefficient(place, K), axis)
    }

    /// All constraints as `a x0 + b x1`.
    pub(super) fn strips<const K: usize>(&self) -> Strips<N, K> {
        let mut strips =
            Strips { a: [SVector::zeros(); K], b: [SVector::zeros(); K], minus: self.minus };
        for place in 0..K {
            for axis in 0..N {
                let [a, b] = self.row(coefficient(place, K), axis);
                (strips.a[place][axis], strips.b[place][axis]) = (a, b);
            }
        }
        strips
    }

    /// Coefficient `k` of all axes.
    #[inline]
    fn at(&self, k: usize, [x0, x1]: [f64; 2]) -> [f64; N] {
        let change = 0.5 * (x1 - x0);
        let [ahead, behind] = [(4.0 - k as f64) * x0, k as f64 * x1];
        std::array::from_fn(|axis| {
            let ahead = if k < 4 { ahead * self.d[k][axis] } else { 0.0 };
            let behind = if k > 0 { behind * self.d[k - 1][axis] } else { 0.0 };
            self.r[k][axis] * change + (ahead + behind)
        })
    }

    /// Largest share of its limit of any of the `K` constraints.
    #[inline]
    pub(super) fn most<const K: usize>(&self, x: [f64; 2]) -> f64 {
        let mut most = [0.0; N];
        for place in 0..K {
            let values = self.at(coefficient(place, K), x);
            for axis in 0..N {
                let value = values[axis];
                let size = largest(value, -value * self.per_minus[axis]);
                most[axis] = if size > most[axis] { size } else { most[axis] };
            }
        }
        most.into_iter().fold(0.0, |most, size| if size > most { size } else { most })
    }

    /// Shares of their limits that the accelerations of all axes take at the start, in the middle and at the end.
    #[inline]
    pub(super) fn at_three(&self, x: [f64; 2]) -> [[f64; N]; 3] {
        let (r, d) = (&self.r, &self.d);
        let [change, mean] = [0.5 * (x[1] - x[0]), 0.5 * (x[0] + x[1])];
        let middle = std::array::from_fn(|axis| {
            let rate = MIDDLE[0] * (r[0][axis] + r[4][axis])
                + MIDDLE[1] * (r[1][axis] + r[3][axis])
                + MIDDLE[2] * r[2][axis];
            // 4 times the quartic's differences, weighted 1 3 3 1.
            let bend = 0.5 * (d[0][axis] + d[3][axis]) + 1.5 * (d[1][axis] + d[2][axis]);
            rate * change + bend * mean
        });
        [self.at(0, x), middle, self.at(4, x)].map(|values| {
            std::array::from_fn(|axis| largest(values[axis], -values[axis] * self.per_minus[axis]))
        })
    }
}

/// A line below the convex `1 / rate²` for a linear `rate`: the tangent in the middle where the
/// rate hardly changes, else at the end where it is largest, which would otherwise lose most.
pub(super) fn tangent(rate: [f64; 2]) -> [f64; 2] {
    let largest = rate[0].max(rate[1]);
    let middle = 0.5 * (rate[0] + rate[1]);
    let at = if largest <= 1.1 * middle { middle } else { largest };
    if at > 0.0 { rate.map(|end| (3.0 - 2.0 * end / at) / (at * at)) } else { [f64::INFINITY; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::sides::Sides;
    use nalgebra::Vector1;

    impl<const N: usize> Cell<N> {
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

    fn cell(rates: [f64; 5], h: f64) -> Cell<1> {
        Cell {
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
        let cell = Cell::between(&node(0.0, 0.0), &node(h, ulp));
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

    /// `q' = s` on [0, 1]: `q'' = 1`, acceleration `s u + x0 + 2 u s`.
    #[test]
    fn strips_are_the_acceleration_in_bernstein_form() {
        let cell = cell([0.0, 0.25, 0.5, 0.75, 1.0], 1.0);
        let acceleration = Sides::both(Vector1::new(0.5));
        let limits = Reciprocals { acceleration, ..Reciprocals::none() };
        let x = [3.0, 7.0];
        for (k, t) in [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().enumerate() {
            let want = (3.0 + 6.0 * t) * 0.5;
            let scaled = cell.accelerations(&limits);
            let [a, b] = scaled.constraint::<5>([k, 0]);
            for got in [scaled.at(k, x)[0], a * x[0] + b * x[1]] {
                assert!((got - want).abs() < 1e-14, "{k}: {got} {want}");
            }
            if k % 2 == 0 {
                assert!((scaled.at_three(x)[k / 2][0] - want).abs() < 1e-14);
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
