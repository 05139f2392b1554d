//! Moves as short pieces whose motion is quadratic in time to within a stated error.

use super::tool::{BodyPose, BodyProbe, ConvexBody, NormalRay};
use crate::verify::VerifyError;
use crate::verify::replay::{Mover, Segment, Swing};
use nalgebra::{Point3, Vector3};

/// A piece of a move, over `u` in -1..=1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotionPiece {
    /// Line of the program.
    pub(crate) line: u32,
    /// Place of the tool in the table.
    pub(crate) tool: usize,
    /// The times in 0..=1 it covers of its move.
    span: [f64; 2],
    /// The tool at u = 0.
    pub(super) middle: MotionInstant,
    /// Coefficients of the tip \[mm\].
    tip: [Vector3<f64>; 3],
    /// Coefficients of the axis vector, unit to within the error.
    axis: [Vector3<f64>; 3],
    /// Bounds over the piece on speed and acceleration of the tip, turn rate and its change.
    speed: f64,
    acceleration: f64,
    turn: f64,
    turn_change: f64,
}

/// `|(u+1) u (u-1)| / 6 <= 0.06416` on -1..=1, and `d/du = d/dt / 2` with t in 0..=1, so that a
/// quadratic through both ends and the middle is off by at most this times the third derivative
/// by t.
const INTERPOLATION: f64 = 0.06416 / 8.0;
/// Largest turn of a piece \[rad\]: keeps the quadratic axis vector close to length 1.
const LARGEST_TURN: f64 = 0.2;
/// Halvings to the time at which a point is deepest: to a millionth of the piece.
const DEEPEST_STEPS: u32 = 20;
/// Pieces of one move; more only in a program that turns a thousand times in a block.
const MOST_PIECES: f64 = 1e6;

/// Splits a segment into pieces that are off by at most `tolerance` \[mm\] anywhere within `reach`
/// \[mm\] of the tip.
///
/// With the rotaries linear in time the axis is a product of two rotations, whose third derivative
/// is at most `theta³`, theta the sum of both turns; on a great circle it is that. A tip carried along
/// at distance `r` from the rotary axes while the linear axes travel `v` has at most
/// `theta³ r + 3 theta² v`. Under TCP the tip is linear but for the error a wrong belief makes, which
/// turns with the tool.
pub(crate) fn pieces(
    mover: &Mover<'_>,
    segment: &Segment,
    reach: f64,
    tolerance: f64,
    out: &mut Vec<MotionPiece>,
) -> Result<(), VerifyError> {
    let Some(Swing { turn, lever, travel }) = mover.swing(segment) else { return Ok(()) };
    let error = |theta: f64, travel: f64| {
        INTERPOLATION * theta.powi(2) * (theta * (lever + reach) + 3.0 * travel)
    };
    let mut count = (turn / LARGEST_TURN).ceil().max(1.0);
    while error(turn / count, travel / count) > tolerance {
        count *= 2.0;
        if count > MOST_PIECES {
            return Err(VerifyError::TurnsTooFar { line: segment.line });
        }
    }
    let mut index = 0.0;
    while index < count {
        let [a, b, c] = [index / count, (index + 0.5) / count, (index + 1.0) / count];
        out.push(MotionPiece::through(mover, segment, [a, b, c])?);
        index += 1.0;
    }
    Ok(())
}

/// A piece cut further until, seen from the tool, points within `reach` of the tip are off the mean of moving
/// straight and of moving on the parabola through its ends by at most `tolerance` \[mm\]: half of
/// [`MotionPiece::bend`].
pub(crate) fn straight(
    mover: &Mover<'_>,
    segment: &Segment,
    piece: &MotionPiece,
    [reach, tolerance]: [f64; 2],
) -> Result<Vec<MotionPiece>, VerifyError> {
    // The bend falls with the square of the length.
    let count = (0.5 * piece.bend(reach) / tolerance).sqrt().ceil();
    if count < 2.0 {
        return Ok(vec![*piece]);
    }
    if count > MOST_PIECES {
        return Err(VerifyError::TurnsTooFar { line: segment.line });
    }
    let [from, to] = piece.span;
    let at = |index: f64| from + (to - from) * index / count;
    let mut straight = Vec::new();
    let mut index = 0.0;
    while index < count {
        let times = [at(index), at(index + 0.5), at(index + 1.0)];
        straight.push(MotionPiece::through(mover, segment, times)?);
        index += 1.0;
    }
    Ok(straight)
}

/// Quadratic through values at -1, 0, 1.
fn quadratic([low, mid, high]: [Vector3<f64>; 3]) -> [Vector3<f64>; 3] {
    [mid, (high - low) * 0.5, (high + low) * 0.5 - mid]
}

/// Bound on how fast the velocity of a point at distance 1 changes because the tool turns: the change of
/// the turn rate, and the square of the rate itself.
///
/// With `n = a / |a|` and `P` across `n`, `P n'' = P a'' / |a| - 2 n' (n a') / |a|`; there
/// `a'' = 2 a2` lies nearly along `n`, and `a a'` is a cubic in `u` with small coefficients.
fn turn_change(axis: &[Vector3<f64>; 3], length: f64, turn: f64) -> f64 {
    let [a0, a1, a2] = axis;
    let aside = (a2 - a0 * (a0.dot(a2) / a0.norm_squared())).norm() + turn * a2.norm();
    let stretch = a0.dot(a1).abs()
        + (a1.norm_squared() + 2.0 * a0.dot(a2)).abs()
        + 3.0 * a1.dot(a2).abs()
        + 2.0 * a2.norm_squared();
    2.0 * (aside + turn * stretch / length) / length + turn * turn
}

/// A tool in motion at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotionInstant {
    pub(crate) stand: BodyPose,
    pub(super) tip_rate: Vector3<f64>,
    pub(super) axis_rate: Vector3<f64>,
}

/// Tool at `u` from the coefficients of tip and axis vector.
#[inline]
fn instant(tip: &[Vector3<f64>; 3], axis: &[Vector3<f64>; 3], u: f64) -> MotionInstant {
    let raw = axis[0] + (axis[1] + axis[2] * u) * u;
    let scale = 1.0 / raw.norm();
    let unit = raw * scale;
    let rate = (axis[1] + axis[2] * (2.0 * u)) * scale;
    MotionInstant {
        stand: BodyPose { tip: Point3::from(tip[0] + (tip[1] + tip[2] * u) * u), axis: unit },
        tip_rate: tip[1] + tip[2] * (2.0 * u),
        axis_rate: rate - unit * unit.dot(&rate),
    }
}

impl MotionInstant {
    /// Velocity by `u` of the tool's own point at `y` from the tip.
    #[inline]
    pub(crate) fn velocity(&self, y: &Vector3<f64>) -> Vector3<f64> {
        let Self { stand, tip_rate, axis_rate } = self;
        tip_rate + axis_rate * stand.axis.dot(y) - stand.axis * axis_rate.dot(y)
    }

    /// Distance of a body from a point, its derivative by `u`, and its gradient.
    #[inline]
    fn distance(&self, body: ConvexBody, point: &Point3<f64>) -> (f64, f64, Vector3<f64>) {
        let Self { stand, tip_rate, axis_rate } = self;
        let y = point - stand.tip;
        let probe = body.probe(&y, &stand.axis);
        let along = probe.axial - probe.radial * probe.height;
        let gradient = y * probe.radial + stand.axis * along;
        let drift = y.dot(axis_rate) * along - gradient.dot(tip_rate);
        (probe.distance, drift, gradient)
    }
}

/// Two planes below the distance of a body from places around a point, at all times of a piece, but for bend: height at
/// the point and gradient of each. The distance is nowhere less than the lower of both.
///
/// In the tool's frame, where the body is fixed and convex, the place `by` from the point moves straight with
/// velocity `v - w x by`; with distance `d` and gradient `g` at u = 0 it is at least `d + g by + u (g v - g (w x by))`
/// away, linear in `u` as well as in `by`: least at one end of the piece or the other.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SupportPlanes {
    pub(crate) sides: [(f64, Vector3<f64>); 2],
}

impl SupportPlanes {
    /// The side that is lower at the point.
    #[inline]
    pub(crate) fn lower(&self) -> &(f64, Vector3<f64>) {
        let [a, b] = &self.sides;
        if a.0 < b.0 { a } else { b }
    }
}

/// What is asked of a piece: does `body` meet `ray` below `limit`? Seen from the point at `s`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayQuery<'a> {
    pub(crate) body: ConvexBody,
    pub(crate) ray: &'a NormalRay,
    pub(crate) s: f64,
    pub(crate) limit: f64,
}

/// How a body stands to the ray at one instant: enough to bound it over an interval.
pub(crate) struct DistanceBound {
    /// Lower bound of the distance function over the interval, at any `s` up to the limit.
    pub(crate) low: f64,
    /// Derivative by `s` where it was probed.
    pub(crate) by_s: f64,
    /// Derivative by `u` at the middle.
    pub(crate) drift: f64,
}

/// A piece of a surface: points within `bulge` of `centre + s a + t b`, s and t in -1..=1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePatch<'a> {
    pub(crate) centre: Point3<f64>,
    pub(crate) half: &'a [Vector3<f64>; 2],
    pub(crate) bulge: f64,
    /// No point is farther from the centre.
    pub(crate) radius: f64,
    /// Unit vector across it.
    pub(crate) normal: Vector3<f64>,
}

/// Distance of a body from a patch's centre at an instant, and what other places and other times can
/// take from it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DistanceMargin {
    pub(crate) distance: f64,
    pub(crate) place: f64,
    pub(crate) time: f64,
}

impl DistanceMargin {
    /// What is left at least.
    pub(crate) fn least(&self) -> f64 {
        self.distance - self.place - self.time
    }
}

impl MotionPiece {
    /// The piece of a segment through three times.
    fn through(
        mover: &Mover<'_>,
        segment: &Segment,
        [a, b, c]: [f64; 3],
    ) -> Result<Self, VerifyError> {
        let pose = |t| mover.pose(segment, t);
        let [low, mid, high] = [pose(a)?, pose(b)?, pose(c)?];
        let tip = quadratic([low.tip.coords, mid.tip.coords, high.tip.coords]);
        let axis = quadratic([low, mid, high].map(|pose| pose.axis.into_inner()));
        let rate = axis[1].norm() + 2.0 * axis[2].norm();
        // The vector is at least this long (at least 0.9 by LARGEST_TURN), since it is 1 at both ends
        // and the middle; its direction turns accordingly faster.
        let length = 1.0 - axis[2].norm() - rate * rate;
        let turn = rate / length;
        let middle = instant(&tip, &axis, 0.0);
        Ok(Self {
            line: segment.line,
            tool: segment.tool,
            middle,
            tip,
            axis,
            speed: tip[1].norm() + 2.0 * tip[2].norm(),
            acceleration: 2.0 * tip[2].norm(),
            turn,
            turn_change: turn_change(&axis, length, turn),
            span: [a, c],
        })
    }

    /// Tool at `u`.
    pub(crate) fn instant(&self, u: f64) -> MotionInstant {
        instant(&self.tip, &self.axis, u)
    }

    /// Tool at u = 0.
    #[inline]
    pub(crate) fn middle(&self) -> &MotionInstant {
        &self.middle
    }

    /// Bounds the distance function `G(s, u)` of a body over `u` within `half` of the instant and
    /// all `s` from the ray's start to `limit`, from its values at `s0 = target.s`.
    ///
    /// In the tool's frame the body is fixed and convex, so `G` is at least its linear part at the
    /// instant less the curvature of the motion of the point: with `w = half`, turn rate `o`, turn
    /// change `b`, tip speed and acceleration `v` and `a`,
    ///
    /// ```text
    /// G >= d + d_s (s - s0) - |d_u| w - (a + 2 o v + b |y|) w²/2 - (o w + b w²/2) |s - s0|
    /// ```
    #[inline]
    pub(crate) fn bound(
        &self,
        instant: &MotionInstant,
        half: f64,
        target: &RayQuery<'_>,
    ) -> DistanceBound {
        let &RayQuery { body, ray, s, limit } = target;
        let MotionInstant { stand, tip_rate, axis_rate } = instant;
        let y = ray.at(s) - stand.tip;
        let probe: BodyProbe = body.probe(&y, &stand.axis);
        let by_s = probe.slope(&y, &stand.axis, &ray.normal);
        let turning = y.dot(axis_rate) * (probe.axial - probe.radial * probe.height);
        let drift = turning - probe.slope(&y, &stand.axis, tip_rate);
        let [bend, shear] = self.beyond(half, y.norm());
        let down = (shear + by_s).max(0.0) * (s + ray.below);
        let up = (shear - by_s).max(0.0) * (limit - s);
        let low = probe.distance - drift.abs() * half - bend - down.max(up);
        DistanceBound { low, by_s, drift }
    }

    /// How far the distance of a point can be from its linear part within `half` of an instant at which the point is
    /// so far from the tip, and how far the tool turns under it: mm, and mm for each mm beside the point.
    #[inline]
    pub(super) fn beyond(&self, half: f64, far: f64) -> [f64; 2] {
        let square = 0.5 * half * half;
        let far = far + self.speed * half;
        let bend = self.acceleration + 2.0 * self.turn * self.speed + self.turn_change * far;
        [bend * square, self.turn * half + self.turn_change * square]
    }

    /// Bounds the distance of a body from a patch over `u` within `half` of the instant: the linear
    /// part of the distance function at the patch's centre supports it, as in [`MotionPiece::bound`], and
    /// while the tool turns the patch's other points move against it by at most turn times radius.
    pub(crate) fn keeps_off(
        &self,
        instant: &MotionInstant,
        half: f64,
        body: ConvexBody,
        patch: &SurfacePatch<'_>,
    ) -> DistanceMargin {
        let MotionInstant { stand, tip_rate, axis_rate } = instant;
        let y = patch.centre - stand.tip;
        let probe = body.probe(&y, &stand.axis);
        let slope = |way: &Vector3<f64>| probe.slope(&y, &stand.axis, way);
        let turning = y.dot(axis_rate) * (probe.axial - probe.radial * probe.height);
        let drift = turning - slope(tip_rate);
        let [a, b] = patch.half;
        let [bend, shear] = self.beyond(half, y.norm() + patch.radius);
        DistanceMargin {
            distance: probe.distance,
            place: slope(a).abs() + slope(b).abs() + patch.bulge,
            time: drift.abs() * half + bend + shear * patch.radius,
        }
    }

    /// Distance of a body from a point at `u`, its derivative by `u`, and its gradient.
    #[inline]
    pub(crate) fn distance(
        &self,
        body: ConvexBody,
        u: f64,
        point: &Point3<f64>,
    ) -> (f64, f64, Vector3<f64>) {
        self.instant(u).distance(body, point)
    }

    /// When a point is deepest in a body, or nearest to it, but for bend: the distance is nearly convex in time. The
    /// motion is taken to go on beyond both ends of the piece, as far again.
    pub(crate) fn deepest(&self, body: ConvexBody, point: &Point3<f64>) -> f64 {
        let (mut low, mut high) = (-2.0, 2.0);
        for _ in 0..DEEPEST_STEPS {
            let u = 0.5 * (low + high);
            if self.distance(body, u, point).1 > 0.0 { high = u } else { low = u }
        }
        0.5 * (low + high)
    }

    /// What holds the distance of a body up over the whole piece, but for bend, from a point.
    #[inline]
    pub(crate) fn tent(&self, body: ConvexBody, point: &Point3<f64>) -> SupportPlanes {
        let (distance, drift, gradient) = self.middle.distance(body, point);
        let MotionInstant { stand, axis_rate, .. } = &self.middle;
        let turn = axis_rate * gradient.dot(&stand.axis) - stand.axis * gradient.dot(axis_rate);
        SupportPlanes {
            sides: [(distance + drift, gradient + turn), (distance - drift, gradient - turn)],
        }
    }

    /// How far a point at most `far` \[mm\] from the tip is from moving straight in the tool's frame
    /// \[mm\]: with turn rate `o`, turn change `b`, tip speed and acceleration `v` and `a`, half of
    /// `a + 2 o v + b far`.
    pub(crate) fn bend(&self, far: f64) -> f64 {
        let far = far + self.speed;
        0.5 * (self.acceleration + 2.0 * self.turn * self.speed + self.turn_change * far)
    }

    /// How far a point of the tool, at most `far` \[mm\] from the tip, is at most from the chord between its places at
    /// both ends of the piece \[mm\]: over a part of it, as the square of the part's length.
    pub(crate) fn sag(&self, far: f64) -> f64 {
        0.5 * (self.acceleration + self.turn_change * far)
    }

    /// How much a direction in the tool's frame changes at most within `time`.
    pub(crate) fn shear(&self, time: f64) -> f64 {
        (self.turn + 0.5 * self.turn_change * time) * time
    }

    /// Distance of a body from a point, less all that the motion of the piece can take from it.
    pub(crate) fn clearance(&self, body: ConvexBody, point: &Point3<f64>) -> f64 {
        let (distance, motion) = self.at_middle(body, point);
        distance - motion
    }

    /// Distance of a body from a point at u = 0, and what the motion of the piece can take from it.
    pub(crate) fn at_middle(&self, body: ConvexBody, point: &Point3<f64>) -> (f64, f64) {
        let stand = &self.middle.stand;
        let y = point - stand.tip;
        (body.probe(&y, &stand.axis).distance, self.pace(y.norm()))
    }

    /// How fast a point so far from the tip at u = 0 moves at most, seen from the tool \[mm\].
    pub(crate) fn pace(&self, far: f64) -> f64 {
        self.speed + self.turn * (far + self.speed)
    }

    /// Corners of a box around the axis points between two heights, over the whole piece.
    pub(crate) fn axis_box(&self, heights: [f64; 2]) -> [Point3<f64>; 2] {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for height in heights {
            let [p0, p1, p2] = [0, 1, 2].map(|k: usize| self.tip[k] + self.axis[k] * height);
            // Bezier control points of the quadratic contain it.
            for corner in [p0 - p1 + p2, p0 - p2, p0 + p1 + p2] {
                low = low.inf(&corner);
                high = high.sup(&corner);
            }
        }
        [Point3::from(low), Point3::from(high)]
    }
}
