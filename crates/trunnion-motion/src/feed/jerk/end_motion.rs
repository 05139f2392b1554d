//! Speeds and accelerations at the ends of a path.

use super::graded_grid;
use super::solve::feasible;
use super::speed_spline::EndMotion;
use crate::feed::error::FeedError;
use crate::feed::options::PathEnds;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::types::AxisPiece;

/// Halvings of the range in which the largest possible speed lies: to a thousandth of it.
const HALVINGS: usize = 10;

impl EndMotion {
    /// Returns the squared speed.
    pub(super) fn square(&self) -> f64 {
        match self {
            Self::Rest => 0.0,
            Self::Moving([x, _]) => *x,
        }
    }
}

/// Returns the ends of a path with these speeds and `d²s/dt²`.
pub(super) fn borders(
    speeds: PathEnds,
    accelerations: PathEnds,
) -> Result<[EndMotion; 2], FeedError> {
    let mut ends = [EndMotion::Rest; 2];
    let start = ("start", speeds.start, accelerations.start);
    let last = ("end", speeds.end, accelerations.end);
    for (end, (name, speed, value)) in [start, last].into_iter().enumerate() {
        if !value.is_finite() || (speed <= 0.0 && value.abs() > 0.0) {
            return Err(FeedError::BadEndAcceleration { name, value, speed });
        }
        if speed > 0.0 {
            ends[end] = EndMotion::Moving([speed * speed, value]);
        }
    }
    Ok(ends)
}

/// Returns the error of the end that asks for too much, with the speed that is possible there.
pub(super) fn refused<const N: usize>(
    piece: &AxisPiece<N>,
    limits: &ReciprocalLimits<N>,
    ends: [EndMotion; 2],
) -> FeedError {
    let possible = |ends: [EndMotion; 2]| {
        let grid = graded_grid::graded(piece, limits, &ends);
        feasible(&grid, limits, ends).is_some_and(|(_, start)| start.is_some())
    };
    // The start alone, to rest; if that can be had, the end is what is too much.
    let end = usize::from(possible([ends[0], EndMotion::Rest]));
    let with = |speed: f64| {
        let mut ends = if end == 0 { [ends[0], EndMotion::Rest] } else { ends };
        let EndMotion::Moving([_, u]) = ends[end] else { return ends };
        ends[end] = EndMotion::Moving([speed * speed, u]);
        ends
    };
    // Bisection between a speed that is possible and one that is not.
    let speed = ends[end].square().sqrt();
    let [mut most, mut above] = [0.0, speed];
    for _ in 0..HALVINGS {
        let middle = 0.5 * (most + above);
        if possible(with(middle)) { most = middle } else { above = middle }
    }
    match end {
        0 => FeedError::StartTooFast { speed, most },
        _ => FeedError::EndTooFast { speed, most },
    }
}
