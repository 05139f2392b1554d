//! Limits of an axis in both directions.

use super::numeric::largest;
use nalgebra::SVector;

/// Reciprocal limits of the axes towards plus and towards minus; 0 is unlimited.
#[derive(Debug, Clone, Copy)]
pub(super) struct DirectionalLimits<const N: usize> {
    pub(super) plus: SVector<f64, N>,
    pub(super) minus: SVector<f64, N>,
}

impl<const N: usize> DirectionalLimits<N> {
    /// Takes limits; those towards minus only where they differ.
    pub(super) fn of(plus: SVector<f64, N>, minus: Option<SVector<f64, N>>) -> Self {
        let inverse = |limits: SVector<f64, N>| limits.map(f64::recip);
        Self { plus: inverse(plus), minus: inverse(minus.unwrap_or(plus)) }
    }

    /// Takes reciprocal limits that are the same in both directions.
    pub(super) fn both(inverse: SVector<f64, N>) -> Self {
        Self { plus: inverse, minus: inverse }
    }

    /// Returns the share of the limit that a value of this axis takes.
    #[inline]
    pub(super) fn share(&self, axis: usize, value: f64) -> f64 {
        largest(value * self.plus[axis], -value * self.minus[axis])
    }

    /// Returns the larger limit of each axis, for both directions.
    pub(super) fn loosest(&self) -> Self {
        Self::both(self.plus.inf(&self.minus))
    }

    /// Multiplies the reciprocal limits.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { plus: self.plus * factor, minus: self.minus * factor }
    }
}
