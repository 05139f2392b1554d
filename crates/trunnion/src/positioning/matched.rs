//! Curvature-matched positioning: one contact, and the lead that bends the circle like the surface.

use super::Active;
use super::Band;
use super::ContactSide;
use super::Location;
use super::PositioningError;
use super::Request;
use super::body;
use super::check::Look;
use super::check::Setting;
use super::check::Strip;
use super::check::strip_of_pose;
use super::constraints::offset_curvature;
use super::placement::Frame;
use super::probe::Probe;
use super::solve::MOST_ROTATION;
use super::widest::check;
use super::widest::cuts_there;
use super::widest::on_sides;
use crate::types::ToolPose;
use nalgebra::UnitVector3;

/// Share of the band by which the contact stays above its lower end: rounding is no gouge.
const MARGIN: f64 = 1e-6;

/// Halvings of the lead's range where the matched lead gouges: to 1e-6 of it.
const HALVINGS: u32 = 20;

/// The location that touches at `request.at` and leans forward until the circle bends like the
/// surface across the feed, and farther where it gouges otherwise.
///
/// A method to compare with: the contact lies inside the strip, which reaches to both sides of
/// `request.at`; the offset range and `axis_near` of the request do not count.
///
/// Source: `docs/sources.md#004`, the baselines.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn curvature_matched(request: &Request) -> Result<Location, PositioningError> {
    check(request)?;
    on_sides(request, |side| matched(request, side))
}

fn matched(request: &Request, side: ContactSide) -> Result<Location, PositioningError> {
    let mut probe = Probe::new(request.face);
    let frame = Frame::new(request, side, &mut probe)?;
    let Band { lower, upper } = request.band;
    let lift = frame.minor + lower + MARGIN * (upper - lower);
    let Some(bend) = offset_curvature(&frame.first, &frame.v, lift) else {
        let (uv, concave) = (request.at, 1.0 / frame.first.curvatures()[1]);
        return Err(PositioningError::ConcaveRadius { uv, concave, minor: frame.minor });
    };
    let least = (frame.major * bend).clamp(0.0, MOST_ROTATION.sin()).asin();
    let touch = Touch { request, frame: &frame, side, lift };
    let mut best = touch.at(least, &mut probe)?;
    if !best.clear(lower) {
        let [mut low, mut high] = [least, MOST_ROTATION];
        best = touch.at(high, &mut probe)?;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let trial = touch.at(middle, &mut probe)?;
            if trial.clear(lower) {
                (high, best) = (middle, trial);
            } else {
                low = middle;
            }
        }
    }
    if !best.clear(lower) {
        return Err(PositioningError::NoStrip {
            uv: request.at,
            smallest: (8.0 * frame.major * (upper - lower)).sqrt(),
            excess: lower - best.strip.front_min.min(best.strip.rear_min),
            binding: Active::Rear,
        });
    }
    let setting = touch.setting();
    cuts_there(&setting, &best.pose, &best.strip)?;
    body::clear(&setting, &best.pose, request.at, &mut probe)?;
    Ok(touch.describe(&best, probe.queries))
}

/// A contact, and what leads are tried with.
struct Touch<'a> {
    request: &'a Request<'a>,
    frame: &'a Frame,
    side: ContactSide,
    lift: f64,
}

/// One lead tried.
struct Trial {
    lead: f64,
    pose: ToolPose,
    strip: Strip,
}

impl Trial {
    fn clear(&self, lower: f64) -> bool {
        self.strip.front_min >= lower && self.strip.rear_min >= lower
    }
}

impl Touch<'_> {
    fn setting(&self) -> Setting<'_> {
        let Request { face, cutter, band, .. } = *self.request;
        Setting { face, cutter, band }
    }

    fn at(&self, lead: f64, probe: &mut Probe) -> Result<Trial, PositioningError> {
        let frame = self.frame;
        let n = frame.first.normal();
        let along = if self.side == ContactSide::Behind { -frame.a } else { frame.a };
        let (sin, cos) = lead.sin_cos();
        let out = along * cos - n.scale(sin);
        let axis = UnitVector3::new_normalize(n.scale(cos) + along * sin);
        let contact = frame.first.foot.point;
        let center = contact + n.scale(self.lift) - out * frame.major;
        let pose = ToolPose { tip: center - axis.scale(frame.minor), axis };
        let (feed, uv, strip) = (frame.a, self.request.at, self.request.strip);
        let look = Look { feed, strip, contact, uv };
        let strip = strip_of_pose(&self.setting(), &pose, &look)?;
        probe.queries += strip.queries;
        Ok(Trial { lead, pose, strip })
    }

    fn describe(&self, best: &Trial, queries: u32) -> Location {
        let Trial { lead, pose, strip } = best;
        let center = pose.tip + pose.axis.scale(self.frame.minor);
        let ring = |p: &nalgebra::Point3<f64>| {
            let out = p - center;
            out - pose.axis.scale(pose.axis.dot(&out))
        };
        let arc = ring(&strip.near.1).angle(&ring(&strip.far.1));
        let touch = ring(&strip.near.1).angle(&ring(&self.frame.first.foot.point));
        Location {
            strip_width: strip.width,
            chord_width: strip.width,
            offset: strip.width,
            offset_direction: 0.0,
            rotation: *lead,
            center,
            pose: *pose,
            side: self.side,
            strip: self.request.strip,
            arc,
            contact_angles: vec![touch],
            active: vec![Active::Touch, Active::GivenLead],
            front_max: strip.front_max,
            front_max_bound: strip.front_max_bound,
            front_min: strip.front_min,
            rear_min: strip.rear_min,
            rear_min_bound: strip.rear_min_bound,
            queries,
            contact: strip.contact.1,
            contact_uv: strip.contact.0,
            end: strip.far.0,
            near: strip.near.0,
            far: strip.far.0,
        }
    }
}
