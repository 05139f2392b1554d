//! Polynomial spans of a smoothed path.

use super::bound;
use super::coordinates::{axis, tip};
use super::report::PathDeviation;
use crate::types::{Interval, PoseSpan, PoseTolerance, ToolPose};

/// One polynomial of a smoothed path.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SmoothSpan {
    /// Parameters of its start and end; spans follow one another without gaps.
    pub range: Interval,
    /// The polynomial, over the distance from its start.
    pub span: PoseSpan,
    /// Deviation from the reference.
    pub deviated: PathDeviation,
    /// Index of the last station before it, or at its start.
    pub station: usize,
    /// `true` if the tool rests where the span starts: a corner that was not blended.
    pub after_stop: bool,
}

impl SmoothSpan {
    /// Returns the number of equal parts of the parameter at which straight moves and great
    /// circles between their ends keep within `tolerance` of the span. The
    /// distance is at most an eighth of the largest second derivative, which lies in the convex
    /// hull of its Bernstein coefficients.
    pub fn chords(&self, tolerance: PoseTolerance) -> u32 {
        let PoseTolerance { tip, axis } = tolerance;
        let width = self.range.width();
        // A chord leaves its curve by at most |f''| w^2 / 8, so that n parts leave it by 1 / n^2 of
        // that.
        let [place, turn] = bound::bend(&self.span.coefficients, width);
        // Axis vectors are unit to within the tolerance of the axis; chords of up to a right angle
        // come no closer than cos 45 degrees to the centre.
        let parts = (0.125 * (place / tip).max(std::f64::consts::SQRT_2 * turn / axis)).sqrt();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count")]
        let parts = parts.ceil().clamp(1.0, f64::from(u16::MAX)) as u32;
        parts
    }

    /// Returns the tool pose at a share of the span; `None` if the axis vector vanishes there.
    pub fn pose(&self, share: f64) -> Option<ToolPose> {
        let x = self.span.value(share * self.range.width());
        ToolPose::new(tip(&x).into(), axis(&x).into())
    }
}
