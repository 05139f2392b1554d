//! Predicts the end of a body on a ray from its end on the neighbouring ray.

use super::closest_approach::{BodyMotion, NearestInstant, RayLine, STEPS, TimeGuess};
use super::ray::{CLOSE, TOUCH};
use nalgebra::{Point3, Vector3};

/// Point at which a swept surface was met on a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfaceTrace {
    at: Point3<f64>,
    gradient: Vector3<f64>,
    guess: TimeGuess,
}

/// Expected point on the neighbouring ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExpectedSurface {
    pub(crate) s: f64,
    pub(crate) guess: TimeGuess,
    /// 1 if the body is below along the ray, -1 if it is above.
    pub(crate) sign: f64,
}

/// Result of following a surface to a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FollowedCut {
    pub(crate) cut: [f64; 2],
    /// Position of the surface, and the nearest instant there.
    pub(crate) s: f64,
    pub(crate) near: NearestInstant,
    /// Depth of the end of the span in the body at that time, if evaluated.
    pub(crate) depth: Option<f64>,
}

/// Least cosine between a ray and the normal of a surface that is followed; grazing rays are clipped one by one.
const STEEPEST: f64 = 0.03;

impl SurfaceTrace {
    pub(crate) fn new(line: &RayLine, s: f64, near: &NearestInstant) -> Self {
        Self { at: line.at(s), gradient: near.gradient, guess: near.guess() }
    }

    /// Returns the intersection of the tangent plane with a line.
    pub(crate) fn on(&self, line: &RayLine) -> Option<ExpectedSurface> {
        // Tangent plane: g (x - at) = 0, with x = from + s direction.
        let along = self.gradient.dot(&line.direction);
        let s = self.gradient.dot(&(self.at - line.from)) / along;
        let sign = along.signum();
        (along.abs() > STEEPEST).then_some(ExpectedSurface { s, guess: self.guess, sign })
    }
}

impl BodyMotion<'_> {
    /// Clips a span from one of its ends to the expected surface.
    ///
    /// `here` is the nearest instant at the expected point; `held` tests if that end is certainly in the body at a time.
    /// `None` if this simple cut is not certain to be all.
    pub(crate) fn follow(
        &self,
        line: &RayLine,
        span: [f64; 2],
        expected: &ExpectedSurface,
        held: impl Fn(f64) -> bool,
        here: NearestInstant,
    ) -> Option<FollowedCut> {
        let &ExpectedSurface { s, sign, .. } = expected;
        let [inside, end] = if sign > 0.0 { span } else { [span[1], span[0]] };

        // Step 1: the plane must rise outwards, so that there is nothing farther out.
        if here.slope * sign <= self.shear {
            return None;
        }
        // A point outside leads in to the surface at once; from a point inside, a step out along the plane
        // comes first.
        let (s, here) = if here.bound >= -TOUCH * self.tolerance {
            self.enter(line, [s, inside], here)?
        } else {
            let out = self.beyond([s, end], &here)?;
            self.enter(line, [out, s], self.nearest(line, out, here.guess()))?
        };
        // Step 2: at this time the body reaches from the surface to the end of the span, or ends before.
        let (other, depth) = if held(here.u) {
            (inside, None)
        } else {
            let (other, distance) = self.through(line, [inside, s], here.u)?;
            (other, Some(-distance))
        };
        Some(FollowedCut { cut: [s.min(other), s.max(other)], s, near: here, depth })
    }

    /// Finds the start of a body at time `u`, from a point outside it towards `to`; returns the distance at `from` as well.
    ///
    /// Newton steps on a convex function approach the root from outside.
    pub(crate) fn through(
        &self,
        line: &RayLine,
        [from, to]: [f64; 2],
        u: f64,
    ) -> Option<(f64, f64)> {
        let sign = if to > from { 1.0 } else { -1.0 };
        let mut s = from;
        let mut first = None;
        for _ in 0..STEPS {
            // At one time the body is convex and at rest: only the position changes.
            let here = self.tangent(line, s, u);
            if here.distance <= CLOSE * self.tolerance {
                return Some((s, first.unwrap_or(here.distance)));
            }
            first = first.or(Some(here.distance));
            // Newton: the tangent of a convex function reaches 0 before the function does.
            let fall = -here.by_s * sign;
            s += sign * here.distance / fall;
            // The distance does not fall towards `to`, or the step passes it: the body is not met on the
            // interval.
            if fall <= 0.0 || (to - s) * sign <= 0.0 {
                return None;
            }
        }
        None
    }
}
