//! Backward and forward pass over one piece.

use super::cell::Cell;
use super::{Ends, Reciprocals, strip};
use crate::types::{Law, SchedulePiece};

/// Rows of a piece and the cells between them.
#[derive(Debug, Clone)]
pub(super) struct Grid<const N: usize> {
    /// Path parameter of each row.
    pub(super) s: Vec<f64>,
    /// One less than rows.
    pub(super) cells: Vec<Cell<N>>,
}

/// Squared speed `x = (ds/dt)²` at each row, linear in between.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Profile {
    pub(super) x: Vec<f64>,
}

impl Profile {
    /// The fastest profile: first what can still stop in time, then as fast as possible. Its ends are
    /// slower than asked for where that cannot be had.
    pub(super) fn fastest<const N: usize>(
        grid: &Grid<N>,
        limits: &Reciprocals<N>,
        ends: &Ends,
    ) -> Self {
        let caps = caps(grid, |cell| cell.caps(limits));
        Self::through::<N, 5>(grid, caps, ends, limits)
    }

    /// As [`Profile::fastest`] by the limits at rows alone: TOPP-RA's interpolation scheme.
    pub(super) fn fastest_at_rows<const N: usize>(
        grid: &Grid<N>,
        limits: &Reciprocals<N>,
        ends: &Ends,
    ) -> Self {
        let caps = caps(grid, |cell| cell.end_caps(limits));
        Self::through::<N, 2>(grid, caps, ends, limits)
    }

    /// Both passes below `x`, with `K` constraints an axis and cell.
    fn through<const N: usize, const K: usize>(
        grid: &Grid<N>,
        mut x: Vec<f64>,
        ends: &Ends,
        limits: &Reciprocals<N>,
    ) -> Self {
        if let Some(last) = x.last_mut() {
            *last = last.min(ends.end);
        }
        let mut guess = None;
        for (row, cell) in grid.cells.iter().enumerate().rev() {
            let cell = cell.accelerations(limits);
            x[row] = strip::backward::<N, K>(&cell, x[row], x[row + 1], &mut guess).0;
        }
        if let Some(first) = x.first_mut() {
            *first = first.min(ends.start);
        }
        guess = None;
        for (row, cell) in grid.cells.iter().enumerate() {
            let cell = cell.accelerations(limits);
            x[row + 1] = strip::forward::<N, K>(&cell, x[row], x[row + 1], &mut guess);
        }
        Self { x }
    }

    /// `x` at both ends of a cell.
    pub(super) fn ends(&self, cell: usize) -> [f64; 2] {
        [self.x[cell], self.x[cell + 1]]
    }

    /// Time through a cell \[s\]: `2 h / (sqrt x0 + sqrt x1)`, exact for constant `d²s/dt²`.
    pub(super) fn time<const N: usize>(&self, grid: &Grid<N>, cell: usize) -> f64 {
        let [from, to] = self.ends(cell);
        let sum = from.sqrt() + to.sqrt();
        // Only a piece on which nothing moves is at rest at both ends of a cell.
        if sum > 0.0 { 2.0 * grid.cells[cell].h / sum } else { 0.0 }
    }

    pub(super) fn schedule<const N: usize>(&self, grid: &Grid<N>) -> SchedulePiece {
        let mut t = Vec::with_capacity(self.x.len());
        let mut acceleration = Vec::with_capacity(self.x.len());
        let mut now = 0.0;
        for (index, cell) in grid.cells.iter().enumerate() {
            let [from, to] = self.ends(index);
            t.push(now);
            now += self.time(grid, index);
            acceleration.push((to - from) / (2.0 * cell.h));
        }
        t.push(now);
        acceleration.push(acceleration.last().copied().unwrap_or(0.0));
        let speed = self.x.iter().map(|x| x.sqrt()).collect();
        SchedulePiece { s: grid.s.clone(), t, speed, acceleration, law: Law::Steps }
    }
}

/// Largest `x` of each row from the speed limits of the cells on both sides.
///
/// Where no limit binds at all (axes and programmed point stand still) the row is passed no faster
/// than the fastest other one; where none binds anywhere, nothing moves, and `x` is 0 throughout.
fn caps<const N: usize>(grid: &Grid<N>, of: impl Fn(&Cell<N>) -> [f64; 2]) -> Vec<f64> {
    let mut caps = vec![f64::INFINITY; grid.s.len()];
    for (row, cell) in grid.cells.iter().enumerate() {
        let [from, to] = of(cell);
        caps[row] = caps[row].min(from);
        caps[row + 1] = caps[row + 1].min(to);
    }
    let fastest = caps.iter().copied().filter(|cap| cap.is_finite()).fold(0.0, f64::max);
    for cap in &mut caps {
        *cap = cap.min(fastest);
    }
    caps
}
