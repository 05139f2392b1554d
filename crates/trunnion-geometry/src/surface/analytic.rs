//! Plane, cylinder, cone, sphere and torus, parametrised as in ISO 10303-42.

use super::error::SurfaceError;
use super::jet::DerivativeTable;
use crate::math;
use crate::types::Interval;
use nalgebra::Point3;
use nalgebra::Rotation3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::TAU;

/// Two directions whose sine is below this are parallel: rounding of file digits.
const PARALLEL: f64 = 1e-9;

/// Origin and right-handed orthonormal axes (`axis2_placement_3d`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFrame {
    origin: Point3<f64>,
    axes: [UnitVector3<f64>; 3],
}

impl SurfaceFrame {
    /// Creates the frame from the z axis and a direction that, made orthogonal to z, is the x axis.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] if `x` and `z` are parallel, zero or not finite.
    pub fn new(
        origin: Point3<f64>,
        z: Vector3<f64>,
        x: Vector3<f64>,
    ) -> Result<Self, SurfaceError> {
        let finite = origin.iter().chain(&z).chain(&x).all(|value| value.is_finite());
        let z_axis = UnitVector3::try_new(z, f64::MIN_POSITIVE).filter(|_| finite);
        let x_axis = z_axis.and_then(|z| {
            let x = x.try_normalize(f64::MIN_POSITIVE)?;
            // Gram-Schmidt: of a unit vector this leaves the sine of the angle to z.
            UnitVector3::try_new(x - z.scale(x.dot(&z)), PARALLEL)
        });
        let (Some(z), Some(x)) = (z_axis, x_axis) else {
            let value = z.cross(&x).norm();
            let need = "of two finite directions that are not parallel";
            return Err(SurfaceError::Size { what: "|z cross x| of a placement", value, need });
        };
        let y = UnitVector3::new_normalize(z.cross(&x));
        Ok(Self { origin, axes: [x, y, z] })
    }

    /// Returns the frame turned about the origin of space.
    pub(super) fn turned(&self, rotation: &Rotation3<f64>) -> Self {
        let axis =
            |axis: UnitVector3<f64>| UnitVector3::new_unchecked(rotation * axis.into_inner());
        Self { origin: rotation * self.origin, axes: self.axes.map(axis) }
    }

    /// Returns the origin.
    pub fn origin(&self) -> Point3<f64> {
        self.origin
    }

    /// Returns the x axis.
    pub fn x(&self) -> UnitVector3<f64> {
        self.axes[0]
    }

    /// Returns the y axis.
    pub fn y(&self) -> UnitVector3<f64> {
        self.axes[1]
    }

    /// Returns the z axis.
    pub fn z(&self) -> UnitVector3<f64> {
        self.axes[2]
    }

    /// Coordinates of `p` in this frame.
    pub(crate) fn local(&self, p: &Point3<f64>) -> Vector3<f64> {
        let d = p - self.origin;
        Vector3::new(d.dot(&self.axes[0]), d.dot(&self.axes[1]), d.dot(&self.axes[2]))
    }
}

/// `origin + u x + v y`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneSurface {
    /// Frame of the plane; its normal is z.
    pub frame: SurfaceFrame,
}

/// `origin + R (cos u x + sin u y) + v z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderSurface {
    pub(super) frame: SurfaceFrame,
    pub(super) radius: f64,
}

/// `origin + (R + v tan a)(cos u x + sin u y) + v z`, from the apex on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConeSurface {
    pub(super) frame: SurfaceFrame,
    pub(super) radius: f64,
    pub(super) slope: f64,
}

/// `origin + R cos v (cos u x + sin u y) + R sin v z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereSurface {
    pub(super) frame: SurfaceFrame,
    pub(super) radius: f64,
}

/// `origin + (R + r cos v)(cos u x + sin u y) + r sin v z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorusSurface {
    pub(super) frame: SurfaceFrame,
    pub(super) major: f64,
    pub(super) minor: f64,
}

impl CylinderSurface {
    /// Creates the cylinder about the z axis of `frame`.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] unless the radius is positive.
    pub fn new(frame: SurfaceFrame, radius: f64) -> Result<Self, SurfaceError> {
        Ok(Self { frame, radius: positive("radius of the cylinder", radius)? })
    }
}

impl ConeSurface {
    /// Creates the cone with `radius` at the origin of `frame`, half angle `angle` \[rad\].
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] unless the radius is 0 or more, [`SurfaceError::ConeAngle`] unless
    /// the angle is between 0 and pi/2.
    pub fn new(frame: SurfaceFrame, radius: f64, angle: f64) -> Result<Self, SurfaceError> {
        if !(radius >= 0.0 && radius.is_finite()) {
            let need = "finite and 0 or more";
            return Err(SurfaceError::Size { what: "radius of the cone", value: radius, need });
        }
        if !(angle > 0.0 && angle < FRAC_PI_2) {
            return Err(SurfaceError::ConeAngle { angle });
        }
        Ok(Self { frame, radius, slope: math::tan(angle) })
    }

    /// Returns `v` of the apex.
    pub(super) fn apex(&self) -> f64 {
        -self.radius / self.slope
    }
}

impl SphereSurface {
    /// Creates the sphere about the origin of `frame`.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] unless the radius is positive.
    pub fn new(frame: SurfaceFrame, radius: f64) -> Result<Self, SurfaceError> {
        Ok(Self { frame, radius: positive("radius of the sphere", radius)? })
    }
}

impl TorusSurface {
    /// Creates the torus about the z axis of `frame`: a circle of radius `minor` swept at the
    /// distance `major`.
    ///
    /// # Errors
    ///
    /// [`SurfaceError::Size`] unless both radii are positive.
    pub fn new(frame: SurfaceFrame, major: f64, minor: f64) -> Result<Self, SurfaceError> {
        let major = positive("major radius of the torus", major)?;
        Ok(Self { frame, major, minor: positive("minor radius of the torus", minor)? })
    }
}

fn positive(what: &'static str, value: f64) -> Result<f64, SurfaceError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(SurfaceError::Size { what, value, need: "finite and above 0" })
    }
}

/// Common interface of the elementary surfaces.
pub(crate) trait ElementarySurface {
    fn domain(&self) -> [Interval; 2];
    fn periods(&self) -> [Option<f64>; 2];
    /// Returns the parameters of a closest point of the whole surface.
    fn closest(&self, p: &Point3<f64>) -> [f64; 2];
    /// Returns bounds of the curvatures over `v` in the range: of the smaller (or 0) from below, of
    /// the larger (or 0) from above; positive towards `S_u x S_v`.
    fn curvatures(&self, v: Interval) -> Interval;
}

const ROUND: Interval = Interval::new(0.0, TAU);

impl PlaneSurface {
    /// Returns the derivatives up to an order.
    #[inline]
    pub(super) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        let (x, y) = (self.frame.x().into_inner(), self.frame.y().into_inner());
        let mut d = [[Vector3::zeros(); 4]; 4];
        d[0][0] = self.frame.origin.coords + x * u + y * v;
        d[1][0] = x;
        d[0][1] = y;
        d
    }
}

impl ElementarySurface for PlaneSurface {
    fn domain(&self) -> [Interval; 2] {
        [Interval::UNBOUNDED; 2]
    }

    fn periods(&self) -> [Option<f64>; 2] {
        [None; 2]
    }

    fn closest(&self, p: &Point3<f64>) -> [f64; 2] {
        let local = self.frame.local(p);
        [local.x, local.y]
    }

    fn curvatures(&self, _: Interval) -> Interval {
        Interval::point(0.0)
    }
}

impl CylinderSurface {
    /// Returns the derivatives up to an order.
    #[inline]
    pub(super) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        round::<ORDER>(&self.frame, u, [self.radius, 0.0, 0.0, 0.0], [v, 1.0, 0.0, 0.0])
    }
}

impl ElementarySurface for CylinderSurface {
    fn domain(&self) -> [Interval; 2] {
        [ROUND, Interval::UNBOUNDED]
    }

    fn periods(&self) -> [Option<f64>; 2] {
        [Some(TAU), None]
    }

    fn closest(&self, p: &Point3<f64>) -> [f64; 2] {
        let local = self.frame.local(p);
        [turn(&local), local.z]
    }

    fn curvatures(&self, _: Interval) -> Interval {
        Interval::new(-self.radius.recip(), 0.0)
    }
}

impl ConeSurface {
    /// Returns the derivatives up to an order.
    #[inline]
    pub(super) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        let rho = [self.radius + v * self.slope, self.slope, 0.0, 0.0];
        round::<ORDER>(&self.frame, u, rho, [v, 1.0, 0.0, 0.0])
    }
}

impl ElementarySurface for ConeSurface {
    fn domain(&self) -> [Interval; 2] {
        [ROUND, Interval::new(self.apex(), f64::INFINITY)]
    }

    fn periods(&self) -> [Option<f64>; 2] {
        [Some(TAU), None]
    }

    /// Returns the foot on the ruling through the half plane of `p`; the apex where it falls short
    /// of it.
    fn closest(&self, p: &Point3<f64>) -> [f64; 2] {
        let local = self.frame.local(p);
        let rho = math::hypot(local.x, local.y);
        // Projection of (rho - R, z) on the ruling (tan a, 1).
        let v = ((rho - self.radius) * self.slope + local.z) / (1.0 + self.slope * self.slope);
        [turn(&local), v.max(self.apex())]
    }

    fn curvatures(&self, v: Interval) -> Interval {
        let rho = self.radius + v.low.max(self.apex()) * self.slope;
        // Square to the rulings: cos a / rho, largest at the narrow end. S_u x S_v points outwards.
        Interval::new(-(rho * math::hypot(1.0, self.slope)).recip(), 0.0)
    }
}

impl SphereSurface {
    /// Returns the derivatives up to an order.
    #[inline]
    pub(super) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        let (sin, cos) = math::sin_cos(v);
        let [rho, z] = circle(self.radius, sin, cos);
        round::<ORDER>(&self.frame, u, rho, z)
    }
}

impl ElementarySurface for SphereSurface {
    fn domain(&self) -> [Interval; 2] {
        [ROUND, Interval::new(-FRAC_PI_2, FRAC_PI_2)]
    }

    fn periods(&self) -> [Option<f64>; 2] {
        [Some(TAU), None]
    }

    fn closest(&self, p: &Point3<f64>) -> [f64; 2] {
        let local = self.frame.local(p);
        [turn(&local), math::atan2(local.z, math::hypot(local.x, local.y))]
    }

    fn curvatures(&self, _: Interval) -> Interval {
        Interval::new(-self.radius.recip(), 0.0)
    }
}

impl TorusSurface {
    /// Returns the derivatives up to an order.
    #[inline]
    pub(super) fn table<const ORDER: usize>(&self, u: f64, v: f64) -> DerivativeTable {
        let (sin, cos) = math::sin_cos(v);
        let [mut rho, z] = circle(self.minor, sin, cos);
        rho[0] += self.major;
        round::<ORDER>(&self.frame, u, rho, z)
    }
}

impl ElementarySurface for TorusSurface {
    fn domain(&self) -> [Interval; 2] {
        [ROUND; 2]
    }

    fn periods(&self) -> [Option<f64>; 2] {
        [Some(TAU); 2]
    }

    /// Returns the closest point of the two circles in the half plane of `p`: the far one matters
    /// only inside a spindle torus.
    fn closest(&self, p: &Point3<f64>) -> [f64; 2] {
        let local = self.frame.local(p);
        let rho = math::hypot(local.x, local.y);
        // The half plane of p cuts the torus in a circle on its own side and one beyond the axis.
        let gap = |x: f64| (math::hypot(x, local.z) - self.minor).abs();
        let (near, far) = (rho - self.major, -rho - self.major);
        let u = turn(&local);
        if gap(far) < gap(near) {
            return [(u + 0.5 * TAU).rem_euclid(TAU), math::atan2(local.z, far).rem_euclid(TAU)];
        }
        [u, math::atan2(local.z, near).rem_euclid(TAU)]
    }

    /// Returns `-1/r` across and `-cos v / (R + r cos v)`, never below `-1/r`, round. Where the
    /// circle reaches the axis (a spindle torus) there is no bound.
    fn curvatures(&self, Interval { low, high }: Interval) -> Interval {
        // cos v is least at v = pi: at the first such turn above `low` if in the range, else at an
        // end.
        let innermost = 0.5 * TAU + ((low - 0.5 * TAU) / TAU).ceil() * TAU;
        let smallest = if innermost <= high { -1.0 } else { math::cos(low).min(math::cos(high)) };
        let rho = self.major + self.minor * smallest;
        if rho > 0.0 {
            Interval::new(-self.minor.recip(), (-smallest / rho).max(0.0))
        } else {
            Interval::UNBOUNDED
        }
    }
}

/// Returns `[rho, z]` of a circle about the origin of the half plane, with derivatives by its
/// angle.
fn circle(radius: f64, sin: f64, cos: f64) -> [[f64; 4]; 2] {
    [[cos, -sin, -cos, sin], [sin, cos, -sin, -cos]].map(|row| row.map(|x| radius * x))
}

/// Returns `origin + rho(v) (cos u x + sin u y) + z(v) z` from the derivatives of `rho` and `z`, up to an order.
#[inline]
fn round<const ORDER: usize>(
    frame: &SurfaceFrame,
    u: f64,
    rho: [f64; 4],
    z: [f64; 4],
) -> DerivativeTable {
    let (sin, cos) = math::sin_cos(u);
    let [x, y, axis] = frame.axes.map(UnitVector3::into_inner);
    // Differentiation by u takes e to f, f to -e and -e to -f.
    let (e, f) = (x * cos + y * sin, y * cos - x * sin);
    let rings = [e, f, -e, -f];
    let mut d = [[Vector3::zeros(); 4]; 4];
    for by_u in 0..=ORDER.min(3) {
        for by_v in 0..=ORDER.min(3) - by_u {
            d[by_u][by_v] = rings[by_u] * rho[by_v];
        }
    }
    for by_v in 0..=ORDER.min(3) {
        d[0][by_v] += axis * z[by_v];
    }
    d[0][0] += frame.origin.coords;
    d
}

/// Returns the angle about z in [0, 2 pi); 0 on the axis.
pub(super) fn turn(local: &Vector3<f64>) -> f64 {
    math::atan2(local.y, local.x).rem_euclid(TAU)
}
