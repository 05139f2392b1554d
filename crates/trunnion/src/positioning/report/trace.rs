//! The error curve of a location, ready to be drawn.

use crate::math;
use crate::positioning::distance::circle::{ErrorCircle, ErrorSample};
use crate::positioning::distance::curve::circle_of_pose;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::request::LocationRequest;
use crate::positioning::solve::placement::EndPointFrame;
use crate::positioning::strip::{CuttingContext, StripQuery};
use crate::types::{Interval, Uv};
use nalgebra::Point3;

/// The error curve of a location, ready to be drawn.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ErrorTrace {
    /// Name in the legend.
    pub name: String,
    /// Points round the circle from the side opposite to the strip and back, on the strip's side of its
    /// middle last; for a ball, across its strip and a little beyond.
    pub points: Vec<TracePoint>,
    /// Angles of the strip's beginning and end \[rad\].
    pub ends: Interval,
    /// Angle from which angles are counted: that of the first end point, or of the strip's beginning
    /// where the cutter touches at the requested point \[rad\].
    pub origin: f64,
    /// Angles of the contacts \[rad\].
    pub contacts: Vec<f64>,
    /// Strip width \[mm\].
    pub width: f64,
}

/// One point of a [`ErrorTrace`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct TracePoint {
    /// Angle on the circle, from about the strip's middle towards its far end \[rad\].
    pub angle: f64,
    /// Distance of the foot from the requested point, across the feed to the strip's side \[mm\].
    pub across: f64,
    /// Error \[mm\].
    pub error: f64,
}

/// Half the number of points of a trace: two a degree.
const TRACE: u32 = 360;

/// Traces the error of a location that was found for `request`, whose cutter it is
/// (`PlacementMethod::cutter`).
///
/// # Errors
///
/// [`PositioningError::NoDirection`], [`PositioningError::Closest`].
pub fn trace(
    request: &LocationRequest,
    location: &CutterLocation,
    name: &str,
) -> Result<ErrorTrace, PositioningError> {
    let mut probe = FaceProbe::new(request.face);
    let frame = EndPointFrame::new(request, location.side, &mut probe)?;
    let mut tracing = TraceBuilder { request, location, frame, probe };
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
    /// Returns `true` if the circle passes over the requested point at the upper end of the band, as it
    /// does over an end point; a contact lies a band lower.
    fn ends_at(&self, frame: &EndPointFrame) -> bool {
        let first = &frame.first;
        let over = first.foot.point + first.normal().scale(frame.lift) - self.center;
        let height = self.pose.axis.dot(&over);
        let out = (over - self.pose.axis.scale(height)).norm() - frame.major;
        // Through rounding alone; the least band is far wider.
        height.abs().max(out.abs()) <= 1e-7
    }
}

struct TraceBuilder<'a> {
    request: &'a LocationRequest<'a>,
    location: &'a CutterLocation,
    frame: EndPointFrame,
    probe: FaceProbe<'a>,
}

/// Points of a trace, the angles of the strip's ends, and the origin of angles.
type TracedCurve = (Vec<TracePoint>, Interval, f64);

impl TraceBuilder<'_> {
    fn across(&self, foot: &Point3<f64>) -> f64 {
        self.frame.v.dot(&(foot - self.frame.first.foot.point))
    }

    fn circle(&mut self) -> Result<TracedCurve, PositioningError> {
        let LocationRequest { face, cutter, band, strip, .. } = *self.request;
        let setting = CuttingContext { face, cutter, band };
        let (contact, uv) = (self.location.contact, self.location.contact_uv);
        let look = StripQuery { feed: self.frame.a, strip, contact, uv };
        let middle = self.probe.read(&contact, uv.into())?;
        let (ring, _) = circle_of_pose(&setting, &self.location.pose, &look, &middle)?;
        let circle = ErrorCircle { ring, minor: cutter.minor() };
        let samples = circle.all_round(middle.foot.uv.into(), TRACE, &mut self.probe)?;
        let lift = cutter.minor() + band.upper;
        let angle = |end: &DistanceReading| ring.angle_over(end, lift);
        let mut end = |uv: Uv| {
            let point = face.face().surface.point(uv.u, uv.v);
            self.probe.foot(&point, uv.into()).map(|end| angle(&end))
        };
        let ends = Interval::new(end(self.location.near)?, end(self.location.far)?);
        let origin =
            if self.location.ends_at(&self.frame) { angle(&self.frame.first) } else { ends.low };
        let point = |sample: &ErrorSample| TracePoint {
            angle: sample.psi,
            across: self.across(&sample.reading.foot.point),
            error: sample.error,
        };
        Ok((samples.iter().map(point).collect(), ends, origin))
    }

    /// Traces the error of the surface points under the ball, across the strip and half as far again.
    fn ball(&mut self) -> Result<TracedCurve, PositioningError> {
        let radius = self.request.cutter.minor();
        let CutterLocation { center, contact, contact_uv, strip_width, .. } = self.location;
        let middle = self.probe.read(contact, (*contact_uv).into())?;
        let half = 0.5 * strip_width;
        let mut points = Vec::new();
        let mut last = middle;
        let count = TRACE / 2;
        for k in 0..=count {
            let out = 1.5 * half * (2.0 * f64::from(k) / f64::from(count) - 1.0);
            let p = contact + self.frame.v * out;
            last = self.probe.read(&p, last.foot.uv.into())?;
            let foot = last.foot.point;
            // Angle on the sphere over a point so far beside the contact.
            let angle = math::asin((out / radius).clamp(-1.0, 1.0));
            let error = (foot - center).norm() - radius;
            points.push(TracePoint { angle, across: self.across(&foot), error });
        }
        let end = math::asin((half / radius).clamp(0.0, 1.0));
        Ok((points, Interval::new(-end, end), -end))
    }
}
