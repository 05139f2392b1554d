//! Upper bounds of the squared speed that do not depend on its slope.

use super::graded_grid::FEWEST_CELLS;
use super::rows::{RestSide, rest_cap};
use super::speed_spline::{EndMotion, SpeedSpline};
use crate::feed::grid::FeedGrid;
use crate::feed::reciprocal::ReciprocalLimits;

/// A given speed up to this share of a limit counts as at the limit: squares, rates and caps are
/// right to a few roundings each.
const AT_LIMIT: f64 = 1.0 + 64.0 * f64::EPSILON;

/// Velocity, feed and tip limits, and everything that limits a rest cell.
#[derive(Debug, Clone)]
pub(super) struct SpeedCaps {
    /// Of the control of each cell.
    pub(super) control: Vec<f64>,
    /// Of `x` at each row; unlimited at the borders of rest cells, whose controls have it all, and where
    /// an end gives it.
    pub(super) row: Vec<f64>,
    /// Largest share of its cap that the motion at an end uses.
    pub(super) given: f64,
}

impl SpeedCaps {
    /// Collects the caps of all cells; `None` where nothing limits anything, because nothing moves.
    pub(super) fn new<const N: usize>(
        grid: &FeedGrid<N>,
        spline: &SpeedSpline,
        limits: &ReciprocalLimits<N>,
    ) -> Option<Self> {
        // A piece without room for rows cannot move either.
        if grid.cells.len() < FEWEST_CELLS {
            return None;
        }
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
        for cell in spline.cells() {
            let [start, end] = lines[cell].map(|cap| cap.min(fastest));
            row[cell] = row[cell].min(start);
            row[cell + 1] = row[cell + 1].min(end);
        }
        let mut caps = Self { control, row, given: 0.0 };
        let borders = [[1, 0, 1, 0], [last - 1, last, last, last + 1]];
        for ([cell, end, border, outer], motion) in borders.into_iter().zip(spline.ends) {
            let side = if end > 0 { RestSide::End } else { RestSide::Start };
            if let EndMotion::Moving([x, _]) = motion {
                let shares = [x / caps.row[outer], spline.controls[end] / caps.control[end]];
                let most = shares[0].max(shares[1]);
                caps.given = caps.given.max(if most <= AT_LIMIT { most.min(1.0) } else { most });
                (caps.row[outer], caps.control[end]) = (f64::INFINITY, f64::INFINITY);
                continue;
            }
            // The border of a rest cell is a fixed share of the control beside it: its cap becomes one of that
            // control.
            let weights = spline.weights(cell);
            let share = match side {
                RestSide::End => weights.end[0],
                RestSide::Start => weights.start[1],
            };
            let cap = rest_cap(&grid.cells[end], limits, side).min(caps.row[border]) / share;
            caps.control[cell] = caps.control[cell].min(cap);
            caps.row[border] = f64::INFINITY;
        }
        Some(caps)
    }
}
