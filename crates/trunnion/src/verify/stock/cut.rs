//! A ray against a body in motion over one piece of a move.
//!
//! What a convex body sweeps while it moves straight is convex, so its distance along a ray,
//! `D(s) = min over u of d(s, u)`, is too: Newton's method from outside finds where the ray goes in and
//! out. Turning bends this by what [`Piece::bend`] bounds, and pieces are cut until that is below the
//! tolerance.

use super::super::body::Body;
use super::super::sweep::Piece;
use nalgebra::{Point3, Vector3};

/// A body in motion, and how exactly it is looked at \[mm\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Tool<'a> {
    pub(super) piece: &'a Piece,
    pub(super) body: Body,
    pub(super) tolerance: f64,
}

/// Share of the tolerance that counts as touching.
const CLOSE: f64 = 0.01;
/// Steps of a search for the nearest instant, and of Newton's method; each halves at least.
const STEPS: u32 = 60;

impl Tool<'_> {
    /// Distance at a point of the ray over the whole piece, and its derivative along `way`.
    fn distance(&self, point: &Point3<f64>, way: &Vector3<f64>) -> [f64; 2] {
        let at = |u: f64| self.piece.distance(self.body, u, point, way);
        let (mut low, mut high) = ((-1.0, at(-1.0)), (1.0, [0.0; 3]));
        // Leaving from the start, as most that was passed is.
        if low.1[1] >= 0.0 {
            return [low.1[0], low.1[2]];
        }
        high.1 = at(1.0);
        if high.1[1] <= 0.0 {
            return [high.1[0], high.1[2]];
        }
        let mut best = if low.1[0] < high.1[0] { low.1 } else { high.1 };
        for step in 0..STEPS {
            let width = high.0 - low.0;
            // False position, with a halving now and then against a side that stays.
            let share = if step % 3 == 2 { 0.5 } else { -low.1[1] / (high.1[1] - low.1[1]) };
            let u = low.0 + width * share.clamp(0.01, 0.99);
            let here = at(u);
            if here[0] < best[0] {
                best = here;
            }
            if here[1].abs() * width <= 0.1 * self.tolerance {
                break;
            }
            if here[1] < 0.0 { low = (u, here) } else { high = (u, here) }
        }
        [best[0], best[2]]
    }

    /// The part of a span of material that the body sweeps, if there is one deeper than the tolerance.
    pub(super) fn swept(
        &self,
        ray: &Point3<f64>,
        way: &Vector3<f64>,
        span: [f64; 2],
    ) -> Option<[f64; 2]> {
        let high = self.enter(ray, way, [span[1], span[0]])?;
        let low = self.enter(ray, way, [span[0], span[1]])?;
        (high > low).then_some([low, high])
    }

    /// From `from` towards `to`: where the body begins.
    fn enter(&self, ray: &Point3<f64>, way: &Vector3<f64>, [from, to]: [f64; 2]) -> Option<f64> {
        let sign = if to > from { 1.0 } else { -1.0 };
        let mut s = from;
        for _ in 0..STEPS {
            let [distance, slope] = self.distance(&(ray + way * s), way);
            let slope = slope * sign;
            if distance < -CLOSE * self.tolerance {
                return Some(s);
            }
            // Leaving, or only touching.
            if slope >= 0.0 {
                return None;
            }
            if distance <= CLOSE * self.tolerance {
                return Some(s);
            }
            s -= sign * distance / slope;
            if (to - s) * sign <= 0.0 {
                return None;
            }
        }
        Some(s)
    }

    /// How deep the body gets below the surface of what it sweeps of a ray: the largest depth found
    /// along the cut.
    pub(super) fn depth(&self, ray: &Point3<f64>, way: &Vector3<f64>, cut: [f64; 2]) -> f64 {
        let [mut low, mut high] = cut;
        let mut deepest = 0.0f64;
        for _ in 0..STEPS {
            let middle = 0.5 * (low + high);
            let [distance, slope] = self.distance(&(ray + way * middle), way);
            deepest = deepest.max(-distance);
            if high - low <= self.tolerance {
                break;
            }
            if slope > 0.0 { high = middle } else { low = middle }
        }
        deepest
    }
}
