//! A ball: the circle shrinks to a point, and the strip is where the surface stays close to it.

use super::ActiveConstraint;
use super::ContactSide;
use super::CutterLocation;
use super::LocationRequest;
use super::PositioningError;
use super::ToleranceBand;
use super::ToolInclination;
use super::check::CuttingContext;
use super::check::MeasuredStrip;
use super::check::across;
use super::location::Found;
use super::placement::Frame;
use super::probe::Probe;
use super::probe::Reading;
use crate::types::ToolPose;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// Ends of the strip of a ball around `center`: the error of a surface point is the height along its normal at which it
/// meets the sphere. The distance is smaller, at the strip's ends by the cosine of the angle to the contact's normal.
pub(super) fn strip(
    setting: &CuttingContext,
    center: Point3<f64>,
    (v, near): (&Vector3<f64>, &Reading),
    mut probe: Probe,
) -> Result<MeasuredStrip, PositioningError> {
    let minor = setting.cutter.minor();
    let touch = probe.read(&center, near.foot.uv)?;
    let error = touch.distance - minor;
    let sphere = Sphere { center, minor, upper: setting.band.upper };
    let (before, after) = if error <= setting.band.upper {
        (sphere.end(&touch, &-v, &mut probe)?, sphere.end(&touch, v, &mut probe)?)
    } else {
        (touch, touch)
    };
    Ok(MeasuredStrip {
        width: across(v, &before, &after).max(0.0),
        near: (before.foot.uv, before.foot.point),
        far: (after.foot.uv, after.foot.point),
        front_max: error.max(setting.band.upper),
        front_max_bound: error.max(setting.band.upper),
        front_min: error,
        rear_min: error,
        rear_min_bound: error,
        contact: (touch.foot.uv, touch.foot.point),
        queries: probe.queries,
    })
}

/// CutterLocation of a ball whose strip begins at the end point: it touches at the lower end of the band
/// where the end point lies at the upper end. The tool axis leans along the feed unless told otherwise.
pub(super) fn location(
    request: &LocationRequest,
    side: ContactSide,
    lean: ToolInclination,
) -> Result<CutterLocation, PositioningError> {
    let mut probe = Probe::new(request.face);
    let frame = Frame::new(request, side, &mut probe)?;
    let (first, minor) = (&frame.first, frame.minor);
    let concave = first.curvatures()[1];
    if concave * frame.lift >= 1.0 {
        let (uv, concave) = (request.at, 1.0 / concave);
        return Err(PositioningError::ConcaveRadius { uv, concave, minor });
    }
    let touch = touching(&frame, request.band, &mut probe)?;
    let n = touch.normal();
    let center = touch.foot.point + n.scale(minor + request.band.lower);
    let along = (frame.a - n.scale(n.dot(&frame.a))).normalize();
    let ahead = if side == ContactSide::Behind { -along } else { along };
    // The strip's side, square to the feed.
    let beside = along.cross(&n).scale(request.strip.sign());
    let (sin, cos) = lean.towards.unwrap_or(0.0).sin_cos();
    let leaning = n.scale(lean.angle.cos()) + (ahead * cos + beside * sin) * lean.angle.sin();
    let axis = UnitVector3::new_normalize(leaning);
    let pose = ToolPose { tip: center - axis.scale(minor), axis };
    let setting = CuttingContext { face: request.face, cutter: request.cutter, band: request.band };
    super::body::clear(&setting, &pose, request.at, &mut probe)?;
    let strip = strip(&setting, center, (&frame.v, &touch), probe)?;
    super::widest::cuts_there(&setting, &pose, &strip)?;
    let chord = nalgebra::distance(&strip.near.1, &strip.far.1);
    let half = (0.5 * chord / minor).min(1.0).asin();
    let found = Found {
        pose,
        side,
        x: [strip.width, 0.0, lean.angle],
        widths: [strip.width; 2],
        arc: 2.0 * half,
        contact_angles: vec![half],
        active: vec![ActiveConstraint::Touch, ActiveConstraint::GivenLead],
        end: strip.far.0,
        queries: strip.queries,
        marks: Vec::new(),
    };
    Ok(CutterLocation::new(request, &strip, found))
}

/// The contact from which the end point is at the upper end of the band.
fn touching(
    frame: &Frame,
    band: ToleranceBand,
    probe: &mut Probe,
) -> Result<Reading, PositioningError> {
    // As in `Sphere::end`: Newton's steps on a function close to `c t^2 - gap`.
    const STEPS: u32 = 20;
    let first = &frame.first;
    let gap = band.upper - band.lower;
    let curvature = 1.0 / frame.lift - first.normal_curvature(&frame.v);
    let mut t = (2.0 * gap / curvature.max(f64::EPSILON)).sqrt().min(frame.lift);
    let raised = first.foot.point + first.normal().scale(band.upper);
    let mut touch = *first;
    for _ in 0..STEPS {
        let step = frame.v * t;
        touch = probe.read(&(first.foot.point + step), first.ahead(&step))?;
        let center = touch.foot.point + touch.normal().scale(frame.minor + band.lower);
        let outside = (raised - center).norm() - frame.minor;
        let rise = outside + gap;
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

/// The ball, and the excess that surface points under it may have \[mm\].
struct Sphere {
    center: Point3<f64>,
    minor: f64,
    upper: f64,
}

impl Sphere {
    /// The surface point where the surface leaves the sphere, raised by the upper end of the band, going from `touch`
    /// along `way`.
    fn end(
        &self,
        touch: &Reading,
        way: &Vector3<f64>,
        probe: &mut Probe,
    ) -> Result<Reading, PositioningError> {
        // Secant steps on a function close to a parabola; the start is its root for a sphere on
        // a plane, from where eight steps reach rounding.
        const STEPS: u32 = 12;
        let origin = touch.foot.point;
        let radius = self.minor + self.upper;
        let outside = |reading: &Reading| {
            let raised = reading.foot.point + reading.normal().scale(self.upper);
            (raised - self.center).norm() - self.minor
        };
        let gap = -outside(touch);
        let curvature = (1.0 / radius - touch.normal_curvature(way)).max(f64::EPSILON);
        let mut t = (2.0 * gap.max(0.0) / curvature).sqrt().min(radius);
        let mut reading = *touch;
        for _ in 0..STEPS {
            let p = origin + way * t;
            reading = probe.read(&p, touch.ahead(&(way * t)))?;
            // For g = c t^2 - gap the step of Newton is (g / 2 (g + gap)) t.
            let g = outside(&reading);
            let rise = g + gap;
            if rise <= 0.0 {
                t *= 2.0;
                continue;
            }
            let step = 0.5 * t * g / rise;
            t -= step;
            if step.abs() <= 1e-9 * radius {
                break;
            }
        }
        Ok(reading)
    }
}
