//! The strip of a ball.

use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::distance::width::width_across;
use crate::positioning::error::PositioningError;
use crate::positioning::strip::{CuttingContext, MeasuredStrip};
use crate::positioning::surface_point::SurfacePoint;
use nalgebra::{Point3, Vector3};

/// Measures the strip of a ball around `center`.
///
/// The error of a surface point is the height along its normal at which it meets the sphere. The
/// distance is smaller, at the strip's ends by the cosine of the angle to the contact's normal.
pub(crate) fn ball_strip(
    setting: &CuttingContext,
    center: Point3<f64>,
    v: &Vector3<f64>,
    near: &DistanceReading,
    mut probe: FaceProbe,
) -> Result<MeasuredStrip, PositioningError> {
    let minor = setting.cutter.minor();
    let touch = probe.read(&center, near.foot.uv.into())?;
    let error = touch.distance - minor;
    let sphere = BallSphere { center, minor, upper: setting.band.upper };
    let (before, after) = if error <= setting.band.upper {
        (sphere.end(&touch, &-v, &mut probe)?, sphere.end(&touch, v, &mut probe)?)
    } else {
        (touch, touch)
    };
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
