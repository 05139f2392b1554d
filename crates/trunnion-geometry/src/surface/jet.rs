//! Point and partial derivatives of a surface, and the curvature they give.

use crate::math;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// Derivatives by `u` (first index) and `v` (second index), as far as they were computed.
pub(crate) type DerivativeTable = [[Vector3<f64>; 4]; 4];

/// Point and first derivatives \[mm, mm per parameter\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceJet1 {
    /// Point.
    pub s: Point3<f64>,
    /// By u.
    pub su: Vector3<f64>,
    /// By v.
    pub sv: Vector3<f64>,
}

/// Point, first and second derivatives \[mm per parameter^k\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceJet2 {
    /// Point.
    pub s: Point3<f64>,
    /// By u.
    pub su: Vector3<f64>,
    /// By v.
    pub sv: Vector3<f64>,
    /// Twice by u.
    pub suu: Vector3<f64>,
    /// By u and v.
    pub suv: Vector3<f64>,
    /// Twice by v.
    pub svv: Vector3<f64>,
}

/// Point and derivatives to order 3 \[mm per parameter^k\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceJet {
    /// Point.
    pub s: Point3<f64>,
    /// By u.
    pub su: Vector3<f64>,
    /// By v.
    pub sv: Vector3<f64>,
    /// Twice by u.
    pub suu: Vector3<f64>,
    /// By u and v.
    pub suv: Vector3<f64>,
    /// Twice by v.
    pub svv: Vector3<f64>,
    /// Three times by u.
    pub suuu: Vector3<f64>,
    /// Twice by u, once by v.
    pub suuv: Vector3<f64>,
    /// Once by u, twice by v.
    pub suvv: Vector3<f64>,
    /// Three times by v.
    pub svvv: Vector3<f64>,
}

/// Principal curvatures, positive where the surface bends towards its normal (concave seen from
/// the side the normal points to), and unit tangent directions, orthogonal to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrincipalCurvatures {
    /// Smaller principal curvature \[1/mm\].
    pub min: f64,
    /// Larger principal curvature \[1/mm\].
    pub max: f64,
    /// Direction of `min`.
    pub min_direction: UnitVector3<f64>,
    /// Direction of `max`: normal x `min_direction`.
    pub max_direction: UnitVector3<f64>,
}

impl SurfaceJet1 {
    pub(crate) fn from_table(d: &DerivativeTable) -> Self {
        Self { s: Point3::from(d[0][0]), su: d[1][0], sv: d[0][1] }
    }

    /// Returns the unit normal along `S_u x S_v`; `None` where the two are parallel or vanish.
    pub fn normal(&self) -> Option<UnitVector3<f64>> {
        unit_normal(&self.su, &self.sv)
    }
}

impl SurfaceJet2 {
    pub(crate) fn from_table(d: &DerivativeTable) -> Self {
        Self {
            s: Point3::from(d[0][0]),
            su: d[1][0],
            sv: d[0][1],
            suu: d[2][0],
            suv: d[1][1],
            svv: d[0][2],
        }
    }

    /// Returns the unit normal along `S_u x S_v`; `None` where the two are parallel or vanish.
    pub fn normal(&self) -> Option<UnitVector3<f64>> {
        unit_normal(&self.su, &self.sv)
    }

    /// Returns the normal as [`SurfaceJet2::normal`] does, and where `S_u x S_v` vanishes (a pole,
    /// a collapsed edge) its limit along the step `[du, dv]` in parameters, from the first
    /// derivatives of `S_u x S_v`.
    pub fn normal_towards(&self, [du, dv]: [f64; 2]) -> Option<UnitVector3<f64>> {
        self.normal().or_else(|| {
            // d(S_u x S_v), by the product rule.
            let by_u = self.suu.cross(&self.sv) + self.su.cross(&self.suv);
            let by_v = self.suv.cross(&self.sv) + self.su.cross(&self.svv);
            UnitVector3::try_new(by_u * du + by_v * dv, f64::MIN_POSITIVE)
        })
    }

    /// Returns the normal curvature in the tangent direction `du S_u + dv S_v` \[1/mm\]: second
    /// over first fundamental form. Positive where the surface bends towards `S_u x S_v`.
    pub fn normal_curvature(&self, [du, dv]: [f64; 2]) -> Option<f64> {
        let n = self.normal()?;
        // II(t, t) / I(t, t) for the tangent t = du S_u + dv S_v.
        let first = (self.su * du + self.sv * dv).norm_squared();
        let second =
            n.dot(&(self.suu * (du * du) + self.suv * (2.0 * du * dv) + self.svv * (dv * dv)));
        (first > 0.0).then(|| second / first)
    }

    /// Returns the principal curvatures and directions; `None` where there is no normal.
    ///
    /// The second fundamental form is written in an orthonormal tangent frame, where it is a
    /// symmetric 2 x 2 matrix; no difference of nearly equal numbers as in `H^2 - K`.
    pub fn curvature(&self) -> Option<PrincipalCurvatures> {
        let n = self.normal()?;
        let e1 = UnitVector3::try_new(self.su, f64::MIN_POSITIVE)?;
        let e2 = UnitVector3::new_normalize(n.cross(&e1));
        // S_u = a e1, S_v = b e1 + c e2, hence e1 = S_u / a and e2 = (S_v - b/a S_u) / c.
        let (a, b, c) = (self.su.norm(), self.sv.dot(&e1), self.sv.dot(&e2));
        let (l, m, k) = (n.dot(&self.suu), n.dot(&self.suv), n.dot(&self.svv));
        let ratio = b / a;
        // Second fundamental form in the orthonormal frame: h_ij = II(e_i, e_j).
        let h11 = l / (a * a);
        let h12 = (m - ratio * l) / (a * c);
        let h22 = (k - 2.0 * ratio * m + ratio * ratio * l) / (c * c);
        let (half_sum, half_difference) = (0.5 * (h11 + h22), 0.5 * (h11 - h22));
        // Eigenvalues: half the trace, plus and minus the radius of Mohr's circle.
        let radius = math::hypot(half_difference, h12);
        // max lies at `angle` from e1, min a quarter turn before it.
        let angle = 0.5 * math::atan2(h12, half_difference);
        let (sin, cos) = math::sin_cos(angle);
        let max_direction = UnitVector3::new_normalize(e1.scale(cos) + e2.scale(sin));
        let min_direction = UnitVector3::new_normalize(e1.scale(sin) - e2.scale(cos));
        let (min, max) = (half_sum - radius, half_sum + radius);
        Some(PrincipalCurvatures { min, max, min_direction, max_direction })
    }
}

impl SurfaceJet {
    pub(crate) fn from_table(d: &DerivativeTable) -> Self {
        Self {
            s: Point3::from(d[0][0]),
            su: d[1][0],
            sv: d[0][1],
            suu: d[2][0],
            suv: d[1][1],
            svv: d[0][2],
            suuu: d[3][0],
            suuv: d[2][1],
            suvv: d[1][2],
            svvv: d[0][3],
        }
    }

    /// Returns the part up to order 2.
    pub fn second(&self) -> SurfaceJet2 {
        let Self { s, su, sv, suu, suv, svv, .. } = *self;
        SurfaceJet2 { s, su, sv, suu, suv, svv }
    }

    /// Returns the unit normal along `S_u x S_v`; `None` where the two are parallel or vanish.
    pub fn normal(&self) -> Option<UnitVector3<f64>> {
        unit_normal(&self.su, &self.sv)
    }

    /// Returns the normal curvature; see [`SurfaceJet2::normal_curvature`].
    pub fn normal_curvature(&self, direction: [f64; 2]) -> Option<f64> {
        self.second().normal_curvature(direction)
    }

    /// Returns the principal curvatures; see [`SurfaceJet2::curvature`].
    pub fn curvature(&self) -> Option<PrincipalCurvatures> {
        self.second().curvature()
    }
}

/// The cross product of two vectors carries an absolute error of about `2 eps |a| |b|` (each
/// component is a difference of two rounded products): below this sine it is mere rounding.
const PARALLEL: f64 = 4.0 * f64::EPSILON;

fn unit_normal(su: &Vector3<f64>, sv: &Vector3<f64>) -> Option<UnitVector3<f64>> {
    let cross = su.cross(sv);
    let product = su.norm_squared() * sv.norm_squared();
    // A derivative that is mere rounding noise beside the other is caught by neither test; such
    // surfaces are refused when they are built (see `SurfaceError::DegeneratePatch`).
    if cross.norm_squared() > PARALLEL * PARALLEL * product {
        UnitVector3::try_new(cross, f64::MIN_POSITIVE)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// z = x^2 / 2 - 2 y^2, sheared parameters: u, v with x = u + v, y = v.
    fn saddle() -> SurfaceJet2 {
        SurfaceJet2 {
            s: Point3::origin(),
            su: Vector3::x(),
            sv: Vector3::x() + Vector3::y(),
            suu: Vector3::z(),
            suv: Vector3::z(),
            svv: Vector3::z() * (1.0 - 4.0),
        }
    }

    #[test]
    fn curvature_of_a_saddle_by_pencil() {
        let curvature = saddle().curvature().unwrap();
        assert!((curvature.max - 1.0).abs() < 1e-14);
        assert!((curvature.min + 4.0).abs() < 1e-14);
        assert!(curvature.max_direction.x.abs() > 1.0 - 1e-14);
        assert!(curvature.min_direction.y.abs() > 1.0 - 1e-14);
        let turned = Vector3::z().cross(&curvature.min_direction);
        assert!((turned - curvature.max_direction.into_inner()).norm() < 1e-14);
        // Along y: du = -1, dv = 1.
        assert!((saddle().normal_curvature([-1.0, 1.0]).unwrap() + 4.0).abs() < 1e-14);
    }

    #[test]
    fn parallel_tangents_have_no_normal() {
        let mut jet = saddle();
        jet.sv = jet.su * 3.0;
        assert_eq!(jet.normal(), None);
        // ... but a collapsed edge has a limit: S_u = v e_x near v = 0.
        let mut edge = saddle();
        (edge.su, edge.sv) = (Vector3::zeros(), Vector3::y());
        edge.suv = Vector3::x();
        assert_eq!(edge.normal(), None);
        assert_eq!(edge.normal_towards([0.0, 1.0]), Some(Vector3::z_axis()));
        assert_eq!(edge.normal_towards([0.0, -1.0]), Some(-Vector3::z_axis()));
    }
}
