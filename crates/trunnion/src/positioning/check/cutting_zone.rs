//! Contacts have to lie where the cutter cuts.

use crate::positioning::error::PositioningError;
use crate::positioning::strip::{CuttingContext, MeasuredStrip};
use crate::positioning::surface_point::SurfacePoint;
use crate::types::ToolPose;

/// Share of the band within which a condition counts as reached.
pub(crate) const TOUCHING: f64 = 1e-3;

/// Checks that the strip lies under the part of the underside that cuts.
pub(crate) fn cuts_there(
    setting: &CuttingContext,
    pose: &ToolPose,
    strip: &MeasuredStrip,
) -> Result<(), PositioningError> {
    within_cutting(setting, pose, [strip.near, strip.contact, strip.far].into_iter())
}

pub(crate) fn within_cutting(
    setting: &CuttingContext,
    pose: &ToolPose,
    contacts: impl Iterator<Item = SurfacePoint>,
) -> Result<(), PositioningError> {
    let inner = setting.cutter.inner_cutting_radius();
    for SurfacePoint { uv, point } in contacts {
        let radius = pose.axis.cross(&(point - pose.tip)).norm();
        if radius < inner {
            return Err(PositioningError::NotCutting { uv, radius, inner });
        }
    }
    Ok(())
}
