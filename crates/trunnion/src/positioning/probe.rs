//! Signed distance of points of the cutter from the surface, with its derivatives.

use super::PositioningError;
use crate::surface::ClosestError;
use crate::surface::FaceIndex;
use crate::surface::Foot;
use nalgebra::Point3;
use nalgebra::UnitVector3;
use nalgebra::Vector3;

/// Closest-point queries on one face, counted.
#[derive(Debug)]
pub(super) struct Probe<'a> {
    face: &'a FaceIndex,
    pub(super) queries: u32,
}

/// Distance of a point from the surface and the foot it belongs to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    pub(super) foot: Foot,
    /// Signed distance \[mm\], positive on the cutter's side.
    pub(super) distance: f64,
    forms: Forms,
}

/// First and second fundamental form; the second is positive where the surface is concave seen
/// from the cutter.
#[derive(Debug, Clone, Copy)]
struct Forms {
    first: [f64; 3],
    second: [f64; 3],
}

impl<'a> Probe<'a> {
    pub(super) fn new(face: &'a FaceIndex) -> Self {
        Self { face, queries: 0 }
    }

    /// Another one that goes on counting.
    pub(super) fn again(&self) -> Self {
        Self { face: self.face, queries: self.queries }
    }

    /// Reads the distance of `p`, whose foot is expected near `guess`.
    pub(super) fn read(
        &mut self,
        p: &Point3<f64>,
        guess: [f64; 2],
    ) -> Result<Reading, PositioningError> {
        self.queries += 1;
        let foot = self
            .face
            .closest_near(p, guess)
            .map_err(|error| PositioningError::Closest { uv: guess, error })?;
        Ok(Reading::new(p, foot))
    }

    /// Distance of `p` from the whole face, unsigned; never too large, and where it is `enough`
    /// not more than that.
    pub(super) fn nearest(
        &mut self,
        p: &Point3<f64>,
        enough: f64,
        uv: [f64; 2],
    ) -> Result<f64, PositioningError> {
        self.queries += 1;
        if self.face.clear_of(p, enough) {
            return Ok(enough);
        }
        match self.face.closest(p) {
            Ok(foot) => Ok((p - foot.point).norm()),
            // Where the surface is equally far in many places, its distance is known all the same.
            Err(ClosestError::NoNormal { distance, .. }) => Ok(distance),
            Err(ClosestError::Undecided { bound, .. }) => Ok(bound),
            Err(error) => Err(PositioningError::Closest { uv, error }),
        }
    }
}

impl Reading {
    fn new(p: &Point3<f64>, foot: Foot) -> Self {
        let (n, jet) = (foot.normal, &foot.jet);
        let first = [jet.su.norm_squared(), jet.su.dot(&jet.sv), jet.sv.norm_squared()];
        let second = [n.dot(&jet.suu), n.dot(&jet.suv), n.dot(&jet.svv)];
        // Along the normal: an error of the foot's place enters only squared.
        let distance = n.dot(&(p - foot.point));
        Self { foot, distance, forms: Forms { first, second } }
    }

    /// Outward unit normal, the gradient of the distance.
    pub(super) fn normal(&self) -> UnitVector3<f64> {
        self.foot.normal
    }

    /// First-order change of the foot's parameters when the point moves by `step`:
    /// `(I - d II) duv = [S_u, S_v] . step`.
    pub(super) fn follow(&self, step: &Vector3<f64>) -> [f64; 2] {
        self.try_follow(step).unwrap_or([0.0, 0.0])
    }

    fn try_follow(&self, step: &Vector3<f64>) -> Option<[f64; 2]> {
        let Forms { first, second } = &self.forms;
        let d = self.distance;
        let matrix = [0, 1, 2].map(|k| first[k] - d * second[k]);
        solve(&matrix, self.covector(step))
    }

    /// Guess for the foot of `p + step`.
    pub(super) fn ahead(&self, step: &Vector3<f64>) -> [f64; 2] {
        let [du, dv] = self.follow(step);
        let [u, v] = self.foot.uv;
        [u + du, v + dv]
    }

    fn covector(&self, step: &Vector3<f64>) -> [f64; 2] {
        [self.foot.jet.su.dot(step), self.foot.jet.sv.dot(step)]
    }

    /// Change of foot point and normal when the point moves by `step` (Weingarten).
    pub(super) fn foot_rate(&self, step: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let [du, dv] = self.follow(step);
        let jet = &self.foot.jet;
        let moved = jet.su * du + jet.sv * dv;
        let [l, m, n] = self.forms.second;
        let turned = solve(&self.forms.first, [l * du + m * dv, m * du + n * dv])
            .map_or_else(Vector3::zeros, |[a, b]| -(jet.su * a + jet.sv * b));
        (moved, turned)
    }

    /// Second derivative of the distance along `step`: `-k/(1 - k d)` per principal direction.
    pub(super) fn hessian(&self, step: &Vector3<f64>) -> f64 {
        self.hessian_between(step, step)
    }

    /// Second derivative of the distance along two directions.
    pub(super) fn hessian_between(&self, one: &Vector3<f64>, two: &Vector3<f64>) -> f64 {
        let (_, turned) = self.foot_rate(one);
        turned.dot(two)
    }

    /// Normal curvature of the surface in the tangent direction nearest to `direction`, positive
    /// where concave; 0 for a normal direction.
    pub(super) fn normal_curvature(&self, direction: &Vector3<f64>) -> f64 {
        let Some([a, b]) = solve(&self.forms.first, self.covector(direction)) else { return 0.0 };
        let form = |[p, q, r]: [f64; 3]| p * a * a + 2.0 * q * a * b + r * b * b;
        let length = form(self.forms.first);
        if length > 0.0 { form(self.forms.second) / length } else { 0.0 }
    }

    /// Principal curvatures `[smaller, larger]`, positive where concave seen from the cutter.
    pub(super) fn curvatures(&self) -> [f64; 2] {
        let Forms { first: [e, f, g], second: [l, m, n] } = self.forms;
        let area = e * g - f * f;
        if area <= 0.0 {
            return [0.0, 0.0];
        }
        let mean = 0.5 * (e * n - 2.0 * f * m + g * l) / area;
        let gauss = (l * n - m * m) / area;
        let spread = (mean * mean - gauss).max(0.0).sqrt();
        [mean - spread, mean + spread]
    }
}

/// Solves `[[a, b], [b, c]] x = y`; `None` where the matrix is singular or indefinite.
fn solve(&[a, b, c]: &[f64; 3], [p, q]: [f64; 2]) -> Option<[f64; 2]> {
    let determinant = a * c - b * b;
    (determinant > 0.0).then(|| [(c * p - b * q) / determinant, (a * q - b * p) / determinant])
}
