//! Closest approach: the time in a piece at which a moving body is nearest to a point of a ray.

use crate::verify::stock::broad_phase::BoundedPiece;
use crate::verify::swept::quadratic::MotionPiece;
use crate::verify::swept::tool::ConvexBody;
use nalgebra::{Point3, Vector3};

/// Body in motion over part of a piece, with the accuracy of its evaluation \[mm\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct BodyMotion<'a> {
    pub(crate) piece: &'a MotionPiece,
    pub(crate) body: ConvexBody,
    pub(crate) tolerance: f64,
    /// Interval of time.
    pub(crate) time: [f64; 2],
    /// Loss of slope of planes below the distance, farther along the ray.
    pub(crate) shear: f64,
    /// Largest departure of points from straight motion in the tool's frame \[mm\].
    pub(crate) bend: f64,
}

/// Line of points `from + s direction`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayLine {
    pub(crate) from: Point3<f64>,
    /// Unit vector.
    pub(crate) direction: Vector3<f64>,
}

impl RayLine {
    #[inline]
    pub(crate) fn at(&self, s: f64) -> Point3<f64> {
        self.from + self.direction * s
    }
}

/// Nearest instant of a body to a point of a line. Nowhere on the line is its distance below
/// `bound + slope (s' - s)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearestInstant {
    pub(crate) distance: f64,
    pub(crate) bound: f64,
    pub(crate) slope: f64,
    pub(crate) u: f64,
    /// Estimated time of the minimum; `u` is the best time evaluated.
    pub(crate) least: f64,
    /// Gradient of the distance; `slope` is its component along the line.
    pub(crate) gradient: Vector3<f64>,
    /// Second derivative of the distance by time; 0 if unknown.
    pub(crate) curve: f64,
}

impl NearestInstant {
    /// Returns the initial guess for a nearby point.
    pub(crate) fn guess(&self) -> TimeGuess {
        TimeGuess { u: self.least, curve: self.curve }
    }
}

/// Distance at a time, with its derivatives by time and along the line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DistanceTangent {
    u: f64,
    pub(crate) distance: f64,
    by_u: f64,
    pub(crate) by_s: f64,
    gradient: Vector3<f64>,
}

impl DistanceTangent {
    /// Returns the lower bound for all times between here and `end`.
    fn towards(&self, end: f64) -> NearestInstant {
        NearestInstant {
            distance: self.distance,
            // The tangent of a convex function is below it, and falls towards `end` only.
            bound: self.distance - self.by_u.abs() * (end - self.u).abs(),
            slope: self.by_s,
            u: self.u,
            least: self.u,
            gradient: self.gradient,
            curve: 0.0,
        }
    }

    /// Returns the lower bound at the intersection of two planes, one falling and one rising with time: the mean of both that is
    /// constant in time. At a sharp edge only this mean has the slope of the nearest point.
    fn meet(&self, other: &Self) -> NearestInstant {
        let weight = other.by_u / (other.by_u - self.by_u);
        let mean = |a: f64, b: f64| weight * a + (1.0 - weight) * b;
        // Heights of both planes at u = 0; their mean with these weights has no slope by u.
        let at_zero = |plane: &Self| plane.distance - plane.by_u * plane.u;
        let near = if self.distance < other.distance { self } else { other };
        NearestInstant {
            distance: near.distance,
            bound: mean(at_zero(self), at_zero(other)),
            slope: mean(self.by_s, other.by_s),
            u: near.u,
            least: mean(self.u, other.u),
            gradient: self.gradient * weight + other.gradient * (1.0 - weight),
            curve: (other.by_u - self.by_u) / (other.u - self.u),
        }
    }
}

/// Initial guess of the nearest time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TimeGuess {
    pub(crate) u: f64,
    /// See [`NearestInstant::curve`].
    pub(crate) curve: f64,
}

impl TimeGuess {
    pub(crate) fn at(u: f64) -> Self {
        Self { u, curve: 0.0 }
    }
}

/// Share of the tolerance that a search over time may lose.
pub(crate) const SEARCH: f64 = 0.1;
/// Most steps of a search for the nearest instant. Two steps at least halve the interval, so this many lead from a metre to
/// below a nanometre.
pub(crate) const STEPS: u32 = 80;

impl<'a> BodyMotion<'a> {
    pub(crate) fn new(bounded: &'a BoundedPiece, body: ConvexBody, tolerance: f64) -> Self {
        let BoundedPiece { piece, bend, .. } = bounded;
        Self { piece, body, tolerance, time: [-1.0, 1.0], shear: piece.shear(2.0), bend: *bend }
    }

    /// Evaluates the distance, made convex in time.
    ///
    /// Its second derivative is at least `-2 bend`. Adding `bend (u² - 1/2)` makes it convex and changes it by at most half the
    /// bend.
    #[inline]
    pub(crate) fn tangent(&self, line: &RayLine, s: f64, u: f64) -> DistanceTangent {
        let (distance, by_u, gradient) = self.piece.distance(self.body, u, &line.at(s));
        DistanceTangent {
            u,
            distance: distance + self.bend * (u * u - 0.5),
            by_u: by_u + 2.0 * self.bend * u,
            by_s: gradient.dot(&line.direction),
            gradient,
        }
    }

    /// Finds the nearest instant to a point of the line, from an initial guess.
    #[inline]
    pub(crate) fn nearest(&self, line: &RayLine, s: f64, guess: TimeGuess) -> NearestInstant {
        let at = |u: f64| self.tangent(line, s, u);
        let enough = SEARCH * self.tolerance;
        // Step 1: accept the guess if its tangent bounds the distance well enough up to the end it falls towards.
        let first = at(guess.u.clamp(self.time[0], self.time[1]));
        // The minimum is on the side to which the distance falls.
        let rises = first.by_u > 0.0;
        let end = self.time[usize::from(!rises)];
        let found = first.towards(end);
        if found.distance - found.bound <= enough {
            let [low, high] = self.time;
            let least =
                if guess.curve > 0.0 { first.u - first.by_u / guess.curve } else { first.u };
            return NearestInstant { curve: guess.curve, least: least.clamp(low, high), ..found };
        }
        // Step 2: bracket the minimum, as far beyond it as the guess is before it, or by the end of the interval.
        let beyond = (first.u - 2.0 * first.by_u / guess.curve).clamp(self.time[0], self.time[1]);
        let beyond = if guess.curve > 0.0 { beyond } else { end };
        let mut last = at(beyond);
        if (last.by_u > 0.0) == rises && (beyond - end).abs() > 0.0 {
            last = at(end);
        }
        // Still falling at the end of the interval: the minimum is there.
        if (last.by_u > 0.0) == rises || last.by_u == 0.0 {
            return last.towards(end);
        }
        let [mut falling, mut rising] = if rises { [last, first] } else { [first, last] };
        let mut found = falling.meet(&rising);
        for step in 0..STEPS {
            if found.distance - found.bound <= enough {
                break;
            }
            // Step 3: narrow the bracket. Alternate between the root of the linear slope, and the intersection of both
            // planes, which is right where the slope jumps.
            let share = if step % 2 == 0 {
                falling.by_u / (falling.by_u - rising.by_u)
            } else {
                (found.bound - falling.distance) / (falling.by_u * (rising.u - falling.u))
            };
            let share = if (0.0..=1.0).contains(&share) { share } else { 0.5 };
            let here = at(falling.u + share * (rising.u - falling.u));
            let before = found;
            *(if here.by_u > 0.0 { &mut rising } else { &mut falling }) = here;
            found = falling.meet(&rising);
            // Keep the best time evaluated: the intersection need not have it.
            if before.distance < found.distance {
                (found.distance, found.u) = (before.distance, before.u);
            }
        }
        found
    }
}
