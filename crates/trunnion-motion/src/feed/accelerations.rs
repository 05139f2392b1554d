//! Axis accelerations of one cell as linear constraints.

use super::cell::{FeedCell, MIDDLE};
use super::numeric::largest;
use super::reciprocal::ReciprocalLimits;
use crate::types::AxisNode;
use nalgebra::SVector;

/// Rates of a cell over the acceleration limits and the length, and their differences.
///
/// `q'` has the coefficients `r_k`, `q''` therefore `4 d_k`; the product of the latter with the linear
/// `x` is raised to the quartic, and `u = (x1 - x0) / 2h`. Coefficient `k` of the acceleration is
/// `r_k (x1 - x0) / 2 + (4 - k) d_k x0 + k d_(k-1) x1`.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellAccelerations<const N: usize> {
    r: [[f64; N]; 5],
    d: [[f64; N]; 4],
    /// Limit towards minus over the one towards plus.
    pub(super) minus: [f64; N],
    /// Reciprocal of `minus`.
    per_minus: [f64; N],
}

/// Returns the Bernstein coefficient of constraint `place`: all coefficients (`of` = 5), or the
/// first and last alone, at the rows (`of` = 2).
const fn coefficient(place: usize, of: usize) -> usize {
    if of == 2 { place * 4 } else { place }
}

impl<const N: usize> CellAccelerations<N> {
    /// Returns the constraints of a cell in which nothing moves.
    #[inline]
    fn within(limits: &ReciprocalLimits<N>) -> Self {
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

    /// Returns the limit of a constraint of this axis, by the sign of the side.
    #[inline]
    pub(super) fn limit(&self, axis: usize, sign: f64) -> f64 {
        if sign < 0.0 { self.minus[axis] } else { 1.0 }
    }

    /// Returns coefficient `k` of one axis as `a x0 + b x1`.
    #[inline]
    fn row(&self, k: usize, axis: usize) -> [f64; 2] {
        // r_k (x1 - x0) / 2 + (4 - k) d_k x0 + k d_(k-1) x1, sorted by x0 and x1.
        let half = 0.5 * self.r[k][axis];
        let ahead = if k < 4 { (4 - k) as f64 * self.d[k][axis] } else { 0.0 };
        let behind = if k > 0 { k as f64 * self.d[k - 1][axis] } else { 0.0 };
        [ahead - half, behind + half]
    }

    /// Returns constraint `place` of `K` of one axis as `a x0 + b x1`.
    #[inline]
    pub(super) fn constraint<const K: usize>(&self, [place, axis]: [usize; 2]) -> [f64; 2] {
        self.row(coefficient(place, K), axis)
    }

    /// Returns the value of coefficient `k` on all axes.
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

    /// Returns the largest share of its limit that any of the `K` constraints takes.
    #[inline]
    pub(super) fn most<const K: usize>(&self, x: [f64; 2]) -> f64 {
        let mut most = [0.0; N];
        for place in 0..K {
            let values = self.at(coefficient(place, K), x);
            for axis in 0..N {
                // Limits are 1 towards plus and `minus` towards minus.
                let value = values[axis];
                let size = largest(value, -value * self.per_minus[axis]);
                most[axis] = if size > most[axis] { size } else { most[axis] };
            }
        }
        most.into_iter().fold(0.0, |most, size| if size > most { size } else { most })
    }

    /// Returns the shares of their limits that the accelerations of all axes take at the start, in
    /// the middle and at the end.
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

impl<const N: usize> FeedCell<N> {
    /// Returns the parts of the Bernstein coefficients of the axis accelerations over their
    /// limits.
    #[inline]
    pub(super) fn accelerations(&self, limits: &ReciprocalLimits<N>) -> CellAccelerations<N> {
        // Divided by h once: u = (x1 - x0) / 2h and q'' = 4 d / h both have it.
        let per_length = 1.0 / self.h;
        let mut scaled = CellAccelerations::within(limits);
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

    /// Returns the same from one node to the next with the coefficients at rows alone, which are
    /// all that limits at rows need.
    #[inline]
    pub(super) fn at_rows(
        from: &AxisNode<N>,
        to: &AxisNode<N>,
        limits: &ReciprocalLimits<N>,
    ) -> CellAccelerations<N> {
        let per_length = 1.0 / (to.s - from.s);
        let mut scaled = CellAccelerations::within(limits);
        for axis in 0..N {
            let inverse = limits.acceleration.plus[axis];
            scaled.r[0][axis] = from.q[1][axis] * (inverse * per_length);
            scaled.r[4][axis] = to.q[1][axis] * (inverse * per_length);
            // q'' = 4 d / h at an end, and d has the 1 / h already.
            scaled.d[0][axis] = from.q[2][axis] * (0.25 * inverse);
            scaled.d[3][axis] = to.q[2][axis] * (0.25 * inverse);
        }
        scaled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::directional::DirectionalLimits;
    use nalgebra::Vector1;

    fn cell(rates: [f64; 5], h: f64) -> FeedCell<1> {
        FeedCell {
            h,
            rates: rates.map(Vector1::new),
            doubt: Vector1::zeros(),
            feed_rate: [1.0, 2.0],
            tip_rate: [1.0, 3.0],
        }
    }

    /// `q' = s` on [0, 1]: `q'' = 1`, acceleration `s u + x0 + 2 u s`.
    #[test]
    fn strips_are_the_acceleration_in_bernstein_form() {
        let cell = cell([0.0, 0.25, 0.5, 0.75, 1.0], 1.0);
        let acceleration = DirectionalLimits::both(Vector1::new(0.5));
        let limits = ReciprocalLimits { acceleration, ..ReciprocalLimits::none() };
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
}
