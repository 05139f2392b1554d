//! Constraints of one cell on the Bernstein coefficients of its squared speed.
//!
//! With `x` quadratic, `u = x'/2` linear and `c = x''/2` constant over a cell, and `q'` a quartic,
//! * accelerations `q' u + q'' x` are polynomials of degree 5,
//! * jerks are `sqrt(x) P` with `P = q''' x + 3 q'' u + q' c` of degree 4,
//!
//! both linear in the coefficients of `x`. A polynomial stays inside the hull of its Bernstein
//! coefficients, so limits on those hold everywhere in the cell. For the factor of the jerk,
//! `1 / sqrt(x) >= (3 - x / r) / (2 sqrt r)` for every reference `r > 0` (a tangent of a convex
//! function), hence `|P| sqrt(r) / J <= (3 - x / r) / 2` is enough, again linear in `x`.

use super::speed_spline::middle;
use crate::feed::cell::FeedCell;
use crate::feed::numeric::largest;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::math;
use nalgebra::SVector;

/// Bernstein coefficients of a jerk and of an acceleration.
const JERKS: usize = 5;
const ACCELERATIONS: usize = 6;

/// Rows of an axis in one array, for the processor to work on several at once.
pub(super) const LANES: usize = 6;

/// A number for every jerk row of an axis, and one that does not count; or for every acceleration row.
pub(super) type RowLanes = [f64; LANES];

/// The two kinds of rows of an axis.
pub(super) const JERK: usize = 0;
pub(super) const ACCELERATION: usize = 1;

/// All rows of a cell over their limits.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellRows<const N: usize> {
    /// Axis by axis and kind by kind: factors of the three coefficients of `x`.
    pub(super) factors: [[[RowLanes; 3]; 2]; N],
}

/// Bernstein coefficients of degree 4 of a quadratic: lane by lane the weights of its own three.
pub(super) const RAISED: [RowLanes; 3] = [
    [1.0, 0.5, 1.0 / 6.0, 0.0, 0.0, 0.0],
    [0.0, 0.5, 4.0 / 6.0, 0.5, 0.0, 0.0],
    [0.0, 0.0, 1.0 / 6.0, 0.5, 1.0, 0.0],
];

/// `C(2, i) C(2, j) / C(4, i + j)`: product of two quadratics.
const TWO_TWO: [[f64; 3]; 3] =
    [[1.0, 0.5, 1.0 / 6.0], [0.5, 4.0 / 6.0, 0.5], [1.0 / 6.0, 0.5, 1.0]];

/// `C(3, i) C(2, j) / C(5, i + j)`: product of a cubic and a quadratic.
const THREE_TWO: [[f64; 3]; 4] =
    [[1.0, 0.4, 0.1], [0.6, 0.6, 0.3], [0.3, 0.6, 0.6], [0.1, 0.4, 1.0]];

/// Rows of a cell of length 1 for each coefficient of `q'` alone: by kind, rate and coefficient of `x`.
const UNIT: [[[RowLanes; 3]; 5]; 2] = unit();

const fn unit() -> [[[RowLanes; 3]; 5]; 2] {
    let mut unit = [[[[0.0; LANES]; 3]; 5]; 2];
    let mut rate = 0;
    while rate < 5 {
        let mut rates = [0.0; 5];
        rates[rate] = 1.0;
        let mut lane = 0;
        while lane < LANES {
            let rows = [jerk_row(&rates, lane), acceleration_row(&rates, lane)];
            let mut coefficient = 0;
            while coefficient < 3 {
                unit[JERK][rate][coefficient][lane] = rows[JERK][coefficient];
                unit[ACCELERATION][rate][coefficient][lane] = rows[ACCELERATION][coefficient];
                coefficient += 1;
            }
            lane += 1;
        }
        rate += 1;
    }
    unit
}

impl<const N: usize> CellRows<N> {
    /// Builds the rows of a cell: those of a unit cell, times its rates and limits.
    pub(super) fn new(cell: &FeedCell<N>, limits: &ReciprocalLimits<N>) -> Self {
        let jerk = limits.jerk.unwrap_or_else(SVector::zeros);
        let mut factors = [[[[0.0; LANES]; 3]; 2]; N];
        for (axis, kinds) in factors.iter_mut().enumerate() {
            // Rows of a unit cell go with h^-2 for jerks and h^-1 for accelerations.
            let scales = [jerk[axis] / (cell.h * cell.h), limits.acceleration.plus[axis] / cell.h];
            for ((unit, scale), factors) in UNIT.iter().zip(scales).zip(kinds) {
                for (unit, rates) in unit.iter().zip(&cell.rates) {
                    let rate = rates[axis] * scale;
                    for (unit, lanes) in unit.iter().zip(&mut *factors) {
                        for lane in 0..LANES {
                            lanes[lane] += unit[lane] * rate;
                        }
                    }
                }
            }
        }
        Self { factors }
    }

    /// Multiplies the limits on accelerations and on jerks.
    pub(super) fn loosen(&mut self, [accelerations, jerks]: [f64; 2]) {
        for axis in &mut self.factors {
            for (kind, by) in axis.iter_mut().zip([jerks, accelerations]) {
                kind.iter_mut().flatten().for_each(|factor| *factor /= by);
            }
        }
    }

    /// Returns the largest values of a kind on all axes, without sign.
    #[inline]
    pub(super) fn largest(&self, kind: usize, x: [f64; 3]) -> RowLanes {
        let mut most = [0.0; LANES];
        for axis in &self.factors {
            let values = values(&axis[kind], x);
            for lane in 0..LANES {
                most[lane] = largest(values[lane].abs(), most[lane]);
            }
        }
        most
    }

    /// Returns the largest accelerations, and jerks over the room that the reference leaves them:
    /// 1 is at the limit, infinite where there is no room.
    pub(super) fn shares(&self, x: [f64; 3], reference: f64) -> [f64; 2] {
        let scale = reference.sqrt();
        let [jerks, rooms] = [self.largest(JERK, x), rooms(x, reference)];
        let mut shares = [0.0_f64; 2];
        for lane in 0..JERKS {
            let room = rooms[lane];
            let share = if room > 0.0 { scale * jerks[lane] / room } else { f64::INFINITY };
            shares[1] = largest(share, shares[1]);
        }
        shares[0] = self.largest(ACCELERATION, x).into_iter().fold(0.0, |most, a| largest(a, most));
        shares
    }
}

/// Returns the values of rows for coefficients of `x`.
#[inline]
pub(super) fn values([a, b, c]: &[RowLanes; 3], x: [f64; 3]) -> RowLanes {
    let mut values = [0.0; LANES];
    for lane in 0..LANES {
        values[lane] = a[lane] * x[0] + b[lane] * x[1] + c[lane] * x[2];
    }
    values
}

/// Returns the room for jerks: `(3 - x / r) / 2`.
#[inline]
pub(super) fn rooms(x: [f64; 3], reference: f64) -> RowLanes {
    let half = 0.5 / reference;
    let mut rooms = values(&RAISED, x);
    for room in &mut rooms {
        *room = 1.5 - half * *room;
    }
    rooms
}

/// Returns a reference that leaves all jerk rows of a cell room: the value in the middle, or half
/// of the largest coefficient.
pub(super) fn reference(x: [f64; 3]) -> f64 {
    middle(x).max(0.5 * x[0].max(x[1]).max(x[2]))
}

/// Returns Bernstein coefficient `k` of `h² (q''' x + 3 q'' u + q' c)`, by the coefficients of
/// `x`; none after the last.
///
/// With `D` the rise from coefficient to coefficient of `q'` and `E` that of `D`, `q''` is `4 D /
/// h` and `q'''` is `12 E / h²`; `h u` has the coefficients `x1 - x0, x2 - x1`, `h² c` is `x0 - 2
/// x1 + x2`.
const fn jerk_row(r: &[f64; 5], k: usize) -> [f64; 3] {
    if k >= JERKS {
        return [0.0; 3];
    }
    // The term q' c.
    let mut row = [r[k], -2.0 * r[k], r[k]];
    if k < 4 {
        // The term 3 q'' u, from the rise after and before coefficient k.
        let term = 3.0 * (4 - k) as f64 * (r[k + 1] - r[k]);
        row[0] -= term;
        row[1] += term;
    }
    if k > 0 {
        let term = 3.0 * k as f64 * (r[k] - r[k - 1]);
        row[1] -= term;
        row[2] += term;
    }
    let mut j = k.saturating_sub(2);
    while j <= k && j <= 2 {
        let at = k - j;
        // The term q''' x.
        row[j] += 12.0 * TWO_TWO[at][j] * (r[at + 2] - 2.0 * r[at + 1] + r[at]);
        j += 1;
    }
    row
}

/// Returns Bernstein coefficient `k` of `h (q' u + q'' x)`; see [`jerk_row`].
const fn acceleration_row(r: &[f64; 5], k: usize) -> [f64; 3] {
    let mut row = [0.0; 3];
    // The term q' u: a quartic times a line, both neighbours in degree 5.
    if k < ACCELERATIONS - 1 {
        let term = 0.2 * (5 - k) as f64 * r[k];
        row[0] -= term;
        row[1] += term;
    }
    if k > 0 {
        let term = 0.2 * k as f64 * r[k - 1];
        row[1] -= term;
        row[2] += term;
    }
    // The term q'' x: a cubic with coefficients 4 D times a quadratic.
    let mut j = k.saturating_sub(3);
    while j <= k && j <= 2 {
        let at = k - j;
        row[j] += 4.0 * THREE_TWO[at][j] * (r[at + 1] - r[at]);
        j += 1;
    }
    row
}

/// End of a rest cell at which the axes rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RestSide {
    /// At its start: the path begins there.
    Start,
    /// At its end: the path ends there.
    End,
}

/// Returns the largest `x` at the border of a rest cell.
///
/// With `x = k σ^(4/3)` and `τ = σ / h`, velocities are below those of a linear `x`, accelerations
/// are `k h^(1/3) τ^(1/3) (2/3 q' + q'' h τ)`, jerks are `k^(3/2) (q''' σ² + 2 q'' σ + 2/9 q')`:
/// both brackets are quartics.
pub(super) fn rest_cap<const N: usize>(
    cell: &FeedCell<N>,
    limits: &ReciprocalLimits<N>,
    side: RestSide,
) -> f64 {
    let mut most = [0.0_f64; 2];
    let jerk = limits.jerk.unwrap_or_else(SVector::zeros);
    for axis in 0..N {
        let mut r = cell.rates.map(|rate| rate[axis]);
        if side == RestSide::End {
            r.reverse();
        }
        for k in 0..5 {
            // 4 D C(3, k - 1) / C(4, k) = k D: the product of τ and q'' h.
            let rise = if k > 0 { k as f64 * (r[k] - r[k - 1]) } else { 0.0 };
            // 12 E C(2, k - 2) / C(4, k): the product of τ² and q''' h².
            let bend = match k {
                2 => 2.0 * (r[2] - 2.0 * r[1] + r[0]),
                3 => 6.0 * (r[3] - 2.0 * r[2] + r[1]),
                4 => 12.0 * (r[4] - 2.0 * r[3] + r[2]),
                _ => 0.0,
            };
            let acceleration = (2.0 / 3.0 * r[k] + rise).abs() * limits.acceleration.plus[axis];
            let change = (bend + 2.0 * rise + 2.0 / 9.0 * r[k]).abs() * jerk[axis];
            most = [most[0].max(acceleration), most[1].max(change)];
        }
    }
    let [start, end] = cell.caps(limits);
    let speed = if side == RestSide::End { start } else { end };
    // With k = x / h^(4/3), accelerations are at most x / h and jerks x^(3/2) / h² times these.
    speed.min(cell.h / most[0]).min(math::cbrt(cell.h * cell.h / most[1]).powi(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::directional::DirectionalLimits;
    use nalgebra::Vector1;

    fn limits() -> ReciprocalLimits<1> {
        let one = Vector1::new(1.0);
        ReciprocalLimits {
            acceleration: DirectionalLimits::both(one),
            jerk: Some(one),
            ..ReciprocalLimits::none()
        }
    }

    fn cell(rates: [f64; 5], h: f64) -> FeedCell<1> {
        FeedCell {
            h,
            rates: rates.map(Vector1::new),
            doubt: Vector1::zeros(),
            feed_rate: [0.0; 2],
            tip_rate: [0.0; 2],
        }
    }

    /// Value of a polynomial from its Bernstein coefficients.
    fn bernstein(c: &[f64], t: f64) -> f64 {
        let mut rest = c.to_vec();
        while rest.len() > 1 {
            rest = rest.windows(2).map(|w| w[0] + t * (w[1] - w[0])).collect();
        }
        rest[0]
    }

    #[test]
    fn rows_are_acceleration_and_jerk_in_bernstein_form() {
        let (r, h, x) = ([1.0, -0.5, 0.7, 2.0, 1.3], 0.6, [2.0, 3.5, 1.2]);
        let rows = CellRows::new(&cell(r, h), &limits());
        let [jerks, accelerations] = rows.factors[0].map(|factors| values(&factors, x));
        let u = [(x[1] - x[0]) / h, (x[2] - x[1]) / h];
        let c = (u[1] - u[0]) / h;
        let [d, e] = [1, 2].map(|order| {
            let mut list = r.to_vec();
            for k in 0..order {
                list = list.windows(2).map(|w| (w[1] - w[0]) * f64::from(4 - k) / h).collect();
            }
            list
        });
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let [rate, curvature, third] = [bernstein(&r, t), bernstein(&d, t), bernstein(&e, t)];
            let [square, u] = [bernstein(&x, t), bernstein(&u, t)];
            let jerk = third * square + 3.0 * curvature * u + rate * c;
            let acceleration = rate * u + curvature * square;
            assert!((bernstein(&jerks[..JERKS], t) - jerk).abs() < 1e-11, "jerk at {t}");
            assert!((bernstein(&accelerations, t) - acceleration).abs() < 1e-12, "at {t}");
        }
    }

    /// `q' = 1 + s` over 0.5 from rest: at the cap, the largest of both is at its limit.
    #[test]
    fn the_cap_of_a_rest_cell_is_reached_and_kept() {
        let rates = [1.0, 1.125, 1.25, 1.375, 1.5];
        for (a, j) in [(1.0, 0.1), (0.1, 1.0)] {
            let limits = ReciprocalLimits {
                acceleration: DirectionalLimits::both(Vector1::new(a)),
                jerk: Some(Vector1::new(j)),
                ..ReciprocalLimits::none()
            };
            let cap = rest_cap(&cell(rates, 0.5), &limits, RestSide::Start);
            let k = cap / 0.5_f64.powf(4.0 / 3.0);
            let mut most = 0.0_f64;
            for step in 1..=1000 {
                let s = 0.5 * f64::from(step) / 1000.0;
                let [x, u] = [k * s.powf(4.0 / 3.0), 2.0 / 3.0 * k * s.cbrt()];
                let c = 2.0 / 9.0 * k * s.powf(-2.0 / 3.0);
                let acceleration = (1.0 + s) * u + x;
                let jerk = x.sqrt() * (3.0 * u + (1.0 + s) * c);
                most = most.max(acceleration * a).max(jerk * j);
            }
            assert!(most <= 1.0 + 1e-12 && most > 0.98, "{most}");
            let mirrored = cell([1.5, 1.375, 1.25, 1.125, 1.0], 0.5);
            assert!((rest_cap(&mirrored, &limits, RestSide::End) - cap).abs() < 1e-14);
        }
    }

    #[test]
    fn the_tangent_of_the_jerk_is_on_the_safe_side() {
        let x = [1.0, 1.8, 2.0];
        let r = reference(x);
        for t in [0.0, 0.25, 0.5, 0.75, 1.0] {
            assert!(bernstein(&rooms(x, r)[..JERKS], t) <= (r / bernstein(&x, t)).sqrt() + 1e-15);
        }
    }
}
