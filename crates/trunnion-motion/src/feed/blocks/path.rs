//! A path run as straight blocks between its nodes.

use super::options::{LookAheadOptions, validate};
use super::ramp::SpeedRamp;
use super::window::{BlockRow, plan_rows, row};
use crate::feed::cell::FeedCell;
use crate::feed::ends::EndSquares;
use crate::feed::error::FeedError;
use crate::feed::grid::FeedGrid;
use crate::feed::limits::Limits;
use crate::feed::lower_bound;
use crate::feed::options::FeedOptions;
use crate::feed::pieces::{PlannedPiece, assemble, plan_all, planned};
use crate::feed::plan::FeedPlan;
use crate::feed::profile::SpeedProfile;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::feed::validate as path_validate;
use crate::types::{AxisPath, AxisPiece, Progress};

/// Runs a path as the classical planner would run straight blocks between its nodes.
///
/// The path's own `s` takes the place of the equivalent displacement. Limits hold for the blocks,
/// not for the path: [`FeedPlan::ratios`] and [`FeedPlan::bounds`] show what the path's own axes
/// do.
///
/// # Errors
///
/// As [`optimal()`](crate::feed::optimal()), and a period or `L_ref` that makes no sense.
///
/// # Source
///
/// `docs/sources.md#001`: the whole of it.
pub fn blocks<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    feeds: &FeedOptions,
    options: &LookAheadOptions,
    progress: &dyn Progress,
) -> Result<FeedPlan, FeedError> {
    path_validate::validate(path, limits, feeds)?;
    validate(options)?;
    let limits = &limits.smaller();
    let count = path.pieces.len();
    let planned = plan_all(path, progress, |index, piece| {
        let inverse = ReciprocalLimits::new(piece.motion, limits, feeds);
        let ends = EndSquares::of(index, count, feeds);
        let mut rows = rows(piece, limits, &inverse);
        // The classical planner works with speeds, the others with their squares.
        let speeds = [ends.start.sqrt(), ends.end.sqrt()];
        let speeds = plan_rows(&mut rows, &limits.acceleration, options, speeds);
        run(piece, &inverse, &rows, &speeds, &ends)
    })?;
    assemble(planned)
}

/// Returns the blocks between the nodes of a piece.
fn rows<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &Limits<N>,
    inverse: &ReciprocalLimits<N>,
) -> Vec<BlockRow<N>> {
    let velocity = if piece.motion.is_free() { limits.rapid } else { limits.velocity };
    let blocks = piece.nodes.windows(2).map(|pair| {
        let [from, to] = [&pair[0], &pair[1]];
        let length = to.s - from.s;
        let rate = from.feed_rate.max(to.feed_rate) * inverse.feed;
        let tip = from.tip_rate.max(to.tip_rate) * inverse.tip;
        // Feed and tip speed as a limit of ds/dt, by the faster end of the block.
        let feed = rate.max(tip).recip();
        row((to.q[0] - from.q[0]) / length, length, feed, velocity, limits.acceleration)
    });
    let mut rows: Vec<BlockRow<N>> = blocks.collect();
    // A block without travel has no limits: it goes like the fastest other.
    let largest = |of: fn(&BlockRow<N>) -> f64| {
        rows.iter().map(of).filter(|value| value.is_finite()).fold(0.0, f64::max)
    };
    let [feed, acceleration] = [largest(|row| row.feed), largest(|row| row.acceleration)];
    for row in &mut rows {
        (row.feed, row.acceleration) = (row.feed.min(feed), row.acceleration.min(acceleration));
    }
    rows
}

/// Cuts nearer to an end of a cell than this share are left out: half the digits. Derivatives of the
/// path in a shorter cell would be lost in rounding; leaving it out moves a time by as little.
const LEAST_SHARE: f64 = 1.5e-8;

/// Turns the speeds of the blocks into a schedule of the path.
fn run<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    rows: &[BlockRow<N>],
    speeds: &[f64],
    ends: &EndSquares,
) -> Result<PlannedPiece, FeedError> {
    let mut grid = FeedGrid { s: Vec::new(), cells: Vec::new() };
    let mut profile = SpeedProfile { x: Vec::new(), acceleration: None };
    let mut nodes = FeedGrid { s: Vec::new(), cells: Vec::new() };
    for ((pair, row), speed) in piece.nodes.windows(2).zip(rows).zip(speeds.windows(2)) {
        let ramp =
            SpeedRamp::new(row.length, [speed[0], speed[1]], row.feed, [row.acceleration; 2]);
        let mut rest = FeedCell::between(&pair[0], &pair[1]);
        let start = pair[0].s;
        nodes.cells.push(rest);
        grid.s.push(start);
        profile.x.push(speed[0] * speed[0]);
        // Rows where the phases of the block meet: x is linear on each of them.
        let [up, even, _] = ramp.distances;
        for cut in [up, up + even] {
            let share = (start + cut - grid.s.last().unwrap_or(&start)) / rest.h;
            if (LEAST_SHARE..=1.0 - LEAST_SHARE).contains(&share) {
                let [cell, remainder] = rest.split(share);
                grid.cells.push(cell);
                grid.s.push(start + cut);
                profile.x.push(ramp.speeds[1] * ramp.speeds[1]);
                rest = remainder;
            }
        }
        grid.cells.push(rest);
    }
    grid.s.extend(piece.nodes.last().map(|node| node.s));
    profile.x.extend(speeds.last().map(|speed| speed * speed));
    profile.check_ends(ends)?;
    let lower_bound = lower_bound::bound(&nodes, limits, ends);
    Ok(planned(piece, &grid, &profile, limits, lower_bound))
}
