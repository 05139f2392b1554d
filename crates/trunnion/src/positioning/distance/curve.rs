//! The error round the cutting circle of a pose.

use crate::positioning::distance::circle::ErrorCircle;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::distance::ring::CenterCircle;
use crate::positioning::error::PositioningError;
use crate::positioning::location::contact_center;
use crate::positioning::strip::{CuttingContext, StripQuery};
use crate::types::ToolPose;
use nalgebra::{UnitVector3, Vector3};

/// Returns the circle of a pose and the direction across the feed, to the strip's side.
pub(crate) fn circle_of_pose(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
    middle: &DistanceReading,
) -> Result<(CenterCircle, UnitVector3<f64>), PositioningError> {
    let no_direction = || PositioningError::NoDirection { feed: [0.0; 2], uv: look.uv };
    // On the right of the feed, seen with the normal up, is feed x normal.
    let v = look.feed.cross(&middle.normal()) * look.strip.sign();
    let v = UnitVector3::try_new(v, f64::MIN_POSITIVE).ok_or_else(no_direction)?;
    let center = contact_center(setting.cutter, pose, &look.contact);
    let radius = if setting.cutter.touches_in_one_point() { 0.0 } else { setting.cutter.major() };
    // A ball has no circle; its point needs no direction.
    if radius <= 0.0 {
        let [f, e2] = [Vector3::zeros(); 2];
        return Ok((CenterCircle { center, f, e2, radius }, v));
    }
    // Angle 0 towards the contact; the side of `e2` towards the strip.
    let out = look.contact - center;
    let f = out - pose.axis.scale(pose.axis.dot(&out));
    let f = UnitVector3::try_new(f, f64::MIN_POSITIVE).ok_or_else(no_direction)?;
    let e2 = pose.axis.cross(&f);
    let e2 = if e2.dot(&v) < 0.0 { -e2 } else { e2 };
    Ok((CenterCircle { center, f: f.into_inner(), e2, radius }, v))
}

/// Point of an error curve.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ErrorCurvePoint {
    /// Angle on the circle from over the contact, positive on the strip's side \[rad\].
    pub angle: f64,
    /// Error \[mm\].
    pub error: f64,
}

/// Returns the error round the cutting circle at `2 half + 1` angles, evenly spaced over `[-pi, pi]`.
/// Angle 0 lies over `look.contact`, positive ones on the strip's side.
///
/// # Errors
///
/// [`PositioningError::NoDirection`] for a feed along the normal, [`PositioningError::Closest`].
pub fn error_curve(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
    half: u32,
) -> Result<Vec<ErrorCurvePoint>, PositioningError> {
    let mut probe = FaceProbe::new(setting.face);
    let middle = probe.read(&look.contact, look.uv.into())?;
    let (ring, _) = circle_of_pose(setting, pose, look, &middle)?;
    let circle = ErrorCircle { ring, minor: setting.cutter.contact_arc().radius };
    let samples = circle.all_round(middle.foot.uv.into(), half, &mut probe)?;
    Ok(samples
        .iter()
        .map(|sample| ErrorCurvePoint { angle: sample.psi, error: sample.error })
        .collect())
}
