//! Bounds on the rotary travel that a path needs, for one rotation of the workpiece and for all rotations
//! near it.

use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math;
use crate::math::angle::unwrap_near;
use crate::types::Interval;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Ball of rotations about a centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RotationBall {
    /// Largest angle of the rotation from the centre to one of them \[rad\].
    pub(super) radius: f64,
    /// Largest change of the angle between tool and workpiece-side rotary from the centre \[rad\].
    pub(super) drift: f64,
}

impl RotationBall {
    /// One rotation alone.
    pub(super) const POINT: Self = Self { radius: 0.0, drift: 0.0 };
}

/// Tool axes of a path in order, one list for each segment between two links.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisTrail {
    /// Angle between neighbours, about \[rad\].
    pub(super) step: f64,
    pub(super) segments: Vec<Vec<Vector3<f64>>>,
}

/// The spherical triangle of the two rotaries and the tool, as [`crate::inverse`] has it, in the
/// machine's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RotaryTriangle {
    /// Towards the tool-side rotary, across, along the workpiece-side rotary.
    frame: [Vector3<f64>; 3],
    /// `cos a1`, `cos a2`, `sin a1`, `sin a2`.
    cos: [f64; 2],
    sin: [f64; 2],
    azimuth2: f64,
    limits: [Interval; 2],
}

/// An interval \[rad\].
type AngleRange = [f64; 2];

/// Cosine of angles that are right angles but for rounding.
const SQUARE: f64 = 1e-9;

/// Error of arc cosines next to 1 \[rad\].
const ROUNDING: f64 = 1e-7;

impl RotaryTriangle {
    /// Creates the triangle of a machine; the setup has no part in it.
    pub(super) fn new(inverse: &Inverse) -> Self {
        let axes = &inverse.kinematics().machine().axes;
        let [w1, w2] =
            [FIRST_ROTARY, SECOND_ROTARY].map(|at| axes[at].dir.into_inner() * axes[at].sense);
        let tool = inverse.kinematics().machine().tool_axis.into_inner();
        let cos = [w1.dot(&w2), w2.dot(&tool)];
        let sin = [w1.cross(&w2).norm(), w2.cross(&tool).norm()];
        let towards = (w2 - w1 * cos[0]) / sin[0];
        let back = (w1 - w2 * cos[0]) / sin[0];
        Self {
            frame: [towards, w1.cross(&towards), w1],
            cos,
            sin,
            azimuth2: math::atan2(tool.dot(&w2.cross(&back)), tool.dot(&back)),
            limits: [FIRST_ROTARY, SECOND_ROTARY].map(|at| axes[at].limits),
        }
    }

    /// Returns `true` if any rotary has an end of travel.
    pub(super) fn ends(&self) -> bool {
        self.limits.iter().any(|limits| *limits != Interval::UNBOUNDED)
    }

    /// Returns the move of the rotaries needed beyond their travel \[rad\], branch and turns of each
    /// segment the best, for every rotation of a ball; 0 where one of them may do with less, or where
    /// nothing is known because a segment comes too close to the singular directions.
    pub(super) fn beyond(
        &self,
        trail: &AxisTrail,
        rotation: &Rotation3<f64>,
        ball: RotationBall,
    ) -> f64 {
        let mut most: f64 = 0.0;
        let rows = self.rows(rotation);
        for segment in &trail.segments {
            let Some(branches) = self.ranges(segment, &rows, ball, trail.step) else {
                continue;
            };
            let worse = |ranges: [AngleRange; 2]| {
                let [first, second] = self.limits;
                beyond(ranges[0], first).max(beyond(ranges[1], second))
            };
            // Each segment takes its better branch; the worst segment decides.
            most = most.max(branches.map(worse).into_iter().fold(f64::INFINITY, f64::min));
        }
        (most - ROUNDING).max(0.0)
    }

    /// Returns for both branches and rotaries a lower bound of the largest position on a segment and an
    /// upper bound of the smallest \[rad\]; `None` next to the singular directions.
    fn ranges(
        &self,
        segment: &[Vector3<f64>],
        rows: &[Vector3<f64>; 3],
        ball: RotationBall,
        step: f64,
    ) -> Option<[[AngleRange; 2]; 2]> {
        let mut ranges = [[[f64::NEG_INFINITY, f64::INFINITY]; 2]; 2];
        let mut last: Option<f64> = None;
        // Between two samples, anywhere in the ball, the tool axis stays off the pole; otherwise the azimuth
        // cannot be unwound from sample to sample.
        let clear = ball.radius + 2.0 * step;
        let polars = polars(segment, &rows[2]);
        if polars[0].min(PI - polars[1]) <= clear {
            return None;
        }
        let turned = if self.endless_first() { &[] } else { segment };
        for axis in turned {
            let place = AxisDirection::of(rows, axis, clear)?;
            let azimuth = last.map_or(place.azimuth, |last| unwrap_near(place.azimuth, last));
            last = Some(azimuth);
            // t1 = azimuth - g B1: both terms are known to within intervals over the ball.
            let (slack, b1) = (place.slack(ball), self.b1(place.around(ball)));
            for (range, sign) in ranges.iter_mut().zip([1.0, -1.0]) {
                let [low, high] = minus(azimuth, sign, b1);
                range[0] = [range[0][0].max(low - slack), range[0][1].min(high + slack)];
            }
        }
        // t2 = -g B2 - azimuth2. `b2` grows with the polar angle, so the extreme directions give the range.
        let [near, far] = polars.map(|polar| self.b2([polar - ball.drift, polar + ball.drift]));
        for (range, sign) in ranges.iter_mut().zip([1.0, -1.0]) {
            let ends = [near, far].map(|b2| minus(-self.azimuth2, sign, b2));
            range[1] = [ends[0][0].max(ends[1][0]), ends[0][1].min(ends[1][1])];
        }
        Some(ranges)
    }

    /// Returns the widest interval that each rotary of a pose may be in, over a ball of rotations \[rad\];
    /// `None` next to the singular directions.
    pub(super) fn slack(
        &self,
        trail: &AxisTrail,
        rotation: &Rotation3<f64>,
        ball: RotationBall,
    ) -> Option<[f64; 2]> {
        let rows = self.rows(rotation);
        let mut most = [0.0_f64; 2];
        for axis in trail.segments.iter().flatten() {
            let place = AxisDirection::of(&rows, axis, ball.radius + 2.0 * trail.step)?;
            let around = place.around(ball);
            let [b1, b2] = [self.b1(around), self.b2(around)].map(|[low, high]| high - low);
            most = [most[0].max(place.slack(ball) + b1), most[1].max(b2)];
        }
        Some(most)
    }

    /// Returns the frame seen from the workpiece.
    fn rows(&self, rotation: &Rotation3<f64>) -> [Vector3<f64>; 3] {
        self.frame.map(|row| rotation.inverse() * row)
    }

    /// Returns `true` if the travel of the tool-side rotary alone, or none, decides which rotations fit: then the
    /// direction of the workpiece-side rotary seen from the workpiece is all that counts.
    pub(super) fn endless_first(&self) -> bool {
        !self.limits[0].is_bounded()
    }

    /// Returns the range of the triangle's angle at the workpiece-side rotary over an interval of polar angles:
    /// `cos B1 = (cos a2 - cos a1 cos φ) / (sin a1 sin φ)`.
    fn b1(&self, around: AngleRange) -> AngleRange {
        // Both arcs right angles: B1 is one as well.
        if self.cos.iter().all(|cos| cos.abs() < SQUARE) {
            return [FRAC_PI_2; 2];
        }
        let at = |polar: f64| {
            let cos =
                (self.cos[1] - self.cos[0] * math::cos(polar)) / (self.sin[0] * math::sin(polar));
            math::acos(cos.clamp(-1.0, 1.0))
        };
        let [low, high] = around.map(at);
        let range = [low.min(high), low.max(high)];
        // The derivative of cos B1 by φ vanishes where cos φ = cos a1 / cos a2: the one extreme inside.
        let turn = self.cos[0] / self.cos[1];
        if turn.abs() < 1.0 {
            let polar = math::acos(turn);
            if around[0] < polar && polar < around[1] {
                let middle = at(polar);
                return [range[0].min(middle), range[1].max(middle)];
            }
        }
        range
    }

    /// Returns the range of the triangle's angle at the tool-side rotary, which grows with the polar angle:
    /// `cos B2 = (cos φ - cos a1 cos a2) / (sin a1 sin a2)`.
    fn b2(&self, around: AngleRange) -> AngleRange {
        let [m, v] = self.cos;
        around.map(|polar| {
            math::acos(((math::cos(polar) - m * v) / (self.sin[0] * self.sin[1])).clamp(-1.0, 1.0))
        })
    }
}

/// Direction of a tool axis about the workpiece-side rotary.
#[derive(Debug, Clone, Copy)]
struct AxisDirection {
    azimuth: f64,
    polar: f64,
    sine: f64,
}

impl AxisDirection {
    /// Returns `None` next to the singular directions, where the azimuth is undefined.
    fn of(rows: &[Vector3<f64>; 3], axis: &Vector3<f64>, clear: f64) -> Option<Self> {
        let [x, y, z] = rows.map(|row| row.dot(axis));
        let sine = math::hypot(x, y);
        let polar = math::atan2(sine, z);
        (polar.min(PI - polar) > clear).then(|| Self { azimuth: math::atan2(y, x), polar, sine })
    }

    /// Returns the largest change of its azimuth in a ball of rotations \[rad\].
    ///
    /// A turn by at most `r` keeps the direction inside a cone that clears the pole; seen from the pole its
    /// half width is `asin(sin r / sin φ)`.
    fn slack(&self, ball: RotationBall) -> f64 {
        math::asin((math::sin(ball.radius) / self.sine).clamp(0.0, 1.0))
    }

    /// Returns the range of its polar angle in a ball of rotations \[rad\].
    fn around(&self, ball: RotationBall) -> AngleRange {
        [self.polar - ball.drift, self.polar + ball.drift]
    }
}

/// Returns the least and the largest angle from a direction \[rad\].
fn polars(segment: &[Vector3<f64>], from: &Vector3<f64>) -> AngleRange {
    let along = segment.iter().map(|axis| from.dot(axis));
    let [low, high] =
        along.fold([1.0_f64, -1.0_f64], |[low, high], along| [low.min(along), high.max(along)]);
    [high, low].map(|along| math::acos(along.clamp(-1.0, 1.0)))
}

/// Returns `value - sign * range`.
fn minus(value: f64, sign: f64, [low, high]: AngleRange) -> AngleRange {
    let [a, b] = [value - sign * low, value - sign * high];
    [a.min(b), a.max(b)]
}

/// Returns the excess of positions up to `far` and down to `near` over an axis' travel at the best whole turn.
fn beyond([far, near]: AngleRange, travel: Interval) -> f64 {
    if !travel.is_bounded() {
        return 0.0;
    }
    // Middle of the interval onto the middle of the travel: the whole turn below or above.
    let Interval { low, high } = travel;
    let best = (0.5 * (low + high - far - near) / TAU).floor();
    let at = |turns: f64| (far + TAU * turns - high).max(low - near - TAU * turns).max(0.0);
    at(best).min(at(best + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inverse::InverseSolutions;
    use crate::machine::{Kinematics, Machine, MachineSpec, Setup, samples};
    use crate::types::ToolPose;
    use nalgebra::{Point3, UnitVector3};
    use proptest::prelude::*;

    fn nutating() -> MachineSpec {
        let mut spec = samples::ac_trunnion();
        spec.axes[4].dir = [0.2, 1.0, 0.9];
        spec
    }

    /// With ends of travel, so that every axis is checked.
    fn limited(mut spec: MachineSpec) -> Machine {
        for axis in &mut spec.axes[3..] {
            (axis.limits, axis.cyclic) = (Some(Interval::new(-1.0, 1.0)), None);
        }
        spec.axes[3].sense = -1.0;
        Machine::new(spec).unwrap()
    }

    fn rotaries(
        machine: &Machine,
        rotation: Rotation3<f64>,
        axis: UnitVector3<f64>,
    ) -> Option<[[f64; 2]; 2]> {
        let setup = Setup { origin: Vector3::zeros(), rotation, tool_length: 0.0 };
        let inverse = Inverse::new(&Kinematics::new(machine, &setup)).unwrap();
        match inverse.solutions(&ToolPose { tip: Point3::origin(), axis }) {
            Ok(InverseSolutions::Regular(both)) => {
                Some(both.map(|q| [q[FIRST_ROTARY], q[SECOND_ROTARY]]))
            }
            _ => None,
        }
    }

    fn unit(parts: [f64; 3]) -> UnitVector3<f64> {
        UnitVector3::new_normalize(Vector3::from(parts))
    }

    proptest! {
        /// The triangle is that of the inverse, and a ball of rotations holds what the inverse says for each
        /// of its rotations.
        #[test]
        fn a_ball_holds_what_the_inverse_says(
            square in any::<bool>(),
            axis in prop::array::uniform3(-1.0..1.0f64),
            turn in prop::array::uniform3(-3.0..3.0f64),
            by in prop::array::uniform3(-1.0..1.0f64),
            radius in 0.0..0.4f64,
        ) {
            let machine = limited(if square { samples::ac_trunnion() } else { nutating() });
            let setup = Setup::new(Vector3::zeros(), [0.0; 3], 0.0);
            let inverse = Inverse::new(&Kinematics::new(&machine, &setup)).unwrap();
            let turning = RotaryTriangle::new(&inverse);
            let axis = unit(axis);
            let centre = Rotation3::from_euler_angles(turn[0], turn[1], turn[2]);
            let near = Rotation3::from_axis_angle(&unit(by), radius) * centre;
            let ball = RotationBall { radius, drift: radius };
            for (rotation, ball) in [(centre, RotationBall::POINT), (near, ball)] {
                let segment = [axis.into_inner()];
                let rows = turning.rows(&centre);
                let (Some(ranges), Some(both)) =
                    (turning.ranges(&segment, &rows, ball, 0.0), rotaries(&machine, rotation, axis))
                else { continue };
                for (range, q) in ranges.iter().zip(both) {
                    for ([far, near], q) in range.iter().zip(q) {
                        // Of one axis the farthest is the nearest: far is the low end of where it may be.
                        let q = unwrap_near(q, 0.5 * (far + near));
                        prop_assert!(far - 1e-6 <= q && q <= near + 1e-6, "{far} {q} {near}");
                        prop_assert!(ball != RotationBall::POINT || near - far < 1e-6);
                    }
                }
            }
        }
    }

    #[test]
    fn whole_turns_are_tried() {
        let limits = Interval::new(-1.0, 1.0);
        assert!(beyond([TAU + 0.5, TAU - 0.5], limits) < 1e-12);
        assert!((beyond([1.5, -0.5], limits) - 0.5).abs() < 1e-12);
        assert!((beyond([PI, PI], limits) - (PI - 1.0)).abs() < 1e-12);
    }
}
