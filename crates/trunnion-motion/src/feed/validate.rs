//! Checks of everything the planners rely on.

use super::error::{FeedError, LimitKind};
use super::limits::Limits;
use super::options::FeedOptions;
use crate::types::{AxisNode, AxisPath, AxisPiece};
use nalgebra::SVector;

/// Smallest and largest limit, and largest number of a path, that a planner can compute with.
///
/// Planners form products of up to three path numbers and a reciprocal limit, and the squares of these: at most
/// `(1e72 * 1e24)²`, far inside the range of numbers. Limits up to 1e150 stand for no limit; their reciprocals only make
/// products smaller.
const LIMITS: std::ops::RangeInclusive<f64> = 1e-24..=1e150;
const LARGEST: f64 = 1e24;

/// Checks everything that a planner relies on.
pub(super) fn validate<const N: usize>(
    path: &AxisPath<N>,
    limits: &Limits<N>,
    options: &FeedOptions,
) -> Result<(), FeedError> {
    validate_limits(limits)?;
    validate_options(options)?;
    path.pieces.iter().enumerate().try_for_each(|(index, piece)| validate_piece(index, piece))
}

/// Checks that all limits are finite and positive.
pub(super) fn validate_limits<const N: usize>(limits: &Limits<N>) -> Result<(), FeedError> {
    let minus = limits.minus;
    let all: [(LimitKind, Option<SVector<f64, N>>); 7] = [
        (LimitKind::Velocity, Some(limits.velocity)),
        (LimitKind::Rapid, Some(limits.rapid)),
        (LimitKind::Acceleration, Some(limits.acceleration)),
        (LimitKind::Jerk, limits.jerk),
        (LimitKind::Velocity, minus.map(|minus| minus.velocity)),
        (LimitKind::Rapid, minus.map(|minus| minus.rapid)),
        (LimitKind::Acceleration, minus.map(|minus| minus.acceleration)),
    ];
    for (kind, values) in all {
        for (axis, &value) in values.iter().flatten().enumerate() {
            // Written so that a NaN is refused.
            if !LIMITS.contains(&value) {
                return Err(FeedError::BadLimit { kind, axis, value });
            }
        }
    }
    Ok(())
}

/// Checks speeds, end speeds and the time tolerance.
pub(super) fn validate_options(options: &FeedOptions) -> Result<(), FeedError> {
    let speeds = &options.speeds;
    let all = [("feed", speeds.feed), ("link_feed", speeds.link_feed), ("tip", speeds.tip)];
    for (name, value) in all {
        if let Some(value) = value.filter(|value| !LIMITS.contains(value)) {
            return Err(FeedError::BadFeed { name, value });
        }
    }
    let ends = options.end_speeds;
    for (name, value) in [("start", ends.start), ("end", ends.end)] {
        if !(0.0..=LARGEST).contains(&value) {
            return Err(FeedError::BadEnd { name, value });
        }
    }
    let value = options.time_tolerance;
    if value > 0.0 { Ok(()) } else { Err(FeedError::BadTolerance { value }) }
}

/// Checks one piece: two nodes or more, in order of `s`.
fn validate_piece<const N: usize>(piece: usize, data: &AxisPiece<N>) -> Result<(), FeedError> {
    if data.nodes.len() < 2 {
        return Err(FeedError::TooFewNodes { piece, nodes: data.nodes.len() });
    }
    let mut before = f64::NEG_INFINITY;
    for (node, at) in data.nodes.iter().enumerate() {
        // The first node comes after minus infinity.
        validate_next([piece, node], at, before)?;
        before = at.s;
    }
    Ok(())
}

/// Checks the next node of a piece, and that it comes after the one before.
pub(super) fn validate_next<const N: usize>(
    [piece, node]: [usize; 2],
    at: &AxisNode<N>,
    before: f64,
) -> Result<(), FeedError> {
    if at.s > before && is_plain(at) {
        return Ok(());
    }
    if !(at.s > before && at.s.is_finite()) {
        return Err(FeedError::NotIncreasing { piece, node, s: at.s, before });
    }
    let large = |name, value: f64| (value.abs() > LARGEST).then_some((name, value));
    validate_node(piece, node, at)?;
    let axes = at.q.iter().enumerate().flat_map(|(order, values)| {
        let name = if order == 0 { "a position" } else { "a derivative" };
        values.iter().map(move |&value| (name, value))
    });
    let rates = [("s", at.s), ("tip_rate", at.tip_rate), ("feed_rate", at.feed_rate)];
    match axes.chain(rates).find_map(|(name, value)| large(name, value)) {
        Some((name, value)) => Err(FeedError::TooLarge { piece, node, name, value }),
        None => Ok(()),
    }
}

/// Returns true if all numbers of a node are of a size to compute with, as they mostly are: without branches, and without
/// a word about which is not.
fn is_plain<const N: usize>(at: &AxisNode<N>) -> bool {
    // A NaN compares as false.
    let fits = |value: f64| value.abs() <= LARGEST;
    let rate_fits = |value: f64| (0.0..=LARGEST).contains(&value);
    let mut plain = fits(at.s) & rate_fits(at.tip_rate) & rate_fits(at.feed_rate);
    for value in at.q.iter().flatten() {
        plain &= fits(*value);
    }
    plain
}

/// Checks that positions, derivatives and rates of a node are finite.
fn validate_node<const N: usize>(
    piece: usize,
    node: usize,
    at: &AxisNode<N>,
) -> Result<(), FeedError> {
    for (order, derivative) in at.q.iter().enumerate() {
        for (axis, &value) in derivative.iter().enumerate() {
            if !value.is_finite() {
                return Err(FeedError::NotFinite { piece, node, axis, order, value });
            }
        }
    }
    for (name, value) in [("tip_rate", at.tip_rate), ("feed_rate", at.feed_rate)] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(FeedError::BadRate { piece, node, name, value });
        }
    }
    Ok(())
}
