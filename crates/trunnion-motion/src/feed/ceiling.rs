//! Speed ceiling at one point of a path.

use super::limits::Limits;
use super::lower_bound;
use super::options::FeedOptions;
use super::reciprocal::ReciprocalLimits;
use crate::types::Motion;
use nalgebra::SVector;

/// Upper bound on `ds/dt` at one point of a path, from that point alone \[mm/s, or s-unit/s\].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SpeedCeiling {
    /// From the axis velocities.
    pub velocity: f64,
    /// From the axis accelerations: above it no `d²s/dt²` satisfies all axes at once.
    pub acceleration: f64,
}

/// Returns the speed ceiling at a point with `rate = dq/ds` and `curvature = d²q/ds²` while
/// cutting.
///
/// `v <= min v_j / |rate_j|`, and the largest `v` for which some `u` satisfies `|rate_j u +
/// curvature_j v²| <= a_j` on every axis.
///
/// # Source
///
/// `docs/sources.md#001`: maximum velocity curve.
///
/// # Example
///
/// On a circle of 10 mm the axis across the path limits the speed to `sqrt(1000 * 10)` mm/s:
///
/// ```
/// use nalgebra::Vector2;
/// use trunnion_motion::feed::{Limits, ceiling};
///
/// let [fast, acceleration] = [Vector2::repeat(500.0), Vector2::repeat(1000.0)];
/// let limits = Limits::symmetric(fast, acceleration, Vector2::repeat(1e5));
/// let top = ceiling(&Vector2::new(1.0, 0.0), &Vector2::new(0.0, 0.1), &limits);
/// assert!((top.acceleration - 100.0).abs() < 1e-9 && (top.velocity - 500.0).abs() < 1e-9);
/// ```
pub fn ceiling<const N: usize>(
    rate: &SVector<f64, N>,
    curvature: &SVector<f64, N>,
    limits: &Limits<N>,
) -> SpeedCeiling {
    let limits = ReciprocalLimits::new(Motion::Cut, limits, &FeedOptions::fastest());
    // v = 1 / max(|rate_j| / v_j), infinite where no axis moves.
    SpeedCeiling {
        velocity: (0..N)
            .map(|axis| limits.velocity.share(axis, rate[axis]))
            .fold(0.0, f64::max)
            .recip(),
        acceleration: lower_bound::pair_cap([*rate, *curvature], &SVector::zeros(), &limits).sqrt(),
    }
}
