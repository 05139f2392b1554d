//! The strip of a ball, or of an arc that stands for one across the feed.

use crate::cutter::{Cutter, CutterKind};
use crate::math;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::distance::width::width_across;
use crate::positioning::error::PositioningError;
use crate::positioning::strip::{CuttingContext, MeasuredStrip};
use crate::positioning::surface_point::SurfacePoint;
use crate::types::{Interval, ToolPose};
use nalgebra::{Point3, Vector3};

/// Measures the strip of a ball around `center`, as wide as its arc goes.
///
/// The error of a surface point is the height along its normal at which it meets the sphere. The
/// distance is smaller, at the strip's ends by the cosine of the angle to the contact's normal.
///
/// The arc of a barrel is a circle of that sphere, in the plane of tool axis and contact: across the feed both leave the
/// same strip.
pub(crate) fn ball_strip(
    setting: &CuttingContext,
    ball: PlacedBall<'_>,
    v: &Vector3<f64>,
    near: &DistanceReading,
    probe: &mut FaceProbe,
) -> Result<MeasuredStrip, PositioningError> {
    let PlacedBall { center, pose, limit } = ball;
    let minor = setting.cutter.contact_arc().radius;
    // The centre of a barrel's arc lies beyond the focus of a face that is hollow along the feed: there the contact is no
    // minimum of the distance. It is known.
    let is_barrel = setting.cutter.is_barrel();
    let touch = if is_barrel { *near } else { probe.read(&center, near.foot.uv.into())? };
    let height = if is_barrel { (center - touch.foot.point).norm() } else { touch.distance };
    let error = height - minor;
    let sphere = BallSphere { center, minor, upper: setting.band.upper };
    let on_arc = |reading: &DistanceReading| {
        let angle = || inclination(&center, pose, &reading.foot.point);
        limit.is_none_or(|limit| limit.contains(angle()))
    };
    let mut end = |direction: &Vector3<f64>| -> Result<DistanceReading, PositioningError> {
        let end = sphere.end(&touch, direction, probe)?;
        // Off the arc another part of the tool is over the face.
        if on_arc(&end) { Ok(end) } else { last_on_arc([&touch, &end], &on_arc, probe) }
    };
    let (before, after) =
        if error <= setting.band.upper { (end(&-v)?, end(v)?) } else { (touch, touch) };
    Ok(MeasuredStrip {
        width: width_across(v, &before, &after).max(0.0),
        near: SurfacePoint::from(&before.foot),
        far: SurfacePoint::from(&after.foot),
        front_max: error.max(setting.band.upper),
        front_max_bound: error.max(setting.band.upper),
        front_min: error,
        rear_min: error,
        rear_min_bound: error,
        contact: SurfacePoint::from(&touch.foot),
        queries: probe.queries,
    })
}

/// A ball, and the tool that it is part of.
#[derive(Clone, Copy)]
pub(crate) struct PlacedBall<'a> {
    pub(crate) center: Point3<f64>,
    pub(crate) pose: &'a ToolPose,
    /// Angles between tool axis and normal of the ball where the tool has its surface \[rad\]; `None` for all of it.
    pub(crate) limit: Option<Interval>,
}

/// Returns the angles to which the strip of a cutter is limited \[rad\]: those of its arc, if the tool turns inwards where
/// that ends; `None` for others.
pub(crate) fn limit(cutter: &Cutter) -> Option<Interval> {
    let is_limited = cutter.is_barrel() || cutter.kind() == CutterKind::Lens;
    is_limited.then(|| cutter.contact_arc().inclinations)
}

/// Returns the angle between the tool axis and the normal of a ball around `center` at a point on it \[rad\].
pub(crate) fn inclination(center: &Point3<f64>, pose: &ToolPose, point: &Point3<f64>) -> f64 {
    let up = center - point;
    // Full accuracy near 0, where the cosine has half of the digits.
    math::atan2(pose.axis.cross(&up).norm(), pose.axis.dot(&up))
}

/// Finds the last point on the arc between a contact and the end of a strip beyond it.
fn last_on_arc(
    [touch, end]: [&DistanceReading; 2],
    on_arc: &dyn Fn(&DistanceReading) -> bool,
    probe: &mut FaceProbe,
) -> Result<DistanceReading, PositioningError> {
    /// To a millionth of the strip.
    const HALVINGS: u32 = 20;
    let (mut good, mut bad) = (*touch, *end);
    for _ in 0..HALVINGS {
        let middle = nalgebra::center(&good.foot.point, &bad.foot.point);
        let reading = probe.read(&middle, good.ahead_to(&middle))?;
        if on_arc(&reading) { good = reading } else { bad = reading }
    }
    Ok(good)
}

/// The ball, and the excess that surface points under it may have \[mm\].
struct BallSphere {
    center: Point3<f64>,
    minor: f64,
    upper: f64,
}

impl BallSphere {
    /// Finds the point where the surface, raised by the upper end of the band, leaves the sphere, going
    /// from `touch` along `direction`.
    fn end(
        &self,
        touch: &DistanceReading,
        direction: &Vector3<f64>,
        probe: &mut FaceProbe,
    ) -> Result<DistanceReading, PositioningError> {
        // Secant steps on a function close to a parabola; the start is its root for a sphere on
        // a plane, from where eight steps reach rounding.
        const STEPS: u32 = 12;
        let origin = touch.foot.point;
        let radius = self.minor + self.upper;
        let outside = |reading: &DistanceReading| {
            let raised = reading.foot.point + reading.normal().scale(self.upper);
            (raised - self.center).norm() - self.minor
        };
        let gap = -outside(touch);
        let curvature = (1.0 / radius - touch.normal_curvature(direction)).max(f64::EPSILON);
        let mut t = (2.0 * gap.max(0.0) / curvature).sqrt().min(radius);
        let mut reading = *touch;
        for _ in 0..STEPS {
            let p = origin + direction * t;
            reading = probe.read(&p, touch.ahead(&(direction * t)))?;
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
