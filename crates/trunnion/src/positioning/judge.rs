//! What a pose is worth, whichever method proposed it.

use super::ActiveConstraint;
use super::ContactSide;
use super::CutterLocation;
use super::LocationRequest;
use super::PositioningError;
use super::ToleranceBand;
use super::body;
use super::check::CuttingContext;
use super::check::MeasuredStrip;
use super::check::StripQuery;
use super::check::across;
use super::check::strip_of_pose;
use super::circle::Circle;
use super::circle::Extremum;
use super::curve::ring;
use super::disc::Disc;
use super::location::Found;
use super::placement::Frame;
use super::placement::Placement;
use super::probe::Probe;
use super::probe::Reading;
use super::widest::cuts_there;
use super::widest::within_cutting;
use crate::types::ToolPose;
use nalgebra::Point3;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Share of the band that searches keep free at both ends: rounding is no gouge.
const MARGIN: f64 = 1e-6;

/// Share of the band within which a condition counts as reached: searches on a grid stop short.
const REACHED: f64 = 0.02;

/// Share of the band within which the cutter touches.
const TOUCHING: f64 = 1e-3;

/// Half the samples round the circle among which extrema are looked for.
const HALF: u32 = 60;

/// A pose that a method proposes, and how it describes it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Proposal {
    pub(super) pose: ToolPose,
    pub(super) side: ContactSide,
    /// About where the strip's middle lies.
    pub(super) middle: ([f64; 2], Point3<f64>),
    /// `(w, alpha, theta)` of a pose through two end points.
    pub(super) ends: Option<[f64; 3]>,
    /// Lead of a pose with one contact \[rad\].
    pub(super) lead: f64,
}

impl Proposal {
    /// The pose through two end points.
    pub(super) fn through(
        request: &LocationRequest,
        side: ContactSide,
        frame: &Frame,
        at: &Placement,
    ) -> Self {
        let ([u1, v1], [u2, v2]) = (request.at, at.second.foot.uv);
        let uv = [0.5 * (u1 + u2), 0.5 * (v1 + v2)];
        let point = request.face.face().surface.point(uv[0], uv[1]);
        let pose = at.pose(frame.minor);
        Self { pose, side, middle: (uv, point), ends: Some(at.x), lead: at.x[2] }
    }
}

/// The band without its margins.
pub(super) fn inner(ToleranceBand { lower, upper }: ToleranceBand) -> ToleranceBand {
    let margin = MARGIN * (upper - lower);
    ToleranceBand { lower: lower + margin, upper: upper - margin }
}

/// The independent look at a proposal.
pub(super) fn look(
    request: &LocationRequest,
    frame: &Frame,
    proposal: &Proposal,
    probe: &mut Probe,
) -> Result<MeasuredStrip, PositioningError> {
    let strip = strip_of_pose(&setting(request), &proposal.pose, &eye(request, frame, proposal))?;
    probe.queries += strip.queries;
    Ok(strip)
}

/// How far the strip or the rest of the cutter comes below the band \[mm\]; 0 where nothing does.
pub(super) fn depth(band: ToleranceBand, strip: &MeasuredStrip) -> f64 {
    (band.lower - strip.front_min.min(strip.rear_min)).max(0.0)
}

/// The location a proposal makes, if it keeps the band, cuts where it touches, and the rest of the
/// tool is clear.
pub(super) fn judge(
    request: &LocationRequest,
    frame: &Frame,
    proposal: &Proposal,
    probe: &mut Probe,
) -> Result<CutterLocation, PositioningError> {
    let strip = look(request, frame, proposal, probe)?;
    accept(request, frame, (proposal, &strip), probe)
}

/// As [`judge`], the strip being known.
pub(super) fn accept(
    request: &LocationRequest,
    frame: &Frame,
    (proposal, strip): (&Proposal, &MeasuredStrip),
    probe: &mut Probe,
) -> Result<CutterLocation, PositioningError> {
    let (setting, pose) = (setting(request), &proposal.pose);
    let findings = Findings::new(request, frame, (proposal, strip), probe)?;
    let depth = depth(request.band, strip).max(request.band.lower - findings.least);
    if depth > 0.0 {
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
        return Err(above(request, strip));
    }
    cuts_there(&setting, pose, strip)?;
    within_cutting(&setting, pose, findings.touching.into_iter())?;
    body::clear(&setting, pose, request.at, probe)?;
    let width = findings.width;
    let x = proposal.ends.unwrap_or([width, 0.0, proposal.lead]);
    let found = Found {
        pose: *pose,
        side: proposal.side,
        x,
        widths: [width, Frame::width(x)],
        arc: findings.arc,
        contact_angles: findings.contacts,
        active: findings.active,
        end: strip.far.0,
        queries: probe.queries,
        marks: Vec::new(),
    };
    Ok(CutterLocation::new(request, strip, found))
}

/// Nowhere does the cutter come as close as the upper end of the band.
fn above(request: &LocationRequest, strip: &MeasuredStrip) -> PositioningError {
    let ToleranceBand { lower, upper } = request.band;
    PositioningError::NoStrip {
        uv: request.at,
        smallest: (8.0 * request.cutter.major() * (upper - lower)).sqrt(),
        excess: strip.front_max - upper,
        binding: ActiveConstraint::Middle,
    }
}

fn setting<'a>(request: &LocationRequest<'a>) -> CuttingContext<'a> {
    let LocationRequest { face, cutter, band, .. } = *request;
    CuttingContext { face, cutter, band }
}

fn eye(request: &LocationRequest, frame: &Frame, proposal: &Proposal) -> StripQuery {
    let (uv, contact) = proposal.middle;
    StripQuery { feed: frame.a, strip: request.strip, contact, uv }
}

/// What is found on the circle and under the disc, whatever the method meant to do.
struct Findings {
    /// Width in the plane of the end point or contact asked for \[mm\].
    width: f64,
    /// Angle between the ends of the strip \[rad\].
    arc: f64,
    /// Minima of the error inside the strip, as angles from the first end point, or from the strip's
    /// beginning where there is none \[rad\].
    contacts: Vec<f64>,
    active: Vec<ActiveConstraint>,
    /// Least error of the strip's minima, which the look may step over where two extrema lie close
    /// together \[mm\].
    least: f64,
    /// Where the cutter touches: parameters and points of the surface.
    touching: Vec<([f64; 2], Point3<f64>)>,
}

impl Findings {
    fn new(
        request: &LocationRequest,
        frame: &Frame,
        (proposal, strip): (&Proposal, &MeasuredStrip),
        probe: &mut Probe,
    ) -> Result<Self, PositioningError> {
        let (setting, pose) = (setting(request), &proposal.pose);
        let (uv, contact) = proposal.middle;
        let middle = probe.read(&contact, uv)?;
        let (ring, _) = ring(&setting, pose, &eye(request, frame, proposal), &middle)?;
        let minor = setting.cutter.minor();
        if ring.radius <= 0.0 {
            let half =
                (0.5 * nalgebra::distance(&strip.near.1, &strip.far.1) / minor).min(1.0).asin();
            let (contacts, touching) = (vec![half], vec![strip.contact]);
            let (arc, active) = (2.0 * half, vec![ActiveConstraint::Touch]);
            let (width, least) = (strip.width, strip.front_min);
            return Ok(Self { width, arc, contacts, active, least, touching });
        }
        let circle = Circle { ring, minor };
        let extrema = all_round(&circle, middle.foot.uv, probe)?;
        let lift = minor + request.band.upper;
        let ends = [strip.near, strip.far].map(|(uv, point)| probe.foot(&point, uv));
        let [near, far] = ends;
        let (near, far) = (near?, far?);
        let width = across(&frame.v, &near, &far).max(0.0);
        let [near, far, first] = [&near, &far, &frame.first].map(|end| ring.angle_over(end, lift));
        let origin = if proposal.ends.is_some() { first } else { near };
        let (contacts, active, touching) = (Vec::new(), Vec::new(), Vec::new());
        let (arc, least) = (far - near, f64::INFINITY);
        let mut found = Self { width, arc, contacts, active, least, touching };
        found.round(&extrema, request.band, (near..=far, origin));
        found.underside(request, pose, &[&frame.first, &middle], probe)?;
        Ok(found)
    }

    fn add(&mut self, active: ActiveConstraint) {
        if !self.active.contains(&active) {
            self.active.push(active);
        }
    }

    fn round(
        &mut self,
        extrema: &[Extremum],
        band: ToleranceBand,
        (strip, origin): (RangeInclusive<f64>, f64),
    ) {
        let width = band.upper - band.lower;
        for Extremum { sample, value, maximum } in extrema {
            let inside = strip.contains(&sample.psi);
            if *maximum {
                if inside && band.upper - value <= REACHED * width {
                    self.add(ActiveConstraint::Middle);
                }
                continue;
            }
            if inside {
                self.contacts.push(sample.psi - origin);
                self.least = self.least.min(*value);
            }
            if value - band.lower <= REACHED * width {
                self.add(if inside { ActiveConstraint::Touch } else { ActiveConstraint::Rear });
            }
            if value - band.lower <= TOUCHING * width {
                let foot = &sample.reading.foot;
                self.touching.push((foot.uv, foot.point));
            }
        }
    }

    fn underside(
        &mut self,
        request: &LocationRequest,
        pose: &ToolPose,
        nearby: &[&Reading],
        probe: &mut Probe,
    ) -> Result<(), PositioningError> {
        let ToleranceBand { lower, upper } = request.band;
        let disc = Disc { center: pose.tip, axis: pose.axis, radius: request.cutter.major() };
        let Some(near) = nearby.first() else { return Ok(()) };
        let centre = disc.middle(near, probe)?;
        if let Some((_, reading)) = disc.lowest(&centre, nearby, probe)? {
            let over = reading.distance - lower;
            if over <= REACHED * (upper - lower) {
                self.add(ActiveConstraint::Disc);
            }
            if over <= TOUCHING * (upper - lower) {
                self.touching.push((reading.foot.uv, reading.foot.point));
            }
        }
        Ok(())
    }
}

/// Local extrema round the whole circle, in the order of their angles; the opposite point is none.
fn all_round(
    circle: &Circle,
    guess: [f64; 2],
    probe: &mut Probe,
) -> Result<Vec<Extremum>, PositioningError> {
    let seed = circle.read(0.0, guess, probe)?;
    let step = PI / f64::from(HALF);
    let angles = |sign: f64| (1..=HALF).map(move |k| sign * step * f64::from(k));
    let mut samples = circle.walk(angles(-1.0), &seed, probe)?;
    samples.reverse();
    samples.push(seed);
    samples.extend(circle.walk(angles(1.0), &seed, probe)?);
    circle.extrema(&samples, probe)
}
