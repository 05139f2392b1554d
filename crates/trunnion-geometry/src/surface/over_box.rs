//! Distances from the part of an elementary surface over a box of parameters, in closed form.
//!
//! Of a trimmed bowl or fillet only that part is there. The whole sphere or torus closes over it, and would keep every
//! tool out.

use super::analytic::turn;
use super::analytic::{ConeSurface, PlaneSurface, TorusSurface};
use super::geometry::Surface;
use super::parameter_box::ParameterBox;
use crate::math;
use crate::types::Interval;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;

/// Returns the unsigned distance \[mm\] of `p` from an elementary surface over a box of u and v; `None` for others.
pub(super) fn distance_over(
    surface: &Surface,
    p: &Point3<f64>,
    [u, v]: ParameterBox,
) -> Option<f64> {
    match surface {
        Surface::Plane(plane) => Some(from_rectangle(plane, p, [u, v])),
        Surface::Cylinder(cylinder) => {
            let local = cylinder.frame.local(p);
            let seen = SeenFromEnd::of(&local, u);
            let above = (v.low - local.z).max(local.z - v.high).max(0.0);
            Some(math::hypot(math::hypot(seen.aside, seen.out - cylinder.radius), above))
        }
        Surface::Cone(cone) => {
            let local = cone.frame.local(p);
            let seen = SeenFromEnd::of(&local, u);
            Some(math::hypot(seen.aside, from_ruling(cone, [seen.out, local.z], v)))
        }
        Surface::Sphere(sphere) => {
            let local = sphere.frame.local(p);
            let seen = SeenFromEnd::of(&local, u);
            Some(math::hypot(seen.aside, from_arc([seen.out, local.z], sphere.radius, v)))
        }
        Surface::Torus(torus) => Some(from_torus(torus, &torus.frame.local(p), [u, v])),
        Surface::Nurbs(_) | Surface::Extrusion(_) | Surface::Revolution(_) => None,
    }
}

/// Point as seen in the half plane through the axis that holds the nearest points of an arc round it: the nearest end
/// of the arc, or the half plane of the point itself within the arc.
struct SeenFromEnd {
    /// Distance from the axis along the half plane; negative behind the axis.
    out: f64,
    /// Distance from the half plane.
    aside: f64,
}

impl SeenFromEnd {
    fn of(local: &Vector3<f64>, u: Interval) -> Self {
        let (sin, cos) = math::sin_cos(beyond_arc(turn(local), u));
        let rho = math::hypot(local.x, local.y);
        Self { out: rho * cos, aside: rho * sin }
    }
}

/// Returns the angle between a direction and the nearer end of an arc; 0 within it.
fn beyond_arc(angle: f64, arc: Interval) -> f64 {
    let (width, after) = (arc.width(), (angle - arc.low).rem_euclid(TAU));
    if after <= width { 0.0 } else { (after - width).min(TAU - after) }
}

/// Returns the distance from an arc about the origin of a half plane.
fn from_arc([x, z]: [f64; 2], radius: f64, arc: Interval) -> f64 {
    let (sin, cos) = math::sin_cos(beyond_arc(math::atan2(z, x), arc));
    let rho = math::hypot(x, z);
    // Seen from the nearest point of the arc, turned to the angle 0.
    math::hypot(rho * sin, rho * cos - radius)
}

/// Returns the distance in a half plane from the ruling of a cone over a range of v.
fn from_ruling(cone: &ConeSurface, [x, z]: [f64; 2], v: Interval) -> f64 {
    let [low, high] = v.ends().map(|v| v.max(cone.apex()));
    // Foot on the line (R, 0) + v (tan a, 1), within the range.
    let foot = ((x - cone.radius) * cone.slope + z) / (1.0 + cone.slope * cone.slope);
    let v = foot.clamp(low, high.max(low));
    math::hypot(x - cone.radius - v * cone.slope, z - v)
}

/// Returns the distance from a rectangle of a plane.
fn from_rectangle(plane: &PlaneSurface, p: &Point3<f64>, bounds: ParameterBox) -> f64 {
    let local = plane.frame.local(p);
    let beyond = |x: f64, range: Interval| (range.low - x).max(x - range.high).max(0.0);
    math::hypot(math::hypot(beyond(local.x, bounds[0]), beyond(local.y, bounds[1])), local.z)
}

/// Returns the distance from part of a torus; of a spindle torus, that of the whole where it is less.
fn from_torus(torus: &TorusSurface, local: &Vector3<f64>, [u, v]: ParameterBox) -> f64 {
    let seen = SeenFromEnd::of(local, u);
    let part = math::hypot(seen.aside, from_arc([seen.out - torus.major, local.z], torus.minor, v));
    if torus.minor <= torus.major {
        return part;
    }
    // Beyond the axis the rings of a spindle torus lie on the other side, where an arc is not looked for.
    let rho = math::hypot(local.x, local.y);
    let whole = |x: f64| (math::hypot(x - torus.major, local.z) - torus.minor).abs();
    part.min(whole(rho)).min(whole(-rho))
}
