//! Straight moves of the axes, block by block.

use super::options::{LookAheadOptions, validate};
use super::ramp::SpeedRamp;
use super::window::{plan_rows, row};
use crate::feed::error::FeedError;
use crate::feed::limits::Limits;
use crate::feed::validate::validate_limits;
use nalgebra::SVector;

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
    pub ramp: SpeedRamp,
}

/// Straight moves of the axes, and the measure of their lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StraightMoves<'a, const N: usize> {
    /// Travel of all axes in each move \[axis unit\].
    pub travels: &'a [SVector<f64, N>],
    /// Weights `w` of the axes in the length `sqrt(sum (w_j d_j)²)` of a move: 1 for a linear axis,
    /// the paper's k \[mm/rad\] for a rotary one.
    pub weights: &'a SVector<f64, N>,
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
    moves: &StraightMoves<'_, N>,
    limits: &Limits<N>,
    feed: f64,
    ends: [f64; 2],
    options: &LookAheadOptions,
) -> Result<Vec<PlannedBlock>, FeedError> {
    validate_limits(limits)?;
    validate(options)?;
    let StraightMoves { travels, weights } = *moves;
    validate_moves(moves, feed, ends)?;
    let limits = limits.smaller();
    let mut sources = Vec::with_capacity(travels.len());
    let mut rows = Vec::with_capacity(travels.len());
    for (source, travel) in travels.iter().enumerate() {
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
        ramp: SpeedRamp::new(row.length, [pair[0], pair[1]], row.feed, [row.acceleration; 2]),
    });
    Ok(planned.collect())
}

fn validate_moves<const N: usize>(
    moves: &StraightMoves<'_, N>,
    feed: f64,
    ends: [f64; 2],
) -> Result<(), FeedError> {
    if !(feed > 0.0 && feed.is_finite()) {
        return Err(FeedError::BadFeed { name: "feed", value: feed });
    }
    if let Some(&value) = moves.weights.iter().find(|value| !(**value > 0.0 && value.is_finite())) {
        return Err(FeedError::BadBlockOption { name: "weight of an axis", value });
    }
    for (name, value) in ["start speed", "end speed"].into_iter().zip(ends) {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(FeedError::BadBlockOption { name, value });
        }
    }
    for (index, travel) in moves.travels.iter().enumerate() {
        if let Some((axis, &value)) =
            travel.iter().enumerate().find(|(_, value)| !value.is_finite())
        {
            return Err(FeedError::BadMove { index, axis, value });
        }
    }
    Ok(())
}
