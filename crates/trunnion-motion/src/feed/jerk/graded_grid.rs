//! Cells for a jerk-limited profile.

use super::speed_spline::EndMotion;
use crate::feed::cell::FeedCell;
use crate::feed::grid::FeedGrid;
use crate::feed::grid::resolvable;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::types::AxisPiece;
use nalgebra::SVector;

/// A rest cell's share of the piece, at most: a profile needs several cells to speed up and stop. On a
/// straight line a move of four phases is at constant jerk over the first twelfth, exactly what a rest
/// cell is; its cell is the power of two below.
const REST_SHARE: f64 = 0.0081;
const STRAIGHT_SHARE: f64 = 0.035;

/// A path counts as straight where the terms of `q''` and of `q'''` change the jerk of a rest cell by no
/// more than this share.
const STRAIGHT: f64 = 0.1;

/// Largest cell, as a share of the piece. No simple fraction: even nodes, halved, would meet it
/// exactly, and rounding would decide.
const LARGEST_SHARE: f64 = 0.0163;

/// Largest cell, as a share of its distance from the nearest end. From rest `x` goes with the
/// distance to the power 4/3, and over a cell jerk goes with the root of `x`: at most 1.17 times. No
/// simple fraction either.
const GROWTH: f64 = 0.26;

/// Fewest cells of a profile: those of rest at both ends, and one between them.
///
/// There are always more, unless the piece is so short beside its `s` that rounding forbids rows inside it.
pub(super) const FEWEST_CELLS: usize = 3;

/// Builds the grid: the path's nodes, with cells halved until they resolve rest at ends that do
/// not move.
pub(super) fn graded<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    ends: &[EndMotion; 2],
) -> FeedGrid<N> {
    let moving = ends.each_ref().map(EndMotion::moves);
    let mut grid = FeedGrid { s: Vec::with_capacity(piece.nodes.len() + 64), cells: Vec::new() };
    let (Some(first), Some(last)) = (piece.nodes.first(), piece.nodes.last()) else { return grid };
    let range = [first.s, last.s];
    let length = range[1] - range[0];
    let last_interval = piece.nodes.len().saturating_sub(2);
    let rest = [(0, first.s), (last_interval, last.s)].map(|(interval, s)| {
        let quintic = piece.quintic(interval);
        quintic.map_or(0.0, |(origin, quintic)| rest_length(quintic.at(s - origin), limits, length))
    });
    let allowed = |from: f64, to: f64| {
        let [before, after] = [from - range[0], range[1] - to];
        // Graded towards rest: cells shrink with their distance from it, down to the rest cell itself.
        let by_end = |end: usize, distance: f64| match (moving[end], distance > 0.0) {
            (true, _) => f64::INFINITY,
            (false, true) => GROWTH * distance,
            (false, false) => rest[end],
        };
        (LARGEST_SHARE * length).min(by_end(0, before)).min(by_end(1, after))
    };
    for pair in piece.nodes.windows(2) {
        // Depth first, left half on top: cells come out in order of s.
        let mut stack = vec![(pair[0].s, pair[1].s, FeedCell::between(&pair[0], &pair[1]))];
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
    grid.s.push(range[1]);
    grid
}

/// Returns the length of a rest cell at an end with these derivatives of the axes.
///
/// Constant jerk `1/j` until the acceleration `1/a` takes `t = j / a` and `s = t³ / 6 j`. The
/// jerks of a rest cell over `σ` are `q''' σ² + 2 q'' σ + 2/9 q'`, times a factor that is the same
/// all over it.
fn rest_length<const N: usize>(
    [_, rate, bend, third]: [SVector<f64, N>; 4],
    limits: &ReciprocalLimits<N>,
    length: f64,
) -> f64 {
    let jerks = limits.jerk.unwrap_or_else(SVector::zeros);
    let jerk = |values: SVector<f64, N>| values.component_mul(&jerks).amax();
    let [a, j] = [rate.component_mul(&limits.acceleration.plus).amax(), jerk(rate)];
    // `a` and `j` are reciprocal: time j / a at jerk 1 / j, distance (j / a)³ / 6 j.
    let phase = (j / a).powi(2) / (6.0 * a);
    let curved = STRAIGHT / 9.0 * j / jerk(bend);
    let twisted = (STRAIGHT * 2.0 / 9.0 * j / jerk(third)).sqrt();
    let straight = (STRAIGHT_SHARE * length).min(0.5 * phase).min(curved).min(twisted);
    (REST_SHARE * length).min(0.25 * phase).max(straight)
}
