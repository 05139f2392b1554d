//! Upper bounds of the squared speed that do not depend on its slope.

use super::rows::rest_cap;
use super::spline::Spline;
use crate::feed::Reciprocals;
use crate::feed::profile::Grid;

/// Velocity, feed and tip limits, and everything that limits a rest cell.
#[derive(Debug, Clone)]
pub(super) struct Caps {
    /// Of the control of each cell.
    pub(super) control: Vec<f64>,
    /// Of `x` at each row; unlimited at the borders of rest cells, whose controls have it all.
    pub(super) row: Vec<f64>,
}

impl Caps {
    /// `None` where nothing limits anything: nothing moves.
    pub(super) fn new<const N: usize>(
        grid: &Grid<N>,
        spline: &Spline,
        limits: &Reciprocals<N>,
    ) -> Option<Self> {
        let last = grid.cells.len() - 1;
        let lines: Vec<[f64; 2]> = grid.cells.iter().map(|cell| cell.caps(limits)).collect();
        let fastest = lines.iter().flatten().copied().filter(|cap| cap.is_finite());
        let fastest = fastest.fold(0.0, f64::max);
        if fastest <= 0.0 {
            return None;
        }
        // Where nothing moves, x is at most what it is at most elsewhere.
        let control = lines.iter().map(|[a, b]| (0.5 * (a + b)).min(fastest)).collect();
        let mut row = vec![f64::INFINITY; grid.s.len()];
        for cell in 1..last {
            let [start, end] = lines[cell].map(|cap| cap.min(fastest));
            row[cell] = row[cell].min(start);
            row[cell + 1] = row[cell + 1].min(end);
        }
        let mut caps = Self { control, row };
        let borders = [(1, 0, 1, false), (last - 1, last, last, true)];
        for (cell, rest, border, to_rest) in borders {
            let weights = spline.weights(cell);
            let share = if to_rest { weights.end[0] } else { weights.start[1] };
            let cap = rest_cap(&grid.cells[rest], limits, to_rest).min(caps.row[border]) / share;
            caps.control[cell] = caps.control[cell].min(cap);
            caps.row[border] = f64::INFINITY;
        }
        Some(caps)
    }
}
