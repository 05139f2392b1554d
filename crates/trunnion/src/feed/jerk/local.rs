//! One cell's part in a Newton step: derivatives of its time and of the barrier of its rows.

use super::rows::{Factors, JERKS, RAISED, ROWS, Rows, room};
use super::spline::middle;

/// Multipliers of the nearer side of every row.
pub(super) type PerRow<const N: usize> = [[f64; N]; ROWS];

/// Products of slack and multiplier are kept within these factors of the barrier's weight.
const LEAST: f64 = 0.2;
const MOST: f64 = 30.0;

/// What a cell is evaluated at.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    /// Bernstein coefficients of the squared speed.
    pub(super) x: [f64; 3],
    /// Reference of the jerk rows.
    pub(super) reference: f64,
    /// Weight of the barrier.
    pub(super) weight: f64,
}

/// Gradient and lower triangle of the Hessian in the coefficients of a cell.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Derivatives {
    pub(super) gradient: [f64; 3],
    /// Entries 00, 10, 11, 20, 21, 22.
    pub(super) hessian: [f64; 6],
}

impl Derivatives {
    /// Adds `weight d d^T` to the Hessian.
    #[inline]
    pub(super) fn add_square(&mut self, weight: f64, d: [f64; 3]) {
        let w = d.map(|entry| weight * entry);
        let squares =
            [w[0] * d[0], w[1] * d[0], w[1] * d[1], w[2] * d[0], w[2] * d[1], w[2] * d[2]];
        for (entry, square) in self.hessian.iter_mut().zip(squares) {
            *entry += square;
        }
    }

    #[inline]
    pub(super) fn add_gradient(&mut self, weight: f64, d: [f64; 3]) {
        for (entry, d) in self.gradient.iter_mut().zip(d) {
            *entry += weight * d;
        }
    }

    /// Adds the time through a cell of length `h`, as `h / sqrt(x)` of the middle.
    pub(super) fn add_time(&mut self, h: f64, x: [f64; 3]) {
        const MIDDLE: [f64; 3] = [0.25, 0.5, 0.25];
        let square = middle(x);
        let time = h / square.sqrt();
        self.add_gradient(-0.5 * time / square, MIDDLE);
        self.add_square(0.75 * time / (square * square), MIDDLE);
    }
}

/// Sums over the axes of one row.
#[derive(Debug, Clone, Copy)]
struct Sums<const N: usize> {
    hessian: [[f64; N]; 6],
    gradient: [[f64; N]; 3],
}

/// Adds the rows of a cell and notes the reciprocal slack of each nearer side, with the sign of the
/// row's value.
///
/// A row and its reference make two constraints `±v + e <= 1.5` (jerk) or `±v <= 1` (acceleration).
/// The multiplier of the nearer side is its own unknown (primal-dual); the other side never matters
/// much, and has the multiplier of the barrier alone.
pub(super) fn add_rows<const N: usize>(
    out: &mut Derivatives,
    rows: &Rows<N>,
    state: &State,
    multipliers: &PerRow<N>,
    inverses: &mut PerRow<N>,
) {
    let mut sums = Sums { hessian: [[0.0; N]; 6], gradient: [[0.0; N]; 3] };
    let scale = state.reference.sqrt();
    for row in 0..ROWS {
        let jerk = row < JERKS;
        let [scale, room] =
            if jerk { [scale, room(row, state.x, state.reference)] } else { [1.0, 1.0] };
        let terms = Terms { scale, room, weight: state.weight };
        let values = rows.values(row, state.x);
        let cross =
            sums.add(&rows.factors[row], &values, &terms, (&multipliers[row], &mut inverses[row]));
        if jerk {
            let lift = RAISED[row].map(|share| 0.5 * share / state.reference);
            out.add_gradient(cross.gradient, lift);
            out.add_square(cross.square, lift);
            let m = cross.mixed;
            let l = lift;
            let mixed = [
                2.0 * m[0] * l[0],
                m[1] * l[0] + m[0] * l[1],
                2.0 * m[1] * l[1],
                m[2] * l[0] + m[0] * l[2],
                m[2] * l[1] + m[1] * l[2],
                2.0 * m[2] * l[2],
            ];
            for (entry, mixed) in out.hessian.iter_mut().zip(mixed) {
                *entry += mixed;
            }
        }
    }
    for (entry, sum) in out.hessian.iter_mut().zip(&sums.hessian) {
        *entry += sum.iter().sum::<f64>();
    }
    for (entry, sum) in out.gradient.iter_mut().zip(&sums.gradient) {
        *entry += sum.iter().sum::<f64>();
    }
}

#[derive(Debug, Clone, Copy)]
struct Terms {
    scale: f64,
    room: f64,
    weight: f64,
}

/// Sums of one row that meet the slope of its room.
#[derive(Debug, Clone, Copy)]
struct Cross {
    gradient: f64,
    square: f64,
    mixed: [f64; 3],
}

impl<const N: usize> Sums<N> {
    #[inline]
    fn add(
        &mut self,
        factors: &Factors<N>,
        values: &[f64; N],
        terms: &Terms,
        (multipliers, inverses): (&[f64; N], &mut [f64; N]),
    ) -> Cross {
        let Terms { scale, room, weight } = *terms;
        let [mut sum, mut difference, mut force, mut pressure] = [[0.0; N]; 4];
        for axis in 0..N {
            let value = scale * values[axis];
            let size = value.abs();
            let [near, far] = [room - size, room + size];
            let both = 1.0 / (near * far);
            let [near, far] = [far * both, near * both];
            inverses[axis] = near.copysign(value);
            let [w, v] = [multipliers[axis] * near, weight * far * far];
            sum[axis] = w + v;
            difference[axis] = (w - v) * 1.0_f64.copysign(value);
            force[axis] = weight * (near - far).copysign(value);
            pressure[axis] = weight * (near + far);
        }
        let [a, b, c] = factors;
        for axis in 0..N {
            let w = sum[axis] * scale * scale;
            let [wa, wb, wc] = [w * a[axis], w * b[axis], w * c[axis]];
            self.hessian[0][axis] += wa * a[axis];
            self.hessian[1][axis] += wb * a[axis];
            self.hessian[2][axis] += wb * b[axis];
            self.hessian[3][axis] += wc * a[axis];
            self.hessian[4][axis] += wc * b[axis];
            self.hessian[5][axis] += wc * c[axis];
            let f = force[axis] * scale;
            self.gradient[0][axis] += f * a[axis];
            self.gradient[1][axis] += f * b[axis];
            self.gradient[2][axis] += f * c[axis];
        }
        let mut cross = Cross { gradient: 0.0, square: 0.0, mixed: [0.0; 3] };
        for axis in 0..N {
            cross.gradient += pressure[axis];
            cross.square += sum[axis];
            let d = difference[axis] * scale;
            cross.mixed[0] += d * a[axis];
            cross.mixed[1] += d * b[axis];
            cross.mixed[2] += d * c[axis];
        }
        cross
    }
}

/// Share of its slack each nearer side loses in a direction `d` of the coefficients, and the largest
/// share of any side.
pub(super) fn turns<const N: usize>(
    rows: &Rows<N>,
    state: &State,
    d: [f64; 3],
    inverses: &PerRow<N>,
    turns: &mut PerRow<N>,
) -> f64 {
    let mut most = [0.0_f64; N];
    let scale = state.reference.sqrt();
    for row in 0..ROWS {
        let values = rows.values(row, d);
        let [scale, room, lift] = if row < JERKS {
            let [a, b, c] = RAISED[row];
            let lift = 0.5 * (a * d[0] + b * d[1] + c * d[2]) / state.reference;
            [scale, room(row, state.x, state.reference), lift]
        } else {
            [1.0, 1.0, 0.0]
        };
        for axis in 0..N {
            let inverse = inverses[row][axis];
            let change = scale * values[axis];
            let near = change * inverse + lift * inverse.abs();
            let far =
                (lift - change.copysign(change * inverse)) / (2.0 * room - 1.0 / inverse.abs());
            turns[row][axis] = near;
            most[axis] = most[axis].max(near).max(far);
        }
    }
    most.into_iter().fold(0.0, f64::max)
}

/// Multiplier after a step of `length` in which its side loses `turn` of its slack, whose reciprocal
/// was `inverse`.
#[inline]
pub(super) fn bring_along(
    multiplier: f64,
    weight: f64,
    length: f64,
    inverse: f64,
    turn: f64,
) -> f64 {
    let centre = weight * inverse / (1.0 - length * turn);
    let change = weight * inverse + multiplier * turn - multiplier;
    let next = multiplier + if change < 0.0 { length * change } else { change };
    next.max(centre * LEAST).min(centre * MOST)
}

/// Multipliers of all rows after a step.
pub(super) fn update<const N: usize>(
    multipliers: &mut PerRow<N>,
    weight: f64,
    length: f64,
    inverses: &PerRow<N>,
    turns: &PerRow<N>,
) {
    for row in 0..ROWS {
        for axis in 0..N {
            let [inverse, turn] = [inverses[row][axis].abs(), turns[row][axis]];
            let multiplier = &mut multipliers[row][axis];
            *multiplier = bring_along(*multiplier, weight, length, inverse, turn);
        }
    }
}
