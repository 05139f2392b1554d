//! The unknown: squared speed as a quadratic spline, at rest at both ends.
//!
//! Over a cell `x` is the quadratic with Bernstein coefficients `(x at the start, control, x at the
//! end)`. The controls are the unknowns: that slopes agree at rows makes each `x` at a row the mean
//! of the controls on both sides, weighted by the opposite lengths. Then `d²s/dt² = x'/2` is
//! continuous and linear in `s`. Next to rest, in the first or the last cell, `x = k σ^(4/3)` with `σ` the
//! distance from rest, the only power with bounded jerk there: `s` goes with `t³`, and `x' = 4 x / 3 σ`.
//! At an end that moves, `x` and the control next to it are given by speed and acceleration.

use std::ops::Range;

/// An end of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum EndMotion {
    /// No speed, no acceleration.
    Rest,
    /// Squared speed and `d²s/dt²`.
    Moving([f64; 2]),
}

impl EndMotion {
    pub(super) fn moves(&self) -> bool {
        matches!(self, Self::Moving(_))
    }
}

/// Squared speed along a piece. The control of a cell next to an end is given: by the motion there, or
/// not used if that is rest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpeedSpline {
    /// Lengths of the cells, at least four.
    pub(super) lengths: Vec<f64>,
    /// Middle Bernstein coefficient of each cell.
    pub(super) controls: Vec<f64>,
    /// Start and end.
    pub(super) ends: [EndMotion; 2],
}

/// Spline inside all limits, with the references of the jerk rows that show it.
#[derive(Debug, Clone)]
pub(super) struct FeasibleSpline {
    pub(super) spline: SpeedSpline,
    /// One per cell; empty or 0 where none is known.
    pub(super) references: Vec<f64>,
}

impl FeasibleSpline {
    /// Starts from a spline without known references.
    pub(super) fn unproven(spline: SpeedSpline) -> Self {
        Self { spline, references: Vec::new() }
    }
}

/// Weights of the controls of a cell and its neighbours in the cell's Bernstein coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) struct ControlWeights {
    /// Of the control before and the cell's own, at the start.
    pub(super) start: [f64; 2],
    /// Of the cell's own control and the one after, at the end.
    pub(super) end: [f64; 2],
}

/// A slope of `x` at the end of a rest cell over `x` there and the cell's length.
const REST_SLOPE: f64 = 4.0 / 3.0;

impl SpeedSpline {
    /// Returns the number of cells.
    pub(super) fn len(&self) -> usize {
        self.lengths.len()
    }

    /// Returns `x` at the border of a rest cell over the neighbouring control: a parabola with the
    /// slope `4 x / 3 rest` at the border has its control half the neighbour's length along that
    /// slope.
    fn rest_share(rest: f64, neighbour: f64) -> f64 {
        1.0 / (1.0 + 0.5 * REST_SLOPE * neighbour / rest)
    }

    /// Builds a spline with the controls that the ends give.
    pub(super) fn new(lengths: Vec<f64>, mut controls: Vec<f64>, ends: [EndMotion; 2]) -> Self {
        let last = lengths.len().saturating_sub(1);
        for (end, cell, sign) in [(ends[0], 0, 1.0), (ends[1], last, -1.0)] {
            if let (EndMotion::Moving([x, u]), Some(control)) = (end, controls.get_mut(cell)) {
                // u = x'/2 = (control - x) / h at a start, with the other sign at an end.
                *control = x + sign * u * lengths[cell];
            }
        }
        Self { lengths, controls, ends }
    }

    /// Returns the cells in which `x` is a parabola: all but those next to rest.
    pub(super) fn cells(&self) -> Range<usize> {
        let [first, last] = self.ends.map(|end| usize::from(!end.moves()));
        first..self.len() - last
    }

    /// Weights of a cell of [`Self::cells`]; what ends give has none.
    pub(super) fn weights(&self, cell: usize) -> ControlWeights {
        let own = self.lengths[cell];
        let start = match cell {
            0 => [0.0; 2],
            1 if !self.ends[0].moves() => [0.0, Self::rest_share(self.lengths[0], own)],
            _ => {
                // Equal slopes on both sides of the row.
                let before = self.lengths[cell - 1];
                [own / (before + own), before / (before + own)]
            }
        };
        // The same at the end, seen from the other side.
        let end = match self.len() - cell {
            1 => [0.0; 2],
            2 if !self.ends[1].moves() => [Self::rest_share(self.lengths[cell + 1], own), 0.0],
            _ => {
                let after = self.lengths[cell + 1];
                [after / (own + after), own / (own + after)]
            }
        };
        ControlWeights { start, end }
    }

    /// Returns the Bernstein coefficients of a cell of [`Self::cells`].
    pub(super) fn coefficients(&self, cell: usize) -> [f64; 3] {
        self.coefficients_with(&self.weights(cell), cell)
    }

    /// Returns the same with the weights of the cell at hand.
    #[inline]
    pub(super) fn coefficients_with(&self, weights: &ControlWeights, cell: usize) -> [f64; 3] {
        let at = |cell: usize| self.controls.get(cell).copied().unwrap_or(0.0);
        let mut x = weights.apply([at(cell.wrapping_sub(1)), at(cell), at(cell + 1)]);
        if let (0, EndMotion::Moving([start, _])) = (cell, self.ends[0]) {
            x[0] = start;
        }
        if let (true, EndMotion::Moving([end, _])) = (cell + 1 == self.len(), self.ends[1]) {
            x[2] = end;
        }
        x
    }

    /// Returns `ds/dt` and `d²s/dt²` at every row.
    pub(super) fn motion(&self) -> [Vec<f64>; 2] {
        let [mut speed, mut acceleration] = [0, 1].map(|_| Vec::with_capacity(self.len() + 1));
        let cells = self.cells();
        if cells.start > 0 {
            speed.push(0.0);
            acceleration.push(0.0);
        }
        for cell in cells.clone() {
            let [x, control, _] = self.coefficients(cell);
            speed.push(x.sqrt());
            // x'/2 at the start of the parabola.
            acceleration.push((control - x) / self.lengths[cell]);
        }
        // The end of the last parabola has no cell of its own that starts there.
        let [_, control, x] = self.coefficients(cells.end - 1);
        speed.push(x.sqrt());
        acceleration.push((x - control) / self.lengths[cells.end - 1]);
        if cells.end < self.len() {
            speed.push(0.0);
            acceleration.push(0.0);
        }
        [speed, acceleration]
    }

    /// Estimates the time from end to end, accurately enough to see whether it still falls.
    pub(super) fn time(&self) -> f64 {
        let cells = self.cells();
        cells.map(|cell| self.lengths[cell] / middle(self.coefficients(cell)).sqrt()).sum()
    }
}

impl ControlWeights {
    /// Returns the Bernstein coefficients from the controls before, here and after; linear.
    #[inline]
    pub(super) fn apply(&self, controls: [f64; 3]) -> [f64; 3] {
        let start = self.start[0] * controls[0] + self.start[1] * controls[1];
        let end = self.end[0] * controls[1] + self.end[1] * controls[2];
        [start, controls[1], end]
    }
}

/// Returns the value in the middle of a quadratic with these Bernstein coefficients.
pub(super) fn middle(x: [f64; 3]) -> f64 {
    0.25 * (x[0] + x[2]) + 0.5 * x[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_agree_at_rows_and_at_rest_cells() {
        let spline = SpeedSpline {
            lengths: vec![0.5, 1.0, 2.0, 0.25, 1.5],
            controls: vec![0.0, 3.0, 5.0, 4.0, 0.0],
            ends: [EndMotion::Rest; 2],
        };
        let slopes = |cell: usize| {
            let [a, b, c] = spline.coefficients(cell);
            [2.0 * (b - a), 2.0 * (c - b)].map(|rise| rise / spline.lengths[cell])
        };
        assert!((slopes(1)[1] - slopes(2)[0]).abs() < 1e-14);
        assert!((slopes(2)[1] - slopes(3)[0]).abs() < 1e-14);
        let [v, u] = spline.motion();
        assert!((slopes(1)[0] - 4.0 / 3.0 * v[1].powi(2) / 0.5).abs() < 1e-14);
        assert!((slopes(3)[1] + 4.0 / 3.0 * v[4].powi(2) / 1.5).abs() < 1e-14);
        assert!((u[2] - 0.5 * slopes(2)[0]).abs() < 1e-14 && u[5].abs() < 1e-300);
    }
}
