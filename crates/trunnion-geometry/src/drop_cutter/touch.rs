//! Heights at which a cutting end touches a facet or an edge of a triangle.

use super::end::CuttingEnd;
use crate::cutter::{ProfilePiece, TangentProfile};
use crate::math;
use nalgebra::{Point3, Vector2, Vector3};

/// Most steps of the root search: bisection alone would need no more for every digit.
const STEPS: u32 = 60;

/// Point of a triangle, and the height of the tip \[mm\] when the end touches it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EndTouch {
    pub(super) tip: f64,
    pub(super) point: Point3<f64>,
}

/// End above a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedEnd<'a> {
    pub(super) end: &'a CuttingEnd,
    pub(super) place: Vector2<f64>,
}

impl PlacedEnd<'_> {
    /// Returns the highest touch of a triangle above `least`.
    pub(super) fn triangle(&self, corners: &[Point3<f64>; 3], least: f64) -> Option<EndTouch> {
        let mut best = self.facet(corners).filter(|touch| touch.tip > least);
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let least = best.map_or(least, |touch| touch.tip);
            let touch = self.edge(&corners[from], &corners[to], least);
            best = touch.filter(|touch| touch.tip > least).or(best);
        }
        best
    }

    /// Returns the touch in the inside of a triangle, in closed form.
    ///
    /// The tube centre of the torus lies on the normal of the contact, and on the circle of radius `R` about the axis:
    /// seen from above the contact lies `R + r |n_xy|` from the axis, against the normal. On a profile with a side it is
    /// the point that is farthest against the normal.
    fn facet(&self, corners: &[Point3<f64>; 3]) -> Option<EndTouch> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a)).try_normalize(f64::MIN_POSITIVE)?;
        // Both sides of a triangle are solid.
        let normal = if normal.z < 0.0 { -normal } else { normal };
        let CuttingEnd { major, minor, side } = self.end;
        let flat = normal.xy();
        let slope = flat.norm();
        let uphill = if slope > 0.0 { flat / slope } else { Vector2::zeros() };
        let [out, up] = match side {
            Some(side) => side.farthest([slope, -normal.z]),
            None => [major + minor * slope, minor * slope * slope / (1.0 + normal.z)],
        };
        let at = self.place - uphill * out;
        if normal.z <= 0.0 || !inside(corners, &at) {
            return None;
        }
        let z = a.z - flat.dot(&(at - a.xy().coords)) / normal.z;
        let tip = z - up;
        Some(EndTouch { tip, point: Point3::new(at.x, at.y, z) })
    }

    /// Returns the touch of an edge with its ends, if it may be above `least`.
    ///
    /// Along the edge, `t` from the foot of the axis, the tip stands at `z(t) - h(sqrt(d² + t²))`. The height `h` is
    /// convex and does not fall outwards, so this is concave in `t` and has one maximum.
    fn edge(&self, from: &Point3<f64>, to: &Point3<f64>, least: f64) -> Option<EndTouch> {
        let along = to.xy() - from.xy();
        let length = along.norm();
        let radius = self.end.radius();
        let offset = from.xy().coords - self.place;
        if length <= 0.0 {
            let distance = offset.norm();
            let top = if from.z > to.z { from } else { to };
            let tip = top.z - self.end.height(distance);
            return (distance <= radius).then_some(EndTouch { tip, point: *top });
        }
        let direction = along / length;
        let start = offset.dot(&direction);
        let side = offset - direction * start;
        let distance = side.norm();
        let reach = (radius * radius - distance * distance).max(0.0).sqrt();
        let (low, high) = (start.max(-reach), (start + length).min(reach));
        let nearest = math::hypot(0.0_f64.clamp(start, start + length), distance);
        let bound = from.z.max(to.z) - self.end.height(nearest.min(radius));
        if distance > radius || low > high || bound <= least {
            return None;
        }
        let slope = (to.z - from.z) / length;
        let t = self.steepest(slope, distance, reach).clamp(low, high);
        let share = ((t - start) / length).clamp(0.0, 1.0);
        let point = from + (to - from) * share;
        let tip = point.z - self.end.height(math::hypot(t, distance));
        Some(EndTouch { tip, point })
    }

    /// Returns the place of the maximum on the endless line: where `slope = h'(rho) t / rho`.
    fn steepest(&self, slope: f64, distance: f64, reach: f64) -> f64 {
        let CuttingEnd { major, minor, side } = self.end;
        let steep = slope.abs();
        if steep <= 0.0 {
            return 0.0;
        }
        let t = match side {
            Some(side) => on_profile(steep, distance, side),
            None if *minor > 0.0 => on_arc(steep, distance, [*major, *minor]),
            None => reach,
        };
        t.min(reach).copysign(slope)
    }
}

/// Returns `t` at which a line of that slope, at a distance from the axis, touches a profile with a side; it may lie
/// beyond the rim.
fn on_profile(steep: f64, distance: f64, profile: &TangentProfile) -> f64 {
    let [tip, side] = profile.pieces();
    let joint = profile.joint()[0];
    let on = |piece: ProfilePiece| match piece {
        ProfilePiece::Arc { center: [major, _], radius, .. } => {
            on_arc(steep, distance, [major, radius])
        }
        ProfilePiece::Line { from, to } => {
            // The slope of a cone is the same everywhere: t / rho is the share of it that the line has.
            let cone = (to[1] - from[1]) / (to[0] - from[0]);
            if steep < cone {
                steep * distance / ((cone - steep) * (cone + steep)).sqrt()
            } else {
                f64::INFINITY
            }
        }
    };
    let ProfilePiece::Arc { to: [out, up], .. } = tip else { return on(side) };
    // h' t / rho grows outwards: it reaches the slope on the tip arc, or beyond its end.
    let share = distance / joint;
    let across = (1.0 - share * share).max(0.0).sqrt();
    if distance < joint && out * across >= -up * steep { on(tip) } else { on(side) }
}

/// Returns `t` at which a line of that slope, at a distance from the axis, touches the arc of radius `minor` about a
/// circle of radius `major`, which is negative for an arc about a centre beyond the axis.
fn on_arc(steep: f64, distance: f64, [major, minor]: [f64; 2]) -> f64 {
    if major.abs() > 0.0 {
        return on_torus(steep, distance, [major, minor]);
    }
    // On a sphere the edge touches its circle, of radius sqrt(r² - d²).
    let reach = (minor * minor - distance * distance).max(0.0).sqrt();
    steep * reach / math::hypot(steep, 1.0)
}

/// Returns `t` at which a line of that slope, at a distance from the axis, touches a torus.
///
/// With the tube angle `a`, `rho = R + r sin a` and `h' = tan a`, the condition is
/// `sin a sqrt(1 - d² / rho²) = steep cos a`. The difference of both sides grows with `a`, is negative where the line
/// enters the torus and positive at its rim: Newton's steps stay inside that bracket.
fn on_torus(steep: f64, distance: f64, [major, minor]: [f64; 2]) -> f64 {
    let rho = |sine: f64| major + minor * sine;
    let mut low = math::asin(((distance - major) / minor).clamp(0.0, 1.0));
    let mut high = std::f64::consts::FRAC_PI_2;
    // The tube angle of the same slope on a line through the axis.
    let mut angle = math::atan(steep).max(low);
    for _ in 0..STEPS {
        let (sine, cosine) = math::sin_cos(angle);
        let share = distance / rho(sine);
        let across = (1.0 - share * share).max(0.0).sqrt();
        let excess = sine * across - steep * cosine;
        if excess > 0.0 {
            high = angle;
        } else {
            low = angle;
        }
        // d/da sqrt(1 - d²/rho²) = d² r cos a / (rho³ sqrt(..)).
        let turn = if across > 0.0 {
            share * share * minor * cosine / (rho(sine) * across)
        } else {
            f64::INFINITY
        };
        let rate = cosine * across + sine * turn + steep * sine;
        let next = angle - excess / rate;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        // The maximum is flat: an error of the angle enters its height by the square.
        if (next - angle).abs() <= 1e-12 {
            angle = next;
            break;
        }
        angle = next;
    }
    let out = rho(math::sin(angle));
    (out * out - distance * distance).max(0.0).sqrt()
}

/// Returns true if a place lies inside a triangle seen from above, or on its rim.
fn inside(corners: &[Point3<f64>; 3], at: &Vector2<f64>) -> bool {
    let side = |from: &Point3<f64>, to: &Point3<f64>| {
        let (edge, there) = (to.xy() - from.xy(), at - from.xy().coords);
        edge.x * there.y - edge.y * there.x
    };
    let [a, b, c] = corners;
    let sides = Vector3::new(side(a, b), side(b, c), side(c, a));
    sides.min() >= 0.0 || sides.max() <= 0.0
}
