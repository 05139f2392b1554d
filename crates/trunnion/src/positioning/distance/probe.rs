//! Signed distance of points of the cutter from the surface, with its derivatives.

use crate::positioning::error::PositioningError;
use crate::surface::{ClosestError, FaceIndex, FootPoint, SurfaceJet2};
use crate::types::Uv;
use nalgebra::{Point3, UnitVector3, Vector3};

/// From a point this near to the foot \[mm\], second-order Taylor terms lead to it: a distance is
/// then off by `k' FOOT^3 / 6`, `k'` the rate of the curvature, 1e-9 mm for 1 / mm^2.
const FOOT: f64 = 2e-3;

/// The same as turn of the normal \[rad\], where the surface bends sharply.
const TURN: f64 = 1e-3;

/// Closest-point queries on one face, counted.
#[derive(Debug)]
pub(crate) struct FaceProbe<'a> {
    face: &'a FaceIndex,
    pub(crate) queries: u32,
    /// `true` if no parameter is an angle and no rim is a point.
    ///
    /// At a pole the normal turns round: there Newton's steps need the distance itself as their guide,
    /// and guesses must not lead over the pole.
    poleless: bool,
}

/// Distance of a point from the surface and the foot it belongs to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DistanceReading {
    pub(crate) foot: FootPoint,
    /// Signed distance \[mm\], positive on the cutter's side.
    pub(crate) distance: f64,
    forms: FundamentalForms,
    /// See [`FaceProbe`].
    poleless: bool,
    /// Distance of the foot from the point where the surface was evaluated \[mm\].
    strayed: f64,
}

/// First and second fundamental form; the second is positive where the surface is concave seen
/// from the cutter.
#[derive(Debug, Clone, Copy)]
struct FundamentalForms {
    first: [f64; 3],
    second: [f64; 3],
}

/// Derivatives of the surface at one point, from which Taylor's formula reaches points nearby.
struct ExpansionPoint<'a> {
    uv: [f64; 2],
    jet: &'a SurfaceJet2,
    /// Unit normal on the cutter's side.
    normal: &'a UnitVector3<f64>,
    forms: &'a FundamentalForms,
}

impl<'a> FaceProbe<'a> {
    pub(crate) fn new(face: &'a FaceIndex) -> Self {
        let poleless = face.face().surface.is_regular();
        Self { face, queries: 0, poleless }
    }

    pub(crate) fn face(&self) -> &'a FaceIndex {
        self.face
    }

    /// Reads the distance of `p`, whose foot is expected near `guess`: as a rule one evaluation of
    /// the surface.
    pub(crate) fn read(
        &mut self,
        p: &Point3<f64>,
        guess: [f64; 2],
    ) -> Result<DistanceReading, PositioningError> {
        match self.newton_to_foot(p, guess) {
            Some(reading) => {
                self.queries += 1;
                Ok(reading)
            }
            None => self.foot(p, guess),
        }
    }

    /// Reads the distance of a point a `step` from one that was read. Right next to it the surface
    /// need not be evaluated again.
    pub(crate) fn read_from(
        &mut self,
        p: &Point3<f64>,
        from: &DistanceReading,
        step: &Vector3<f64>,
    ) -> Result<DistanceReading, PositioningError> {
        let near = step.norm_squared() <= FOOT;
        match if near { from.beside(p) } else { None } {
            Some(reading) => {
                self.queries += 1;
                Ok(reading)
            }
            None => self.read(p, from.ahead(step)),
        }
    }

    /// Takes Newton's steps to the foot, the last of them by Taylor's formula alone; `None` where they
    /// do not lead straight to a minimum of the distance.
    fn newton_to_foot(&self, p: &Point3<f64>, guess: [f64; 2]) -> Option<DistanceReading> {
        /// Each at least halves what is left: from 1 mm nine do, from usual guesses one or two.
        const STEPS: u32 = 9;
        let face = self.face.face();
        if !self.poleless {
            return None;
        }
        let mut uv = guess;
        let mut before = f64::INFINITY;
        for _ in 0..STEPS {
            let jet = face.surface.jet2(uv[0], uv[1]);
            let normal = jet.normal()?;
            let normal = if face.flip { -normal } else { normal };
            let offset = p - jet.s;
            let distance = normal.dot(&offset);
            let forms = FundamentalForms::new(&jet, &normal);
            // Newton's step for the foot: (I - d II) duv = [S_u, S_v] . (p - S), the Hessian of |p
            // - S|^2 / 2. A matrix that is not positive leads to no minimum.
            let way = solve(&forms.offset(distance), [jet.su.dot(&offset), jet.sv.dot(&offset)])?;
            let left = (jet.su * way[0] + jet.sv * way[1]).norm();
            // Near enough, Taylor's formula gives the foot without another evaluation.
            let here = ExpansionPoint { uv, jet: &jet, normal: &normal, forms: &forms };
            if left <= FOOT
                && let Some(reading) = here.reading(p, way, left)
            {
                return Some(reading);
            }
            // Steps that do not halve show that the guess was not near: the global search takes
            // over.
            if left > 0.5 * before {
                return None;
            }
            before = left;
            uv = [uv[0] + way[0], uv[1] + way[1]];
        }
        None
    }

    /// Reads the distance of `p`, the foot itself as exact as rounding allows.
    pub(crate) fn foot(
        &mut self,
        p: &Point3<f64>,
        guess: [f64; 2],
    ) -> Result<DistanceReading, PositioningError> {
        self.queries += 1;
        let foot = self
            .face
            .closest_near(p, guess.into())
            .map_err(|error| PositioningError::Closest { uv: guess.into(), error })?;
        Ok(DistanceReading { poleless: self.poleless, ..DistanceReading::new(p, foot) })
    }

    /// Returns the unsigned distance of `p` from a point of the face nearer than `enough`, mostly the
    /// nearest one; at least `enough` where there is none. What counts is the surface over the box of the trims.
    pub(crate) fn nearest(
        &mut self,
        p: &Point3<f64>,
        enough: f64,
        uv: Uv,
    ) -> Result<f64, PositioningError> {
        self.queries += 1;
        match self.face.nearer(p, enough) {
            Ok(nearer) => Ok(nearer.unwrap_or(enough)),
            Err(ClosestError::Undecided { bound, .. }) => Ok(bound),
            Err(error) => Err(PositioningError::Closest { uv, error }),
        }
    }
}

impl DistanceReading {
    #[inline]
    fn new(p: &Point3<f64>, foot: FootPoint) -> Self {
        let forms = FundamentalForms::new(&foot.jet, &foot.normal);
        // Along the normal: an error of the foot's place enters only squared.
        let distance = foot.normal.dot(&(p - foot.point));
        Self { foot, distance, forms, poleless: true, strayed: 0.0 }
    }

    /// Returns the reading of the point at `distance` over the same foot.
    pub(crate) fn lifted(&self, distance: f64) -> Self {
        Self { distance, foot: FootPoint { distance, ..self.foot }, ..*self }
    }

    /// Returns the outward unit normal, the gradient of the distance.
    pub(crate) fn normal(&self) -> UnitVector3<f64> {
        self.foot.normal
    }

    /// Returns the first-order change of the foot's parameters when the point moves by `step`:
    /// `(I - d II) duv = [S_u, S_v] . step`.
    pub(crate) fn follow(&self, step: &Vector3<f64>) -> [f64; 2] {
        self.try_follow(step).unwrap_or([0.0, 0.0])
    }

    fn try_follow(&self, step: &Vector3<f64>) -> Option<[f64; 2]> {
        solve(&self.matrix(), self.covector(step))
    }

    /// `I - d II`.
    fn matrix(&self) -> [f64; 3] {
        self.forms.offset(self.distance)
    }

    /// Returns a guess for the foot of `p + step`, right to second order where there are no poles.
    pub(crate) fn ahead(&self, step: &Vector3<f64>) -> [f64; 2] {
        let Uv { u, v } = self.foot.uv;
        let first = self.follow(step);
        if !self.poleless {
            return [u + first[0], v + first[1]];
        }
        // Second order: a Newton step at the place to which the first order leads, with derivatives
        // by Taylor's formula.
        let (out, [su, sv]) = taylor(&self.foot.jet, first);
        // What a step of Newton leaves to be gone from there; the foot lies along the normal.
        let left = self.normal().scale(self.distance) + step - out;
        let matrix = self.matrix();
        let second = solve(&matrix, [su.dot(&left), sv.dot(&left)]).unwrap_or([0.0, 0.0]);
        let jet = &self.foot.jet;
        let size = |[du, dv]: [f64; 2]| (jet.su * du + jet.sv * dv).norm_squared();
        // Where the correction is no small one, Taylor's formula does not reach so far.
        let near = size(second) <= 0.25 * size(first);
        let [du, dv] = if near { [0, 1].map(|k| first[k] + second[k]) } else { first };
        [u + du, v + dv]
    }

    /// Returns the same guess for the foot of the point `p`.
    pub(crate) fn ahead_to(&self, p: &Point3<f64>) -> [f64; 2] {
        let from = self.foot.point + self.normal().scale(self.distance);
        self.ahead(&(p - from))
    }

    /// Returns the reading of a point whose foot is right next to this one.
    fn beside(&self, p: &Point3<f64>) -> Option<Self> {
        if !self.poleless {
            return None;
        }
        let way = self.try_follow(&(p - self.foot.point))?;
        let left = (self.foot.jet.su * way[0] + self.foot.jet.sv * way[1]).norm();
        let strayed = self.strayed + left;
        let FootPoint { uv, normal, jet, .. } = &self.foot;
        if strayed > FOOT {
            return None;
        }
        ExpansionPoint { uv: (*uv).into(), jet, normal, forms: &self.forms }
            .reading(p, way, strayed)
    }

    fn covector(&self, step: &Vector3<f64>) -> [f64; 2] {
        [self.foot.jet.su.dot(step), self.foot.jet.sv.dot(step)]
    }

    /// Returns the change of foot point and normal when the point moves by `step` (Weingarten).
    pub(crate) fn foot_rate(&self, step: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        self.turned(self.follow(step))
    }

    /// Returns the change of foot point and normal for a change of the foot's parameters.
    fn turned(&self, [du, dv]: [f64; 2]) -> (Vector3<f64>, Vector3<f64>) {
        let jet = &self.foot.jet;
        (jet.su * du + jet.sv * dv, self.forms.turned(jet, [du, dv]))
    }

    /// Returns the second derivative of the distance along `step`: `-k/(1 - k d)` per principal direction.
    pub(crate) fn hessian(&self, step: &Vector3<f64>) -> f64 {
        self.hessians(step, step)[0]
    }

    /// Returns the second derivatives of the distance along `step`, and along it and `other`: as
    /// [`DistanceReading::hessian_between`], by the components along `S_u` and `S_v` alone.
    pub(crate) fn hessians(&self, step: &Vector3<f64>, other: &Vector3<f64>) -> [f64; 2] {
        let along = self.covector(step);
        // H(t, .) = dn(t): the foot moves by (du, dv) = (I - d II)^-1 [S_u, S_v] . t, and the
        // normal turns by Weingarten's equations, dn = -I^-1 II (du, dv).
        let Some([du, dv]) = solve(&self.matrix(), along) else { return [0.0; 2] };
        let [l, m, n] = self.forms.second;
        let turned = solve(&self.forms.first, [l * du + m * dv, m * du + n * dv]);
        let [a, b] = turned.unwrap_or([0.0; 2]);
        [along, self.covector(other)].map(|[p, q]| -(p * a + q * b))
    }

    /// Returns the second derivative of the distance along two directions.
    pub(crate) fn hessian_between(&self, one: &Vector3<f64>, two: &Vector3<f64>) -> f64 {
        let (_, turned) = self.foot_rate(one);
        turned.dot(two)
    }

    /// Returns the normal curvature of the surface in the tangent direction nearest to `direction`, positive
    /// where concave; 0 for a normal direction.
    pub(crate) fn normal_curvature(&self, direction: &Vector3<f64>) -> f64 {
        // Components in the tangent plane of the orthogonal projection of the direction.
        let Some([a, b]) = solve(&self.forms.first, self.covector(direction)) else { return 0.0 };
        // Euler's quotient II(a, b) / I(a, b).
        let form = |[p, q, r]: [f64; 3]| p * a * a + 2.0 * q * a * b + r * b * b;
        let length = form(self.forms.first);
        if length > 0.0 { form(self.forms.second) / length } else { 0.0 }
    }

    /// Returns the principal curvatures `[smaller, larger]`, positive where concave seen from the cutter.
    pub(crate) fn curvatures(&self) -> [f64; 2] {
        let FundamentalForms { first: [e, f, g], second: [l, m, n] } = self.forms;
        // Roots of det(II - k I) = 0 by mean and Gaussian curvature.
        let area = e * g - f * f;
        if area <= 0.0 {
            return [0.0, 0.0];
        }
        let mean = 0.5 * (e * n - 2.0 * f * m + g * l) / area;
        let gauss = (l * n - m * m) / area;
        // At an umbilic the difference is 0 but for rounding, which may be negative.
        let spread = (mean * mean - gauss).max(0.0).sqrt();
        [mean - spread, mean + spread]
    }
}

impl FundamentalForms {
    #[inline]
    fn new(jet: &SurfaceJet2, n: &UnitVector3<f64>) -> Self {
        Self {
            first: [jet.su.norm_squared(), jet.su.dot(&jet.sv), jet.sv.norm_squared()],
            second: [n.dot(&jet.suu), n.dot(&jet.suv), n.dot(&jet.svv)],
        }
    }

    /// `I - d II`.
    #[inline]
    fn offset(&self, d: f64) -> [f64; 3] {
        [0, 1, 2].map(|k| self.first[k] - d * self.second[k])
    }

    /// Returns the change of the normal for a change of the foot's parameters.
    #[inline]
    fn turned(&self, jet: &SurfaceJet2, [du, dv]: [f64; 2]) -> Vector3<f64> {
        let [l, m, n] = self.second;
        solve(&self.first, [l * du + m * dv, m * du + n * dv])
            .map_or_else(Vector3::zeros, |[a, b]| -(jet.su * a + jet.sv * b))
    }
}

/// Returns the vector from a surface point to that `[du, dv]` further, and the first derivatives
/// there, from the derivatives here.
#[inline]
fn taylor(jet: &SurfaceJet2, [du, dv]: [f64; 2]) -> (Vector3<f64>, [Vector3<f64>; 2]) {
    // S(u + du, v + dv) - S = (S_u + S_uu du / 2 + ..) du + ..; the first derivatives change by the
    // second ones.
    let (bent_u, bent_v) = (jet.suu * du + jet.suv * dv, jet.suv * du + jet.svv * dv);
    let out = (jet.su + bent_u * 0.5) * du + (jet.sv + bent_v * 0.5) * dv;
    (out, [jet.su + bent_u, jet.sv + bent_v])
}

impl ExpansionPoint<'_> {
    /// Returns the reading at the parameters `uv + step`, next to the foot of `p` and `strayed`
    /// \[mm\] from the point of evaluation; `None` where the normal turns too far on the way.
    #[inline]
    fn reading(&self, p: &Point3<f64>, step: [f64; 2], strayed: f64) -> Option<DistanceReading> {
        let Self { uv, jet, normal, forms } = *self;
        let turned = forms.turned(jet, step);
        // Where the normal turns so far, Taylor's formula of second order does not hold any more.
        if turned.norm_squared() > TURN * TURN {
            return None;
        }
        let (out, [su, sv]) = taylor(jet, step);
        let point = jet.s + out;
        let normal = UnitVector3::new_normalize(normal.into_inner() + turned);
        let jet = SurfaceJet2 { s: point, su, sv, ..*jet };
        let distance = normal.dot(&(p - point));
        let foot = FootPoint {
            uv: [uv[0] + step[0], uv[1] + step[1]].into(),
            point,
            normal,
            distance,
            jet,
        };
        Some(DistanceReading { strayed, ..DistanceReading::new(p, foot) })
    }
}

/// Solves `[[a, b], [b, c]] x = y`; `None` where the matrix is not positive.
#[inline]
fn solve(&[a, b, c]: &[f64; 3], [p, q]: [f64; 2]) -> Option<[f64; 2]> {
    // Cramer's rule; both leading minors positive means a positive matrix.
    let determinant = a * c - b * b;
    (a > 0.0 && determinant > 0.0)
        .then(|| [(c * p - b * q) / determinant, (a * q - b * p) / determinant])
}
