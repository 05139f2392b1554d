//! The error along the cutting circle as a curve.

use super::CutterLocation;
use super::LocationRequest;
use super::PositioningError;
use super::check::CuttingContext;
use super::check::StripQuery;
use super::circle::Circle;
use super::circle::Sample;
use super::placement::Frame;
use super::placement::Ring;
use super::probe::Probe;
use super::probe::Reading;
use crate::types::ToolPose;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Circle of a pose and the direction across the feed, to the strip's side.
pub(super) fn ring(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
    middle: &Reading,
) -> Result<(Ring, UnitVector3<f64>), PositioningError> {
    let no_direction = || PositioningError::NoDirection { feed: [0.0; 2], uv: look.uv };
    let v = look.feed.cross(&middle.normal()) * look.strip.sign();
    let v = UnitVector3::try_new(v, f64::MIN_POSITIVE).ok_or_else(no_direction)?;
    let center = pose.tip + pose.axis.scale(setting.cutter.minor());
    let radius = setting.cutter.major();
    // A ball has no circle; its point needs no direction.
    if radius <= 0.0 {
        let [f, e2] = [Vector3::zeros(); 2];
        return Ok((Ring { center, f, e2, radius }, v));
    }
    // Angle 0 towards the contact; the side of `e2` towards the strip.
    let out = look.contact - center;
    let f = out - pose.axis.scale(pose.axis.dot(&out));
    let f = UnitVector3::try_new(f, f64::MIN_POSITIVE).ok_or_else(no_direction)?;
    let e2 = pose.axis.cross(&f);
    let e2 = if e2.dot(&v) < 0.0 { -e2 } else { e2 };
    Ok((Ring { center, f: f.into_inner(), e2, radius }, v))
}

/// Error round the cutting circle: `[angle, error]` \[rad, mm\], evenly spaced over `[-pi, pi]`,
/// `2 half + 1` of them. Angle 0 lies over `look.contact`, positive ones on the strip's side.
///
/// # Errors
///
/// [`PositioningError::NoDirection`] for a feed along the normal, [`PositioningError::Closest`].
pub fn error_curve(
    setting: &CuttingContext,
    pose: &ToolPose,
    look: &StripQuery,
    half: u32,
) -> Result<Vec<[f64; 2]>, PositioningError> {
    let mut probe = Probe::new(setting.face);
    let middle = probe.read(&look.contact, look.uv)?;
    let (ring, _) = ring(setting, pose, look, &middle)?;
    let circle = Circle { ring, minor: setting.cutter.minor() };
    let samples = all_round(&circle, middle.foot.uv, half, &mut probe)?;
    Ok(samples.iter().map(|sample| [sample.psi, sample.error]).collect())
}

/// Samples over `[-pi, pi]`, `2 half + 1` of them.
fn all_round(
    circle: &Circle,
    guess: [f64; 2],
    half: u32,
    probe: &mut Probe,
) -> Result<Vec<Sample>, PositioningError> {
    let seed = circle.read(0.0, guess, probe)?;
    let step = PI / f64::from(half.max(1));
    let angles = |sign: f64| (1..=half).map(move |k| sign * step * f64::from(k));
    let mut samples = circle.walk(angles(-1.0), &seed, probe)?;
    samples.reverse();
    samples.push(seed);
    samples.extend(circle.walk(angles(1.0), &seed, probe)?);
    Ok(samples)
}

/// The error curve of a location, ready to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorTrace {
    /// What the legend calls it.
    pub name: String,
    /// Round the circle from the side opposite to the strip and back, on the strip's side of its
    /// middle last; for a ball, across its strip and a little beyond.
    pub points: Vec<TracePoint>,
    /// Angles of the strip's beginning and end \[rad\].
    pub ends: [f64; 2],
    /// Angle from which angles are told: that of the first end point, or of the strip's beginning where
    /// the cutter touches at the place asked for \[rad\].
    pub origin: f64,
    /// Angles of the contacts \[rad\].
    pub contacts: Vec<f64>,
    /// MeasuredStrip width \[mm\].
    pub width: f64,
}

/// One point of a [`ErrorTrace`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracePoint {
    /// On the circle, from about the strip's middle towards its far end \[rad\].
    pub angle: f64,
    /// Distance of the foot from the place asked for, across the feed to the strip's side \[mm\].
    pub across: f64,
    /// Error \[mm\].
    pub error: f64,
}

/// Half the points of a trace: two a degree.
const TRACE: u32 = 360;

/// Traces the error of a location that was found for `request`, whose cutter it is
/// ([`super::PlacementMethod::cutter`]).
///
/// # Errors
///
/// [`PositioningError::NoDirection`], [`PositioningError::Closest`].
pub fn trace(
    request: &LocationRequest,
    location: &CutterLocation,
    name: &str,
) -> Result<ErrorTrace, PositioningError> {
    let mut probe = Probe::new(request.face);
    let frame = Frame::new(request, location.side, &mut probe)?;
    let mut tracing = Tracing { request, location, frame, probe };
    let (points, ends, origin) =
        if request.cutter.major() > 0.0 { tracing.circle()? } else { tracing.ball()? };
    let contacts = location.contact_angles.iter().map(|angle| origin + angle).collect();
    Ok(ErrorTrace {
        name: name.to_owned(),
        points,
        ends,
        origin,
        contacts,
        width: location.strip_width,
    })
}

impl CutterLocation {
    /// Whether the circle passes over the place asked for at the upper end of the band, as it does over
    /// an end point; a contact lies a band lower.
    fn ends_at(&self, frame: &Frame) -> bool {
        let first = &frame.first;
        let over = first.foot.point + first.normal().scale(frame.lift) - self.center;
        let height = self.pose.axis.dot(&over);
        let out = (over - self.pose.axis.scale(height)).norm() - frame.major;
        // Through rounding alone; the least band is far wider.
        height.abs().max(out.abs()) <= 1e-7
    }
}

struct Tracing<'a> {
    request: &'a LocationRequest<'a>,
    location: &'a CutterLocation,
    frame: Frame,
    probe: Probe<'a>,
}

/// Points of a trace, the angles of the strip's ends, and the one angles are told from.
type Traced = (Vec<TracePoint>, [f64; 2], f64);

impl Tracing<'_> {
    fn across(&self, foot: &Point3<f64>) -> f64 {
        self.frame.v.dot(&(foot - self.frame.first.foot.point))
    }

    fn circle(&mut self) -> Result<Traced, PositioningError> {
        let LocationRequest { face, cutter, band, strip, .. } = *self.request;
        let setting = CuttingContext { face, cutter, band };
        let (contact, uv) = (self.location.contact, self.location.contact_uv);
        let look = StripQuery { feed: self.frame.a, strip, contact, uv };
        let middle = self.probe.read(&contact, uv)?;
        let (ring, _) = ring(&setting, &self.location.pose, &look, &middle)?;
        let circle = Circle { ring, minor: cutter.minor() };
        let samples = all_round(&circle, middle.foot.uv, TRACE, &mut self.probe)?;
        let lift = cutter.minor() + band.upper;
        let angle = |end: &Reading| ring.angle_over(end, lift);
        let mut end = |uv: [f64; 2]| {
            let point = face.face().surface.point(uv[0], uv[1]);
            self.probe.foot(&point, uv).map(|end| angle(&end))
        };
        let ends = [end(self.location.near)?, end(self.location.far)?];
        let origin =
            if self.location.ends_at(&self.frame) { angle(&self.frame.first) } else { ends[0] };
        let point = |sample: &Sample| TracePoint {
            angle: sample.psi,
            across: self.across(&sample.reading.foot.point),
            error: sample.error,
        };
        Ok((samples.iter().map(point).collect(), ends, origin))
    }

    /// The error of the surface points under the ball, across the strip and half as far again.
    fn ball(&mut self) -> Result<Traced, PositioningError> {
        let radius = self.request.cutter.minor();
        let CutterLocation { center, contact, contact_uv, strip_width, .. } = self.location;
        let middle = self.probe.read(contact, *contact_uv)?;
        let half = 0.5 * strip_width;
        let mut points = Vec::new();
        let mut last = middle;
        let count = TRACE / 2;
        for k in 0..=count {
            let out = 1.5 * half * (2.0 * f64::from(k) / f64::from(count) - 1.0);
            let p = contact + self.frame.v * out;
            last = self.probe.read(&p, last.foot.uv)?;
            let foot = last.foot.point;
            let angle = (out / radius).clamp(-1.0, 1.0).asin();
            let error = (foot - center).norm() - radius;
            points.push(TracePoint { angle, across: self.across(&foot), error });
        }
        let end = (half / radius).clamp(0.0, 1.0).asin();
        Ok((points, [-end, end], -end))
    }
}
