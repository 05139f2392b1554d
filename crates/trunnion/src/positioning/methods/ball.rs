//! A ball, which touches in one point, and cutters with an arc that stands for one: the tip of a tapered cutter, the
//! large arc of a lens or a barrel.

use crate::math;
use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::ball_strip::{PlacedBall, ball_strip};
use crate::positioning::check::body::check_body;
use crate::positioning::check::cutting_zone::cuts_there;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::error::PositioningError;
use crate::positioning::location::{CutterLocation, LocationParts};
use crate::positioning::methods::arc_fit;
use crate::positioning::methods::arc_limit::on_arc;
use crate::positioning::methods::touching_ball::TouchingBall;
use crate::positioning::request::{ContactSide, LocationRequest, ToleranceBand, ToolInclination};
use crate::positioning::solve::placement::EndPointFrame;
use crate::positioning::strip::CuttingContext;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// Location of a ball whose strip begins at the end point: it touches at the lower end of the band
/// where the end point lies at the upper end. The tool axis
/// is inclined along the feed unless a direction is given; that of a barrel to the strip's side.
pub(crate) fn ball_location(
    request: &LocationRequest,
    side: ContactSide,
    lean: ToolInclination,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let frame = EndPointFrame::new(request, side, &mut probe)?;
    let lean = if request.cutter.is_barrel() {
        let angle = request.cutter.contact_arc().inclinations.clamp(lean.angle);
        ToolInclination { angle, ..lean }
    } else {
        lean
    };
    let found = on_arc(request.cutter, first_band(request, &frame), lean, |band, lean| {
        touching_ball(&LocationRequest { band, ..*request }, &frame, lean, &mut probe)
    })?;
    let (TouchingBall { pose, strip, .. }, lean) = found;
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    check_body(&setting, &pose, request.at, &mut probe)?;
    cuts_there(&setting, &pose, &strip)?;
    let chord = nalgebra::distance(&strip.near.point, &strip.far.point);
    // A chord of a circle of radius r spans the angle 2 asin(c / 2 r).
    let half = math::asin((0.5 * chord / frame.minor).min(1.0));
    let found = LocationParts {
        pose,
        side,
        x: [strip.width, 0.0, lean.angle],
        widths: [strip.width; 2],
        arc: 2.0 * half,
        contact_angles: vec![half],
        active: vec![ActiveConstraint::Touch, ActiveConstraint::GivenLead],
        end: strip.far.uv,
        queries: probe.queries,
        marks: Vec::new(),
    };
    Ok(CutterLocation::new(request, &strip, found))
}

/// Returns the band with which the search for a strip on the arc begins.
///
/// A face may bend nearly as the arc of a barrel does. Then the whole band gives a strip that is far longer than the arc.
/// This band gives one of which half is as long as the arc at most, by the curvature at the end point.
fn first_band(request: &LocationRequest, frame: &EndPointFrame) -> ToleranceBand {
    let ToleranceBand { lower, upper } = request.band;
    if !request.cutter.is_barrel() {
        return request.band;
    }
    let arc = request.cutter.contact_arc();
    let bend = arc.radius.recip() - frame.first.normal_curvature(&frame.v);
    let length = arc.radius * arc.inclinations.width();
    // The gap at the distance t from a contact is bend t^2 / 2.
    let most = 0.5 * bend.max(0.0) * length * length;
    ToleranceBand { lower, upper: if most > 0.0 { upper.min(lower + most) } else { upper } }
}

/// Places the ball in contact, and measures its strip.
fn touching_ball(
    request: &LocationRequest,
    frame: &EndPointFrame,
    lean: ToolInclination,
    probe: &mut FaceProbe,
) -> Result<TouchingBall, PositioningError> {
    let arc = request.cutter.contact_arc();
    let is_barrel = request.cutter.is_barrel();
    let (first, minor) = (&frame.first, frame.minor);
    let usual = if is_barrel { FRAC_PI_2 } else { 0.0 };
    let (sin, cos) = math::sin_cos(lean.towards.unwrap_or(usual));
    // Directions along the feed and to the strip's side, as they are at a contact.
    let towards = |along: &Vector3<f64>, beside: &Vector3<f64>| {
        let ahead = if frame.side == ContactSide::Behind { -along } else { *along };
        ahead * cos + beside * sin
    };
    if is_barrel {
        arc_fit::fits(&arc, first, &towards(&frame.a, &frame.v), lean.angle)?;
    } else {
        let concave = first.curvatures()[1];
        // k (r + e) >= 1: the ball raised by the band does not fit into the hollow.
        if concave * (minor + request.band.upper) >= 1.0 {
            let (uv, concave) = (request.at, 1.0 / concave);
            return Err(PositioningError::ConcaveRadius { uv, concave, minor });
        }
    }
    let touch = touching(frame, request.band, probe)?;
    let n = touch.normal();
    let center = touch.foot.point + n.scale(minor + request.band.lower);
    // The contact lies beside P1: the feed is projected into the tangent plane there.
    let along = (frame.a - n.scale(n.dot(&frame.a))).normalize();
    // The strip's side, square to the feed.
    let beside = along.cross(&n).scale(request.strip.sign());
    let towards = towards(&along, &beside);
    if is_barrel {
        arc_fit::fits(&arc, &touch, &towards, lean.angle)?;
    }
    // Any inclination leaves the same strip; only the part of the ball that cuts differs.
    let pose = arc.pose(center, &n, &towards, lean.angle);
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    // In the plane of its arc a barrel is a ball, and in no other.
    let across = if is_barrel { &beside } else { &frame.v };
    let ball = PlacedBall { center, pose: &pose, limit: None };
    let strip = ball_strip(&setting, ball, across, &touch, probe)?;
    Ok(TouchingBall { pose, center, strip })
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
    let lift = frame.minor + band.upper;
    let curvature = 1.0 / lift - first.normal_curvature(&frame.v);
    let mut t = (2.0 * gap / curvature.max(f64::EPSILON)).sqrt().min(lift);
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
        if step.abs() <= 1e-9 * lift {
            break;
        }
    }
    Ok(touch)
}
