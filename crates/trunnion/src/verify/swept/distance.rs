//! Exact signed distance of a point from a body, with its gradient.

use super::tool::{BodyPose, ConvexBody};
use crate::math;
use nalgebra::{Point3, Vector3};

/// Distance in the half plane through the axis, with its derivatives by the distance from the axis and by the height.
type ProfileDistance = (f64, f64, f64);

/// Returns the signed distance of a point from a body, negative inside, and the unit vector in which it grows.
pub(crate) fn distance(
    body: ConvexBody,
    pose: &BodyPose,
    point: &Point3<f64>,
) -> (f64, Vector3<f64>) {
    // The body is a solid of revolution: the half plane through the axis and the point decides.
    let y = point - pose.tip;
    let height = pose.axis.dot(&y);
    let aside = y - pose.axis * height;
    let rho = aside.norm();
    let (distance, out, up) = match body {
        ConvexBody::Nose { major, minor, top } => nose([rho, height], [major, minor, top]),
        ConvexBody::Tangent(profile) => {
            let found = profile.distance([rho, height]);
            (found.distance, found.gradient[0], found.gradient[1])
        }
        ConvexBody::Frustum { low, high, radius, slope } => {
            // Signed distance from the line of the cone, whose outward unit normal is (1, -slope) / steep.
            let steep = math::hypot(slope, 1.0);
            let side = (rho - radius - slope * (height - low)) / steep;
            let ends = [[radius, low], [radius + slope * (high - low), high]];
            frustum([rho, height], (side, 1.0 / steep, -slope / steep), ends)
        }
    };
    // On the axis every direction across it is as good as any other.
    let across = if rho > f64::MIN_POSITIVE { aside / rho } else { any_across(&pose.axis) };
    (distance, across * out + pose.axis * up)
}

/// Returns the directions across and along the axis, with both signs.
///
/// They point to other sides of a body, which may be about as near to a point as its nearest side.
pub(crate) fn other_sides(pose: &BodyPose, point: &Point3<f64>) -> [Vector3<f64>; 4] {
    let y = point - pose.tip;
    let aside = y - pose.axis * pose.axis.dot(&y);
    let across = aside.try_normalize(0.0).unwrap_or_else(|| any_across(&pose.axis));
    [across, -across, pose.axis, -pose.axis]
}

/// Returns the unit normals of the sides of a body in the half plane of a point.
pub(crate) fn sides(body: ConvexBody, pose: &BodyPose, point: &Point3<f64>) -> [Vector3<f64>; 3] {
    let [across, _, up, down] = other_sides(pose, point);
    let side = match body {
        ConvexBody::Nose { .. } | ConvexBody::Tangent(_) => across,
        ConvexBody::Frustum { slope, .. } => (across + down * slope) / math::hypot(slope, 1.0),
    };
    [side, up, down]
}

fn any_across(axis: &Vector3<f64>) -> Vector3<f64> {
    let mut direction = Vector3::zeros();
    // The coordinate axis farthest from parallel gives the best conditioned product.
    direction[axis.iamin()] = 1.0;
    direction.cross(axis).normalize()
}

fn nose([rho, height]: [f64; 2], [major, minor, top]: [f64; 3]) -> ProfileDistance {
    // Above the top end, its disc or its rim is nearest.
    let above = height - top;
    if above > 0.0 {
        return from_disc([rho - major - minor, above]);
    }
    // Relative to the centre of the corner arc: its quadrant, the cylinder above, or the flat end inside.
    let [out, down] = [rho - major, minor - height];
    let side = if out > 0.0 && down > 0.0 {
        let away = math::hypot(out, down);
        (away - minor, out / away, -down / away)
    } else if out >= down {
        (out - minor, 1.0, 0.0)
    } else {
        (down - minor, 0.0, -1.0)
    };
    // Below the top end, the side with the smallest depth counts.
    if above > side.0 { (above, 0.0, 1.0) } else { side }
}

/// Returns the distance from a frustum: `side` is that of the cone alone, `ends` are radius and height of both discs.
fn frustum(
    [rho, height]: [f64; 2],
    side: ProfileDistance,
    [low, high]: [[f64; 2]; 2],
) -> ProfileDistance {
    // Heights beyond both ends; at most one of them is positive.
    let [above, below] = [height - high[1], low[1] - height];
    // Inside, the nearest of side and ends counts.
    if side.0 <= 0.0 && above <= 0.0 && below <= 0.0 {
        let ends = if above > below { (above, 0.0, 1.0) } else { (below, 0.0, -1.0) };
        return if ends.0 > side.0 { ends } else { side };
    }
    // Outside, the foot of the perpendicular on the cone decides between side and rims.
    let foot = height - side.2 * side.0.max(0.0);
    if foot > high[1] {
        from_disc([rho - high[0], above])
    } else if foot < low[1] {
        let (distance, out, down) = from_disc([rho - low[0], below]);
        (distance, out, -down)
    } else {
        side
    }
}

/// Returns the distance from a disc's face or rim, from `out` beyond the rim and `up` above it; one of them is positive.
fn from_disc([out, up]: [f64; 2]) -> ProfileDistance {
    // Over the disc the face is nearest, beside it the rim.
    let out = out.max(0.0);
    let away = math::hypot(out, up);
    (away, out / away, up / away)
}

/// Returns the point of a body that is farthest along the unit vector `direction`.
pub(crate) fn farthest(body: ConvexBody, pose: &BodyPose, direction: &Vector3<f64>) -> Point3<f64> {
    let up = direction.dot(&pose.axis);
    let aside = direction - pose.axis * up;
    let across = aside.try_normalize(0.0).unwrap_or_default();
    let rim = |radius: f64, height: f64| across * radius + pose.axis * height;
    match body {
        ConvexBody::Nose { major, minor, top } if up > 0.0 => pose.tip + rim(major + minor, top),
        ConvexBody::Nose { major, minor, .. } => pose.tip + rim(major, minor) + direction * minor,
        ConvexBody::Tangent(profile) => {
            let [radius, height] = profile.farthest([aside.norm(), up]);
            pose.tip + rim(radius, height)
        }
        ConvexBody::Frustum { low, high, radius, slope } => {
            // A linear function on a frustum is largest on one of its rims.
            let [lower, upper] = [rim(radius, low), rim(radius + slope * (high - low), high)];
            pose.tip + if lower.dot(direction) > upper.dot(direction) { lower } else { upper }
        }
    }
}

/// Returns the height of the axis point that is deepest inside the body \[mm above the tip\].
pub(crate) fn deepest(body: ConvexBody) -> f64 {
    let [low, high] = body.heights();
    let middle = 0.5 * (low + high);
    match body {
        ConvexBody::Nose { .. } => middle,
        ConvexBody::Tangent(profile) => profile.deepest(),
        ConvexBody::Frustum { radius, slope, .. } => {
            // At this height the side is as near as the wider end.
            let steep = math::hypot(slope, 1.0);
            if slope < 0.0 {
                // x above the lower end, the side is (radius + slope x) / steep away: equal to x at radius / (steep - slope).
                middle.min(low + radius / (steep - slope))
            } else {
                middle.max(high - (radius + slope * (high - low)) / (steep + slope))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{Cutter, CutterSpec};
    use proptest::prelude::*;

    fn body() -> impl Strategy<Value = ConvexBody> {
        let frustum =
            (5.0..20.0, 1.0..30.0, 1.0..9.0, -0.9..0.9).prop_map(|(low, long, r, lean)| {
                let slope = f64::max(lean * 4.0, (0.1 - r) / long);
                ConvexBody::Frustum { low, high: low + long, radius: r, slope }
            });
        let nose = (0.0..5.0, 0.0..4.0, 0.5..30.0).prop_map(|(major, minor, more)| {
            ConvexBody::Nose { major: major + 0.1, minor, top: minor + more }
        });
        prop_oneof![frustum, nose, tangent()]
    }

    /// Tapered, barrel and lens cutters.
    fn tangent() -> impl Strategy<Value = ConvexBody> {
        let spec = (0..4u32, 0.3..2.0f64, 0.5..6.0f64, 0.1..0.7f64, 30.0..200.0f64);
        spec.prop_map(|(kind, r, more, angle, large)| {
            let diameter = 2.0 * (r + more);
            let spec = match kind {
                0 => CutterSpec::taper(r, angle, diameter),
                1 => CutterSpec::barrel(r, large, diameter),
                2 => CutterSpec::conical_barrel(r, large, angle, diameter),
                _ => CutterSpec::lens(large, r, diameter),
            };
            let cutter = Cutter::new(CutterSpec { length: 70.0, ..spec }).unwrap();
            ConvexBody::Tangent(*cutter.tangent_profile().unwrap())
        })
    }

    fn pose() -> BodyPose {
        let axis = Vector3::new(0.3, -0.5, 0.8).normalize();
        BodyPose { tip: Point3::new(1.0, -2.0, 3.0), axis }
    }

    /// A grid of points of the body's outline in the half plane.
    fn outline(body: ConvexBody) -> Vec<[f64; 2]> {
        let along = |k: u32| f64::from(k) / 400.0;
        let mut points = Vec::new();
        for k in 0..=400 {
            let s = along(k);
            match body {
                ConvexBody::Tangent(profile) => {
                    let end = profile.flank_start();
                    // The arc of a barrel is long.
                    let finer = (0..8).map(|j| s + along(j) / 8.0).filter(|s| *s <= 1.0);
                    for share in finer {
                        points.extend(profile.pieces().iter().map(|piece| piece.at(share)));
                    }
                    points.push([profile.radius(), end + (profile.top() - end) * s]);
                    points.push([profile.radius() * s, profile.top()]);
                }
                ConvexBody::Nose { major, minor, top } => {
                    let angle = s * std::f64::consts::FRAC_PI_2;
                    points.push([major + minor * angle.sin(), minor - minor * angle.cos()]);
                    points.push([major * s, 0.0]);
                    points.push([major + minor, minor + (top - minor) * s]);
                    points.push([(major + minor) * s, top]);
                }
                ConvexBody::Frustum { low, high, radius, slope } => {
                    let end = radius + slope * (high - low);
                    points.push([radius * s, low]);
                    points.push([end * s, high]);
                    points.push([radius + (end - radius) * s, low + (high - low) * s]);
                }
            }
        }
        points
    }

    proptest! {
        /// Against the nearest of many points of the outline.
        #[test]
        fn the_distance_is_that_to_the_outline(body in body(), rho in 0.0..30.0f64, height in -15.0..60.0f64) {
            let pose = pose();
            let across = any_across(&pose.axis);
            let point = pose.tip + pose.axis * height + across * rho;
            let (distance, direction) = distance(body, &pose, &point);
            let outline = outline(body);
            let sampled = outline.iter().map(|[r, h]| (r - rho).hypot(h - height)).fold(f64::INFINITY, f64::min);
            prop_assert!((distance.abs() - sampled).abs() < 0.1, "{distance} {sampled}");
            prop_assert!(distance.abs() <= sampled + 1e-12, "{distance} {sampled}");
            prop_assert!((direction.norm() - 1.0).abs() < 1e-12);
            // The plane at the surface leaves all of the body on one side.
            let reach = farthest(body, &pose, &direction);
            let most = pose.tip.coords.dot(&direction) + body.extent(&pose.axis, &direction);
            prop_assert!((reach.coords.dot(&direction) - most).abs() < 1e-12);
            prop_assert!((point.coords.dot(&direction) - distance - most).abs() < 1e-9);
            for [r, h] in outline {
                let p = pose.axis * h + across * r;
                prop_assert!((pose.tip + p).coords.dot(&direction) < most + 1e-9);
            }
        }

        #[test]
        fn nowhere_on_the_axis_is_deeper_than_the_deepest_place(body in body()) {
            let pose = pose();
            let at = |height: f64| distance(body, &pose, &(pose.tip + pose.axis * height)).0;
            let least = at(deepest(body));
            for k in -10..=50 {
                prop_assert!(at(f64::from(k)) >= least - 1e-12);
            }
        }
    }
}
