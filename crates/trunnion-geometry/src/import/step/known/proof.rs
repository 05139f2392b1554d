//! Upper bound on the distance of a rational surface from an elementary one.
//!
//! An elementary surface is where a polynomial of the coordinates vanishes. Put in it, the
//! homogeneous coordinates of a patch give a polynomial of the parameters; by its Bernstein
//! coefficients it is bounded over all of the patch, and the value of the first bounds the
//! distance.

use crate::import::step::model::StepFrame;
use crate::import::step::shape::StepShape;
use crate::math;
use crate::surface::BezierPatch;
use crate::surface::NurbsSurface;

/// A polynomial of two parameters in Bernstein form, the second running fastest.
#[derive(Debug, Clone)]
struct BernsteinPolynomial {
    coefficients: Vec<f64>,
    columns: usize,
}

/// Homogeneous coordinates in a frame.
struct LocalCoordinates {
    x: BernsteinPolynomial,
    y: BernsteinPolynomial,
    z: BernsteinPolynomial,
    w: BernsteinPolynomial,
}

/// Bounds the distance of the net's points from an elementary surface \[mm\]; `None` for other
/// shapes.
pub(super) fn distance(net: &NurbsSurface, shape: &StepShape) -> Option<f64> {
    let [columns, rows] = net.patch_count();
    let patches = (0..columns).flat_map(|i| (0..rows).filter_map(move |j| net.patch(i, j)));
    let mut most = 0.0_f64;
    for patch in patches {
        let off = of_patch(&patch, net.degree()[1] + 1, shape)?;
        // A number that is not one is no bound.
        most = if off >= 0.0 { most.max(off) } else { f64::INFINITY };
    }
    Some(most)
}

fn of_patch(patch: &BezierPatch<'_>, columns: usize, shape: &StepShape) -> Option<f64> {
    let local = |frame: &StepFrame| LocalCoordinates::new(patch, columns, frame);
    match shape {
        StepShape::Plane(frame) => {
            let LocalCoordinates { z, w, .. } = local(frame);
            // z = (w z) / w: the largest numerator over the least weight.
            Some(z.largest() / w.least())
        }
        // | |p| - R | = | |p|^2 - R^2 | / (|p| + R)
        StepShape::Sphere { frame, radius } => {
            let l = local(frame);
            let square = l.x.square().plus(&l.y.square()).plus(&l.z.square());
            let value = square.plus(&l.w.square().times_number(-radius * radius));
            Some(value.largest() / (l.w.least().powi(2) * radius))
        }
        StepShape::Cylinder { frame, radius } => {
            let l = local(frame);
            // As for the sphere, with the distance from the axis: |rho - R| <= |rho^2 - R^2| / R.
            let square = l.x.square().plus(&l.y.square());
            let value = square.plus(&l.w.square().times_number(-radius * radius));
            Some(value.largest() / (l.w.least().powi(2) * radius))
        }
        StepShape::Cone { frame, radius, angle } => {
            Some(cone(&local(frame), *radius, math::tan(*angle)))
        }
        StepShape::Torus { frame, major, minor } => Some(torus(&local(frame), *major, *minor)),
        _ => None,
    }
}

/// Bounds the distance from a cone. With `rho` the distance from the axis and `q = R + z tan a`
/// that of the cone at the same height, `|rho - q| <= |rho^2 - q^2| / max(q, |rho - q|)`, where `q`
/// is not negative.
fn cone(l: &LocalCoordinates, radius: f64, slope: f64) -> f64 {
    let q = l.w.times_number(radius).plus(&l.z.times_number(slope));
    let value = l.x.square().plus(&l.y.square()).plus(&q.square().times_number(-1.0));
    let least = l.w.least();
    let off = value.largest() / (least * least);
    // Least radius of the cone along the net; near the apex the root is the sharper bound.
    let narrowest = q.smallest() / l.w.largest();
    let by_apex = off.sqrt();
    let near = if narrowest > by_apex { off / narrowest } else { by_apex };
    // Control points beyond the apex bound how far points are beyond it.
    near + (-q.smallest()).max(0.0) / least
}

/// Bounds the distance from a torus:
/// `(|p|^2 + R^2 - r^2)^2 - 4 R^2 rho^2 = ((rho - R)^2 + z^2 - r^2) ((rho + R)^2 + z^2 - r^2)`. The
/// second factor is at least `R^2 - r^2`, and the first at least `r` times the distance.
fn torus(l: &LocalCoordinates, major: f64, minor: f64) -> f64 {
    let rho = l.x.square().plus(&l.y.square());
    // All terms are brought to the fourth power of the weight.
    let room = major * major - minor * minor;
    let whole = rho.plus(&l.z.square()).plus(&l.w.square().times_number(room));
    let turned = rho.times(&l.w.square()).times_number(-4.0 * major * major);
    let value = whole.square().plus(&turned);
    value.largest() / (l.w.least().powi(4) * room * minor)
}

impl LocalCoordinates {
    fn new(patch: &BezierPatch<'_>, columns: usize, frame: &StepFrame) -> Self {
        let poly = |of: &dyn Fn(&nalgebra::Vector4<f64>) -> f64| BernsteinPolynomial {
            coefficients: patch.points.iter().map(of).collect(),
            columns,
        };
        let along = |axis: &nalgebra::UnitVector3<f64>| {
            poly(&|p| axis.dot(&(p.xyz() - frame.origin.coords * p.w)))
        };
        Self { x: along(&frame.x), y: along(&frame.y), z: along(&frame.z), w: poly(&|p| p.w) }
    }
}

impl BernsteinPolynomial {
    fn rows(&self) -> usize {
        self.coefficients.len() / self.columns
    }

    /// Bounds the absolute value.
    fn largest(&self) -> f64 {
        // Values are convex combinations of the coefficients, so that the largest of these bounds
        // them. A coefficient that overflowed to NaN bounds nothing.
        let larger =
            |most: f64, x: &f64| if x.is_nan() { f64::INFINITY } else { most.max(x.abs()) };
        self.coefficients.iter().fold(0.0, larger)
    }

    /// Bounds the value from below.
    fn smallest(&self) -> f64 {
        let smaller =
            |least: f64, x: &f64| if x.is_nan() { f64::NEG_INFINITY } else { least.min(*x) };
        self.coefficients.iter().fold(f64::INFINITY, smaller)
    }

    /// Bounds a polynomial that is positive from below.
    fn least(&self) -> f64 {
        self.smallest().max(0.0)
    }

    fn plus(&self, other: &Self) -> Self {
        let sum = self.coefficients.iter().zip(&other.coefficients).map(|(a, b)| a + b);
        Self { coefficients: sum.collect(), columns: self.columns }
    }

    fn times_number(&self, factor: f64) -> Self {
        let scaled = self.coefficients.iter().map(|x| x * factor).collect();
        Self { coefficients: scaled, columns: self.columns }
    }

    fn square(&self) -> Self {
        self.times(self)
    }

    /// Multiplies: `c_k = sum C(m,i) C(n,j) / C(m+n,k) a_i b_j`, `i + j = k`, by both parameters.
    fn times(&self, other: &Self) -> Self {
        let (m, n) = ([self.rows(), self.columns], [other.rows(), other.columns]);
        let columns = m[1] + n[1] - 1;
        let mut coefficients = vec![0.0; (m[0] + n[0] - 1) * columns];
        for (a, x) in self.coefficients.iter().enumerate() {
            for (b, y) in other.coefficients.iter().enumerate() {
                let (i, j) = ([a / m[1], a % m[1]], [b / n[1], b % n[1]]);
                let share = |k: usize| {
                    binomial(m[k] - 1, i[k]) * binomial(n[k] - 1, j[k])
                        / binomial(m[k] + n[k] - 2, i[k] + j[k])
                };
                coefficients[(i[0] + j[0]) * columns + i[1] + j[1]] += x * y * share(0) * share(1);
            }
        }
        Self { coefficients, columns }
    }
}

/// Returns `n` over `k`, exact in `f64` for the degrees in use.
fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |product, i| product * (n - i) as f64 / (i + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_by_pencil() {
        // (1 - s) (s) = s - s^2: Bernstein coefficients 0, 1/2, 0.
        let [a, b] = [vec![1.0, 0.0], vec![0.0, 1.0]]
            .map(|coefficients| BernsteinPolynomial { coefficients, columns: 1 });
        let product = a.times(&b);
        assert_eq!(product.coefficients, vec![0.0, 0.5, 0.0]);
        assert!((product.largest() - 0.5).abs() < 1e-15);
    }
}
