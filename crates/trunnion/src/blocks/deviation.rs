//! Deviation of a control from a path between two block ends.

use super::bend::{AxisRates, PoseBend, RotaryArms, arms};
use super::options::BlockInterpolation;
use crate::machine::Kinematics;
use crate::math::angle::{angle_between, great_circle};
use crate::types::{AxisVector, Block, ToolPose};
use nalgebra::{UnitVector3, Vector3, Vector6};

/// Halvings of a segment between two samples until its bound counts as too large.
const HALVINGS: u32 = 6;

/// Point on a path: parameter, axis positions and pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathPoint {
    pub(super) s: f64,
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
}

/// Path that blocks stand for: poses over a parameter.
pub(super) trait PosePath: Sync {
    /// Returns the point of the path at `s`.
    fn at(&self, s: f64) -> PathPoint;

    /// Bounds the second derivative of the pose over a segment without a kink, by the share of it.
    fn bend(&self, ends: [&PathPoint; 2]) -> PoseBend;

    /// Returns increasing parameters strictly inside a segment, at which it is sampled first. Kinks are
    /// among them.
    fn inside(&self, ends: [f64; 2]) -> Vec<f64>;
}

/// A path under one control.
pub(super) struct ControlledPath<'a, T> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) control: BlockInterpolation,
    pub(super) poses: T,
    pub(super) lever: f64,
}

/// Pose of the control that a point of the path is compared with.
#[derive(Debug, Clone, Copy)]
enum PoseMatch {
    /// Approximately the nearest pose.
    Nearest,
    /// Pose at the same share of the block.
    EqualShare,
}

/// Block that is tried.
struct BlockTrial<'a> {
    ends: [&'a PathPoint; 2],
    by: PoseMatch,
    /// Largest arms at its ends, for controls that move the axes.
    arms: RotaryArms,
    /// Angle between the tool axes at its ends \[rad\].
    turn: f64,
    enough: f64,
}

/// Point of the path, with the share of the block that it is compared with.
#[derive(Clone, Copy)]
struct BlockSample {
    point: PathPoint,
    share: f64,
    /// Distance, tip plus chord of the tool axis times lever \[mm\].
    off: f64,
}

/// A chord of unit vectors up to 1 is shorter than its angle by at most this times its square:
/// `2 asin(c/2) = c (1 + c²/24 + ...) <= c (1 + c²/20)`.
const CHORD: f64 = 0.05;

impl<T: PosePath> ControlledPath<'_, T> {
    pub(super) fn at(&self, s: f64) -> PathPoint {
        self.poses.at(s)
    }

    /// Returns an upper bound of the deviation between two points of the path; if that exceeds
    /// `enough`, some value above it.
    ///
    /// Any matching of points of the path with poses of the control gives an upper bound: first
    /// the approximately nearest ones, then equal shares of `s`, which is exact for moves that are
    /// straight in the axes or straight by construction, however far they turn.
    pub(super) fn deviation(&self, from: &PathPoint, to: &PathPoint, enough: f64) -> f64 {
        let nearest = self.matched([from, to], enough, PoseMatch::Nearest);
        if nearest <= enough {
            return nearest;
        }
        nearest.min(self.matched([from, to], enough, PoseMatch::EqualShare))
    }

    fn matched(&self, ends: [&PathPoint; 2], enough: f64, by: PoseMatch) -> f64 {
        let chain = self.kinematics.chain();
        let both = ends.map(|end| arms(chain, &end.q));
        // The larger arm of both ends: a move in between can only add to it.
        let arms = [0, 1].map(|k: usize| both[0][k].max(both[1][k]));
        let turn = angle_between(&ends[0].pose.axis, &ends[1].pose.axis);
        let trial = BlockTrial { ends, by, arms, turn, enough };
        let mut samples = vec![BlockSample { point: *ends[0], share: 0.0, off: 0.0 }];
        for s in self.poses.inside(ends.map(|end| end.s)) {
            let Some(sample) = self.sample(&trial, s) else { return f64::INFINITY };
            // A sample beyond the limit decides at once; no bound is needed.
            if sample.off > enough {
                return sample.off;
            }
            samples.push(sample);
        }
        samples.push(BlockSample { point: *ends[1], share: 1.0, off: 0.0 });
        let mut worst = 0.0_f64;
        for pair in samples.windows(2) {
            worst = worst.max(self.between(&trial, [&pair[0], &pair[1]], HALVINGS));
            if worst > enough {
                break;
            }
        }
        worst
    }

    /// Bounds the deviation over a segment between two samples, between which the shares run evenly:
    /// the difference of path and control leaves its own chord by at most an eighth of its second
    /// derivative.
    fn between(&self, trial: &BlockTrial, ends: [&BlockSample; 2], halvings: u32) -> f64 {
        let [from, to] = ends;
        // The difference of path and control is within `off` of 0 at both ends, and strays from its
        // chord by |f''| / 8 at most; an axis vector counts with the lever.
        let off = from.off.max(to.off);
        let path = self.poses.bend([&from.point, &to.point]);
        let control = self.control_bend(trial, to.share - from.share);
        let bend = path.tip + control.tip + self.lever * (path.axis + control.axis);
        let chord = off + 0.125 * bend;
        // So far the axes are compared by the chord of unit vectors; the angle is longer by CHORD
        // times its square.
        let angle = if self.lever > 0.0 { (chord / self.lever).min(2.0) } else { 0.0 };
        let bound = if angle > 1.0 { f64::INFINITY } else { chord * (1.0 + CHORD * angle * angle) };
        if bound <= trial.enough || halvings == 0 {
            return bound;
        }
        let Some(middle) = self.sample(trial, 0.5 * (from.point.s + to.point.s)) else {
            return f64::INFINITY;
        };
        if middle.off > trial.enough {
            return middle.off;
        }
        // Halving the stretch divides the second-order term by four.
        let first = self.between(trial, [from, &middle], halvings - 1);
        if first > trial.enough {
            return first;
        }
        first.max(self.between(trial, [&middle, to], halvings - 1))
    }

    /// Returns the bend of the control over a part of the block, by the share of that part.
    fn control_bend(&self, trial: &BlockTrial, share: f64) -> PoseBend {
        let travel = trial.ends[1].q - trial.ends[0].q;
        // Second derivatives by the share of a part scale with the square of its length.
        let square = share * share;
        match self.control {
            BlockInterpolation::Axes => {
                // In a straight move of the axes the arms change most over the whole block.
                let rates = AxisRates::straight(&travel);
                let whole = PoseBend::of(self.kinematics.chain(), &rates, trial.arms);
                PoseBend { tip: whole.tip * square, axis: whole.axis * square }
            }
            BlockInterpolation::RotaryLinear => {
                // R1(q1) R2(q2) d, both rates constant: |d''| <= (|q1'| + |q2'|)^2.
                let turn = travel[3].abs() + travel[4].abs();
                PoseBend { tip: 0.0, axis: turn * turn * square }
            }
            BlockInterpolation::GreatCircle => {
                PoseBend { tip: 0.0, axis: trial.turn * trial.turn * square }
            }
        }
    }

    fn sample(&self, trial: &BlockTrial, s: f64) -> Option<BlockSample> {
        let point = self.poses.at(s);
        let share = self.share(trial, &point)?;
        let moved = self.moved(trial.ends, share)?;
        let tip = (point.pose.tip - moved.tip).norm();
        let axis = (*point.pose.axis - *moved.axis).norm();
        Some(BlockSample { point, share, off: tip + self.lever * axis })
    }

    /// Returns the share of the block at which the control is compared with a point of the path. For the
    /// nearest pose, one projection and one correction are enough in blocks that are nearly straight.
    fn share(&self, trial: &BlockTrial, point: &PathPoint) -> Option<f64> {
        let [from, to] = trial.ends;
        let [start, end] = [self.weighted(&from.pose), self.weighted(&to.pose)];
        let chord = end - start;
        let square = chord.norm_squared();
        if matches!(trial.by, PoseMatch::EqualShare) || square <= 0.0 {
            return Some((point.s - from.s) / (to.s - from.s));
        }
        let target = self.weighted(&point.pose);
        // Foot of the perpendicular on the chord between the block's ends.
        let first = ((target - start).dot(&chord) / square).clamp(0.0, 1.0);
        // One Newton correction with the chord as tangent: the curve leaves it by little in blocks
        // within tolerance.
        let rest = target - self.weighted(&self.moved(trial.ends, first)?);
        Some((first + rest.dot(&chord) / square).clamp(0.0, 1.0))
    }

    /// Returns the pose of the control at a share of the block.
    fn moved(&self, ends: [&PathPoint; 2], share: f64) -> Option<ToolPose> {
        let ends = ends.map(|end| BlockEnd { q: &end.q, pose: &end.pose });
        moved(self.kinematics, self.control, ends, share)
    }

    /// Returns tip and tool axis as one vector, the axis times the lever \[mm\].
    fn weighted(&self, pose: &ToolPose) -> Vector6<f64> {
        let axis: &UnitVector3<f64> = &pose.axis;
        let [tip, axis]: [Vector3<f64>; 2] = [pose.tip.coords, axis.scale(self.lever)];
        Vector6::new(tip.x, tip.y, tip.z, axis.x, axis.y, axis.z)
    }
}

/// Axis positions at one end of a block, and the pose they stand for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockEnd<'a> {
    /// Axis positions.
    pub q: &'a AxisVector,
    /// Tool pose there.
    pub pose: &'a ToolPose,
}

impl<'a> BlockEnd<'a> {
    /// Creates the end at the axis positions `q`, which stand for `pose`.
    pub const fn new(q: &'a AxisVector, pose: &'a ToolPose) -> Self {
        Self { q, pose }
    }
}

/// Returns the pose of a control at a share of a block, 0 at its start and 1 at its end; `None` if the tool axes at
/// its ends are opposite, so that no great circle is defined.
pub fn moved(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    [from, to]: [BlockEnd<'_>; 2],
    share: f64,
) -> Option<ToolPose> {
    // Axes run linearly by the share; what of their pose the control takes depends on its kind.
    let axes = || kinematics.forward(&from.q.lerp(to.q, share));
    let tip = from.pose.tip + (to.pose.tip - from.pose.tip) * share;
    let axis = match control {
        BlockInterpolation::Axes => return Some(axes()),
        BlockInterpolation::RotaryLinear => axes().axis,
        BlockInterpolation::GreatCircle => great_circle(&from.pose.axis, &to.pose.axis, share)?,
    };
    Some(ToolPose { tip, axis })
}

/// Bounds the second derivatives of tip \[mm\] and tool axis, by the share of a block that a control runs between
/// two positions: no pose in it leaves the chord of its ends by more than an eighth of them.
pub fn bend(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    ends: [BlockEnd<'_>; 2],
) -> [f64; 2] {
    let PoseBend { tip, axis } = bend_of(kinematics, control, ends);
    [tip, axis]
}

/// Returns the bend of a control over a whole block.
pub(super) fn block_bend(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    ends: [&Block; 2],
) -> PoseBend {
    bend_of(kinematics, control, ends.map(|end| BlockEnd { q: &end.q, pose: &end.pose }))
}

fn bend_of(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    [from, to]: [BlockEnd<'_>; 2],
) -> PoseBend {
    let travel = to.q - from.q;
    match control {
        BlockInterpolation::Axes => {
            let chain = kinematics.chain();
            let both = [from.q, to.q].map(|q| arms(chain, q));
            let arms = [0, 1].map(|k: usize| both[0][k].max(both[1][k]));
            PoseBend::of(chain, &AxisRates::straight(&travel), arms)
        }
        BlockInterpolation::RotaryLinear => {
            let turn = travel[3].abs() + travel[4].abs();
            PoseBend { tip: 0.0, axis: turn * turn }
        }
        BlockInterpolation::GreatCircle => {
            let turn = angle_between(&from.pose.axis, &to.pose.axis);
            PoseBend { tip: 0.0, axis: turn * turn }
        }
    }
}
