//! From points in space back to the parameters of a surface.

use super::curve::StepCurve;
use super::model::StepFrame;
use super::shape::StepShape;
use crate::math;
use crate::surface::FaceIndex;
use crate::surface::Surface;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;
use std::f64::consts::TAU;

/// A point of the surface at which one parameter is fixed and the other is arbitrary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChartPole {
    /// Fixed parameter: 0 = u, 1 = v.
    pub(super) fixed: usize,
    /// Its value.
    pub(super) at: f64,
    /// Point \[mm\].
    pub(super) point: Point3<f64>,
}

/// A surface and its inverse.
#[derive(Debug)]
pub(super) struct SurfaceChart<'a> {
    shape: &'a StepShape,
    pub(super) surface: &'a Surface,
    /// Closest points, for surfaces without a closed form.
    index: Option<FaceIndex>,
    /// Periods by u and v. Other than those of the surface these include spline surfaces that
    /// close with an edge.
    pub(super) periods: [Option<f64>; 2],
    pub(super) poles: Vec<ChartPole>,
    tolerance: f64,
}

impl<'a> SurfaceChart<'a> {
    /// Creates the chart; points closer than `tolerance` \[mm\] count as one.
    pub(super) fn new(
        shape: &'a StepShape,
        surface: &'a Surface,
        index: Option<FaceIndex>,
        tolerance: f64,
    ) -> Self {
        let periods = match shape {
            StepShape::Plane(_) => [None; 2],
            StepShape::Cylinder { .. } | StepShape::Cone { .. } | StepShape::Sphere { .. } => {
                [Some(TAU), None]
            }
            StepShape::Torus { .. } => [Some(TAU); 2],
            StepShape::Extrusion { curve, .. } => [curve.period(tolerance), None],
            StepShape::Revolution { curve, .. } => [Some(TAU), curve.period(tolerance)],
            StepShape::Net(_) => closed_rims(surface, tolerance),
        };
        let poles = poles(shape, surface, tolerance);
        Self { shape, surface, index, periods, poles, tolerance }
    }

    /// Returns the pole at `p`, if there is one.
    pub(super) fn pole(&self, p: &Point3<f64>) -> Option<ChartPole> {
        self.poles.iter().copied().find(|pole| (pole.point - p).norm() <= self.tolerance)
    }

    /// Finds the parameters of the surface point at `p`, on the turn closest to `near`. `None`
    /// where the search fails (it does not on points that lie on the surface and away from its
    /// poles).
    pub(super) fn uv(&self, p: &Point3<f64>, near: Option<[f64; 2]>) -> Option<[f64; 2]> {
        let uv = self.any_turn(p, near)?;
        if !uv.iter().all(|x| x.is_finite()) {
            return None;
        }
        Some(near.map_or(uv, |near| self.nearest_turn(uv, near)))
    }

    /// Moves `uv` by whole periods to lie closest to `near`.
    pub(super) fn nearest_turn(&self, uv: [f64; 2], near: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| match self.periods[k] {
            Some(period) => uv[k] + period * ((near[k] - uv[k]) / period).round(),
            None => uv[k],
        })
    }

    /// Returns the surface point, with closed spline surfaces continued round their rim.
    pub(super) fn point(&self, uv: [f64; 2]) -> Point3<f64> {
        let [u, v] = self.wrapped(uv);
        self.surface.point(u, v)
    }

    /// Brings parameters into the domain by whole periods.
    pub(super) fn wrapped(&self, uv: [f64; 2]) -> [f64; 2] {
        let domain = self.surface.domain();
        [0, 1].map(|k| match self.periods[k] {
            Some(period) if domain[k].low.is_finite() => {
                let turns = ((uv[k] - domain[k].low) / period).floor();
                uv[k] - turns * period
            }
            _ => uv[k],
        })
    }

    fn any_turn(&self, p: &Point3<f64>, near: Option<[f64; 2]>) -> Option<[f64; 2]> {
        match self.shape {
            StepShape::Plane(frame) => {
                let q = frame.local(p);
                Some([q.x, q.y])
            }
            StepShape::Cylinder { frame, .. } => {
                let q = frame.local(p);
                // S = O + R (cos u x + sin u y) + v z: longitude and height.
                Some([math::atan2(q.y, q.x), q.z])
            }
            StepShape::Cone { frame, radius, angle } => {
                let q = frame.local(p);
                // Beyond the apex the radius is negative: the point is on the far side of the axis.
                let turn = if radius + q.z * math::tan(*angle) < 0.0 { PI } else { 0.0 };
                Some([math::atan2(q.y, q.x) + turn, q.z])
            }
            StepShape::Sphere { frame, .. } => {
                let q = frame.local(p);
                // Longitude, and latitude from the equator; both hold off the sphere, too.
                Some([math::atan2(q.y, q.x), math::atan2(q.z, math::hypot(q.x, q.y))])
            }
            StepShape::Torus { frame, major, .. } => {
                let q = frame.local(p);
                // In the half plane of p, the angle about the centre of the tube.
                Some([math::atan2(q.y, q.x), math::atan2(q.z, math::hypot(q.x, q.y) - major)])
            }
            StepShape::Extrusion { curve, direction } => Some(extrusion(curve, direction, p)),
            StepShape::Revolution { curve, axis } => Some(revolution(curve, axis, p)),
            StepShape::Net(_) => self.searched(p, near),
        }
    }

    fn searched(&self, p: &Point3<f64>, near: Option<[f64; 2]>) -> Option<[f64; 2]> {
        let index = self.index.as_ref()?;
        let foot = match near {
            Some(near) => index.closest_near(p, self.wrapped(near).into()),
            None => index.closest(p),
        };
        let mut foot = foot.ok()?;
        // Newton's method may have settled in a far hollow; a point of the surface has a foot at
        // no distance.
        if near.is_some() && foot.distance.abs() > self.tolerance {
            foot = index.closest(p).ok().filter(|f| f.distance.abs() < foot.distance.abs())?;
        }
        let domain = self.surface.domain();
        // A foot beyond the rim, by the tolerance of the file, is moved to the rim.
        let foot: [f64; 2] = foot.uv.into();
        Some([0, 1].map(|k| match self.periods[k] {
            Some(_) => foot[k],
            None => foot[k].clamp(domain[k].low, domain[k].high),
        }))
    }
}

/// Returns the parameters on an extrusion: seen along the direction, the surface is its curve.
fn extrusion(curve: &StepCurve, direction: &Vector3<f64>, p: &Point3<f64>) -> [f64; 2] {
    let length = direction.norm_squared();
    // Part of a vector square to the direction: what remains when it is seen along it.
    let across = |x: Vector3<f64>| x - direction * (direction.dot(&x) / length);
    let u = curve.nearest(window(curve, p), &|s, ds| (across(s - p), across(ds)));
    [u, direction.dot(&(p - curve.point(u))) / length]
}

/// Returns the parameters on a revolution: turned into one half plane of the axis, it is its curve.
fn revolution(curve: &StepCurve, axis: &StepFrame, p: &Point3<f64>) -> [f64; 2] {
    let q = axis.local(p);
    let radius = math::hypot(q.x, q.y);
    let v = curve.nearest(window(curve, p), &|s, ds| {
        let local = axis.local(&s);
        let along = Vector3::new(axis.x.dot(&ds), axis.y.dot(&ds), axis.z.dot(&ds));
        // rho = |(x, y)| and d rho / dt = (x x' + y y') / rho; on the axis it has no derivative.
        let r = math::hypot(local.x, local.y);
        let slope = if r > 0.0 { (local.x * along.x + local.y * along.y) / r } else { 0.0 };
        (Vector3::new(r - radius, local.z - q.z, 0.0), Vector3::new(slope, along.z, 0.0))
    });
    // The profile need not lie in the half plane u = 0: u counts from its own longitude.
    let s = axis.local(&curve.point(v));
    [math::atan2(q.y, q.x) - math::atan2(s.y, s.x), v]
}

/// Returns a range of an endless profile that holds every point as far from its origin as `p`.
fn window(curve: &StepCurve, p: &Point3<f64>) -> [f64; 2] {
    let reach = match curve {
        StepCurve::Line { origin, direction } => 2.0 * (p - origin).norm() / direction.norm(),
        StepCurve::Hyperbola { frame, semi } => (2.0 * (p - frame.origin).norm() / semi[1]).asinh(),
        StepCurve::Parabola { frame, focal } => (p - frame.origin).norm() / focal,
        StepCurve::Ellipse { .. } | StepCurve::Spline(_) => 0.0,
    };
    [-reach, reach]
}

/// Intervals of samples by which rims are compared: enough to distinguish rims of the same ends.
const RIM: usize = 16;

fn rim(domain: [Interval; 2], k: usize, end: usize) -> impl Iterator<Item = [f64; 2]> {
    (0..=RIM).map(move |i| {
        let Interval { low, high } = domain[1 - k];
        let mut uv = [low + (high - low) * i as f64 / RIM as f64; 2];
        uv[k] = domain[k].ends()[end];
        uv
    })
}

fn closed_rims(surface: &Surface, tolerance: f64) -> [Option<f64>; 2] {
    let domain = surface.domain();
    [0, 1].map(|k| {
        let mut pairs = rim(domain, k, 0).zip(rim(domain, k, 1));
        let meet = pairs.all(|([a, b], [c, d])| {
            (surface.point(a, b) - surface.point(c, d)).norm() <= tolerance
        });
        meet.then(|| domain[k].width())
    })
}

fn poles(shape: &StepShape, surface: &Surface, tolerance: f64) -> Vec<ChartPole> {
    let at_v = |at: f64, point: Point3<f64>| ChartPole { fixed: 1, at, point };
    match shape {
        StepShape::Sphere { frame, radius } => [-1.0, 1.0]
            .map(|side| at_v(side * FRAC_PI_2, frame.point(0.0, 0.0, side * radius)))
            .to_vec(),
        StepShape::Cone { frame, radius, angle } => {
            // R + v tan a = 0.
            let apex = -radius / math::tan(*angle);
            vec![at_v(apex, frame.point(0.0, 0.0, apex))]
        }
        StepShape::Torus { frame, major, minor } if minor >= major => {
            // The tube reaches the axis where `major + minor cos v` vanishes.
            let v = math::acos(-major / minor);
            [-v, v].map(|v| at_v(v, frame.point(0.0, 0.0, minor * math::sin(v)))).to_vec()
        }
        StepShape::Revolution { axis, .. } => {
            let domain = surface.domain()[1];
            if !domain.is_bounded() {
                return Vec::new();
            }
            // A profile that starts or ends on the axis closes the surface there.
            let ends = domain.ends().map(|v| (v, surface.point(surface.domain()[0].low, v)));
            let on_axis = |p: &Point3<f64>| axis.local(p).xy().norm() <= tolerance;
            ends.into_iter().filter(|(_, p)| on_axis(p)).map(|(v, p)| at_v(v, p)).collect()
        }
        StepShape::Net(_) => {
            let domain = surface.domain();
            let mut poles = Vec::new();
            for (k, end) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let points: Vec<_> =
                    rim(domain, k, end).map(|[u, v]| surface.point(u, v)).collect();
                let Some(&point) = points.first() else { continue };
                // A whole side of the control net that shrinks to one point.
                if points.iter().all(|p| (p - point).norm() <= tolerance) {
                    poles.push(ChartPole { fixed: k, at: domain[k].ends()[end], point });
                }
            }
            poles
        }
        _ => Vec::new(),
    }
}
