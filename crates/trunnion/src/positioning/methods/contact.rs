//! One contact: fixed lead (Sturz), curvature-matched, the best lead and swivel, a fixed tool axis.

use crate::math;
use crate::positioning::active::ActiveConstraint;
use crate::positioning::check::acceptance::{accept_measured, accept_proposal};
use crate::positioning::check::proposal::{PoseProposal, gouge_depth, measure_proposal};
use crate::positioning::distance::probe::FaceProbe;
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::request::{ContactSide, LocationRequest, ToleranceBand};
use crate::positioning::solve::conditions::offset_curvature;
use crate::positioning::solve::placement::{EndPointFrame, MOST_ROTATION};
use crate::positioning::strip::MeasuredStrip;
use crate::positioning::surface_point::SurfacePoint;
use crate::types::ToolPose;
use nalgebra::{UnitVector3, Vector3};

/// Share of the band by which the contact stays above its lower end. Where the circle bends like the
/// surface the error is flat, and falls a little beside the contact, by up to some 1e-5 of the band
/// before a measurement between samples shows it.
const CLEARANCE: f64 = 1e-4;

/// Halvings of the lead's range where a lead gouges: to 1e-6 of it.
const HALVINGS: u32 = 20;

/// Swivels tried in a row, before the best one's surroundings are narrowed.
const SWIVELS: u32 = 9;

/// Narrowings of the swivel: each to 0.618 of the range, 2 / (SWIVELS - 1) of it at first.
const NARROWINGS: u32 = 14;

/// Places the cutter in contact at `request.at`, inclined by `lead` along the feed; gouging is
/// refused.
pub(crate) fn sturz(
    request: &LocationRequest,
    side: ContactSide,
    lead: f64,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let touch = ContactFrame::new(request, side, &mut probe)?;
    let mut location = accept_proposal(request, &touch.frame, &touch.at(lead, 0.0), &mut probe)?;
    location.active.push(ActiveConstraint::GivenLead);
    Ok(location)
}

/// Places the cutter in contact at `request.at`, inclined until the circle bends like the surface across the feed, and
/// farther where it gouges otherwise.
pub(crate) fn curvature_matched(
    request: &LocationRequest,
    side: ContactSide,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let touch = ContactFrame::new(request, side, &mut probe)?;
    let frame = &touch.frame;
    let Some(bend) = offset_curvature(&frame.first, &frame.v, touch.lift) else {
        return Err(touch.too_concave());
    };
    // Inclined by theta, the circle bends across the feed by sin(theta) / R: equal to the bend of
    // the offset surface for sin(theta) = R k.
    let least = math::asin((frame.major * bend).clamp(0.0, math::sin(MOST_ROTATION)));
    let (proposal, strip) = touch.clear(least, 0.0, &mut probe)?;
    accept_measured(request, frame, &proposal, &strip, &mut probe)
}

/// Places the cutter in contact at `request.at` with the swivel, at most `most` to either side, and the lead that give
/// the widest strip.
pub(crate) fn lead_and_swivel(
    request: &LocationRequest,
    side: ContactSide,
    most: f64,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let touch = ContactFrame::new(request, side, &mut probe)?;
    let mut best: Option<(PoseProposal, MeasuredStrip, f64)> = None;
    // The least lead that does not gouge is the widest: beyond it the circle bends more than the
    // surface, and more the farther it leans.
    let mut width = |swivel: f64, probe: &mut FaceProbe| -> Result<f64, PositioningError> {
        let (proposal, strip) = touch.clear(-MOST_ROTATION, swivel, probe)?;
        let clear = gouge_depth(request.band, &strip) <= 0.0;
        if clear && best.as_ref().is_none_or(|(_, best, _)| strip.width > best.width) {
            best = Some((proposal, strip, swivel));
        }
        Ok(if clear { strip.width } else { -1.0 })
    };
    // A coarse row of swivels finds the basin, golden section its maximum.
    let step = 2.0 * most / f64::from(SWIVELS - 1);
    let mut widest = (f64::NEG_INFINITY, 0.0);
    for k in 0..SWIVELS {
        let swivel = -most + step * f64::from(k);
        let found = width(swivel, &mut probe)?;
        if found > widest.0 {
            widest = (found, swivel);
        }
    }
    let [mut low, mut high] = [(widest.1 - step).max(-most), (widest.1 + step).min(most)];
    for _ in 0..NARROWINGS {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        // The inner points divide the interval by the golden section; the half with the lower width
        // goes.
        let [a, b] = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
        if width(a, &mut probe)? >= width(b, &mut probe)? {
            high = b;
        } else {
            low = a;
        }
    }
    // Every lead of every swivel gouges: accepting the steepest one reports by how much.
    let Some((proposal, strip, _)) = best else {
        let proposal = touch.at(MOST_ROTATION, 0.0);
        return accept_proposal(request, &touch.frame, &proposal, &mut probe);
    };
    accept_measured(request, &touch.frame, &proposal, &strip, &mut probe)
}

/// Places the cutter in contact at `request.at` with a given tool axis, as on three axes.
pub(crate) fn fixed_axis(
    request: &LocationRequest,
    axis: UnitVector3<f64>,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let touch = ContactFrame::new(request, ContactSide::Ahead, &mut probe)?;
    let frame = &touch.frame;
    let n = frame.first.normal().into_inner();
    // The torus' own normal at the contact is -n: its part across the axis points to the circle.
    let up = n.dot(&axis);
    let out = (axis.scale(up) - n).try_normalize(f64::EPSILON);
    let out = out.unwrap_or_else(|| (frame.a - axis.scale(axis.dot(&frame.a))).normalize());
    // The corner that touches lies behind the axis where the surface falls along the feed.
    let side = if out.dot(&frame.a) < 0.0 { ContactSide::Behind } else { ContactSide::Ahead };
    if side == ContactSide::Behind && !request.cutter.centre_cutting() {
        let inner = request.cutter.inner_cutting_radius();
        return Err(PositioningError::NotCentreCutting { inner });
    }
    let lead = math::atan2(axis.dot(&frame.a), up);
    let proposal = PoseProposal { side, ..touch.propose(&out, axis, lead) };
    let mut location = accept_proposal(request, frame, &proposal, &mut probe)?;
    location.active.push(ActiveConstraint::GivenLead);
    Ok(location)
}

/// A contact at `request.at`.
struct ContactFrame<'a> {
    request: &'a LocationRequest<'a>,
    frame: EndPointFrame,
    side: ContactSide,
    /// Height of the circle above the contact \[mm\].
    lift: f64,
}

impl<'a> ContactFrame<'a> {
    fn new(
        request: &'a LocationRequest<'a>,
        side: ContactSide,
        probe: &mut FaceProbe,
    ) -> Result<Self, PositioningError> {
        let frame = EndPointFrame::new(request, side, probe)?;
        let ToleranceBand { lower, upper } = request.band;
        let lift = frame.minor + lower + CLEARANCE * (upper - lower);
        let touch = Self { request, frame, side, lift };
        let concave = touch.frame.first.curvatures()[1];
        if concave * lift >= 1.0 { Err(touch.too_concave()) } else { Ok(touch) }
    }

    fn too_concave(&self) -> PositioningError {
        let (uv, minor) = (self.request.at, self.frame.minor);
        let concave = 1.0 / self.frame.first.curvatures()[1];
        PositioningError::ConcaveRadius { uv, concave, minor }
    }

    /// Proposes the pose inclined by `lead` towards the feed, swivelled towards the strip.
    fn at(&self, lead: f64, swivel: f64) -> PoseProposal {
        let frame = &self.frame;
        let n = frame.first.normal();
        let ahead = frame.a * math::cos(swivel) + frame.v * math::sin(swivel);
        let along = if self.side == ContactSide::Behind { -ahead } else { ahead };
        let (sin, cos) = math::sin_cos(lead);
        // Unit vector square to the axis, towards the contact: the axis n cos + a sin turned by 90
        // degrees.
        let out = along * cos - n.scale(sin);
        let axis = UnitVector3::new_normalize(n.scale(cos) + along * sin);
        self.propose(&out, axis, lead)
    }

    /// Proposes the pose that touches with the corner on the side `out` of the axis.
    fn propose(&self, out: &Vector3<f64>, axis: UnitVector3<f64>, lead: f64) -> PoseProposal {
        let first = &self.frame.first;
        let contact = first.foot.point;
        // The circle's point over the contact lies `lift` above it; the centre lies R back along
        // `out`.
        let center = contact + first.normal().scale(self.lift) - out * self.frame.major;
        let pose = ToolPose { tip: center - axis.scale(self.frame.minor), axis };
        let middle = SurfacePoint::from(&first.foot);
        PoseProposal { pose, side: self.side, middle, ends: None, lead }
    }

    /// Finds the least lead from `least` that does not gouge; the largest one where all do.
    fn clear(
        &self,
        least: f64,
        swivel: f64,
        probe: &mut FaceProbe,
    ) -> Result<(PoseProposal, MeasuredStrip), PositioningError> {
        let mut trial = |lead: f64| -> Result<(PoseProposal, MeasuredStrip), PositioningError> {
            let proposal = self.at(lead, swivel);
            let strip = measure_proposal(self.request, &self.frame, &proposal, probe)?;
            Ok((proposal, strip))
        };
        let ToleranceBand { lower, upper } = self.request.band;
        // Half of the clearance is for the bisection, the other half for rounding.
        let spared = ToleranceBand { lower: lower + 0.5 * CLEARANCE * (upper - lower), upper };
        let gouges = |strip: &MeasuredStrip| gouge_depth(spared, strip) > 0.0;
        let at_least = trial(least)?;
        if !gouges(&at_least.1) {
            return Ok(at_least);
        }
        let [mut low, mut high] = [least, MOST_ROTATION];
        let mut best = trial(high)?;
        if gouges(&best.1) {
            return Ok(best);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let tried = trial(middle)?;
            if gouges(&tried.1) {
                low = middle;
            } else {
                (high, best) = (middle, tried);
            }
        }
        Ok(best)
    }
}
