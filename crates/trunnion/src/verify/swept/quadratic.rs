//! Splits moves into short pieces whose motion is quadratic in time to within a stated error.
//!
//! All bounds are over a piece, with its local time `u` in -1..=1. Symbols: `o` turn rate \[rad\], `b` bound on the change
//! of the velocity at distance 1 due to turning, `v` and `a` speed and acceleration of the tip \[mm\], all by `u`;
//! `y` a point relative to the tip, `d` its distance from the body, `g` the gradient of `d`.

use super::tool::{BodyPose, BodyProbe, BodySurface, ConvexBody, NormalRay};
use crate::verify::error::VerifyError;
use crate::verify::replay::mover::{Mover, Swing};
use crate::verify::replay::segment::Segment;
use nalgebra::{Point3, Vector3};

/// Piece of a move with quadratic motion, over `u` in -1..=1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotionPiece {
    /// Line of the program.
    pub(crate) line: u32,
    /// Index of the tool in the tool table.
    pub(crate) tool: usize,
    /// Interval of the move's time, within 0..=1, that the piece covers.
    span: [f64; 2],
    /// Tool at u = 0.
    pub(super) middle: MotionInstant,
    /// Polynomial coefficients of the tip by `u` \[mm\].
    tip: [Vector3<f64>; 3],
    /// Polynomial coefficients of the axis vector, whose length is 1 to within the error.
    axis: [Vector3<f64>; 3],
    /// Bounds over the piece: speed and acceleration of the tip, turn rate, and the change of velocity by turning.
    speed: f64,
    acceleration: f64,
    turn: f64,
    turn_change: f64,
}

/// Interpolation error of a quadratic through both ends and the middle, per third derivative by `t`.
///
/// `|(u+1) u (u-1)| / 6 <= 0.06416` on -1..=1, and `d/du = d/dt / 2` with `t` in 0..=1.
const INTERPOLATION: f64 = 0.06416 / 8.0;
/// Largest turn of a piece \[rad\]; it keeps the quadratic axis vector close to length 1.
const LARGEST_TURN: f64 = 0.2;
/// Bisections for the time at which a point is deepest: to a millionth of the piece.
const DEEPEST_STEPS: u32 = 20;
/// Most pieces of one move. Only a program that turns a thousand times in a block needs more.
const MOST_PIECES: f64 = 1e6;

/// Splits a segment into pieces that are accurate to `tolerance` \[mm\] within `reach` \[mm\] of the tip.
///
/// Error bound: with rotaries linear in time, the axis is a product of two rotations; its third derivative is at most
/// `theta³`, `theta` being the sum of both turns. On a great circle it is exactly that. A tip carried at distance `r`
/// from the rotary axes while the linear axes travel `v` has at most `theta³ r + 3 theta² v`. Under TCP the tip is
/// linear, except for the error of a wrong machine model, which turns with the tool.
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
    // Step 1: limit the turn of a piece, then halve the pieces until the interpolation error is within the
    // tolerance.
    let mut count = (turn / LARGEST_TURN).ceil().max(1.0);
    while error(turn / count, travel / count) > tolerance {
        count *= 2.0;
        if count > MOST_PIECES {
            return Err(VerifyError::TurnsTooFar { line: segment.line });
        }
    }
    let mut index = 0.0;
    while index < count {
        // Step 2: interpolate each piece through both ends and the middle.
        let [a, b, c] = [index / count, (index + 0.5) / count, (index + 1.0) / count];
        out.push(MotionPiece::through(mover, segment, [a, b, c])?);
        index += 1.0;
    }
    Ok(())
}

/// Subdivides a piece until points within `reach` of the tip move nearly straight in the tool's frame.
///
/// They are then off the mean of the straight line and of the parabola through its ends by at most `tolerance`
/// \[mm\], which is half of [`MotionPiece::bend`].
pub(crate) fn straight(
    mover: &Mover<'_>,
    segment: &Segment,
    piece: &MotionPiece,
    [reach, tolerance]: [f64; 2],
) -> Result<Vec<MotionPiece>, VerifyError> {
    // The bend falls with the square of the duration.
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

/// Returns the coefficients of the quadratic through values at -1, 0 and 1.
fn quadratic([low, mid, high]: [Vector3<f64>; 3]) -> [Vector3<f64>; 3] {
    [mid, (high - low) * 0.5, (high + low) * 0.5 - mid]
}

/// Bounds the change of velocity, due to turning, of a point at distance 1: change of the turn rate plus its square.
///
/// With `n = a / |a|` and `P` the projection across `n`, `P n'' = P a'' / |a| - 2 n' (n a') / |a|`. Here
/// `a'' = 2 a2` is nearly along `n`, and `a a'` is a cubic in `u` with small coefficients.
fn turn_change(axis: &[Vector3<f64>; 3], length: f64, turn: f64) -> f64 {
    let [a0, a1, a2] = axis;
    // Step 1: the part of a2 across the axis, at the middle of the piece and as the axis turns away from it.
    let aside = (a2 - a0 * (a0.dot(a2) / a0.norm_squared())).norm() + turn * a2.norm();
    // Step 2: bound the cubic a a' on -1..=1 by the sum of its coefficients.
    let lengthening = a0.dot(a1).abs()
        + (a1.norm_squared() + 2.0 * a0.dot(a2)).abs()
        + 3.0 * a1.dot(a2).abs()
        + 2.0 * a2.norm_squared();
    2.0 * (aside + turn * lengthening / length) / length + turn * turn
}

/// Pose and velocity of the tool at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotionInstant {
    pub(crate) pose: BodyPose,
    pub(super) tip_rate: Vector3<f64>,
    pub(super) axis_rate: Vector3<f64>,
}

/// Evaluates the motion at `u` from the coefficients of tip and axis vector.
#[inline]
fn instant(tip: &[Vector3<f64>; 3], axis: &[Vector3<f64>; 3], u: f64) -> MotionInstant {
    let raw = axis[0] + (axis[1] + axis[2] * u) * u;
    // The quadratic axis vector is not quite a unit vector: divide its value and its rate by its length, and
    // project the rate across the axis.
    let scale = 1.0 / raw.norm();
    let unit = raw * scale;
    let rate = (axis[1] + axis[2] * (2.0 * u)) * scale;
    MotionInstant {
        pose: BodyPose { tip: Point3::from(tip[0] + (tip[1] + tip[2] * u) * u), axis: unit },
        tip_rate: tip[1] + tip[2] * (2.0 * u),
        axis_rate: rate - unit * unit.dot(&rate),
    }
}

impl MotionInstant {
    /// Returns the velocity by `u` of the tool's own point at `y` from the tip.
    #[inline]
    pub(crate) fn velocity(&self, y: &Vector3<f64>) -> Vector3<f64> {
        let Self { pose, tip_rate, axis_rate } = self;
        // w x y = (a x a') x y = a' (a y) - a (a' y); the tool does not spin about its own axis.
        tip_rate + axis_rate * pose.axis.dot(y) - pose.axis * axis_rate.dot(y)
    }

    /// Returns the distance of a body from a point, its derivative by `u`, and its gradient.
    #[inline]
    fn distance(&self, body: ConvexBody, point: &Point3<f64>) -> (f64, f64, Vector3<f64>) {
        let Self { pose, tip_rate, axis_rate } = self;
        let y = point - pose.tip;
        // Gradient g = f_rho / rho (y - height axis) + f_height axis, sorted by y and the axis.
        let probe = body.probe(&y, &pose.axis);
        let along = probe.axial - probe.radial * probe.height;
        let gradient = y * probe.radial + pose.axis * along;
        // A fixed point drifts backwards as seen from the tool; the turn changes only its height.
        let drift = y.dot(axis_rate) * along - gradient.dot(tip_rate);
        (probe.distance, drift, gradient)
    }
}

/// Two planes that bound the distance of a body from points around a given point, at all times of a piece.
///
/// Each has a height at the given point and a gradient. Except for the bend, the distance is nowhere below the lower
/// of both. Proof: in the tool's frame the body is fixed and convex, and the point at offset `by` moves straight with
/// velocity `v - w x by`. With distance `d` and gradient `g` at u = 0 its distance is at least
/// `d + g by + u (g v - g (w x by))`. That is linear in `u` as well as in `by`, hence least at one end of the piece.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SupportPlanes {
    pub(crate) sides: [(f64, Vector3<f64>); 2],
}

impl SupportPlanes {
    /// Returns the plane that is lower at the given point.
    #[inline]
    pub(crate) fn lower(&self) -> &(f64, Vector3<f64>) {
        let [a, b] = &self.sides;
        if a.0 < b.0 { a } else { b }
    }
}

/// Query for the first point at which `body` meets `ray` below `limit`, evaluated at `s`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayQuery<'a> {
    pub(crate) body: ConvexBody,
    pub(crate) ray: &'a NormalRay,
    pub(crate) s: f64,
    pub(crate) limit: f64,
}

/// Distance bound of a body from a ray over an interval of time.
pub(crate) struct DistanceBound {
    /// Lower bound of the distance function over the interval, for every `s` up to the limit.
    pub(crate) low: f64,
    /// Derivative by `s` at the probed point.
    pub(crate) by_s: f64,
    /// Derivative by `u` at the middle of the interval.
    pub(crate) drift: f64,
}

/// Piece of a surface: points within `bulge` of `centre + s a + t b`, with `s` and `t` in -1..=1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePatch<'a> {
    pub(crate) centre: Point3<f64>,
    pub(crate) half: &'a [Vector3<f64>; 2],
    pub(crate) bulge: f64,
    /// Bound on the distance of its points from the centre.
    pub(crate) radius: f64,
    /// Unit normal.
    pub(crate) normal: Vector3<f64>,
    /// Part of the rectangle that the surface fills, if it is less than all of it.
    pub(crate) part: Option<&'a PatchPart>,
}

/// Part of a patch: points `[s, t]` whose hull, grown by `slack` in s and t, holds it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PatchPart {
    pub(crate) corners: Vec<[f64; 2]>,
    pub(crate) slack: [f64; 2],
}

impl SurfacePatch<'_> {
    /// Returns the patch that is the origin of a ray alone.
    pub(crate) fn point(ray: &NormalRay) -> Self {
        const HALF: &[Vector3<f64>; 2] = &[Vector3::new(0.0, 0.0, 0.0); 2];
        let half = HALF;
        let (centre, normal) = (ray.origin, ray.normal);
        Self { centre, half, bulge: 0.0, radius: 0.0, normal, part: None }
    }

    /// Bounds the loss of a linear function over the patch against its centre; `slopes` are its changes along both
    /// halves. Over a part of the patch the loss may be negative.
    pub(crate) fn loss(&self, [a, b]: [f64; 2]) -> f64 {
        let whole = a.abs() + b.abs();
        let loss = self.part.map_or(whole, |part| {
            let corners = part.corners.iter().map(|[s, t]| -a * s - b * t);
            let most = corners.fold(f64::NEG_INFINITY, f64::max);
            (most + a.abs() * part.slack[0] + b.abs() * part.slack[1]).min(whole)
        });
        loss + self.bulge
    }
}

/// Distance of a body from the centre of a patch at an instant, with what other points and other times can take off it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DistanceMargin {
    pub(crate) distance: f64,
    /// Loss over the patch; negative where its part lies beyond the centre.
    pub(crate) extent: f64,
    /// Size of the patch as the bound sees it, which quartering the patch halves.
    pub(crate) spread: f64,
    /// Loss over the interval of time.
    pub(crate) time: f64,
}

impl DistanceMargin {
    /// Returns the lower bound over the whole patch and interval.
    pub(crate) fn least(&self) -> f64 {
        self.distance - self.extent - self.time
    }
}

impl MotionPiece {
    /// Interpolates a segment through three times.
    fn through(
        mover: &Mover<'_>,
        segment: &Segment,
        [a, b, c]: [f64; 3],
    ) -> Result<Self, VerifyError> {
        let pose = |t| mover.pose(segment, t);
        let [low, mid, high] = [pose(a)?, pose(b)?, pose(c)?];
        let tip = quadratic([low.tip.coords, mid.tip.coords, high.tip.coords]);
        let axis = quadratic([low, mid, high].map(|pose| pose.axis.into_inner()));
        // |a'| on -1..=1, by the triangle inequality.
        let rate = axis[1].norm() + 2.0 * axis[2].norm();
        // The axis vector is at least this long, since it is 1 at both ends and in the middle; LARGEST_TURN keeps
        // that above 0.9. Its direction turns faster by the same ratio.
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

    /// Returns pose and velocity at `u`.
    pub(crate) fn instant(&self, u: f64) -> MotionInstant {
        instant(&self.tip, &self.axis, u)
    }

    /// Returns pose and velocity at u = 0.
    #[inline]
    pub(crate) fn middle(&self) -> &MotionInstant {
        &self.middle
    }

    /// Bounds the distance function `G(s, u)` of a body over `u` within `half` of the instant and
    /// all `s` from the start of the ray to `limit`, from its values at `s0 = target.s`.
    ///
    /// In the tool's frame the body is fixed and convex. Hence `G` is at least its linear part at the instant, less the
    /// curvature of the point's motion. With `w = half`, turn rate `o`, turn change `b`, tip speed and acceleration `v`
    /// and `a`:
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
        let MotionInstant { pose, tip_rate, axis_rate } = instant;
        let y = ray.at(s) - pose.tip;
        let probe: BodyProbe = body.probe(&y, &pose.axis);
        // d_s by the chain rule. d_u: a fixed point drifts by -tip' as seen from the tool. By the turn its height changes by
        // h' = y a', and its distance from the axis by -h h' / rho.
        let by_s = probe.slope(&y, &pose.axis, &ray.normal);
        let turning = y.dot(axis_rate) * (probe.axial - probe.radial * probe.height);
        let drift = turning - probe.slope(&y, &pose.axis, tip_rate);
        // The linear part is least at one end of the ray: the slope may be off by the shear in both
        // directions.
        let [bend, shear] = self.beyond(half, y.norm());
        let down = (shear + by_s).max(0.0) * (s + ray.below);
        let up = (shear - by_s).max(0.0) * (limit - s);
        let low = probe.distance - drift.abs() * half - bend - down.max(up);
        DistanceBound { low, by_s, drift }
    }

    /// Bounds the departure from linearity within `half` of an instant, for a point at distance `far` from the tip.
    ///
    /// Returns the part of its own motion \[mm\], and the turn of the tool under it \[mm per mm beside the point\].
    #[inline]
    pub(super) fn beyond(&self, half: f64, far: f64) -> [f64; 2] {
        // The tip moves at most `speed * half` away from the point, which adds to the lever.
        let square = 0.5 * half * half;
        let far = far + self.speed * half;
        let bend = self.acceleration + 2.0 * self.turn * self.speed + self.turn_change * far;
        [bend * square, self.turn * half + self.turn_change * square]
    }

    /// Bounds the distance of a body from a patch over `u` within `half` of the instant.
    ///
    /// The linear part of the distance function at the centre supports it, as in [`MotionPiece::bound`]. While the tool
    /// turns, the other points of the patch move against it by at most turn times radius.
    pub(crate) fn keeps_off(
        &self,
        instant: &MotionInstant,
        half: f64,
        body: BodySurface,
        patch: &SurfacePatch<'_>,
    ) -> DistanceMargin {
        let MotionInstant { pose, tip_rate, axis_rate } = instant;
        let y = patch.centre - pose.tip;
        let probe = body.probe(&y, &pose.axis);
        let slope = |direction: &Vector3<f64>| probe.slope(&y, &pose.axis, direction);
        let turning = y.dot(axis_rate) * (probe.axial - probe.radial * probe.height);
        let drift = turning - slope(tip_rate);
        let [a, b] = patch.half;
        let [bend, shear] = self.beyond(half, y.norm() + patch.radius);
        DistanceMargin {
            distance: probe.distance,
            extent: patch.loss([slope(a), slope(b)]),
            spread: slope(a).abs() + slope(b).abs() + patch.bulge,
            time: drift.abs() * half + bend + shear * patch.radius,
        }
    }

    /// Returns the distance of a body from a point at `u`, its derivative by `u`, and its gradient.
    #[inline]
    pub(crate) fn distance(
        &self,
        body: ConvexBody,
        u: f64,
        point: &Point3<f64>,
    ) -> (f64, f64, Vector3<f64>) {
        self.instant(u).distance(body, point)
    }

    /// Returns the time at which a point is deepest in a body, or nearest to it, except for the bend.
    ///
    /// The distance is nearly convex in time. The motion is extrapolated beyond both ends of the piece, as far again.
    pub(crate) fn deepest(&self, body: ConvexBody, point: &Point3<f64>) -> f64 {
        let (mut low, mut high) = (-2.0, 2.0);
        for _ in 0..DEEPEST_STEPS {
            // The derivative by time changes its sign once, at the minimum.
            let u = 0.5 * (low + high);
            if self.distance(body, u, point).1 > 0.0 { high = u } else { low = u }
        }
        0.5 * (low + high)
    }

    /// Returns the planes below the distance of a body around a point, over the whole piece and except for the bend.
    #[inline]
    pub(crate) fn support_planes(&self, body: ConvexBody, point: &Point3<f64>) -> SupportPlanes {
        let (distance, drift, gradient) = self.middle.distance(body, point);
        let MotionInstant { pose, axis_rate, .. } = &self.middle;
        // With w = axis x axis_rate, -g (w x by) = turn by. The ends u = 1 and u = -1 give the two planes.
        let turn = axis_rate * gradient.dot(&pose.axis) - pose.axis * gradient.dot(axis_rate);
        SupportPlanes {
            sides: [(distance + drift, gradient + turn), (distance - drift, gradient - turn)],
        }
    }

    /// Bounds the departure of a point from straight motion in the tool's frame \[mm\], at most `far` \[mm\] from the tip:
    /// half of `a + 2 o v + b far`.
    pub(crate) fn bend(&self, far: f64) -> f64 {
        let far = far + self.speed;
        0.5 * (self.acceleration + 2.0 * self.turn * self.speed + self.turn_change * far)
    }

    /// Bounds the distance of a tool point from the chord between its two end positions \[mm\], at most `far` \[mm\] from
    /// the tip. Over a part of the piece it falls with the square of the duration.
    pub(crate) fn sag(&self, far: f64) -> f64 {
        // |chord - arc| <= max |x''| (2)² / 8 over an interval of length 2.
        0.5 * (self.acceleration + self.turn_change * far)
    }

    /// Bounds the change of a direction in the tool's frame within `time`.
    pub(crate) fn shear(&self, time: f64) -> f64 {
        // Taylor: |n(t) - n(0)| <= |n'| t + max |n''| t² / 2.
        (self.turn + 0.5 * self.turn_change * time) * time
    }

    /// Returns the distance of a body from a point, less all that the motion of the piece can take off it.
    pub(crate) fn clearance(&self, body: ConvexBody, point: &Point3<f64>) -> f64 {
        let (distance, motion) = self.at_middle(body, point);
        distance - motion
    }

    /// Returns the distance of a body from a point at u = 0, and what the motion of the piece can take off it.
    pub(crate) fn at_middle(&self, body: ConvexBody, point: &Point3<f64>) -> (f64, f64) {
        let pose = &self.middle.pose;
        let y = point - pose.tip;
        (body.probe(&y, &pose.axis).distance, self.point_speed(y.norm()))
    }

    /// Bounds the speed of a point in the tool's frame, at distance `far` from the tip at u = 0 \[mm\].
    pub(crate) fn point_speed(&self, far: f64) -> f64 {
        // The tip moves by up to `speed` within the piece, which adds to the lever of the turn.
        self.speed + self.turn * (far + self.speed)
    }

    /// Returns the corners of a box around the axis points between two heights, over the whole piece.
    pub(crate) fn axis_box(&self, heights: [f64; 2]) -> [Point3<f64>; 2] {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = -low;
        for height in heights {
            // A point of the axis is quadratic in time as well.
            let [p0, p1, p2] = [0, 1, 2].map(|k: usize| self.tip[k] + self.axis[k] * height);
            // The Bezier control points of the quadratic contain it.
            for corner in [p0 - p1 + p2, p0 - p2, p0 + p1 + p2] {
                low = low.inf(&corner);
                high = high.sup(&corner);
            }
        }
        [Point3::from(low), Point3::from(high)]
    }
}
