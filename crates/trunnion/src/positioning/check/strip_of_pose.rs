//! Independent measurement of the strip that a pose leaves.

use crate::positioning::check::ball_strip::ball_strip;
use crate::positioning::check::survey::CircleSurvey;
use crate::positioning::distance::circle::ErrorCircle;
use crate::positioning::distance::curve::circle_of_pose;
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::strip::{CuttingContext, MeasuredStrip, StripQuery};
use crate::types::ToolPose;

/// Looks at the strip a pose leaves, without any of the assumptions it was made with.
///
/// The signed error (distance from the surface minus the corner radius) is sampled round the whole
/// circle, extrema and ends of the strip are refined; between samples it is bounded through a range
/// of its second derivative, from curvatures bounded over all the surface that feet can reach.
/// The bounds hold for the foot that is followed round the circle; of the continuation beyond the
/// face's domain they know the curvature at the samples only.
///
/// A pose that gouges is not an error: `front_min` and `rear_min` say so.
///
/// # Errors
///
/// [`PositioningError::NoDirection`] for a feed along the normal, [`PositioningError::Closest`].
pub fn strip_of_pose(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
) -> Result<MeasuredStrip, PositioningError> {
    let mut probe = FaceProbe::new(setting.face);
    let minor = setting.cutter.minor();
    let middle = probe.read(&look.contact, look.uv)?;
    let (ring, v) = circle_of_pose(setting, pose, look, &middle)?;
    if ring.radius <= 0.0 {
        return ball_strip(setting, ring.center, (&v, &middle), probe);
    }
    let circle = ErrorCircle { ring, minor };
    let (axis, v) = (pose.axis, v.into_inner());
    let survey =
        CircleSurvey { setting, circle, axis, v, half_arc: 0.0, seen: &[], thorough: true };
    survey.strip(middle.foot.uv, &mut probe)
}
