//! Axis limits.

use super::error::FeedError;
use nalgebra::SVector;

/// Velocity, acceleration and jerk limits of the axes. All values are finite and positive.
///
/// Begin with [`Limits::symmetric`] and change the rest by struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<const N: usize> {
    /// Axis velocities while cutting, leading in and leading out \[axis unit/s\].
    pub velocity: SVector<f64, N>,
    /// Axis velocities on links \[axis unit/s\].
    pub rapid: SVector<f64, N>,
    /// Axis accelerations \[axis unit/s²\].
    pub acceleration: SVector<f64, N>,
    /// Axis jerks \[axis unit/s³\]: kept by [`jerk()`](crate::feed::jerk()); measured, not kept, by
    /// [`optimal()`](crate::feed::optimal()).
    pub jerk: Option<SVector<f64, N>>,
    /// Limits towards minus where they differ; `None` for limits that are the same in both
    /// directions. [`optimal()`](crate::feed::optimal()), [`super::FeedStream`] and [`given()`](crate::feed::given()) use them to
    /// the full. Planners with jerk limits and [`blocks()`](crate::feed::blocks()) keep the smaller limit of both
    /// directions.
    pub minus: Option<MinusLimits<N>>,
}

/// Limits towards minus: a falling axis brakes less than it speeds up. All values are finite and
/// positive.
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
    /// Makes limits that are the same in both directions, and on links as on cuts.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Vector2;
    /// use trunnion_motion::feed::Limits;
    ///
    /// let [velocity, acceleration] = [Vector2::repeat(500.0), Vector2::repeat(2000.0)];
    /// let limits = Limits::symmetric(velocity, acceleration,
    /// Vector2::repeat(5e4)).without_jerk();
    /// assert_eq!((limits.rapid, limits.jerk), (velocity, None));
    /// ```
    #[must_use]
    pub fn symmetric(
        velocity: SVector<f64, N>,
        acceleration: SVector<f64, N>,
        jerk: SVector<f64, N>,
    ) -> Self {
        Self { velocity, rapid: velocity, acceleration, jerk: Some(jerk), minus: None }
    }

    /// Drops the jerk limits.
    #[must_use]
    pub const fn without_jerk(mut self) -> Self {
        self.jerk = None;
        self
    }

    /// Returns limits that hold in both directions: the smaller of both, axis by axis.
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
    /// Lowers the accelerations until a straight line between two setpoints leaves the motion of
    /// no axis by more than `error` \[axis unit\]; infinite for no limit. The setpoints are
    /// `period` \[s\] apart.
    ///
    /// A chord over `T` of a motion whose acceleration is at most `a` is off by at most `a T² /
    /// 8`. So `a <= 8 e / T²` is enough; on a circle that is `v <= sqrt(8 e / curvature) / T`.
    ///
    /// # Errors
    ///
    /// [`FeedError::BadChord`] for an error or a period that is not positive.
    ///
    /// # Source
    ///
    /// `docs/sources.md#001`: chord error of a sampled curve.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Vector1;
    /// use trunnion_motion::feed::Limits;
    ///
    /// let limits = Limits::symmetric(Vector1::new(500.0), Vector1::new(5000.0),
    /// Vector1::new(1e6));
    /// // 1 um at 10 ms: 8 * 0.001 / 0.01² = 80 mm/s².
    /// let limits = limits.with_chord_error(&Vector1::new(0.001), 0.01)?;
    /// assert!((limits.acceleration[0] - 80.0).abs() < 1e-9);
    /// # Ok::<(), trunnion_motion::feed::FeedError>(())
    /// ```
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
            // a T² / 8 <= e, in both directions of the axis.
            let most = 8.0 * value / (period * period);
            let minus = self.minus.as_mut().map(|minus| &mut minus.acceleration[axis]);
            for limit in std::iter::once(&mut self.acceleration[axis]).chain(minus) {
                *limit = limit.min(most);
            }
        }
        Ok(self)
    }

    /// Returns which axes have a lower acceleration limit than in `own`, because of a chord error.
    pub fn lowered_from(&self, own: &Self) -> [bool; N] {
        std::array::from_fn(|axis| self.acceleration[axis] < own.acceleration[axis])
    }
}
