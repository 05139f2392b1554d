//! Where a body ends on a ray, from where it ends on the ray beside.

use super::closest_approach::{BodyMotion, NearestInstant, RayLine, STEPS, TimeGuess};
use super::ray::{CLOSE, TOUCH};
use nalgebra::{Point3, Vector3};

/// Where the surface of what a body sweeps was met on a ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfaceTrace {
    at: Point3<f64>,
    gradient: Vector3<f64>,
    guess: TimeGuess,
}

/// Where it is expected on the ray beside.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExpectedSurface {
    pub(crate) s: f64,
    pub(crate) guess: TimeGuess,
    /// 1 if the body is below along the ray, -1 if it is above.
    pub(crate) way: f64,
}

/// What was taken off a ray there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FollowedCut {
    pub(crate) cut: [f64; 2],
    /// Where the surface is, and what is nearest there.
    pub(crate) s: f64,
    pub(crate) near: NearestInstant,
    /// How deep the end of the span is in the body then, if that was looked at.
    pub(crate) depth: Option<f64>,
}

/// Least cosine between a ray and a surface that is followed along it: rays that graze are cut one by one.
const STEEPEST: f64 = 0.03;

impl SurfaceTrace {
    pub(crate) fn new(line: &RayLine, s: f64, near: &NearestInstant) -> Self {
        Self { at: line.at(s), gradient: near.gradient, guess: near.guess() }
    }

    /// Where the tangent plane meets a line.
    pub(crate) fn on(&self, line: &RayLine) -> Option<ExpectedSurface> {
        let along = self.gradient.dot(&line.way);
        let s = self.gradient.dot(&(self.at - line.from)) / along;
        let way = along.signum();
        (along.abs() > STEEPEST).then_some(ExpectedSurface { s, guess: self.guess, way })
    }
}

impl BodyMotion<'_> {
    /// What the body sweeps of a span from one of its ends to where its surface is expected, where that is, and
    /// what is nearest there; `here`: what is nearest to where it is expected; `held`: whether that end
    /// is in the body at a time for certain. `None` if that is not all there is to it.
    pub(crate) fn follow(
        &self,
        line: &RayLine,
        span: [f64; 2],
        expected: &ExpectedSurface,
        held: impl Fn(f64) -> bool,
        here: NearestInstant,
    ) -> Option<FollowedCut> {
        let &ExpectedSurface { s, way, .. } = expected;
        let [inside, end] = if way > 0.0 { span } else { [span[1], span[0]] };

        // Farther out there is nothing, then.
        if here.slope * way <= self.shear {
            return None;
        }
        let (s, here) = if here.bound >= -TOUCH * self.tolerance {
            self.enter(line, [s, inside], here)?
        } else {
            let out = self.beyond([s, end], &here)?;
            self.enter(line, [out, s], self.nearest(line, out, here.guess()))?
        };
        // At this time the body reaches from there to the end of the span, or less far.
        let (other, depth) = if held(here.u) {
            (inside, None)
        } else {
            let (other, distance) = self.through(line, [inside, s], here.u)?;
            (other, Some(-distance))
        };
        Some(FollowedCut { cut: [s.min(other), s.max(other)], s, near: here, depth })
    }

    /// From outside a body or an end of a span towards its surface at `to`: where it begins at time `u`. Newton
    /// steps on a convex function come down to it from outside. Returned with the distance at `from`.
    pub(crate) fn through(
        &self,
        line: &RayLine,
        [from, to]: [f64; 2],
        u: f64,
    ) -> Option<(f64, f64)> {
        let way = if to > from { 1.0 } else { -1.0 };
        let mut s = from;
        let mut first = None;
        for _ in 0..STEPS {
            let here = self.tangent(line, s, u);
            if here.distance <= CLOSE * self.tolerance {
                return Some((s, first.unwrap_or(here.distance)));
            }
            first = first.or(Some(here.distance));
            let fall = -here.by_s * way;
            s += way * here.distance / fall;
            if fall <= 0.0 || (to - s) * way <= 0.0 {
                return None;
            }
        }
        None
    }
}
