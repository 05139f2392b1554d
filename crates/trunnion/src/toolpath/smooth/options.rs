//! Options of smoothing.

use super::coordinates::{axis, tip};
use crate::types::{PoseCoordinates, PoseTolerance};

/// Path between the stations that a smoothed path stands for and is compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SmoothReference {
    /// Straight moves of tip and contact, great circles of the tool axis at the same share: a file
    /// of cutter locations, taken literally.
    Chords,
    /// The curve through the stations that is the pass: the C2 cubic of [`through`](crate::toolpath::through).
    /// [`PathSmoother::push_along`](crate::toolpath::PathSmoother::push_along) gives it to a smoother, which takes
    /// the [`local_cubic`](crate::toolpath::local_cubic) otherwise.
    Curve,
}

/// Options of smoothing. Begin with [`SmoothOptions::within`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SmoothOptions {
    /// Largest distance of tip and contact \[mm\].
    pub tip: f64,
    /// Largest angle of the tool axis \[rad\].
    pub axis: f64,
    /// Path between the stations that the tolerance refers to.
    pub reference: SmoothReference,
    /// Distance from the tip at which a turn of the tool axis counts as movement \[mm per rad\];
    /// only used where tip and contact (nearly) stand still.
    pub lever: f64,
    /// Turn of the direction of the tip from which a station is a corner, if it stands out by more
    /// than the tolerance \[rad\].
    pub corner: f64,
    /// Ratio of neighbouring steps from which the station between them is a corner.
    pub step_ratio: f64,
    /// Largest turn of the direction of the tip that is blended; at others the tool stops \[rad\].
    pub largest_blend: f64,
    /// Stations in memory at a time; at least 64.
    pub window: usize,
}

impl SmoothOptions {
    /// Smooths within a tolerance of straight moves between the stations, with a lever of 10 mm.
    ///
    /// Stations at which the path turns by 0.35 rad (20 degrees), or the steps change eightfold, are
    /// corners; corners of up to 2 rad are blended. 1024 stations are in memory at a time.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::toolpath::{SmoothOptions, SmoothReference};
    /// use trunnion::types::PoseTolerance;
    ///
    /// let tolerance = PoseTolerance { tip: 0.005, axis: 1e-4 };
    /// let mut options = SmoothOptions::within(tolerance);
    /// options.reference = SmoothReference::Curve;
    /// assert_eq!(options.tip, 0.005);
    /// ```
    #[must_use]
    pub const fn within(tolerance: PoseTolerance) -> Self {
        Self {
            tip: tolerance.tip,
            axis: tolerance.axis,
            reference: SmoothReference::Chords,
            lever: 10.0,
            corner: 0.35,
            step_ratio: 8.0,
            largest_blend: 2.0,
            window: 1024,
        }
    }
}

/// Tolerances and what they refer to.
#[derive(Debug, Clone, Copy)]
pub(super) struct SmoothLimits {
    pub(super) tip: f64,
    pub(super) axis: f64,
    pub(super) reference: SmoothReference,
}

impl SmoothLimits {
    /// Returns the square of a difference in tip and axis, in tolerances.
    pub(super) fn square(&self, difference: &PoseCoordinates) -> f64 {
        // Sum of both squares: neither part hides behind the other.
        let tip = tip(difference).norm_squared() / (self.tip * self.tip);
        tip + axis(difference).norm_squared() / (self.axis * self.axis)
    }
}
