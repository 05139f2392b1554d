//! Newton's method for the closest point, free and confined to a rectangle.

use super::geometry::Surface;
use super::jet::SurfaceJet2;
use super::parameter_box::ParameterBox;
use nalgebra::Point3;

/// Steps of one run: quadratic convergence needs 3 to 6; the rest is damping far away.
const STEPS: u32 = 40;

/// A step this small (share of the size of the numbers involved) is applied and is the last: the
/// next one, of the order of its square times curvature, would be below rounding.
const LAST: f64 = 1e-9;

/// A distance is known to this share of the coordinates' size: control points are summed with
/// weights that add up to 1 over at most 100 terms, whose errors add up like a random walk.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Evaluations of one run: where as many do not lead to a minimum, near a centre of curvature or a
/// fold of the continuation, a search over the surface takes less than going on.
const EVALUATIONS: u32 = 64;

/// Parameters with the point and the derivatives there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FacePoint {
    pub(crate) uv: [f64; 2],
    pub(crate) jet: SurfaceJet2,
}

/// Finds parameters and derivatives of a local minimum of the distance from `p` on the continued
/// surface; `None` where the method does not settle at one, or ends at a rim that is a point:
/// another way down from there may lead on.
pub(crate) fn free(surface: &Surface, p: &Point3<f64>, guess: [f64; 2]) -> Option<FacePoint> {
    let at = |uv: [f64; 2]| surface.jet2(uv[0], uv[1]);
    let ends = surface.ends();
    let found = minimise(at, p, guess, ends)?;
    // At a rim that is a point the continuation turns over: a minimum there is not one of the face.
    let inside = |k: usize| ends[k].low < found.uv[k] && found.uv[k] < ends[k].high;
    (inside(0) && inside(1)).then_some(found)
}

/// Finds a minimum as [`free`] does over a rectangle of parameters; minima at its border count.
pub(crate) fn minimise(
    at: impl Fn([f64; 2]) -> SurfaceJet2,
    p: &Point3<f64>,
    guess: [f64; 2],
    bounds: ParameterBox,
) -> Option<FacePoint> {
    let mut descent = DampedDescent { at, p, bounds, left: EVALUATIONS };
    let uv = descent.clamp(guess);
    let mut current = FacePoint { uv, jet: (descent.at)(uv) };
    for _ in 0..STEPS {
        let step = descent.step(&current)?;
        current = descent.advance(&current, &step)?;
        if step.is_last {
            return Some(current);
        }
    }
    None
}

/// A step in parameters.
struct NewtonStep {
    by: [f64; 2],
    /// `true` for a step so small that the next one would be below rounding.
    is_last: bool,
}

/// Damped Newton steps towards `p`, confined to a rectangle of parameters.
struct DampedDescent<'a, F> {
    at: F,
    p: &'a Point3<f64>,
    bounds: ParameterBox,
    /// Evaluations left.
    left: u32,
}

impl<F: Fn([f64; 2]) -> SurfaceJet2> DampedDescent<'_, F> {
    /// Moves parameters to the nearest ones of the rectangle.
    fn clamp(&self, uv: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| uv[k].clamp(self.bounds[k].low, self.bounds[k].high))
    }

    /// Returns the size of the coordinates, of which distances are known to a share.
    fn scale(&self, jet: &SurfaceJet2) -> f64 {
        jet.s.coords.norm() + self.p.coords.norm()
    }

    fn step(&self, from: &FacePoint) -> Option<NewtonStep> {
        let jet = &from.jet;
        let by = descent(jet, self.p, from.uv, self.bounds)?;
        // Length of the step in the tangent plane, to be compared with the rounding of coordinates.
        let length = (jet.su * by[0] + jet.sv * by[1]).norm();
        Some(NewtonStep { by, is_last: length <= LAST * self.scale(jet) })
    }

    /// Takes `step`, halved until the distance does not grow beyond its rounding (a last, small
    /// step is not questioned: rounding decides there).
    fn advance(&mut self, from: &FacePoint, step: &NewtonStep) -> Option<FacePoint> {
        // 2^-30 of a step above LAST is below rounding: no descent exists.
        const HALVINGS: u32 = 30;
        let allowed = (from.jet.s - self.p).norm() + ROUNDING * self.scale(&from.jet);
        let mut share = 1.0;
        for _ in 0..HALVINGS.min(self.left) {
            self.left -= 1;
            let uv = self.clamp([from.uv[0] + share * step.by[0], from.uv[1] + share * step.by[1]]);
            let jet = (self.at)(uv);
            let after = (jet.s - self.p).norm();
            if step.is_last || after <= allowed {
                return after.is_finite().then_some(FacePoint { uv, jet });
            }
            share *= 0.5;
        }
        None
    }
}

/// Returns the Newton step for half the squared distance, Gauss-Newton where its Hessian is not
/// positive; a parameter held at its bound by the gradient stays. `None` on a degenerate tangent
/// plane.
fn descent(
    jet: &SurfaceJet2,
    p: &Point3<f64>,
    uv: [f64; 2],
    bounds: ParameterBox,
) -> Option<[f64; 2]> {
    // f = |S(u, v) - p|^2 / 2: gradient g_k = r . S_k, Hessian S_k . S_l + r . S_kl with r = S - p.
    let r = jet.s - p;
    let g = [r.dot(&jet.su), r.dot(&jet.sv)];
    // A parameter that the gradient presses against its bound stays there.
    let held = [0, 1]
        .map(|k| (uv[k] <= bounds[k].low && g[k] > 0.0) || (uv[k] >= bounds[k].high && g[k] < 0.0));
    // Gauss-Newton leaves out r . S_kl: the first fundamental form, which is never indefinite.
    let first = [jet.su.norm_squared(), jet.su.dot(&jet.sv), jet.sv.norm_squared()];
    let full = [first[0] + r.dot(&jet.suu), first[1] + r.dot(&jet.suv), first[2] + r.dot(&jet.svv)];
    match held {
        [true, true] => Some([0.0, 0.0]),
        [true, false] => Some([0.0, single(g[1], full[2], [first[2], first[0]])?]),
        [false, true] => Some([single(g[0], full[0], [first[0], first[2]])?, 0.0]),
        // Far from the surface or near a centre of curvature the full Hessian may not lead
        // downhill.
        [false, false] => solve(&full, g, &first).or_else(|| solve(&first, g, &first)),
    }
}

/// Returns `-g / h` with the curvature term only where it leaves `h` positive; nothing along a rim
/// that is a point, where the pace is rounding beside that across it.
fn single(g: f64, full: f64, [first, across]: [f64; 2]) -> Option<f64> {
    // Both are squared speeds: along a rim that is a point this one is rounding.
    if first <= ROUNDING * across {
        return Some(0.0);
    }
    let h = if full > CONDITION * first { full } else { first };
    (h > 0.0).then(|| -g / h)
}

/// A Hessian below this share of the first fundamental form is indefinite or about to be: near a
/// centre of curvature Newton's step would be mostly rounding.
const CONDITION: f64 = 1e-6;

/// Solves the symmetric system `[[a, b], [b, c]] step = -g` if it is safely positive definite.
fn solve([a, b, c]: &[f64; 3], g: [f64; 2], first: &[f64; 3]) -> Option<[f64; 2]> {
    // Sylvester's criterion for a positive definite matrix, with a margin; then Cramer's rule.
    let determinant = a * c - b * b;
    let safe = CONDITION * CONDITION * first[0] * first[2];
    if *a > 0.0 && *c > 0.0 && determinant > safe {
        Some([(b * g[1] - c * g[0]) / determinant, (b * g[0] - a * g[1]) / determinant])
    } else {
        None
    }
}
