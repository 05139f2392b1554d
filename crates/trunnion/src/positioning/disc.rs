//! The flat disc inside the cutting circle.
//!
//! Over a surface that is concave or saddle-shaped below it, the distance of a point of the disc
//! has no minimum inside the disc (its second derivative is not positive in some direction), and
//! the rim lies `r` below the circle whose points keep `r` and more. Only over a convex surface
//! the inside can come closer than the rim.

use super::PositioningError;
use super::probe::Probe;
use super::probe::Reading;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// Underside of the cutter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc {
    pub(super) center: Point3<f64>,
    pub(super) axis: UnitVector3<f64>,
    pub(super) radius: f64,
}

/// Newton steps in the plane of the disc; from its centre over a surface whose curvature hardly
/// changes below it, three suffice.
const STEPS: u32 = 20;

impl Disc {
    /// Lowest point strictly inside the disc, if the distance has a minimum there.
    pub(super) fn lowest(
        &self,
        nearby: &[&Reading],
        probe: &mut Probe,
    ) -> Result<Option<(Point3<f64>, Reading)>, PositioningError> {
        let convex = |reading: &Reading| reading.curvatures()[1] < 0.0;
        let Some(end) = nearby.first() else { return Ok(None) };
        let mut point = self.center;
        let mut reading = probe.read(&point, end.foot.uv)?;
        if !convex(&reading) && !nearby.iter().any(|end| convex(end)) {
            return Ok(None);
        }
        let across = self.axis.cross(&end.foot.jet.su);
        let Some(one) = UnitVector3::try_new(across, f64::MIN_POSITIVE) else { return Ok(None) };
        let two = self.axis.cross(&one);
        for _ in 0..STEPS {
            let Some(step) = descent(&reading, [&one, &two]) else { return Ok(None) };
            let reach = self.radius / step.norm().max(f64::MIN_POSITIVE);
            let step = step * reach.min(1.0);
            if (point + step - self.center).norm() >= 2.0 * self.radius {
                return Ok(None);
            }
            point += step;
            reading = probe.read(&point, reading.ahead(&step))?;
            // The distance is stationary: what is left of the step counts only squared.
            if step.norm() <= 1e-6 * self.radius {
                let inside = (point - self.center).norm() < self.radius;
                return Ok(inside.then_some((point, reading)));
            }
        }
        Ok(None)
    }
}

/// Newton step to the minimum of the distance in the plane; `None` where there is none.
fn descent(reading: &Reading, [one, two]: [&Vector3<f64>; 2]) -> Option<Vector3<f64>> {
    let n = reading.normal();
    let (g1, g2) = (n.dot(one), n.dot(two));
    let h11 = reading.hessian(one);
    let h12 = reading.hessian_between(one, two);
    let h22 = reading.hessian(two);
    let determinant = h11 * h22 - h12 * h12;
    if h11 <= 0.0 || determinant <= 0.0 {
        return None;
    }
    let a = (h12 * g2 - h22 * g1) / determinant;
    let b = (h12 * g1 - h11 * g2) / determinant;
    Some(one * a + two * b)
}
