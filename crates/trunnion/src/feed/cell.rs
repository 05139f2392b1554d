//! One stretch of path between two rows: its rates as Bernstein coefficients, and the linear
//! constraints they put on the squared speeds at both ends.
//!
//! With `x = (ds/dt)²` linear between the rows, an axis acceleration `q' u + q'' x` is a quartic in
//! `s` whose Bernstein coefficients are linear in the two end values of `x`. A polynomial stays
//! inside the hull of its Bernstein coefficients, so limits on all five coefficients are limits
//! *everywhere* between the rows. The first and the last are the interpolation scheme of TOPP-RA.

use super::Reciprocals;
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

/// Constraints `|a x0 + b x1| <= 1` of one cell: one per axis and Bernstein coefficient (`K` = 5), or
/// per axis and row alone (`K` = 2).
#[derive(Debug, Clone, Copy)]
pub(super) struct Strips<const N: usize, const K: usize = 5> {
    pub(super) a: [SVector<f64, N>; K],
    pub(super) b: [SVector<f64, N>; K],
}

/// Weights of a quartic's Bernstein coefficients at the middle.
pub(super) const MIDDLE: [f64; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];

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

    /// Bernstein coefficients of every axis acceleration over its limit, as `a x0 + b x1`.
    ///
    /// `q'` has the coefficients `r_k`, `q''` therefore `4 (r_(k+1) - r_k) / h`; the product of the
    /// latter with the linear `x` is raised to the quartic, and `u = (x1 - x0) / 2h`.
    pub(super) fn strips(&self, limits: &Reciprocals<N>) -> Strips<N> {
        let r = &self.rates;
        let scale = limits.acceleration / self.h;
        let mut strips = Strips { a: [SVector::zeros(); 5], b: [SVector::zeros(); 5] };
        for k in 0..5 {
            let half = r[k] * 0.5;
            let ahead = if k < 4 { (r[k + 1] - r[k]) * (4 - k) as f64 } else { SVector::zeros() };
            let behind = if k > 0 { (r[k] - r[k - 1]) * k as f64 } else { SVector::zeros() };
            strips.a[k] = (ahead - half).component_mul(&scale);
            strips.b[k] = (behind + half).component_mul(&scale);
        }
        strips
    }

    /// The first and last of [`Cell::strips`]: accelerations at both rows, and nothing in between.
    pub(super) fn end_strips(&self, limits: &Reciprocals<N>) -> Strips<N, 2> {
        let r = &self.rates;
        let scale = limits.acceleration / self.h;
        let [half, last] = [(r[0] * 0.5).component_mul(&scale), (r[4] * 0.5).component_mul(&scale)];
        let ahead = ((r[1] - r[0]) * 4.0).component_mul(&scale);
        let behind = ((r[4] - r[3]) * 4.0).component_mul(&scale);
        Strips { a: [ahead - half, -last], b: [half, behind + last] }
    }

    /// Largest `x` at both ends by the speed limits there alone.
    pub(super) fn end_caps(&self, limits: &Reciprocals<N>) -> [f64; 2] {
        let cap = |rate: &SVector<f64, N>, end: usize| {
            let point = (self.feed_rate[end] * limits.feed).max(self.tip_rate[end] * limits.tip);
            rate.component_mul(&limits.velocity).amax().max(point).powi(-2)
        };
        [cap(&self.rates[0], 0), cap(&self.rates[4], 1)]
    }

    /// Largest `x` at both ends such that a linear `x` below keeps every speed limit in between.
    pub(super) fn caps(&self, limits: &Reciprocals<N>) -> [f64; 2] {
        let mut caps = [f64::INFINITY; 2];
        let mut lower = |[c0, c1]: [f64; 2]| caps = [caps[0].min(c0), caps[1].min(c1)];
        for axis in 0..N {
            lower(tangent(self.speed_line(axis).map(|rate| rate * limits.velocity[axis])));
        }
        lower(tangent(self.feed_rate.map(|rate| rate.abs() * limits.feed)));
        lower(tangent(self.tip_rate.map(|rate| rate.abs() * limits.tip)));
        caps
    }

    /// A line (its values at both ends) above `|q'|` of one axis.
    pub(super) fn speed_line(&self, axis: usize) -> [f64; 2] {
        let rate = |k: usize| self.rates[k][axis].abs();
        let [first, last] = [rate(0), rate(4)];
        let above = |k: usize| rate(k) - (first + 0.25 * k as f64 * (last - first));
        let rise = above(1).max(above(2)).max(above(3)).max(0.0);
        [first + rise, last + rise]
    }

    /// Rates at fraction `t` by de Casteljau's scheme: `q'` and `q''`.
    pub(super) fn rates_at(&self, t: f64) -> [SVector<f64, N>; 2] {
        let mut rest = self.rates;
        for level in 0..3 {
            for k in 0..4 - level {
                rest[k] = rest[k].lerp(&rest[k + 1], t);
            }
        }
        [rest[0].lerp(&rest[1], t), (rest[1] - rest[0]) * (4.0 / self.h)]
    }
}

impl<const N: usize> Cell<N> {
    /// What rounding leaves open of second derivatives: `4 / h` of differences of rates is taken.
    pub(super) fn blur(&self) -> SVector<f64, N> {
        self.doubt * (8.0 / self.h)
    }
}

/// Roundings of the largest rate in the coefficients of a cell: a few in forming the quintic, and one in each of
/// the averages of up to a dozen cuts.
const ROUNDINGS: f64 = 64.0;

impl<const N: usize> Strips<N> {
    /// Bernstein coefficient `k` of all axis accelerations over their limits.
    pub(super) fn coefficient(&self, k: usize, x: [f64; 2]) -> SVector<f64, N> {
        self.a[k] * x[0] + self.b[k] * x[1]
    }
}

/// A line below the convex `1 / rate²` for a linear `rate`: the tangent in the middle where the
/// rate hardly changes, else at the end where it is largest, which would otherwise lose most.
fn tangent(rate: [f64; 2]) -> [f64; 2] {
    let largest = rate[0].max(rate[1]);
    let middle = 0.5 * (rate[0] + rate[1]);
    let at = if largest <= 1.1 * middle { middle } else { largest };
    if at > 0.0 { rate.map(|end| (3.0 - 2.0 * end / at) / (at * at)) } else { [f64::INFINITY; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

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
        let limits = Reciprocals { acceleration: Vector1::new(0.5), ..Reciprocals::none() };
        let x = [3.0, 7.0];
        for (k, t) in [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().enumerate() {
            let want = (3.0 + 6.0 * t) * 0.5;
            let got = cell.strips(&limits).coefficient(k, x)[0];
            assert!((got - want).abs() < 1e-14, "{k}: {got} {want}");
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
