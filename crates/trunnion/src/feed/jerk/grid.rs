//! Cells for a jerk-limited profile.

use crate::feed::Reciprocals;
use crate::feed::cell::Cell;
use crate::feed::profile::Grid;
use crate::feed::refine::resolvable;
use crate::types::AxisPiece;
use nalgebra::SVector;

/// A rest cell's share of the piece, at most: a profile needs several cells to speed up and stop.
const REST_SHARE: f64 = 0.0081;

/// Largest cell, as a share of the piece. No simple fraction: even nodes, halved, would meet it
/// exactly, and rounding would decide.
const LARGEST_SHARE: f64 = 0.0163;

/// Largest cell, as a share of its distance from the nearest end. From rest `x` goes with the
/// distance to the power 4/3: over such a cell it grows by 1.75, and the bound of the jerk, which is
/// exact in the middle, is 3 % off at its ends. No simple fraction either.
const GROWTH: f64 = 0.523;

/// The path's nodes, with cells halved until they resolve rest at both ends.
pub(super) fn graded<const N: usize>(piece: &AxisPiece<N>, limits: &Reciprocals<N>) -> Grid<N> {
    let mut grid = Grid { s: Vec::with_capacity(piece.nodes.len() + 64), cells: Vec::new() };
    let (Some(first), Some(last)) = (piece.nodes.first(), piece.nodes.last()) else { return grid };
    let ends = [first.s, last.s];
    let length = ends[1] - ends[0];
    let rest = [&first.q[1], &last.q[1]].map(|rate| {
        let most = |limits: &SVector<f64, N>| rate.component_mul(limits).amax();
        let [a, j] =
            [most(&limits.acceleration), most(&limits.jerk.unwrap_or_else(SVector::zeros))];
        // Constant jerk 1/j until the acceleration 1/a: t = j / a, s = t³ / 6 j.
        (REST_SHARE * length).min((j / a).powi(2) / (24.0 * a))
    });
    let allowed = |from: f64, to: f64| {
        let [before, after] = [from - ends[0], ends[1] - to];
        let by_end = |distance: f64, rest: f64| rest.max(GROWTH * distance);
        (LARGEST_SHARE * length).min(by_end(before, rest[0])).min(by_end(after, rest[1]))
    };
    for pair in piece.nodes.windows(2) {
        let mut stack = vec![(pair[0].s, pair[1].s, Cell::between(&pair[0], &pair[1]))];
        while let Some((from, to, cell)) = stack.pop() {
            let middle = 0.5 * (from + to);
            if cell.h > allowed(from, to) && resolvable(from, middle, to) {
                let [left, right] = cell.split(0.5);
                stack.push((middle, to, right));
                stack.push((from, middle, left));
            } else {
                grid.s.push(from);
                grid.cells.push(cell);
            }
        }
    }
    grid.s.push(ends[1]);
    grid
}
