//! The flat disc inside the cutting circle.
//!
//! Over a surface that is concave or saddle-shaped below it, the distance of a point of the disc
//! has no minimum inside the disc (its second derivative is not positive in some direction), and
//! the rim lies `r` below the circle whose points keep `r` and more. Only over a convex surface
//! the inside can come closer than the rim.

use crate::math;
use crate::positioning::distance::gaps::curvatures_under;
use crate::positioning::distance::probe::{DistanceReading, FaceProbe};
use crate::positioning::error::PositioningError;
use crate::surface::FaceIndex;
use nalgebra::{Point3, UnitVector3, Vector3};

/// Underside of the cutter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlatDisc {
    pub(crate) center: Point3<f64>,
    pub(crate) axis: UnitVector3<f64>,
    pub(crate) radius: f64,
}

/// Steps to a minimum; over a surface whose curvature hardly changes below the disc, three suffice.
const STEPS: u32 = 20;

/// Share of the radius from which a search starts that sets out towards a convex end point.
const TOWARDS: f64 = 0.7;

/// Squares examined before the bound of the disc is left as it is.
const SQUARES: u32 = 400;

/// Two directions in the disc's plane.
type PlaneBasis = [Vector3<f64>; 2];

impl FlatDisc {
    /// Reads the centre, from one under the rim.
    pub(crate) fn middle(
        &self,
        rim: &DistanceReading,
        probe: &mut FaceProbe,
    ) -> Result<DistanceReading, PositioningError> {
        probe.read(&self.center, rim.ahead_to(&self.center))
    }

    /// Finds the lowest point strictly inside the disc, if the distance has a minimum there that is found
    /// from its centre, whose reading is given, or from near the end points `nearby`.
    pub(crate) fn lowest(
        &self,
        centre: &DistanceReading,
        nearby: &[&DistanceReading],
        probe: &mut FaceProbe,
    ) -> Result<Option<(Point3<f64>, DistanceReading)>, PositioningError> {
        let convex = |reading: &DistanceReading| reading.curvatures()[1] < 0.0;
        // The largest principal curvature is negative: the surface bends away from the cutter
        // everywhere below, and one descent from the centre decides.
        if convex(centre) {
            return self.descend(self.center, *centre, probe);
        }
        // Otherwise only where an end point is convex can there be a minimum inside: start on the
        // way to it.
        for end in nearby.iter().filter(|end| convex(end)) {
            let out = end.foot.point - self.center;
            let out = out - self.axis.scale(self.axis.dot(&out));
            let Some(out) = out.try_normalize(f64::MIN_POSITIVE) else { continue };
            let start = self.center + out * (TOWARDS * self.radius);
            let reading = probe.read(&start, end.foot.uv.into())?;
            if let Some(found) = self.descend(start, reading, probe)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    fn plane(&self) -> PlaneBasis {
        let mut across = Vector3::zeros();
        across[self.axis.iamin()] = 1.0;
        let one = UnitVector3::new_normalize(self.axis.cross(&across)).into_inner();
        [one, self.axis.cross(&one)]
    }

    /// Descends from a point of the disc; `None` where that leads over the rim.
    fn descend(
        &self,
        mut point: Point3<f64>,
        mut reading: DistanceReading,
        probe: &mut FaceProbe,
    ) -> Result<Option<(Point3<f64>, DistanceReading)>, PositioningError> {
        let plane = self.plane();
        for _ in 0..STEPS {
            let (step, convex) = descent(&reading, &plane, self.radius);
            let out = point + step - self.center;
            // Once over the rim a search may come back, but not far beyond it.
            if out.norm() >= 1.5 * self.radius {
                return Ok(None);
            }
            point += step;
            reading = probe.read(&point, reading.ahead(&step))?;
            // The distance is stationary: what is left of the step counts only squared.
            if convex && step.norm() <= 1e-6 * self.radius {
                let inside = (point - self.center).norm() < self.radius;
                return Ok(inside.then_some((point, reading)));
            }
        }
        Ok(None)
    }

    /// Returns the least distance found inside the disc, and a lower bound on it; both infinite where the
    /// distance is proved to have no minimum inside, so that the rim is nearest.
    ///
    /// `[low, high]` bounds the curvatures below the disc. In a square of half diagonal `h` around a
    /// point at the distance `d`, where the normal leans by `s` (sine), nothing is closer than
    /// `d - s h - c h^2 / 2`, `c = k / (1 - k d)` for `k = high` over the whole square; and where
    /// `s` exceeds `h` times the largest second derivative, no minimum lies within.
    pub(crate) fn floor(
        &self,
        enough: f64,
        face: &FaceIndex,
        centre: &DistanceReading,
        probe: &mut FaceProbe,
    ) -> Result<[f64; 2], PositioningError> {
        let [mut least, mut bound] = [f64::INFINITY; 2];
        // The distance is 1-Lipschitz: no point of the disc is farther from the surface than this.
        let far = centre.distance + self.radius;
        let under = curvatures_under(face, &std::iter::once(centre), self.radius, far);
        let [low, high] = under.curvatures;
        // Nowhere convex below the disc: the distance has no minimum inside (see the module's
        // docs).
        if low >= 0.0 {
            return Ok([least, bound]);
        }
        // Branch and bound over squares of the disc.
        let plane = self.plane();
        let side = 2.0 * self.radius;
        let mut squares = vec![(self.center, side, *centre)];
        let mut left = SQUARES;
        while let Some((middle, side, reading)) = squares.pop() {
            let half = side * std::f64::consts::FRAC_1_SQRT_2;
            // Squares beyond the rim hold no point of the disc.
            let out = (middle - self.center).norm();
            if out - half > self.radius {
                continue;
            }
            let n = reading.normal();
            // Length of the distance's gradient in the plane of the disc: the sine of the lean.
            let lean = math::hypot(n.dot(&plane[0]), n.dot(&plane[1]));
            // Lower bound over the square: no curvature within pulls the distance lower.
            let falling = falling(high, reading.distance + half);
            let under = reading.distance - half * (lean + 0.5 * half * falling);
            // Only distances that may matter count as found; the rest of the square is bounded
            // below them.
            if out < self.radius && under < enough {
                least = least.min(reading.distance);
            }
            // The second test: by the mean value theorem the gradient does not vanish in the
            // square, so the least distance lies on its border and, in the end, on the rim.
            if under >= enough || lean > half * falling.max(-low) {
                continue;
            }
            // The budget is spent: what is bounded so far stays the bound.
            if left == 0 {
                bound = bound.min(under);
                continue;
            }
            left -= 1;
            // Four squares of half the side, their centres a quarter of the side off.
            for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                let step = (plane[0] * x + plane[1] * y) * (0.25 * side);
                let quarter = probe.read(&(middle + step), reading.ahead(&step))?;
                squares.push((middle + step, 0.5 * side, quarter));
            }
        }
        Ok([least, bound.min(least)])
    }
}

/// Returns the largest fall of the distance per square \[1/mm\] where curvatures stay below `high` and
/// distances below `distance`.
fn falling(high: f64, distance: f64) -> f64 {
    // k / (1 - k d) grows with d and k; at 1 - k d = 0 the foot is a centre of curvature, and there
    // is no bound.
    let left = 1.0 - high * distance.max(0.0);
    if high <= 0.0 {
        0.0
    } else if left > 0.0 {
        high / left
    } else {
        f64::INFINITY
    }
}

/// Returns Newton's step to the minimum of the distance in the plane, and `true` if the distance is
/// convex here; where it is not, a step down of half a radius along the gradient.
fn descent(
    reading: &DistanceReading,
    [one, two]: &PlaneBasis,
    radius: f64,
) -> (Vector3<f64>, bool) {
    let n = reading.normal();
    // Gradient and Hessian of the distance, restricted to the plane of the disc.
    let (g1, g2) = (n.dot(one), n.dot(two));
    let h11 = reading.hessian(one);
    let h12 = reading.hessian_between(one, two);
    let h22 = reading.hessian(two);
    let determinant = h11 * h22 - h12 * h12;
    // Sylvester's criterion fails: the restricted distance is not convex, and Newton's step could
    // lead to a saddle or a maximum.
    if h11 <= 0.0 || determinant <= 0.0 {
        let size = math::hypot(g1, g2).max(f64::MIN_POSITIVE);
        return (-(one * g1 + two * g2) * (0.5 * radius / size), false);
    }
    // Newton's step -H^-1 g by Cramer's rule.
    let a = (h12 * g2 - h22 * g1) / determinant;
    let b = (h12 * g1 - h11 * g2) / determinant;
    let step = one * a + two * b;
    // No step longer than the radius: the quadratic model is only local.
    let reach = radius / step.norm().max(f64::MIN_POSITIVE);
    (step * reach.min(1.0), true)
}
