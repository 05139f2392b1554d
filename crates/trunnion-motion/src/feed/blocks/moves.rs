//! Straight moves of the axes, block by block.

use super::options::{LookAheadOptions, validate};
use super::ramp::SpeedRamp;
use super::window::{plan_rows, row};
use crate::feed::error::FeedError;
use crate::feed::limits::Limits;
use crate::feed::options::PathEnds;
use crate::feed::validate::validate_limits;
use nalgebra::SVector;

/// One block as the classical planner runs it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PlannedBlock {
    /// Index of the move it came from.
    pub source: usize,
    /// Equivalent displacement.
    pub length: f64,
    /// Largest speed the axes and the programmed feed allow.
    pub feed: f64,
    /// Largest acceleration.
    pub acceleration: f64,
    /// Motion over the block.
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
/// `feed` is a speed in the measure of the moves' lengths. Moves without length are left out.
/// `ends` are the speeds before the first and after the last block; what is impossible is lowered,
/// as in the paper. Of the limits, `limits.velocity` and `limits.acceleration` count.
///
/// # Errors
///
/// [`FeedError`] names the wrong limit, option or move.
///
/// # Source
///
/// `docs/sources.md#001`: (1)-(2) equivalent displacement and axis coefficients, (14)-(16) feed,
/// acceleration, junction.
///
/// # Example
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::feed::{Limits, LookAheadOptions, PathEnds, StraightMoves, look_ahead};
///
/// let limits = Limits::symmetric(Vector1::new(50.0), Vector1::new(500.0), Vector1::new(1e4));
/// let moves = StraightMoves { travels: &[Vector1::new(100.0)], weights: &Vector1::new(1.0) };
/// let planned = look_ahead(&moves, &limits, 50.0, PathEnds::REST, &LookAheadOptions::whole(0.001))?;
/// // 0.1 s up, 1.9 s at 50 mm/s, 0.1 s down.
/// assert!((planned[0].ramp.duration() - 2.1).abs() < 1e-12);
/// # Ok::<(), trunnion_motion::feed::FeedError>(())
/// ```
pub fn look_ahead<const N: usize>(
    moves: &StraightMoves<'_, N>,
    limits: &Limits<N>,
    feed: f64,
    ends: PathEnds,
    options: &LookAheadOptions,
) -> Result<Vec<PlannedBlock>, FeedError> {
    validate_limits(limits)?;
    validate(options)?;
    let StraightMoves { travels, weights } = *moves;
    let ends = [ends.start, ends.end];
    validate_moves(moves, feed, ends)?;
    let limits = limits.smaller();
    let mut sources = Vec::with_capacity(travels.len());
    let mut rows = Vec::with_capacity(travels.len());
    for (source, travel) in travels.iter().enumerate() {
        // Equivalent displacement, (1) of the paper.
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

/// Checks feed, weights, end speeds and travels.
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
