//! Poses that methods propose.

use crate::positioning::check::strip_of_pose::strip_of_pose;
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::request::{ContactSide, LocationRequest, ToleranceBand};
use crate::positioning::solve::placement::{EndPointFrame, TorusPlacement};
use crate::positioning::strip::{CuttingContext, MeasuredStrip, StripQuery};
use crate::positioning::surface_point::SurfacePoint;
use crate::types::{ToolPose, Uv};

/// A pose that a method proposes, with its description.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PoseProposal {
    pub(crate) pose: ToolPose,
    pub(crate) side: ContactSide,
    /// Point near the middle of the strip.
    pub(crate) middle: SurfacePoint,
    /// `(w, alpha, theta)` of a pose through two end points.
    pub(crate) ends: Option<[f64; 3]>,
    /// Lead of a pose with one contact \[rad\].
    pub(crate) lead: f64,
}

impl PoseProposal {
    /// Proposes the pose through two end points.
    pub(crate) fn through(
        request: &LocationRequest,
        side: ContactSide,
        frame: &EndPointFrame,
        at: &TorusPlacement,
    ) -> Self {
        let (Uv { u, v }, Uv { u: u2, v: v2 }) = (request.at, at.second.foot.uv);
        let uv = Uv::new(0.5 * (u + u2), 0.5 * (v + v2));
        let point = request.face.face().surface.point(uv.u, uv.v);
        let pose = at.pose(frame.minor);
        Self { pose, side, middle: SurfacePoint { uv, point }, ends: Some(at.x), lead: at.x[2] }
    }
}

pub(crate) fn cutting_context<'a>(request: &LocationRequest<'a>) -> CuttingContext<'a> {
    let LocationRequest { face, cutter, band, .. } = *request;
    CuttingContext { face, cutter, band }
}

pub(crate) fn strip_query(
    request: &LocationRequest,
    frame: &EndPointFrame,
    proposal: &PoseProposal,
) -> StripQuery {
    let SurfacePoint { uv, point: contact } = proposal.middle;
    StripQuery { feed: frame.a, strip: request.strip, contact, uv }
}

/// Measures the strip of a proposal independently.
pub(crate) fn measure_proposal(
    request: &LocationRequest,
    frame: &EndPointFrame,
    proposal: &PoseProposal,
    probe: &mut FaceProbe,
) -> Result<MeasuredStrip, PositioningError> {
    let strip = strip_of_pose(
        &cutting_context(request),
        &proposal.pose,
        &strip_query(request, frame, proposal),
    )?;
    probe.queries += strip.queries;
    Ok(strip)
}

/// Returns the depth of the strip or the rest of the cutter below the band \[mm\]; 0 where nothing is
/// below.
pub(crate) fn gouge_depth(band: ToleranceBand, strip: &MeasuredStrip) -> f64 {
    (band.lower - strip.front_min.min(strip.rear_min)).max(0.0)
}
