//! Newton steps on stretches of the spline.
//!
//! The time is convex in the controls and the rows are linear. With a logarithmic barrier for the
//! rows, a Newton step is one banded system. The row that is reached first limits the length of a
//! step; one length for a whole path would be the shortest of all, and a long path would stall.
//! Each stretch therefore has its own, with everything outside it held. Stretches of the next
//! sweep lie across the borders of this one. Every step keeps all limits everywhere.

use super::band_matrix::BandMatrix;
use super::derivatives::{
    CellDerivatives, CellState, PerRow, RowSlacks, add_rows, bring_along, turns, update,
};
use super::rows::{CellRows, JERK, LANES, reference, rooms};
use super::slow_down::SlowDown;
use super::speed_caps::SpeedCaps;
use super::speed_spline::{ControlWeights, FeasibleSpline, SpeedSpline, middle};
use crate::feed::grid::FeedGrid;
use crate::feed::numeric::smallest;
use crate::feed::plan::LimitRatios;
use crate::feed::reciprocal::ReciprocalLimits;
use std::ops::Range;

/// Share of the distance to the first limiting row that a step takes.
const TO_BORDER: f64 = 0.97;
/// A control keeps at least this share of itself in a step.
const KEEP: f64 = 0.2;
/// A new reference may leave a cell's rows this share of the room they had.
const ROOM_KEPT: f64 = 0.3;

/// Interior-point solver: a spline inside its limits that becomes faster step by step.
#[derive(Debug)]
pub(super) struct BarrierSolver<'a, const N: usize> {
    grid: &'a FeedGrid<N>,
    limits: &'a ReciprocalLimits<N>,
    pub(super) caps: SpeedCaps,
    /// Cells that are faster than wanted, while braking.
    pub(super) slower: Option<SlowDown>,
    pub(super) spline: SpeedSpline,
    pub(super) references: Vec<f64>,
    multipliers: Vec<PerRow<N>>,
    cap_multipliers: Vec<[f64; 2]>,
    /// Rows of all cells: they are needed in every sweep.
    rows: Vec<CellRows<N>>,
    /// The rows are those of other limits than `limits`.
    is_loose: bool,
    /// Factor of the barrier's weight for caps.
    pub(super) caution: f64,
    work: StretchWork<N>,
}

/// Buffers of one stretch, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct StretchWork<const N: usize> {
    /// Controls, and cells they have a part in.
    range: Range<usize>,
    cells: Range<usize>,
    slacks: Vec<RowSlacks<N>>,
    turns: Vec<PerRow<N>>,
    /// Of the barrier.
    weights: Vec<f64>,
    shapes: Vec<ControlWeights>,
    band: BandMatrix,
}

impl<'a, const N: usize> BarrierSolver<'a, N> {
    /// Starts from a spline within all limits; `loose` multiplies the limits, cell by cell.
    pub(super) fn new(
        grid: &'a FeedGrid<N>,
        limits: &'a ReciprocalLimits<N>,
        caps: SpeedCaps,
        loose: &[[f64; 2]],
        spline: SpeedSpline,
    ) -> Self {
        let cells = spline.len();
        let mut rows: Vec<CellRows<N>> =
            grid.cells.iter().map(|cell| CellRows::new(cell, limits)).collect();
        rows.iter_mut().zip(loose).for_each(|(rows, loose)| rows.loosen(*loose));
        let mut solver = Self {
            grid,
            limits,
            caps,
            slower: None,
            references: vec![0.0; cells],
            multipliers: vec![[[[0.0; LANES]; 2]; N]; cells],
            cap_multipliers: vec![[0.0; 2]; cells],
            rows,
            is_loose: !loose.is_empty(),
            caution: 1.0,
            work: StretchWork::default(),
            spline,
        };
        for cell in solver.spline.cells() {
            solver.references[cell] = reference(solver.spline.coefficients(cell));
        }
        solver
    }

    /// Keeps references of an earlier solution where they leave more room.
    pub(super) fn keep_references(&mut self, earlier: &[f64]) {
        for cell in self.spline.cells() {
            let x = self.spline.coefficients(cell);
            let rows = &self.rows[cell];
            let jerk = |reference: f64| rows.shares(x, reference)[1];
            let kept = earlier.get(cell).copied().unwrap_or_default();
            if kept > 0.0 && jerk(kept) < jerk(self.references[cell]) {
                self.references[cell] = kept;
            }
        }
    }

    /// Sets the multipliers to those of the central path: `weight` is the barrier's, as a share of
    /// each cell's time.
    pub(super) fn centre(&mut self, weight: f64, range: Range<usize>) {
        for cell in range {
            let state = self.state(cell, &self.spline.weights(cell), weight * self.time(cell));
            let rows = &self.rows[cell];
            let mut slacks = RowSlacks::default();
            let none = [[[0.0; LANES]; 2]; N];
            add_rows(&mut CellDerivatives::default(), rows, &state, &none, &mut slacks);
            self.multipliers[cell] = slacks
                .near
                .map(|kinds| kinds.map(|row| row.map(|inverse| state.weight * inverse.abs())));
            self.centre_caps(weight, cell);
        }
    }

    /// Sets the multipliers of the caps of one cell.
    pub(super) fn centre_caps(&mut self, weight: f64, cell: usize) {
        let weight = self.caution * weight * self.time(cell);
        let slacks = self.cap_slacks(cell, self.spline.coefficients(cell));
        self.cap_multipliers[cell] = slacks.map(|slack| weight / slack);
    }

    /// Starts again from another spline, with the references that suit it.
    pub(super) fn restart(&mut self, start: FeasibleSpline) {
        self.spline = start.spline;
        for cell in self.spline.cells() {
            self.references[cell] = reference(self.spline.coefficients(cell));
        }
        self.keep_references(&start.references);
    }

    /// Returns upper bounds of all ratios, everywhere on the piece.
    pub(super) fn bounds(&self) -> LimitRatios {
        let last = self.spline.len() - 1;
        let rests = self.spline.ends.map(|end| !end.moves());
        let [mut square, mut acceleration, mut jerk] = [self.caps.given, 0.0, 0.0];
        for cell in self.spline.cells() {
            let x = self.spline.coefficients(cell);
            let strict = self.is_loose.then(|| CellRows::new(&self.grid.cells[cell], self.limits));
            let rows = strict.as_ref().unwrap_or(&self.rows[cell]);
            let [a, j] = rows.shares(x, self.references[cell]);
            acceleration = acceleration.max(a);
            jerk = jerk.max(j);
            let control = x[1] / self.caps.control[cell];
            square = square.max(control).max(x[2] / self.caps.row[cell + 1]);
            if (cell == 1 && rests[0]) || (cell + 1 == last && rests[1]) {
                // The rest cell next to it: its accelerations go with x, its jerks with x^(3/2).
                acceleration = acceleration.max(control);
                jerk = jerk.max(control * control.sqrt());
            }
        }
        // Caps bound squared speeds, so the ratio of speeds is the root.
        LimitRatios { velocity: square.sqrt(), acceleration, jerk: Some(jerk) }
    }

    /// Returns the point at which a cell is evaluated.
    fn state(&self, cell: usize, shape: &ControlWeights, weight: f64) -> CellState {
        let x = self.spline.coefficients_with(shape, cell);
        CellState { x, reference: self.references[cell], weight }
    }

    /// Returns the time through a cell, accurate enough to weigh it.
    fn time(&self, cell: usize) -> f64 {
        self.spline.lengths[cell] / middle(self.spline.coefficients(cell)).sqrt()
    }

    /// Returns the unused share of the caps of a cell's control and of the row at its end.
    fn cap_slacks(&self, cell: usize, x: [f64; 3]) -> [f64; 2] {
        [1.0 - x[1] / self.caps.control[cell], 1.0 - x[2] / self.caps.row[cell + 1]]
    }

    /// Sweeps once over the piece with stretches of `size` cells, the first of them of `first`:
    /// `steps` Newton steps on each with the barrier's `weight`.
    pub(super) fn sweep(&mut self, weight: f64, steps: usize, [first, size]: [usize; 2]) {
        let last = self.spline.len() - 1;
        self.sweep_over(1..last, weight, steps, [first, size]);
    }

    /// Sweeps over a range of controls.
    pub(super) fn sweep_over(
        &mut self,
        range: Range<usize>,
        weight: f64,
        steps: usize,
        [first, size]: [usize; 2],
    ) {
        let last = range.end;
        let mut from = range.start;
        let mut to = (from + first).min(last);
        while from < last {
            self.stretch(from..to, weight, steps);
            (from, to) = (to, (to + size).min(last));
        }
    }

    /// Takes Newton steps on the controls of a range.
    fn stretch(&mut self, range: Range<usize>, weight: f64, steps: usize) {
        let mut work = self.open(range);
        self.weigh(&mut work, |_| weight);
        for _ in 0..steps {
            if self.step(&mut work).is_none() {
                break;
            }
        }
        self.close(work);
    }

    /// Prepares steps on the controls of a range, all but the weights. [`Self::close`] takes the
    /// buffers back.
    pub(super) fn open(&mut self, range: Range<usize>) -> StretchWork<N> {
        // Cells that the controls of the range have a part in.
        let all = self.spline.cells();
        let cells = (range.start - 1).max(all.start)..(range.end + 1).min(all.end);
        let mut work = std::mem::take(&mut self.work);
        work.shapes.clear();
        for cell in cells.clone() {
            work.shapes.push(self.spline.weights(cell));
        }
        work.slacks.resize(cells.len(), RowSlacks::default());
        work.turns.resize(cells.len(), [[[0.0; LANES]; 2]; N]);
        (work.range, work.cells) = (range, cells);
        work
    }

    /// Sets the weights of the barrier from shares of the times of the cells.
    pub(super) fn weigh(&self, work: &mut StretchWork<N>, share: impl Fn(usize) -> f64) {
        work.weights.clear();
        work.weights.extend(work.cells.clone().map(|cell| share(cell) * self.time(cell)));
    }

    /// Takes back the buffers of [`Self::open`].
    pub(super) fn close(&mut self, work: StretchWork<N>) {
        self.work = work;
    }

    /// Returns the time through some cells, accurate enough to compare.
    pub(super) fn time_through(&self, cells: Range<usize>) -> f64 {
        cells.map(|cell| self.time(cell)).sum()
    }

    /// Takes one step and returns its length, 1 being the whole step; `None` if rounding leaves
    /// none.
    pub(super) fn step(&mut self, work: &mut StretchWork<N>) -> Option<f64> {
        let (range, cells) = (work.range.clone(), work.cells.clone());
        // Step 1: gradient and Hessian of the time and the barrier, cell by cell.
        work.band.reset(range.len());
        for (index, cell) in cells.clone().enumerate() {
            let state = self.state(cell, &work.shapes[index], work.weights[index]);
            let mut out = CellDerivatives::default();
            let target = self.slower.as_ref().and_then(|slower| slower.target(cell));
            out.add_time(self.spline.lengths[cell], state.x, target);
            add_rows(
                &mut out,
                &self.rows[cell],
                &state,
                &self.multipliers[cell],
                &mut work.slacks[index],
            );
            self.add_caps(&mut out, cell, &state);
            Self::scatter(&out, cell, &work.shapes[index], &range, &mut work.band);
        }
        self.add_rest(&range, &mut work.band);
        // Step 2: the Newton direction.
        if !work.band.solve() {
            return None;
        }
        // Step 3: as far along it as the nearest row allows.
        let length = self.length(&range, &cells, work);
        self.advance(length, &range, &cells, work);
        Some(length)
    }

    /// Adds the barrier of the caps of a cell.
    fn add_caps(&self, out: &mut CellDerivatives, cell: usize, state: &CellState) {
        let caps = [self.caps.control[cell], self.caps.row[cell + 1]];
        let slacks = self.cap_slacks(cell, state.x);
        for side in 0..2 {
            let mut d = [0.0; 3];
            d[1 + side] = 1.0 / caps[side];
            out.add_gradient(self.caution * state.weight / slacks[side], d);
            out.add_square(self.cap_multipliers[cell][side] / slacks[side], d);
        }
    }

    /// Adds a cell's derivatives to the system of the controls of a range.
    fn scatter(
        out: &CellDerivatives,
        cell: usize,
        weights: &ControlWeights,
        range: &Range<usize>,
        band: &mut BandMatrix,
    ) {
        // Coefficients as combinations of the controls before, here and after.
        let [s, e] = [weights.start, weights.end];
        let columns = [[s[0], 0.0, 0.0], [s[1], 1.0, e[0]], [0.0, 0.0, e[1]]];
        let h = &out.hessian;
        let full = [[h[0], h[1], h[3]], [h[1], h[2], h[4]], [h[3], h[4], h[5]]];
        // Chain rule: with `C` the columns, add `C^T H C` and `C^T g`; first `H C`.
        let mut times = [[0.0; 3]; 3];
        for (times, c) in times.iter_mut().zip(&columns) {
            for (product, row) in times.iter_mut().zip(&full) {
                *product = row[0] * c[0] + row[1] * c[1] + row[2] * c[2];
            }
        }
        for i in 0..3 {
            let Some(row) = (cell + i).checked_sub(1 + range.start).filter(|r| *r < range.len())
            else {
                continue;
            };
            let c = columns[i];
            let g = &out.gradient;
            // The right side of a Newton system is the negative gradient.
            band.right[row] -= c[0] * g[0] + c[1] * g[1] + c[2] * g[2];
            for j in 0..=i.min(row) {
                let product = &times[i - j];
                band.rows[row][j] += c[0] * product[0] + c[1] * product[1] + c[2] * product[2];
            }
        }
    }

    /// Adds the times of the rest cells, `3 h / v` at their borders.
    fn add_rest(&self, range: &Range<usize>, band: &mut BandMatrix) {
        let last = self.spline.len() - 1;
        for (cell, rest) in [(1, 0), (last - 1, last)] {
            let Some(row) = cell.checked_sub(range.start).filter(|row| *row < range.len()) else {
                continue;
            };
            if self.spline.ends[usize::from(rest > 0)].moves() {
                continue;
            }
            let x = self.spline.coefficients(cell);
            let border = if rest == 0 { x[0] } else { x[2] };
            // The border is a fixed share of the control, so the time goes with control^(-1/2).
            let time = 3.0 * self.spline.lengths[rest] / border.sqrt();
            let control = self.spline.controls[cell];
            band.right[row] += 0.5 * time / control;
            band.rows[row][0] += 0.75 * time / (control * control);
        }
    }

    /// Returns the change of the coefficients of a cell in the direction found.
    fn direction(
        cell: usize,
        shape: &ControlWeights,
        range: &Range<usize>,
        band: &BandMatrix,
    ) -> [f64; 3] {
        let at = |control: usize| {
            if range.contains(&control) { band.right[control - range.start] } else { 0.0 }
        };
        shape.apply([at(cell.wrapping_sub(1)), at(cell), at(cell + 1)])
    }

    /// Returns the longest step that keeps all rows, at most 1.
    fn length(&self, range: &Range<usize>, cells: &Range<usize>, work: &mut StretchWork<N>) -> f64 {
        // Largest share of its slack that anything loses in a whole step; the step is scaled by it.
        // No control may lose more than 1 - KEEP of itself, and no row more than TO_BORDER of its
        // slack.
        let mut most: f64 = TO_BORDER;
        for (control, change) in range.clone().zip(&work.band.right) {
            let fall = -change / self.spline.controls[control];
            most = most.max(fall * TO_BORDER / (1.0 - KEEP));
        }
        for (index, cell) in cells.clone().enumerate() {
            let d = Self::direction(cell, &work.shapes[index], range, &work.band);
            let state = self.state(cell, &work.shapes[index], work.weights[index]);
            let turn =
                turns(&self.rows[cell], &state, d, &work.slacks[index], &mut work.turns[index]);
            let slacks = self.cap_slacks(cell, state.x);
            let control = d[1] / (self.caps.control[cell] * slacks[0]);
            let row = d[2] / (self.caps.row[cell + 1] * slacks[1]);
            most = most.max(turn).max(control).max(row);
        }
        TO_BORDER / most
    }

    /// Takes the step, brings multipliers along, and moves references after the new coefficients.
    fn advance(
        &mut self,
        length: f64,
        range: &Range<usize>,
        cells: &Range<usize>,
        work: &StretchWork<N>,
    ) {
        for (index, cell) in cells.clone().enumerate() {
            let weight = work.weights[index];
            let (slacks, turns) = (&work.slacks[index], &work.turns[index]);
            update(&mut self.multipliers[cell], weight, length, slacks, turns);
            let d = Self::direction(cell, &work.shapes[index], range, &work.band);
            let x = self.spline.coefficients_with(&work.shapes[index], cell);
            let slacks = self.cap_slacks(cell, x);
            let caps = [self.caps.control[cell], self.caps.row[cell + 1]];
            let caution = self.caution;
            for side in 0..2 {
                let inverse = 1.0 / slacks[side];
                let turn = d[1 + side] / caps[side] * inverse;
                let multiplier = &mut self.cap_multipliers[cell][side];
                *multiplier = bring_along(*multiplier, caution * weight, length, inverse, turn);
            }
        }
        for (control, change) in range.clone().zip(&work.band.right) {
            self.spline.controls[control] += length * change;
        }
        for (index, cell) in cells.clone().enumerate() {
            self.move_reference(cell, &work.shapes[index]);
        }
    }

    /// Takes the reference that suits the coefficients, unless it leaves some row much less room.
    fn move_reference(&mut self, cell: usize, shape: &ControlWeights) {
        let x = self.spline.coefficients_with(shape, cell);
        let [old, new] = [self.references[cell], reference(x)];
        let values = self.rows[cell].largest(JERK, x);
        let roots = [old.sqrt(), new.sqrt()];
        let [rooms_before, rooms_after] = [rooms(x, old), rooms(x, new)];
        let [mut before, mut after] = [f64::INFINITY; 2];
        for lane in 0..LANES {
            before = smallest(rooms_before[lane] - roots[0] * values[lane], before);
            after = smallest(rooms_after[lane] - roots[1] * values[lane], after);
        }
        // Any reference is valid for the rows; a worse one would only shorten the next steps.
        if after > ROOM_KEPT * before {
            self.references[cell] = new;
        }
    }
}
