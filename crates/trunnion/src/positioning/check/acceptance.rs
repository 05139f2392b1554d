//! Acceptance of a proposed pose as a cutter location.

use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::body::check_body;
use crate::positioning::check::cutting_zone::{cuts_there, within_cutting};
use crate::positioning::check::findings::PoseFindings;
use crate::positioning::check::proposal::{
    PoseProposal, cutting_context, gouge_depth, measure_proposal,
};
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::{CutterLocation, LocationParts};
use crate::positioning::request::LocationRequest;
use crate::positioning::solve::placement::EndPointFrame;
use crate::positioning::strip::MeasuredStrip;

/// Returns the location that a proposal makes, if it keeps the band, cuts where it touches, and the rest of the
/// tool is clear.
pub(crate) fn accept_proposal(
    request: &LocationRequest,
    frame: &EndPointFrame,
    proposal: &PoseProposal,
    probe: &mut FaceProbe,
) -> Result<CutterLocation, PositioningError> {
    let strip = measure_proposal(request, frame, proposal, probe)?;
    accept_measured(request, frame, proposal, &strip, probe)
}

/// Accepts a proposal whose strip is measured already.
pub(crate) fn accept_measured(
    request: &LocationRequest,
    frame: &EndPointFrame,
    proposal: &PoseProposal,
    strip: &MeasuredStrip,
    probe: &mut FaceProbe,
) -> Result<CutterLocation, PositioningError> {
    let (setting, pose) = (cutting_context(request), &proposal.pose);
    let findings = PoseFindings::new(request, frame, proposal, strip, probe)?;
    let depth = gouge_depth(request.band, strip).max(request.band.lower - findings.least);
    if depth > 0.0 {
        // The part that goes deepest gives the remedy.
        let front = strip.front_min.min(findings.least);
        let binding = if front <= strip.rear_min {
            ActiveConstraint::Touch
        } else if findings.active.contains(&ActiveConstraint::Disc) {
            ActiveConstraint::Disc
        } else {
            ActiveConstraint::Rear
        };
        return Err(PositioningError::Gouges { uv: request.at, depth, binding });
    }
    if findings.width <= 0.0 {
        return Err(never_in_band(request, strip));
    }
    cuts_there(&setting, pose, strip)?;
    within_cutting(&setting, pose, findings.touching.into_iter())?;
    check_body(&setting, pose, request.at, probe)?;
    let width = findings.width;
    let x = proposal.ends.unwrap_or([width, 0.0, proposal.lead]);
    let found = LocationParts {
        pose: *pose,
        side: proposal.side,
        x,
        widths: [width, EndPointFrame::width(x)],
        arc: findings.arc,
        contact_angles: findings.contacts,
        active: findings.active,
        end: strip.far.uv,
        queries: probe.queries,
        marks: Vec::new(),
    };
    Ok(CutterLocation::new(request, strip, found))
}

/// Error of a cutter that nowhere comes as close as the upper end of the band.
fn never_in_band(request: &LocationRequest, strip: &MeasuredStrip) -> PositioningError {
    PositioningError::NoStrip {
        uv: request.at,
        smallest: request.narrowest_strip(),
        excess: strip.front_max - request.band.upper,
        binding: ActiveConstraint::Middle,
    }
}
