//! Speed ceiling at one point of a path.

use super::limits::Limits;
use super::lower_bound;
use super::options::FeedOptions;
use super::reciprocal::ReciprocalLimits;
use crate::types::Motion;
use nalgebra::SVector;

/// Largest `ds/dt` at one place, whatever happens elsewhere \[s per s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedCeiling {
    /// From the axis velocities.
    pub velocity: f64,
    /// From the axis accelerations: above it no `d²s/dt²` satisfies all axes at once.
    pub acceleration: f64,
}

/// Feed ceiling of a place with `rate = dq/ds` and `curvature = d²q/ds²` while cutting.
///
/// `v <= min v_j / |rate_j|`, and the largest `v` for which some `A` satisfies
/// `|rate_j A + curvature_j v²| <= a_j` on every axis.
///
/// # Source
///
/// `docs/sources.md#001`: maximum velocity curve.
pub fn ceiling<const N: usize>(
    rate: &SVector<f64, N>,
    curvature: &SVector<f64, N>,
    limits: &Limits<N>,
) -> SpeedCeiling {
    let limits = ReciprocalLimits::new(Motion::Cut, limits, &FeedOptions::fastest());
    SpeedCeiling {
        velocity: (0..N)
            .map(|axis| limits.velocity.share(axis, rate[axis]))
            .fold(0.0, f64::max)
            .recip(),
        acceleration: lower_bound::pair_cap([*rate, *curvature], &SVector::zeros(), &limits).sqrt(),
    }
}
