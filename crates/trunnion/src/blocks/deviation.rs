//! How far a control strays from a path between two block ends.

use super::Control;
use super::bend::{Arms, Bend, Rates, arms};
use crate::machine::Kinematics;
use crate::math::angle::{angle_between, great_circle};
use crate::types::{AxisVector, Block, ToolPose};
use nalgebra::{UnitVector3, Vector3, Vector6};

/// Halvings of a stretch between two samples until its bound counts as too large.
const HALVINGS: u32 = 6;

/// A place on a path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) s: f64,
    pub(super) q: AxisVector,
    pub(super) pose: ToolPose,
}

/// What blocks stand for: poses over a parameter.
pub(super) trait Trail: Sync {
    /// Where the path is.
    fn at(&self, s: f64) -> Place;

    /// How much the pose bends over a stretch without a kink, by the share of it.
    fn bend(&self, ends: [&Place; 2]) -> Bend;

    /// Increasing parameters strictly inside a stretch at which it is sampled first; kinks are among them.
    fn inside(&self, ends: [f64; 2]) -> Vec<f64>;
}

/// A path under one control.
pub(super) struct Course<'a, T> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) control: Control,
    pub(super) trail: T,
    pub(super) lever: f64,
}

/// Which pose of the control a place of the path is compared with.
#[derive(Debug, Clone, Copy)]
enum Match {
    /// About the nearest.
    Nearest,
    /// The one at the same share of the block.
    EqualShare,
}

/// A block that is tried.
struct Trial<'a> {
    ends: [&'a Place; 2],
    by: Match,
    /// Largest arms at its ends, for controls that move the axes.
    arms: Arms,
    /// Angle between the tool axes at its ends.
    turn: f64,
    enough: f64,
}

/// A place of the path and its partner.
#[derive(Clone, Copy)]
struct Sample {
    place: Place,
    share: f64,
    /// Distance, tip plus chord of the tool axis times lever \[mm\].
    off: f64,
}

/// A chord of unit vectors up to 1 is shorter than its angle by at most this times its square:
/// `2 asin(c/2) = c (1 + c²/24 + ...) <= c (1 + c²/20)`.
const CHORD: f64 = 0.05;

impl<T: Trail> Course<'_, T> {
    pub(super) fn at(&self, s: f64) -> Place {
        self.trail.at(s)
    }

    /// Upper bound of the deviation between two places; where it exceeds `enough`, just more than that.
    ///
    /// Any matching of places on the path with places of the control gives an upper bound: first
    /// about the nearest, then equal shares of `s`, which is exact for moves that are straight in
    /// the axes or straight by construction, however far they turn.
    pub(super) fn deviation(&self, from: &Place, to: &Place, enough: f64) -> f64 {
        let nearest = self.matched([from, to], enough, Match::Nearest);
        if nearest <= enough {
            return nearest;
        }
        nearest.min(self.matched([from, to], enough, Match::EqualShare))
    }

    fn matched(&self, ends: [&Place; 2], enough: f64, by: Match) -> f64 {
        let chain = self.kinematics.chain();
        let both = ends.map(|end| arms(chain, &end.q));
        let arms = [0, 1].map(|k: usize| both[0][k].max(both[1][k]));
        let turn = angle_between(&ends[0].pose.axis, &ends[1].pose.axis);
        let trial = Trial { ends, by, arms, turn, enough };
        let mut samples = vec![Sample { place: *ends[0], share: 0.0, off: 0.0 }];
        for s in self.trail.inside(ends.map(|end| end.s)) {
            let Some(sample) = self.sample(&trial, s) else { return f64::INFINITY };
            if sample.off > enough {
                return sample.off;
            }
            samples.push(sample);
        }
        samples.push(Sample { place: *ends[1], share: 1.0, off: 0.0 });
        let mut worst = 0.0_f64;
        for pair in samples.windows(2) {
            worst = worst.max(self.between(&trial, [&pair[0], &pair[1]], HALVINGS));
            if worst > enough {
                break;
            }
        }
        worst
    }

    /// Bound over a stretch between two samples, between which the shares run evenly: the difference of
    /// path and control strays from its own chord by at most an eighth of its second derivative.
    fn between(&self, trial: &Trial, ends: [&Sample; 2], halvings: u32) -> f64 {
        let [from, to] = ends;
        let off = from.off.max(to.off);
        let path = self.trail.bend([&from.place, &to.place]);
        let control = self.control_bend(trial, to.share - from.share);
        let bend = path.tip + control.tip + self.lever * (path.axis + control.axis);
        let chord = off + 0.125 * bend;
        let angle = if self.lever > 0.0 { (chord / self.lever).min(2.0) } else { 0.0 };
        let bound = if angle > 1.0 { f64::INFINITY } else { chord * (1.0 + CHORD * angle * angle) };
        if bound <= trial.enough || halvings == 0 {
            return bound;
        }
        let Some(middle) = self.sample(trial, 0.5 * (from.place.s + to.place.s)) else {
            return f64::INFINITY;
        };
        if middle.off > trial.enough {
            return middle.off;
        }
        let first = self.between(trial, [from, &middle], halvings - 1);
        if first > trial.enough {
            return first;
        }
        first.max(self.between(trial, [&middle, to], halvings - 1))
    }

    /// Bend of the control over a part of the block, by the share of that part.
    fn control_bend(&self, trial: &Trial, share: f64) -> Bend {
        let travel = trial.ends[1].q - trial.ends[0].q;
        let square = share * share;
        match self.control {
            Control::Axes => {
                // In a straight move of the axes the arms change most over the whole block.
                let rates = Rates::straight(&travel);
                let whole = Bend::of(self.kinematics.chain(), &rates, trial.arms);
                Bend { tip: whole.tip * square, axis: whole.axis * square }
            }
            Control::RotaryLinear => {
                let turn = travel[3].abs() + travel[4].abs();
                Bend { tip: 0.0, axis: turn * turn * square }
            }
            Control::GreatCircle => Bend { tip: 0.0, axis: trial.turn * trial.turn * square },
        }
    }

    fn sample(&self, trial: &Trial, s: f64) -> Option<Sample> {
        let place = self.trail.at(s);
        let share = self.share(trial, &place)?;
        let moved = self.moved(trial.ends, share)?;
        let tip = (place.pose.tip - moved.tip).norm();
        let axis = (*place.pose.axis - *moved.axis).norm();
        Some(Sample { place, share, off: tip + self.lever * axis })
    }

    /// Share of the block at which the control is compared with a place of the path. For the nearest,
    /// one projection and one correction are enough in blocks that are nearly straight.
    fn share(&self, trial: &Trial, place: &Place) -> Option<f64> {
        let [from, to] = trial.ends;
        let [start, end] = [self.weighted(&from.pose), self.weighted(&to.pose)];
        let chord = end - start;
        let square = chord.norm_squared();
        if matches!(trial.by, Match::EqualShare) || square <= 0.0 {
            return Some((place.s - from.s) / (to.s - from.s));
        }
        let target = self.weighted(&place.pose);
        let first = ((target - start).dot(&chord) / square).clamp(0.0, 1.0);
        let rest = target - self.weighted(&self.moved(trial.ends, first)?);
        Some((first + rest.dot(&chord) / square).clamp(0.0, 1.0))
    }

    /// Where the control is at a share of the block.
    fn moved(&self, ends: [&Place; 2], share: f64) -> Option<ToolPose> {
        let ends = ends.map(|end| (&end.q, &end.pose));
        moved(self.kinematics, self.control, ends, share)
    }

    /// Tip and tool axis as one vector, the axis with the lever \[mm\].
    fn weighted(&self, pose: &ToolPose) -> Vector6<f64> {
        let axis: &UnitVector3<f64> = &pose.axis;
        let [tip, axis]: [Vector3<f64>; 2] = [pose.tip.coords, axis.scale(self.lever)];
        Vector6::new(tip.x, tip.y, tip.z, axis.x, axis.y, axis.z)
    }
}

/// Where a control is at a share of the way between two positions (axes, and the pose they stand for);
/// `None` where a great circle is not defined.
pub fn moved(
    kinematics: &Kinematics,
    control: Control,
    [(q0, from), (q1, to)]: [(&AxisVector, &ToolPose); 2],
    share: f64,
) -> Option<ToolPose> {
    let axes = || kinematics.forward(&q0.lerp(q1, share));
    let tip = from.tip + (to.tip - from.tip) * share;
    let axis = match control {
        Control::Axes => return Some(axes()),
        Control::RotaryLinear => axes().axis,
        Control::GreatCircle => great_circle(&from.axis, &to.axis, share)?,
    };
    Some(ToolPose { tip, axis })
}

/// Bounds on the second derivatives of tip \[mm\] and tool axis, by the share of a block, that a control
/// runs between two positions: no pose in it strays from the chord of its ends by more than an eighth.
pub fn bend(
    kinematics: &Kinematics,
    control: Control,
    ends: [(&AxisVector, &ToolPose); 2],
) -> [f64; 2] {
    let Bend { tip, axis } = bend_of(kinematics, control, ends);
    [tip, axis]
}

/// How a control bends over a whole block.
pub(super) fn block_bend(kinematics: &Kinematics, control: Control, ends: [&Block; 2]) -> Bend {
    bend_of(kinematics, control, ends.map(|end| (&end.q, &end.pose)))
}

fn bend_of(
    kinematics: &Kinematics,
    control: Control,
    [(q0, from), (q1, to)]: [(&AxisVector, &ToolPose); 2],
) -> Bend {
    let travel = q1 - q0;
    match control {
        Control::Axes => {
            let chain = kinematics.chain();
            let both = [q0, q1].map(|q| arms(chain, q));
            let arms = [0, 1].map(|k: usize| both[0][k].max(both[1][k]));
            Bend::of(chain, &Rates::straight(&travel), arms)
        }
        Control::RotaryLinear => {
            let turn = travel[3].abs() + travel[4].abs();
            Bend { tip: 0.0, axis: turn * turn }
        }
        Control::GreatCircle => {
            let turn = angle_between(&from.axis, &to.axis);
            Bend { tip: 0.0, axis: turn * turn }
        }
    }
}
