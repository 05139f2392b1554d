//! The centre circle of the torus.

use crate::math;
use crate::positioning::distance::probe::DistanceReading;
use nalgebra::{Point3, Vector3};

/// Point of a circle, and the derivative of the point by the angle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CirclePoint {
    /// Angle \[rad\].
    pub(crate) psi: f64,
    /// The point \[mm\].
    pub(crate) at: Point3<f64>,
    /// Derivative of the point by the angle \[mm/rad\].
    pub(crate) tangent: Vector3<f64>,
}

/// The centre circle of the torus.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CenterCircle {
    pub(crate) center: Point3<f64>,
    /// Unit vector towards the angle 0.
    pub(crate) f: Vector3<f64>,
    /// Unit vector towards the angle pi/2.
    pub(crate) e2: Vector3<f64>,
    pub(crate) radius: f64,
}

impl CenterCircle {
    /// Returns the point of the circle at the angle `psi`.
    pub(crate) fn at(&self, psi: f64) -> Point3<f64> {
        let (sin, cos) = math::sin_cos(psi);
        self.center + self.f * (self.radius * cos) + self.e2 * (self.radius * sin)
    }

    /// Returns the angle of the point `lift` above a foot, which lies on the circle or near it.
    pub(crate) fn angle_over(&self, end: &DistanceReading, lift: f64) -> f64 {
        let out = end.foot.point + end.normal().scale(lift) - self.center;
        math::atan2(self.e2.dot(&out), self.f.dot(&out))
    }

    /// Returns the point at the angle `psi` and its derivative.
    pub(crate) fn point(&self, psi: f64) -> CirclePoint {
        let (sin, cos) = math::sin_cos(psi);
        let (sin, cos) = (self.radius * sin, self.radius * cos);
        CirclePoint {
            psi,
            at: self.center + self.f * cos + self.e2 * sin,
            tangent: self.e2 * cos - self.f * sin,
        }
    }
}
