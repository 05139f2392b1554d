//! The classical planner: straight blocks from node to node, with look-ahead.
//!
//! What many controls do, and the baseline to beat. Blocks are straight in the axes; where two meet,
//! axis velocities step, by no more than the axes manage in a servo period. Curvature inside a
//! block, jerk, and the tip's own feed are unknown to it: [`Plan::ratios`] of [`blocks`] tells what
//! that does to the limits of the path it stands for.

mod ahead;
mod ramp;

pub use ramp::Ramp;

use super::cell::Cell;
use super::profile::{Grid, Profile};
use super::{
    Ends, FeedError, FeedOptions, Limits, Plan, PlannedPiece, Reciprocals, assemble, error, lower,
    plan_all, planned,
};
use crate::types::{AxisPath, AxisPiece, Progress};
use ahead::Row;
use nalgebra::SVector;

/// How the classical planner works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockOptions {
    /// Servo period \[s\]: axis velocities may step at a junction by acceleration times period.
    pub period: f64,
    /// How far it looks ahead.
    pub ahead: Ahead,
    /// Blocks that are passed through in runs, if any.
    pub tiny: Option<Tiny>,
}

/// How many blocks are looked at before one is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ahead {
    /// None: it stops at every junction.
    Stops,
    /// A fixed number.
    Blocks(usize),
    /// `blocks` at first, and on until they last `periods` servo periods at their feed.
    Dynamic {
        /// Least number of blocks; the paper has 5.
        blocks: usize,
        /// Least time in servo periods; the paper has 1000.
        periods: f64,
    },
    /// All.
    Whole,
}

/// Which blocks are tiny.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tiny {
    /// Blocks shorter than this are tiny: `L_ref`, in the measure of the path.
    pub length: f64,
    /// Runs of more tiny blocks than this are passed through like one block: `N_ref`.
    pub count: usize,
}

/// One block as the classical planner runs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedBlock {
    /// Index of the move it came from.
    pub source: usize,
    /// Equivalent displacement.
    pub length: f64,
    /// Largest speed the axes and the programmed feed allow.
    pub feed: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// What is driven.
    pub ramp: Ramp,
}

/// Plans straight moves of the axes as in paper 001.
///
/// `moves` are travels of all axes; the length of one is `sqrt(sum (w_j d_j)²)` with `weights` w (1
/// for a linear axis, the paper's k \[mm/rad\] for a rotary one), and `feed` is a speed in that
/// measure. Moves without length are left out. `ends` are the speeds before the first and after the
/// last block; what cannot be had is lowered, as in the paper. `limits.velocity` counts.
///
/// # Errors
///
/// [`FeedError`] names the wrong limit, option or move.
///
/// # Source
///
/// `docs/sources.md#001`: (1)-(2) equivalent displacement and axis coefficients, (14)-(16) feed,
/// acceleration, junction.
pub fn look_ahead<const N: usize>(
    moves: &[SVector<f64, N>],
    weights: &SVector<f64, N>,
    (limits, feed): (&Limits<N>, f64),
    (options, ends): (&BlockOptions, [f64; 2]),
) -> Result<Vec<PlannedBlock>, FeedError> {
    error::validate_limits(limits)?;
    validate(options)?;
    validate_moves(moves, weights, feed, ends)?;
    let limits = limits.smaller();
    let mut sources = Vec::with_capacity(moves.len());
    let mut rows = Vec::with_capacity(moves.len());
    for (source, travel) in moves.iter().enumerate() {
        let length = travel.component_mul(weights).norm();
        if length > 0.0 {
            sources.push(source);
            rows.push(row(travel / length, length, feed, limits.velocity, limits.acceleration));
        }
    }
    let speeds = plan_rows(&mut rows, &limits.acceleration, options, ends);
    let planned = sources.into_iter().zip(&rows).zip(speeds.windows(2));
    let planned = planned.map(|((source, row), pair)| PlannedBlock {
        source,
        length: row.length,
        feed: row.feed,
        acceleration: row.acceleration,
        ramp: Ramp::new(row.length, [pair[0], pair[1]], row.feed, [row.acceleration; 2]),
    });
    Ok(planned.collect())
}

/// (14), (15): feed and acceleration of a block from its axis coefficients.
fn row<const N: usize>(
    coefficients: SVector<f64, N>,
    length: f64,
    feed: f64,
    velocity: SVector<f64, N>,
    acceleration: SVector<f64, N>,
) -> Row<N> {
    let least = |limits: SVector<f64, N>| limits.component_div(&coefficients.abs()).min();
    let feed = feed.min(least(velocity));
    Row { length, coefficients, feed, acceleration: least(acceleration) }
}

fn plan_rows<const N: usize>(
    rows: &mut [Row<N>],
    acceleration: &SVector<f64, N>,
    options: &BlockOptions,
    ends: [f64; 2],
) -> Vec<f64> {
    if let Some(tiny) = options.tiny {
        ahead::join_tiny(rows, tiny);
    }
    let junctions = ahead::junctions(rows, acceleration, options.period);
    ahead::speeds(rows, &junctions, ends, (options.ahead, options.period))
}

/// Runs a path as the classical planner would run straight blocks between its nodes.
///
/// The path's own `s` takes the place of the equivalent displacement. Limits hold for the blocks, not
/// for the path: [`Plan::ratios`] and [`Plan::bounds`] say what the path's own axes do.
///
/// # Errors
///
/// As [`super::optimal`], and a period or `L_ref` that makes no sense.
///
/// # Source
///
/// `docs/sources.md#001`: the whole of it.
pub fn blocks<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    (feeds, options): (&FeedOptions, &BlockOptions),
    progress: &dyn Progress,
) -> Result<Plan, FeedError> {
    error::validate(path, limits, feeds)?;
    validate(options)?;
    let limits = &limits.smaller();
    let count = path.pieces.len();
    let planned = plan_all(path, progress, |index, piece| {
        let inverse = Reciprocals::new(piece.motion, limits, feeds);
        let ends = Ends::of(index, count, feeds);
        let mut rows = rows(piece, limits, &inverse);
        let speeds = [ends.start.sqrt(), ends.end.sqrt()];
        let speeds = plan_rows(&mut rows, &limits.acceleration, options, speeds);
        run(piece, &inverse, (&rows, &speeds), &ends)
    })?;
    Ok(assemble(planned))
}

/// Blocks between the nodes of a piece.
fn rows<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &Limits<N>,
    inverse: &Reciprocals<N>,
) -> Vec<Row<N>> {
    let velocity = if piece.motion.is_free() { limits.rapid } else { limits.velocity };
    let blocks = piece.nodes.windows(2).map(|pair| {
        let [from, to] = [&pair[0], &pair[1]];
        let length = to.s - from.s;
        let rate = from.feed_rate.max(to.feed_rate) * inverse.feed;
        let tip = from.tip_rate.max(to.tip_rate) * inverse.tip;
        let feed = rate.max(tip).recip();
        row((to.q[0] - from.q[0]) / length, length, feed, velocity, limits.acceleration)
    });
    let mut rows: Vec<Row<N>> = blocks.collect();
    // A block without travel has no limits: it goes like the fastest other.
    let largest = |of: fn(&Row<N>) -> f64| {
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

/// The blocks' speeds as a schedule of the path.
fn run<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &Reciprocals<N>,
    (rows, speeds): (&[Row<N>], &[f64]),
    ends: &Ends,
) -> Result<PlannedPiece, FeedError> {
    let mut grid = Grid { s: Vec::new(), cells: Vec::new() };
    let mut profile = Profile { x: Vec::new(), acceleration: None };
    let mut nodes = Grid { s: Vec::new(), cells: Vec::new() };
    for ((pair, row), speed) in piece.nodes.windows(2).zip(rows).zip(speeds.windows(2)) {
        let ramp = Ramp::new(row.length, [speed[0], speed[1]], row.feed, [row.acceleration; 2]);
        let mut rest = Cell::between(&pair[0], &pair[1]);
        let start = pair[0].s;
        nodes.cells.push(rest);
        grid.s.push(start);
        profile.x.push(speed[0] * speed[0]);
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
    ends.reached(&profile)?;
    let lower_bound = lower::bound(&nodes, limits, ends);
    Ok(planned(piece, (&grid, &profile), limits, lower_bound))
}

fn validate(options: &BlockOptions) -> Result<(), FeedError> {
    let positive = |name: &'static str, value: f64| {
        let good = value > 0.0 && value.is_finite();
        if good { Ok(()) } else { Err(FeedError::BadBlockOption { name, value }) }
    };
    positive("servo period", options.period)?;
    if let Some(tiny) = options.tiny {
        positive("length of a tiny block", tiny.length)?;
    }
    match options.ahead {
        Ahead::Dynamic { periods, .. } => positive("window in servo periods", periods),
        _ => Ok(()),
    }
}

fn validate_moves<const N: usize>(
    moves: &[SVector<f64, N>],
    weights: &SVector<f64, N>,
    feed: f64,
    ends: [f64; 2],
) -> Result<(), FeedError> {
    if !(feed > 0.0 && feed.is_finite()) {
        return Err(FeedError::BadFeed { name: "feed", value: feed });
    }
    if let Some(&value) = weights.iter().find(|value| !(**value > 0.0 && value.is_finite())) {
        return Err(FeedError::BadBlockOption { name: "weight of an axis", value });
    }
    for (name, value) in ["start speed", "end speed"].into_iter().zip(ends) {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(FeedError::BadBlockOption { name, value });
        }
    }
    for (index, travel) in moves.iter().enumerate() {
        if let Some((axis, &value)) =
            travel.iter().enumerate().find(|(_, value)| !value.is_finite())
        {
            return Err(FeedError::BadMove { index, axis, value });
        }
    }
    Ok(())
}
