//! The tool as convex bodies of revolution: signed distance and its gradient.

use crate::cutter::{Cutter, TangentProfile};
use crate::math;
use nalgebra::{Point3, Vector3};

/// Convex body of revolution about the tool axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ConvexBody {
    /// Cutting end and flank: a circle of radius `minor` swept around one of radius `major`, and the
    /// cylinder above it up to `top`.
    Nose { major: f64, minor: f64, top: f64 },
    /// Cutting end with a cone or a second arc beside its tip arc, and the cylinder above it.
    Tangent(TangentProfile),
    /// Section of the shank or holder between two heights; `slope` is the growth of the radius with height.
    Frustum { low: f64, high: f64, radius: f64, slope: f64 },
}

/// Value of a convex function that is 0 on the surface of a body, negative inside, and never above the distance.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyProbe {
    /// Value of the function \[mm\].
    pub(crate) distance: f64,
    /// Derivative by the distance `rho` from the axis, divided by `rho` \[1/mm\].
    pub(crate) radial: f64,
    /// Derivative by the height above the tip.
    pub(crate) axial: f64,
    /// Height above the tip \[mm\].
    pub(crate) height: f64,
}

/// Returns the bodies of a tool, from tip to spindle.
pub(crate) fn bodies(cutter: &Cutter) -> Vec<ConvexBody> {
    let shank = &cutter.spec().shank;
    let top = shank.first().map_or(cutter.length(), |&[height, _]| height);
    let end = match cutter.tangent_profile() {
        Some(profile) => ConvexBody::Tangent(*profile),
        None => ConvexBody::Nose { major: cutter.major(), minor: cutter.minor(), top },
    };
    let mut bodies = vec![end];
    let last = shank.last().map(|&[_, radius]| [cutter.length(), radius]);
    let ends = shank.iter().copied().skip(1).chain(last);
    for ([low, radius], [high, end]) in shank.iter().copied().zip(ends) {
        // A step of the radius has no height: the ends of its neighbours bound it.
        if high > low {
            bodies.push(ConvexBody::Frustum {
                low,
                high,
                radius,
                slope: (end - radius) / (high - low),
            });
        }
    }
    bodies
}

/// Returns a bound on the distance of the tool's points from its tip \[mm\].
pub(crate) fn size(cutter: &Cutter) -> f64 {
    let widest = bodies(cutter).iter().map(|body| body.radius()).fold(0.0, f64::max);
    // No point is higher than the length, or farther from the axis than the largest radius.
    math::hypot(cutter.length(), widest)
}

/// Returns the bodies of each tool with a bound on the distance of their points from the tip \[mm\].
pub(crate) fn tools(cutters: &[&Cutter]) -> Vec<(Vec<ConvexBody>, f64)> {
    cutters.iter().map(|cutter| (bodies(cutter), size(cutter))).collect()
}

impl ConvexBody {
    /// Returns the lowest and the highest point on the axis \[mm above the tip\].
    pub(crate) fn heights(self) -> [f64; 2] {
        match self {
            Self::Nose { top, .. } => [0.0, top],
            Self::Tangent(profile) => [0.0, profile.top()],
            Self::Frustum { low, high, .. } => [low, high],
        }
    }

    /// Returns the largest radius \[mm\].
    pub(crate) fn radius(self) -> f64 {
        match self {
            Self::Nose { major, minor, .. } => major + minor,
            Self::Tangent(profile) => profile.radius(),
            Self::Frustum { low, high, radius, slope } => radius.max(radius + slope * (high - low)),
        }
    }

    /// Returns the top of the flank over the cutting end \[mm above the tip\]; `None` for shank and holder.
    ///
    /// Below it the body faces across its axis and back along it: its radius never falls with height.
    pub(crate) fn end_top(self) -> Option<f64> {
        match self {
            Self::Nose { top, .. } => Some(top),
            Self::Tangent(profile) => Some(profile.top()),
            Self::Frustum { .. } => None,
        }
    }

    /// Returns the support function: the reach of the body along the unit vector `direction`, from the tip \[mm\].
    pub(crate) fn extent(self, axis: &Vector3<f64>, direction: &Vector3<f64>) -> f64 {
        let up = direction.dot(axis);
        let out = (direction - axis * up).norm();
        match self {
            Self::Nose { major, minor, top } => {
                // Upwards the rim of the top end reaches farthest, otherwise the torus of the corner.
                if up > 0.0 {
                    (major + minor) * out + top * up
                } else {
                    major * out + minor * up + minor
                }
            }
            Self::Tangent(profile) => profile.extent([out, up]),
            Self::Frustum { low, high, radius, slope } => {
                let end = radius + slope * (high - low);
                (radius * out + low * up).max(end * out + high * up)
            }
        }
    }

    /// Evaluates the distance function at `y`, a point relative to the tip, for a tool along the unit vector `axis`.
    ///
    /// Each piece is a convex function of `y`, hence so is their maximum. At a kink the derivative of one side is
    /// returned; it is a subgradient and supports the function as well.
    #[inline]
    pub(crate) fn probe(self, y: &Vector3<f64>, axis: &Vector3<f64>) -> BodyProbe {
        let height = axis.dot(y);
        let rho = (y - axis * height).norm();
        let (distance, by_rho, axial) = match self {
            Self::Nose { major, minor, top } => nose([rho, height], [major, minor, top]),
            Self::Tangent(profile) => {
                let found = profile.distance([rho, height]);
                (found.distance, found.gradient[0], found.gradient[1])
            }
            Self::Frustum { low, high, radius, slope } => {
                frustum([rho, height], [low, high], [radius, slope])
            }
        };
        BodyProbe::of([rho, height], [distance, by_rho, axial])
    }

    /// Evaluates the distance function of the body without the ends at which another body goes on ([`BodySurface::Skin`]).
    fn probe_skin(self, y: &Vector3<f64>, axis: &Vector3<f64>) -> BodyProbe {
        let height = axis.dot(y);
        let rho = (y - axis * height).norm();
        let found = match self {
            Self::Nose { major, minor, .. } => {
                let (distance, by_rho, axial) = nose([rho, height], [major, minor, f64::INFINITY]);
                [distance, by_rho, axial]
            }
            Self::Tangent(profile) => {
                let found = profile.distance([rho, height]);
                // At its upper end nothing is known of what goes on.
                let is_end = found.gradient[1] >= 1.0;
                let distance = if is_end { f64::NEG_INFINITY } else { found.distance };
                [distance, found.gradient[0], found.gradient[1]]
            }
            Self::Frustum { low, radius, slope, .. } => {
                let steep = math::hypot(slope, 1.0);
                [(rho - radius - slope * (height - low)) / steep, 1.0 / steep, -slope / steep]
            }
        };
        BodyProbe::of([rho, height], found)
    }
}

/// Returns value and derivatives by `rho` and height for the cutting end.
#[inline]
fn nose([rho, height]: [f64; 2], [major, minor, top]: [f64; 3]) -> (f64, f64, f64) {
    // Distance to the quadrant {out <= 0, down <= 0} of the profile, less the corner radius.
    let [out, down] = [rho - major, minor - height];
    let side = if out > 0.0 && down > 0.0 {
        // Millimetres do not overflow, and hypot is a slow call.
        let away = (out * out + down * down).sqrt();
        (away - minor, out / away, -down / away)
    } else if out >= down {
        (out - minor, 1.0, 0.0)
    } else {
        (down - minor, 0.0, -1.0)
    };
    // Beyond the upper rim the distance is that of the rim; elsewhere the largest of the pieces counts.
    let [beyond, above] = [rho - major - minor, height - top];
    if beyond > 0.0 && above > 0.0 {
        return from_rim([beyond, above]);
    }
    if above > side.0 { (above, 0.0, 1.0) } else { side }
}

/// Returns value and derivatives by `rho` and height for a frustum.
///
/// Beyond a rim this is the distance from the rim: the maximum of the two planes has a kink there that no single
/// plane bounds.
#[inline]
fn frustum(
    [rho, height]: [f64; 2],
    [low, high]: [f64; 2],
    [radius, slope]: [f64; 2],
) -> (f64, f64, f64) {
    for (sign, rim) in [(-1.0, [radius, low]), (1.0, [radius + slope * (high - low), high])] {
        let out = [rho - rim[0], height - rim[1]];
        // Outside the edge of the end plane and beyond the end of the slanted line.
        if out[0] > 0.0 && sign * (slope * out[0] + out[1]) > 0.0 {
            return from_rim(out);
        }
    }
    let steep = math::hypot(slope, 1.0);
    let side = (rho - radius - slope * (height - low)) / steep;
    let end =
        if height - high > low - height { (height - high, 1.0) } else { (low - height, -1.0) };
    if end.0 > side { (end.0, 0.0, end.1) } else { (side, 1.0 / steep, -slope / steep) }
}

/// Returns the distance from a rim and its derivatives.
fn from_rim([out, up]: [f64; 2]) -> (f64, f64, f64) {
    // Millimetres do not overflow, and hypot is a slow call.
    let away = (out * out + up * up).sqrt();
    (away, out / away, up / away)
}

/// Tool pose as plain vectors, for inner loops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BodyPose {
    pub(crate) tip: Point3<f64>,
    /// Unit vector.
    pub(crate) axis: Vector3<f64>,
}

/// Ray from a surface point along its normal, searched upwards from `-below`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NormalRay {
    pub(crate) origin: Point3<f64>,
    /// Unit vector.
    pub(crate) normal: Vector3<f64>,
    /// Start of the search below the origin \[mm\].
    pub(crate) below: f64,
    /// Rule for gouges at the origin.
    pub(crate) rule: DepthRule,
}

/// Rule for the depth of a gouge at a point of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DepthRule {
    /// Depth of the tool along the normal.
    AlongNormal,
    /// Depth of the point inside the tool, as at an edge: a tool that goes down beside the next face leaves this one
    /// by its border, and what it takes there is as deep as it takes off the next.
    InsideTool,
}

impl NormalRay {
    /// Returns the point at `s`.
    #[inline]
    pub(crate) fn at(&self, s: f64) -> Point3<f64> {
        self.origin + self.normal * s
    }
}

/// Most steps of a root search. Newton steps on a convex function approach its root from one side. The slowest case
/// is halving, at a double root; 60 halvings lead from metres to below a nanometre.
const STEPS: u32 = 60;

impl ConvexBody {
    /// Returns the distance function at `s` on a ray, and its derivative by `s`.
    fn along(self, pose: &BodyPose, ray: &NormalRay, s: f64) -> (f64, f64) {
        let y = ray.at(s) - pose.tip;
        let probe = self.probe(&y, &pose.axis);
        (probe.distance, probe.slope(&y, &pose.axis, &ray.normal))
    }

    /// Tests if a point is inside the body.
    pub(crate) fn holds(self, pose: &BodyPose, point: &Point3<f64>) -> bool {
        self.probe(&(point - pose.tip), &pose.axis).distance <= 0.0
    }

    /// Returns the `s` in `[-below, limit]` at which the distance function is smallest.
    ///
    /// Bisects on the slope until a linear bound from there loses at most a tenth of the distance. Near a sharp edge the
    /// slope reverses within about that distance, which takes more steps than elsewhere.
    pub(crate) fn closest(self, pose: &BodyPose, ray: &NormalRay, limit: f64) -> f64 {
        let (mut low, mut high) = (-ray.below, limit);
        let range = high - low;
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            let (distance, slope) = self.along(pose, ray, middle);
            if slope.abs() * range <= 0.1 * distance.abs() {
                return middle;
            }
            if slope > 0.0 { high = middle } else { low = middle }
        }
        0.5 * (low + high)
    }

    /// Returns the lowest `s` in `[-below, limit)` at which the ray is inside the body, to within
    /// `tolerance` \[mm\]; `None` if there is none.
    ///
    /// The distance function is convex along the ray. Newton's method that starts where it is positive and falling never
    /// passes the root: it finds the first root or shows that there is none.
    pub(crate) fn entry(
        self,
        pose: &BodyPose,
        ray: &NormalRay,
        limit: f64,
        tolerance: f64,
    ) -> Option<f64> {
        let mut s = -ray.below;
        let inside = self.along(pose, ray, limit).0;
        if inside <= 0.0 {
            // Step 1: start as high as possible. The distance changes by at most 1 per mm, so the root is at least
            // this far below the limit.
            let guess = limit + 2.0 * inside - tolerance;
            if guess > s {
                let (value, slope) = self.along(pose, ray, guess);
                if value > 0.0 && slope < 0.0 {
                    s = guess;
                }
            }
        }
        for _ in 0..STEPS {
            let (value, slope) = self.along(pose, ray, s);
            // Inside already: at the start, or by the rounding of the last step.
            if value <= 0.0 {
                break;
            }
            // A convex function that rises here has no root farther on.
            if slope >= 0.0 {
                return None;
            }
            let step = -value / slope;
            s += step;
            // A Newton step never passes the root, so the root is beyond the limit as well.
            if s >= limit {
                return None;
            }
            if step <= tolerance {
                break;
            }
        }
        Some(s)
    }

    /// Returns the height of the origin of a ray that enters the body at `s`, by the rule of the ray.
    pub(crate) fn height_of(self, pose: &BodyPose, ray: &NormalRay, s: f64) -> f64 {
        match ray.rule {
            DepthRule::InsideTool if s < 0.0 => {
                s.max(self.probe_skin(&(ray.origin - pose.tip), &pose.axis).distance.min(0.0))
            }
            _ => s,
        }
    }
}

/// Surface of a body from which distances are counted.
#[derive(Debug, Clone, Copy)]
pub(crate) enum BodySurface {
    /// All of it.
    Whole(ConvexBody),
    /// The tool's own skin, without the ends at which another body goes on. A point inside the body is at least as deep
    /// under it as under the whole surface.
    ///
    /// An end is left out even where the next body is thinner. There a point counts as deeper than it is.
    Skin(ConvexBody),
}

impl BodySurface {
    /// Evaluates the distance function as [`ConvexBody::probe`] does.
    #[inline]
    pub(crate) fn probe(self, y: &Vector3<f64>, axis: &Vector3<f64>) -> BodyProbe {
        match self {
            Self::Whole(body) => body.probe(y, axis),
            Self::Skin(body) => body.probe_skin(y, axis),
        }
    }
}

impl BodyProbe {
    /// Describes a distance function with its derivatives by `rho` and height.
    #[inline]
    fn of([rho, height]: [f64; 2], [distance, by_rho, axial]: [f64; 3]) -> Self {
        // On the axis every radial slope up to `by_rho` is a subgradient; 0 is one of them.
        let radial = if rho > f64::MIN_POSITIVE { by_rho / rho } else { 0.0 };
        Self { distance, radial, axial, height }
    }

    /// Returns the derivative when the point moves along `direction`.
    #[inline]
    pub(crate) fn slope(
        &self,
        y: &Vector3<f64>,
        axis: &Vector3<f64>,
        direction: &Vector3<f64>,
    ) -> f64 {
        let out = y.dot(direction) - self.height * axis.dot(direction);
        self.radial * out + self.axial * axis.dot(direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BULL: ConvexBody = ConvexBody::Nose { major: 10.0, minor: 6.0, top: 50.0 };

    fn distance(body: ConvexBody, y: [f64; 3]) -> f64 {
        body.probe(&Vector3::from(y), &Vector3::z()).distance
    }

    /// No point is farther from the skin than from the whole surface. Inside, both distances are equal unless an end is
    /// nearest.
    #[test]
    fn a_skin_is_the_body_without_its_ends() {
        let frustum = ConvexBody::Frustum { low: 10.0, high: 30.0, radius: 3.0, slope: 0.2 };
        for body in [BULL, frustum] {
            let [bottom, top] = body.heights();
            for k in 0..4000 {
                let share = |n: u32| f64::from(k / n % 20) / 20.0;
                let y =
                    Vector3::new(24.0 * share(1) - 12.0, 9.0 * share(20) - 4.5, 60.0 * share(200));
                let (whole, skin) = (
                    body.probe(&y, &Vector3::z()).distance,
                    body.probe_skin(&y, &Vector3::z()).distance,
                );
                assert!(skin <= whole + 1e-12, "{y}: {skin} {whole}");
                let ends =
                    (y.z - top).max(if body == BULL { f64::NEG_INFINITY } else { bottom - y.z });
                if whole <= 0.0 && ends < whole {
                    assert!((skin - whole).abs() < 1e-12, "{y}: {skin} {whole}");
                }
            }
        }
    }

    #[test]
    fn distances_to_a_bull_nose_are_a_pencil_calculation() {
        assert!((distance(BULL, [0.0, 3.0, -2.0]) - 2.0).abs() < 1e-15); // below the disc
        assert!((distance(BULL, [20.0, 0.0, 20.0]) - 4.0).abs() < 1e-15); // beside the flank
        assert!((distance(BULL, [14.0, 0.0, 3.0]) + 1.0).abs() < 1e-15); // 3-4-5 in the corner
        assert!((distance(BULL, [0.0, 0.0, 51.0]) - 1.0).abs() < 1e-15); // above
    }

    #[test]
    fn a_ray_from_below_enters_where_the_disc_is() {
        let pose = BodyPose { tip: Point3::new(0.0, 0.0, 0.3), axis: Vector3::z() };
        let ray = NormalRay {
            origin: Point3::new(5.0, 0.0, 0.0),
            normal: Vector3::z(),
            below: 4.0,
            rule: DepthRule::AlongNormal,
        };
        assert!((BULL.entry(&pose, &ray, 2.0, 1e-9).unwrap() - 0.3).abs() < 1e-9);
        assert_eq!(BULL.entry(&pose, &ray, 0.2, 1e-9), None);
        let beside = NormalRay { origin: Point3::new(17.0, 0.0, 0.0), ..ray };
        assert_eq!(BULL.entry(&pose, &beside, 2.0, 1e-9), None);
        let deep = NormalRay { origin: Point3::new(5.0, 0.0, 9.0), ..ray };
        assert_eq!(BULL.entry(&pose, &deep, 2.0, 1e-9), Some(-4.0));
    }

    #[test]
    fn a_ray_past_a_sharp_edge_is_bounded_from_its_closest_point() {
        // 1e-5 mm below and beside the edge of a flat end, at 45 deg to it.
        let (flat, limit) = (ConvexBody::Nose { major: 5.0, minor: 0.0, top: 50.0 }, 2.0);
        let pose = BodyPose { tip: Point3::origin(), axis: Vector3::z() };
        let normal = Vector3::new(1.0, 0.0, 1.0).normalize();
        let ray = NormalRay {
            origin: Point3::new(5.0 + 1e-5, 0.0, -1e-5),
            normal,
            below: 2.0,
            rule: DepthRule::AlongNormal,
        };
        let s = flat.closest(&pose, &ray, limit);
        let (distance, slope) = flat.along(&pose, &ray, s);
        assert!(slope.abs() * (limit + ray.below) <= 0.1 * distance, "{s} {distance} {slope}");
        assert!((distance - 2.0f64.sqrt() * 1e-5).abs() < 1e-7);
    }

    #[test]
    fn extents_are_where_no_point_is_beyond() {
        let direction = Vector3::new(0.6, 0.0, -0.8);
        // Edge of the disc at 10, rounding 6 about height 6: 10 0.6 - 6 0.8 + 6.
        assert!((BULL.extent(&Vector3::z(), &direction) - 7.2).abs() < 1e-12);
        assert!((BULL.extent(&Vector3::z(), &Vector3::z()) - 50.0).abs() < 1e-12);
        let body = ConvexBody::Frustum { low: 10.0, high: 20.0, radius: 5.0, slope: 0.75 };
        assert!((body.extent(&Vector3::z(), &Vector3::x()) - 12.5).abs() < 1e-12);
        assert!((body.extent(&Vector3::z(), &direction) - (5.0 * 0.6 - 8.0)).abs() < 1e-12);
    }

    #[test]
    fn a_frustum_ends_at_its_planes_and_its_cone() {
        let body = ConvexBody::Frustum { low: 10.0, high: 20.0, radius: 5.0, slope: 0.75 };
        assert!((distance(body, [0.0, 0.0, 8.0]) - 2.0).abs() < 1e-15);
        assert!((distance(body, [10.0, 0.0, 10.0]) - 4.0).abs() < 1e-15); // 5 / hypot(1, 0.75)
        assert!((body.radius() - 12.5).abs() < 1e-15);
        assert!((distance(body, [8.0, 0.0, 6.0]) - 5.0).abs() < 1e-15); // 3-4-5 from the lower rim
        assert!((distance(body, [15.5, 0.0, 24.0]) - 5.0).abs() < 1e-15); // and from the upper one
        assert!((distance(BULL, [19.0, 0.0, 54.0]) - 5.0).abs() < 1e-15);
        // Beside the slanting line near its lower end, where a level line would be below the rim.
        assert!((distance(body, [9.0, 0.0, 8.0]) - (4.0 - 0.75 * -2.0) / 1.25).abs() < 1e-15);
    }
}
