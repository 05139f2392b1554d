//! The unknown: squared speed as a quadratic spline, at rest at both ends.
//!
//! Over a cell `x` is the quadratic with Bernstein coefficients `(x at the start, control, x at the
//! end)`. The controls are the unknowns: that slopes agree at rows makes each `x` at a row the mean
//! of the controls on both sides, weighted by the opposite lengths. Then `d²s/dt² = x'/2` is
//! continuous and linear in `s`. In the first and the last cell `x = k σ^(4/3)` with `σ` the distance
//! from rest, the only power with bounded jerk there: `s` goes with `t³`, and `x' = 4 x / 3 σ`.

/// Squared speed along a piece. Controls of the first and the last cell are not used.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spline {
    /// Lengths of the cells, at least four.
    pub(super) lengths: Vec<f64>,
    /// Middle Bernstein coefficient of each cell.
    pub(super) controls: Vec<f64>,
}

/// Weights of the controls of a cell and its neighbours in the cell's Bernstein coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weights {
    /// Of the control before and the cell's own, at the start.
    pub(super) start: [f64; 2],
    /// Of the cell's own control and the one after, at the end.
    pub(super) end: [f64; 2],
}

/// A slope of `x` at the end of a rest cell over `x` there and the cell's length.
const REST_SLOPE: f64 = 4.0 / 3.0;

impl Spline {
    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.lengths.len()
    }

    /// `x` at the border of a rest cell over the neighbouring control: a parabola with the slope
    /// `4 x / 3 rest` at the border has its control half the neighbour's length along that slope.
    fn rest_share(rest: f64, neighbour: f64) -> f64 {
        1.0 / (1.0 + 0.5 * REST_SLOPE * neighbour / rest)
    }

    /// Weights of cell `cell`, which is neither the first nor the last.
    pub(super) fn weights(&self, cell: usize) -> Weights {
        let [before, own, after] =
            [self.lengths[cell - 1], self.lengths[cell], self.lengths[cell + 1]];
        let start = if cell == 1 {
            [0.0, Self::rest_share(before, own)]
        } else {
            [own / (before + own), before / (before + own)]
        };
        let end = if cell + 2 == self.len() {
            [Self::rest_share(after, own), 0.0]
        } else {
            [after / (own + after), own / (own + after)]
        };
        Weights { start, end }
    }

    /// Bernstein coefficients of a cell that is neither the first nor the last.
    pub(super) fn coefficients(&self, cell: usize) -> [f64; 3] {
        self.weights(cell).apply([
            self.controls[cell - 1],
            self.controls[cell],
            self.controls[cell + 1],
        ])
    }

    /// `ds/dt` and `d²s/dt²` at every row.
    pub(super) fn motion(&self) -> [Vec<f64>; 2] {
        let [mut speed, mut acceleration] = [vec![0.0], vec![0.0]];
        let last = self.len() - 1;
        for cell in 1..last {
            let [x, control, _] = self.coefficients(cell);
            speed.push(x.sqrt());
            acceleration.push((control - x) / self.lengths[cell]);
        }
        let [_, control, x] = self.coefficients(last - 1);
        speed.extend([x.sqrt(), 0.0]);
        acceleration.extend([(x - control) / self.lengths[last - 1], 0.0]);
        [speed, acceleration]
    }

    /// Time from rest to rest, near enough to see whether it still falls.
    pub(super) fn time(&self) -> f64 {
        let cells = 1..self.len() - 1;
        cells.map(|cell| self.lengths[cell] / middle(self.coefficients(cell)).sqrt()).sum()
    }
}

impl Weights {
    /// Bernstein coefficients from the controls before, here and after; linear.
    pub(super) fn apply(&self, controls: [f64; 3]) -> [f64; 3] {
        let start = self.start[0] * controls[0] + self.start[1] * controls[1];
        let end = self.end[0] * controls[1] + self.end[1] * controls[2];
        [start, controls[1], end]
    }
}

/// Value in the middle of a quadratic with these Bernstein coefficients.
pub(super) fn middle(x: [f64; 3]) -> f64 {
    0.25 * (x[0] + x[2]) + 0.5 * x[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_agree_at_rows_and_at_rest_cells() {
        let spline = Spline {
            lengths: vec![0.5, 1.0, 2.0, 0.25, 1.5],
            controls: vec![0.0, 3.0, 5.0, 4.0, 0.0],
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
