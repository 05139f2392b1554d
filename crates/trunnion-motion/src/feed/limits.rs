//! Axis limits.

use super::error::FeedError;
use nalgebra::SVector;

/// What the axes can do. All finite and positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<const N: usize> {
    /// Axis velocities while cutting, leading in and leading out \[axis unit/s\].
    pub velocity: SVector<f64, N>,
    /// Axis velocities on links \[axis unit/s\].
    pub rapid: SVector<f64, N>,
    /// Axis accelerations \[axis unit/s²\].
    pub acceleration: SVector<f64, N>,
    /// Axis jerks \[axis unit/s³\]: kept by [`super::jerk()`]; measured, not kept, by [`super::optimal`].
    pub jerk: Option<SVector<f64, N>>,
    /// What differs towards minus; `None` for limits that are the same in both directions. Kept to the full by
    /// [`super::optimal`], [`super::FeedStream`] and [`super::given()`]; planners with jerk limits and [`super::blocks()`]
    /// keep the smaller of both directions.
    pub minus: Option<MinusLimits<N>>,
}

/// What the axes can do towards minus: a falling axis is braked by less than it is sped up with. All finite
/// and positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MinusLimits<const N: usize> {
    /// As [`Limits::velocity`] \[axis unit/s\].
    pub velocity: SVector<f64, N>,
    /// As [`Limits::rapid`] \[axis unit/s\].
    pub rapid: SVector<f64, N>,
    /// As [`Limits::acceleration`] \[axis unit/s²\].
    pub acceleration: SVector<f64, N>,
}

impl<const N: usize> Limits<N> {
    /// The same limits in both directions, on links as on cuts.
    #[must_use]
    pub fn symmetric(
        velocity: SVector<f64, N>,
        acceleration: SVector<f64, N>,
        jerk: SVector<f64, N>,
    ) -> Self {
        Self { velocity, rapid: velocity, acceleration, jerk: Some(jerk), minus: None }
    }

    /// The same without jerk limits.
    #[must_use]
    pub const fn without_jerk(mut self) -> Self {
        self.jerk = None;
        self
    }

    /// The smaller of both directions, in both.
    #[must_use]
    pub fn smaller(&self) -> Self {
        let Some(minus) = self.minus else { return *self };
        Self {
            velocity: self.velocity.inf(&minus.velocity),
            rapid: self.rapid.inf(&minus.rapid),
            acceleration: self.acceleration.inf(&minus.acceleration),
            minus: None,
            ..*self
        }
    }
}

impl<const N: usize> Limits<N> {
    /// The same, with accelerations so low that between two setpoints `period` \[s\] apart a straight
    /// line leaves the motion of no axis by more than `error` \[axis unit\]; infinite for any.
    ///
    /// A chord over `T` of a motion whose acceleration is at most `a` is off by at most `a T² / 8`, so
    /// `a <= 8 e / T²` is enough; on a circle that is `v <= sqrt(8 e / curvature) / T`.
    ///
    /// # Errors
    ///
    /// [`FeedError::BadChord`] for an error or a period that is not positive.
    ///
    /// # Source
    ///
    /// `docs/sources.md#001`: chord error of a sampled curve.
    pub fn with_chord_error(
        mut self,
        error: &SVector<f64, N>,
        period: f64,
    ) -> Result<Self, FeedError> {
        for axis in 0..N {
            let value = error[axis];
            if !(value > 0.0 && period > 0.0 && period.is_finite()) {
                return Err(FeedError::BadChord { axis, value, period });
            }
            let most = 8.0 * value / (period * period);
            let minus = self.minus.as_mut().map(|minus| &mut minus.acceleration[axis]);
            for limit in std::iter::once(&mut self.acceleration[axis]).chain(minus) {
                *limit = limit.min(most);
            }
        }
        Ok(self)
    }

    /// Axes whose acceleration is limited to less than in `own`: by a chord error.
    pub fn lowered_from(&self, own: &Self) -> [bool; N] {
        std::array::from_fn(|axis| self.acceleration[axis] < own.acceleration[axis])
    }
}
