//! One cell's part in a Newton step: derivatives of its time and of the barrier of its rows.

use super::rows::{ACCELERATION, CellRows, JERK, LANES, RAISED, RowLanes, rooms, values};
use super::speed_spline::middle;
use crate::feed::numeric::largest;

/// A number for every row of every axis.
pub(super) type PerRow<const N: usize> = [[RowLanes; 2]; N];

/// Products of slack and multiplier are kept between these factors of the barrier's weight.
const LEAST: f64 = 0.2;
const MOST: f64 = 30.0;

/// Point at which a cell is evaluated.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellState {
    /// Bernstein coefficients of the squared speed.
    pub(super) x: [f64; 3],
    /// Reference of the jerk rows.
    pub(super) reference: f64,
    /// Weight of the barrier.
    pub(super) weight: f64,
}

/// Gradient and lower triangle of the Hessian in the coefficients of a cell.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CellDerivatives {
    pub(super) gradient: [f64; 3],
    /// Entries 00, 10, 11, 20, 21, 22.
    pub(super) hessian: [f64; 6],
}

impl CellDerivatives {
    /// Adds `weight d d^T` to the Hessian.
    #[inline]
    pub(super) fn add_square(&mut self, weight: f64, d: [f64; 3]) {
        let w = [weight * d[0], weight * d[1], weight * d[2]];
        let squares =
            [w[0] * d[0], w[1] * d[0], w[1] * d[1], w[2] * d[0], w[2] * d[1], w[2] * d[2]];
        for (entry, square) in self.hessian.iter_mut().zip(squares) {
            *entry += square;
        }
    }

    /// Adds `weight d` to the gradient.
    #[inline]
    pub(super) fn add_gradient(&mut self, weight: f64, d: [f64; 3]) {
        for (entry, d) in self.gradient.iter_mut().zip(d) {
            *entry += weight * d;
        }
    }

    /// Adds the time through a cell of length `h`, as `h / sqrt(x)` of the middle. Where the cell
    /// is to be slower, adds the distance of the middle from a target instead, with the same
    /// curvature.
    pub(super) fn add_time(&mut self, h: f64, x: [f64; 3], target: Option<f64>) {
        const MIDDLE: [f64; 3] = [0.25, 0.5, 0.25];
        let square = middle(x);
        let time = h / square.sqrt();
        // T = h x^(-1/2), so T' = -T / 2x and T'' = 3 T / 4x².
        let curvature = 0.75 * time / (square * square);
        let slope =
            target.map_or(-0.5 * time / square, |target| curvature * (square - target).max(0.0));
        self.add_gradient(slope, MIDDLE);
        self.add_square(curvature, MIDDLE);
    }
}

/// Reciprocal slacks of both sides of the rows of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowSlacks<const N: usize> {
    /// Of the nearer side, with the sign of the row's value.
    pub(super) near: PerRow<N>,
    /// Of the other side.
    far: PerRow<N>,
}

impl<const N: usize> Default for RowSlacks<N> {
    fn default() -> Self {
        Self { near: [[[0.0; LANES]; 2]; N], far: [[[0.0; LANES]; 2]; N] }
    }
}

/// Number of sums that run side by side, so that the processor adds them at once.
const APART: usize = 2;

#[inline]
fn add_up(p: &RowLanes, q: &RowLanes, into: &mut [f64; APART]) {
    for (k, sum) in into.iter_mut().enumerate() {
        // No `map`: built in several units it is not inlined, and this is where a plan spends its time.
        *sum += p[k] * q[k] + p[k + APART] * q[k + APART] + p[k + 2 * APART] * q[k + 2 * APART];
    }
}

/// Sums over axes and rows of one kind.
#[derive(Debug, Default)]
struct RowSums {
    hessian: [[f64; APART]; 6],
    gradient: [[f64; APART]; 3],
}

/// Sums, row by row, that multiply the slope of the rooms of jerks.
#[derive(Debug, Default)]
struct RoomSums {
    pressure: RowLanes,
    square: RowLanes,
    mixed: [RowLanes; 3],
}

/// Weights of the rows of one kind of an axis in the derivatives: sums and differences over both sides.
struct RowForces {
    pressure: RowLanes,
    force: RowLanes,
    square: RowLanes,
    difference: RowLanes,
}

/// Adds the rows of a cell and notes their slacks.
///
/// A row and its reference make two constraints `±v + e <= 1.5` (jerk) or `±v <= 1` (acceleration).
/// The multiplier of the nearer side is its own unknown (primal-dual); the other side never matters
/// much, and has the multiplier of the barrier alone.
pub(super) fn add_rows<const N: usize>(
    out: &mut CellDerivatives,
    rows: &CellRows<N>,
    state: &CellState,
    multipliers: &PerRow<N>,
    slacks: &mut RowSlacks<N>,
) {
    let scale = state.reference.sqrt();
    let room = rooms(state.x, state.reference);
    let [mut jerks, mut accelerations] = [RowSums::default(), RowSums::default()];
    let mut cross = RoomSums::default();
    let axes = rows.factors.iter().zip(multipliers);
    for ((factors, multipliers), (near, far)) in
        axes.zip(slacks.near.iter_mut().zip(&mut slacks.far))
    {
        let [jerk, acceleration] = factors;
        let mut jerk_values = values(jerk, state.x);
        for value in &mut jerk_values {
            *value *= scale;
        }
        note(&jerk_values, &room, &mut near[JERK], &mut far[JERK]);
        let forces = RowForces::new(&multipliers[JERK], &near[JERK], &far[JERK], state.weight);
        jerks.add(jerk, &forces);
        cross.add(jerk, &forces);
        let (near, far) = (&mut near[ACCELERATION], &mut far[ACCELERATION]);
        note(&values(acceleration, state.x), &[1.0; LANES], near, far);
        let forces = RowForces::new(&multipliers[ACCELERATION], near, far, state.weight);
        accelerations.add(acceleration, &forces);
    }
    jerks.hand_over(out, scale);
    accelerations.hand_over(out, 1.0);
    cross.hand_over(out, state.reference);
}

/// Computes the reciprocal slacks of rows with these values.
#[inline]
fn note(values: &RowLanes, rooms: &RowLanes, near: &mut RowLanes, far: &mut RowLanes) {
    for lane in 0..LANES {
        let size = values[lane].abs();
        let [left, other] = [rooms[lane] - size, rooms[lane] + size];
        // One division for both sides.
        let both = 1.0 / (left * other);
        near[lane] = (other * both).copysign(values[lane]);
        far[lane] = left * both;
    }
}

impl RowForces {
    #[inline]
    fn new(multipliers: &RowLanes, near: &RowLanes, far: &RowLanes, weight: f64) -> Self {
        let zero = [0.0; LANES];
        let mut forces = Self { pressure: zero, force: zero, square: zero, difference: zero };
        for lane in 0..LANES {
            let [inverse, other] = [near[lane].abs(), far[lane]];
            // The nearer side has its own multiplier, the other that of the central path, weight / slack.
            let [w, v] = [multipliers[lane] * inverse, weight * other * other];
            // A larger x takes room from both sides, so their forces add; a larger value takes slack
            // from one and gives it to the other, so theirs subtract.
            forces.pressure[lane] = weight * (inverse + other);
            forces.force[lane] = (weight * (inverse - other)).copysign(near[lane]);
            forces.square[lane] = w + v;
            forces.difference[lane] = (w - v) * 1.0_f64.copysign(near[lane]);
        }
        forces
    }
}

impl RowSums {
    /// Adds the rows of one axis.
    #[inline]
    fn add(&mut self, [a, b, c]: &[RowLanes; 3], forces: &RowForces) {
        let mut weighted = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let square = forces.square[lane];
            weighted[0][lane] = square * a[lane];
            weighted[1][lane] = square * b[lane];
            weighted[2][lane] = square * c[lane];
        }
        let [wa, wb, wc] = &weighted;
        let pairs = [(wa, a), (wb, a), (wb, b), (wc, a), (wc, b), (wc, c)];
        for (into, (p, q)) in self.hessian.iter_mut().zip(pairs) {
            add_up(p, q, into);
        }
        for (into, factor) in self.gradient.iter_mut().zip([a, b, c]) {
            add_up(&forces.force, factor, into);
        }
    }

    /// Adds the sums of rows whose values are `scale` times their factors'.
    #[inline]
    fn hand_over(&self, out: &mut CellDerivatives, scale: f64) {
        for (entry, [p, q]) in out.hessian.iter_mut().zip(&self.hessian) {
            *entry += scale * scale * (p + q);
        }
        for (entry, [p, q]) in out.gradient.iter_mut().zip(&self.gradient) {
            *entry += scale * (p + q);
        }
    }
}

impl RoomSums {
    /// Adds the rows of one axis.
    #[inline]
    fn add(&mut self, factors: &[RowLanes; 3], forces: &RowForces) {
        for lane in 0..LANES {
            self.pressure[lane] += forces.pressure[lane];
            self.square[lane] += forces.square[lane];
        }
        for (into, factor) in self.mixed.iter_mut().zip(factors) {
            for lane in 0..LANES {
                into[lane] += forces.difference[lane] * factor[lane];
            }
        }
    }

    /// Adds the part of the slopes of the rooms, `RAISED / 2 r`.
    #[inline]
    fn hand_over(&self, out: &mut CellDerivatives, reference: f64) {
        let dot = |p: &RowLanes, q: &RowLanes| {
            let mut sums = [0.0; APART];
            add_up(p, q, &mut sums);
            sums[0] + sums[1]
        };
        let half = 0.5 / reference;
        // `mixed` is of factors, which lack the root of the reference.
        let across = half * reference.sqrt();
        let [mut mixed, mut lifted] = [[[0.0; 3]; 3]; 2];
        for i in 0..3 {
            let mut raised = RAISED[i];
            for (entry, square) in raised.iter_mut().zip(&self.square) {
                *entry *= square;
            }
            for j in 0..3 {
                mixed[i][j] = across * dot(&RAISED[j], &self.mixed[i]);
                lifted[i][j] = half * half * dot(&RAISED[j], &raised);
            }
        }
        // A side has the gradient e ± v. `RowSums` holds v v^T; this adds e e^T, v e^T and e v^T.
        let entry = |i: usize, j: usize| lifted[i][j] + (mixed[i][j] + mixed[j][i]);
        let entries =
            [entry(0, 0), entry(1, 0), entry(1, 1), entry(2, 0), entry(2, 1), entry(2, 2)];
        for (into, entry) in out.hessian.iter_mut().zip(entries) {
            *into += entry;
        }
        for (into, raised) in out.gradient.iter_mut().zip(&RAISED) {
            *into += half * dot(&self.pressure, raised);
        }
    }
}

/// Computes the share of its slack that each nearer side loses in a direction `d` of the
/// coefficients, and returns the largest share of any side.
pub(super) fn turns<const N: usize>(
    rows: &CellRows<N>,
    state: &CellState,
    d: [f64; 3],
    slacks: &RowSlacks<N>,
    turns: &mut PerRow<N>,
) -> f64 {
    let mut most = [0.0; LANES];
    let mut lifts = values(&RAISED, d);
    for lift in &mut lifts {
        // Derivative of x / 2r, by which x lessens the room.
        *lift *= 0.5 / state.reference;
    }
    let kinds = [(JERK, state.reference.sqrt(), lifts), (ACCELERATION, 1.0, [0.0; LANES])];
    for axis in 0..N {
        for (kind, scale, lifts) in &kinds {
            let changes = values(&rows.factors[axis][*kind], d);
            let (near, far) = (&slacks.near[axis][*kind], &slacks.far[axis][*kind]);
            let turns = &mut turns[axis][*kind];
            for lane in 0..LANES {
                let change = scale * changes[lane];
                // `near` has the sign of the value: a change of the same sign uses up the nearer slack.
                let turn = change * near[lane] + lifts[lane] * near[lane].abs();
                let other = (lifts[lane] - change * 1.0_f64.copysign(near[lane])) * far[lane];
                turns[lane] = turn;
                most[lane] = largest(largest(turn, other), most[lane]);
            }
        }
    }
    most.into_iter().fold(0.0, |most, turn| largest(turn, most))
}

/// Returns the multiplier after a step of `length` in which its side loses `turn` of its slack,
/// whose reciprocal was `inverse`.
#[inline]
pub(super) fn bring_along(
    multiplier: f64,
    weight: f64,
    length: f64,
    inverse: f64,
    turn: f64,
) -> f64 {
    // On the central path the multiplier would be this; the step is kept near it.
    let centre = weight * inverse / (1.0 - length * turn);
    // Newton's step for multiplier * slack = weight.
    let change = weight * inverse + multiplier * turn - multiplier;
    // A falling multiplier takes the share of the step, a rising one the whole change.
    let next = multiplier + if change < 0.0 { length * change } else { change };
    let [low, high] = [centre * LEAST, centre * MOST];
    let raised = if next < low { low } else { next };
    if raised > high { high } else { raised }
}

/// Updates the multipliers of all rows after a step.
pub(super) fn update<const N: usize>(
    multipliers: &mut PerRow<N>,
    weight: f64,
    length: f64,
    slacks: &RowSlacks<N>,
    turns: &PerRow<N>,
) {
    for axis in 0..N {
        for kind in [JERK, ACCELERATION] {
            let (near, turns) = (&slacks.near[axis][kind], &turns[axis][kind]);
            let multipliers = &mut multipliers[axis][kind];
            for lane in 0..LANES {
                let inverse = near[lane].abs();
                multipliers[lane] =
                    bring_along(multipliers[lane], weight, length, inverse, turns[lane]);
            }
        }
    }
}
