//! Cutter locations of a ball.

use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::ball_strip::ball_strip;
use crate::positioning::check::body::check_body;
use crate::positioning::check::cutting_zone::cuts_there;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::error::PositioningError;
use crate::positioning::location::{CutterLocation, LocationParts};
use crate::positioning::request::{ContactSide, LocationRequest, ToleranceBand, ToolInclination};
use crate::positioning::solve::placement::EndPointFrame;
use crate::positioning::strip::CuttingContext;
use crate::types::ToolPose;
use nalgebra::UnitVector3;

/// Location of a ball whose strip begins at the end point: it touches at the lower end of the band
/// where the end point lies at the upper end. The tool axis
/// is inclined along the feed unless a direction is given.
pub(crate) fn ball_location(
    request: &LocationRequest,
    side: ContactSide,
    lean: ToolInclination,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let frame = EndPointFrame::new(request, side, &mut probe)?;
    let (first, minor) = (&frame.first, frame.minor);
    let concave = first.curvatures()[1];
    // k (r + e) >= 1: the ball raised by the band does not fit into the hollow.
    if concave * frame.lift >= 1.0 {
        let (uv, concave) = (request.at, 1.0 / concave);
        return Err(PositioningError::ConcaveRadius { uv, concave, minor });
    }
    let touch = touching(&frame, request.band, &mut probe)?;
    let n = touch.normal();
    let center = touch.foot.point + n.scale(minor + request.band.lower);
    // The contact lies beside P1: the feed is projected into the tangent plane there.
    let along = (frame.a - n.scale(n.dot(&frame.a))).normalize();
    let ahead = if side == ContactSide::Behind { -along } else { along };
    // The strip's side, square to the feed.
    let beside = along.cross(&n).scale(request.strip.sign());
    let (sin, cos) = lean.towards.unwrap_or(0.0).sin_cos();
    // Any inclination leaves the same strip; only the part of the ball that cuts differs.
    let leaning = n.scale(lean.angle.cos()) + (ahead * cos + beside * sin) * lean.angle.sin();
    let axis = UnitVector3::new_normalize(leaning);
    let pose = ToolPose { tip: center - axis.scale(minor), axis };
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    check_body(&setting, &pose, request.at, &mut probe)?;
    let strip = ball_strip(&setting, center, &frame.v, &touch, probe)?;
    cuts_there(&setting, &pose, &strip)?;
    let chord = nalgebra::distance(&strip.near.point, &strip.far.point);
    // A chord of a circle of radius r spans the angle 2 asin(c / 2 r).
    let half = (0.5 * chord / minor).min(1.0).asin();
    let found = LocationParts {
        pose,
        side,
        x: [strip.width, 0.0, lean.angle],
        widths: [strip.width; 2],
        arc: 2.0 * half,
        contact_angles: vec![half],
        active: vec![ActiveConstraint::Touch, ActiveConstraint::GivenLead],
        end: strip.far.uv,
        queries: strip.queries,
        marks: Vec::new(),
    };
    Ok(CutterLocation::new(request, &strip, found))
}

/// Finds the contact from which the end point is at the upper end of the band.
fn touching(
    frame: &EndPointFrame,
    band: ToleranceBand,
    probe: &mut FaceProbe,
) -> Result<DistanceReading, PositioningError> {
    // As in `BallSphere::end`: Newton's steps on a function close to `c t^2 - gap`.
    const STEPS: u32 = 20;
    let first = &frame.first;
    let gap = band.upper - band.lower;
    // Over a surface of curvature k the ball rises by (1 / lift - k) t^2 / 2 at the distance
    // t from its contact.
    let curvature = 1.0 / frame.lift - first.normal_curvature(&frame.v);
    let mut t = (2.0 * gap / curvature.max(f64::EPSILON)).sqrt().min(frame.lift);
    let raised = first.foot.point + first.normal().scale(band.upper);
    let mut touch = *first;
    for _ in 0..STEPS {
        let step = frame.v * t;
        touch = probe.read(&(first.foot.point + step), first.ahead(&step))?;
        let center = touch.foot.point + touch.normal().scale(frame.minor + band.lower);
        // Height of the raised end point above the ball; 0 is wanted.
        let outside = (raised - center).norm() - frame.minor;
        let rise = outside + gap;
        // The end point is deeper than the contact itself: the step was far too short.
        if rise <= 0.0 {
            t *= 2.0;
            continue;
        }
        let step = 0.5 * t * outside / rise;
        t -= step;
        if step.abs() <= 1e-9 * frame.lift {
            break;
        }
    }
    Ok(touch)
}
