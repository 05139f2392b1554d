//! What the machine does when a control runs a program: joints, tool, time.

use super::{Input, VerifyError};
use crate::machine::{Kinematics, Setup};
use crate::math::angle::{angle_between, great_circle};
use crate::nc::read::{Frame, Move, Turning};
use crate::types::{AxisVector, ToolPose};
use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// One move of the machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// Line of the program.
    pub(super) line: u32,
    /// Axes at both ends.
    pub(super) joints: [AxisVector; 2],
    /// How the axes get from one end to the other.
    pub(super) course: Course,
    /// Time \[s\].
    pub(super) duration: f64,
    /// Of which block it is.
    pub(super) block: Block,
    /// Run at rapid speed: its time is an estimate.
    pub(super) rapid: bool,
}

/// The block that a move is a part of, as the chords of an arc are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    /// Time of all of it \[s\].
    pub(super) duration: f64,
    /// Angle of an arc \[rad\].
    pub(super) sweep: f64,
    /// It begins with this move.
    pub(super) begins: bool,
    /// It ends with this move.
    pub(super) ends: bool,
}

impl Block {
    /// A block of one move.
    pub(super) fn of_one(duration: f64) -> Self {
        Self { duration, sweep: 0.0, begins: true, ends: true }
    }
}

/// What is linear in a move.
#[derive(Debug, Clone, Copy)]
pub(super) enum Course {
    /// All axes.
    Joints,
    /// The rotaries, and the tip in the table frame as the control knows it.
    Tip {
        /// Tip at both ends \[mm\].
        ends: [Point3<f64>; 2],
        /// The tool length counts.
        length: bool,
    },
    /// The tip, and the tool axis on the great circle, in the workpiece frame.
    Circle {
        /// The tool at both ends.
        ends: [ToolPose; 2],
    },
    /// Nothing moves.
    Rest,
    /// After a tool vector, a rapid move of axes whose places are not known.
    Unknown,
}

impl Segment {
    /// Whether its way is not known.
    pub(super) fn is_unknown(&self) -> bool {
        matches!(self.course, Course::Unknown)
    }
}

/// What carries the tool out: a machine under its control, or the cutter locations themselves.
pub(super) enum Mover<'a> {
    /// A machine.
    Machine(&'a Control<'a>),
    /// Tip straight, tool axis on the great circle from location to location.
    Locations,
}

/// What bounds how far a move is from a quadratic.
#[derive(Debug, Clone, Copy)]
pub(super) struct Swing {
    /// Sum of all turns \[rad\].
    pub(super) turn: f64,
    /// Largest distance of the tip from what turns it \[mm\].
    pub(super) lever: f64,
    /// Travel of the linear axes while it is turned \[mm\].
    pub(super) travel: f64,
}

impl Mover<'_> {
    /// The tool as it really stands at `t` in 0..=1.
    pub(super) fn pose(&self, segment: &Segment, t: f64) -> Result<ToolPose, VerifyError> {
        match (self, &segment.course) {
            (_, Course::Circle { ends }) => on_circle(ends, t, segment.line),
            (Self::Machine(control), _) => control.pose(segment, t),
            (Self::Locations, _) => Err(VerifyError::NoMotion),
        }
    }

    /// A rapid move as each axis runs it at its own speed: straight from where one axis arrives to where the
    /// next one does. Nothing for other moves, and for cutter locations.
    pub(super) fn dog_leg(&self, segment: &Segment) -> Vec<Segment> {
        let (Self::Machine(control), true) = (self, segment.rapid) else { return Vec::new() };
        let [from, to] = segment.joints;
        let change = to - from;
        let times = change.abs().component_div(&control.rapid());
        let mut stops: Vec<f64> = times.iter().copied().filter(|time| *time > 0.0).collect();
        stops.sort_by(f64::total_cmp);
        stops.dedup();
        let at = |time: f64| {
            let share = times.map(|whole| if whole > time { time / whole } else { 1.0 });
            from + change.component_mul(&share)
        };
        let mut before = (0.0, from);
        let legs = stops.into_iter().map(|time| {
            let (start, joints) = std::mem::replace(&mut before, (time, at(time)));
            let (joints, duration) = ([joints, before.1], time - start);
            let block = Block::of_one(duration);
            Segment { joints, duration, block, course: Course::Joints, ..*segment }
        });
        let legs: Vec<Segment> = legs.collect();
        // One leg of all axes is the move itself, unless the tip was to run straight.
        if legs.len() == 1 && matches!(segment.course, Course::Joints) { Vec::new() } else { legs }
    }

    /// What bounds a segment's third derivatives; `None` if nothing moves.
    pub(super) fn swing(&self, segment: &Segment) -> Option<Swing> {
        let change = segment.joints[1] - segment.joints[0];
        let turn = change[3].abs() + change[4].abs();
        match (self, &segment.course) {
            (_, Course::Circle { ends: [from, to] }) => {
                let turn = angle_between(&from.axis, &to.axis);
                Some(Swing { turn, lever: 0.0, travel: 0.0 })
            }
            (Self::Machine(control), Course::Tip { length, .. }) => {
                Some(Swing { turn, lever: control.error_lever(*length), travel: 0.0 })
            }
            (Self::Machine(control), Course::Joints) => {
                let travel = change.fixed_rows::<3>(0).lp_norm(1);
                Some(Swing { turn, lever: control.lever(segment) + travel, travel })
            }
            (_, Course::Rest | Course::Unknown) | (Self::Locations, _) => None,
        }
    }
}

/// Between two poses.
fn on_circle([from, to]: &[ToolPose; 2], t: f64, line: u32) -> Result<ToolPose, VerifyError> {
    let axis = great_circle(&from.axis, &to.axis, t).ok_or(VerifyError::TurnsTooFar { line })?;
    Ok(ToolPose { tip: from.tip + (to.tip - from.tip) * t, axis })
}

/// A control's belief about the machine, and the machine.
pub(super) struct Control<'a> {
    /// As the control believes it to be, with the tool length.
    believed: &'a Kinematics,
    /// The same without a tool length, for `G49`.
    bare: Kinematics,
    /// As it is.
    real: &'a Kinematics,
    /// Work offset `G54`.
    offset: Vector3<f64>,
}

impl<'a> Control<'a> {
    /// The control of a job.
    pub(super) fn new(input: &Input<'a>) -> Result<Self, VerifyError> {
        let believed = input.believed;
        let setup = Setup { tool_length: 0.0, ..*believed.setup() };
        let bare = Kinematics::new(believed.machine(), &setup);
        // The work offset puts the gauge point on the workpiece origin, rotaries at zero.
        let joints = linear_joints(&bare, &Point3::origin(), &AxisVector::zeros());
        let offset = joints.ok_or(VerifyError::LinearAxes)?;
        Ok(Self { believed, bare, real: input.real, offset })
    }

    /// The kinematics a control reckons with.
    pub(super) fn reckons(&self, length: bool) -> &Kinematics {
        if length { self.believed } else { &self.bare }
    }

    /// Joints of a segment at `t` in 0..=1.
    pub(super) fn joints(&self, segment: &Segment, t: f64) -> Result<AxisVector, VerifyError> {
        let [from, to] = segment.joints;
        let mut q = from + (to - from) * t;
        if let Course::Tip { ends: [from, to], length } = segment.course {
            let tip = from + (to - from) * t;
            let linear = self.linear_joints(&tip, &q, length)?;
            q.fixed_rows_mut::<3>(0).copy_from(&linear);
        }
        Ok(q)
    }

    /// The tool as it really stands at `t` in 0..=1.
    pub(super) fn pose(&self, segment: &Segment, t: f64) -> Result<ToolPose, VerifyError> {
        Ok(self.real.forward(&self.joints(segment, t)?))
    }

    /// Largest distance between the tip a control reckons with and the real one, up to a constant
    /// shift \[mm\]: what tool length and origin can differ by.
    pub(super) fn error_lever(&self, length: bool) -> f64 {
        let [believed, real] = [self.reckons(length).setup(), self.real.setup()];
        (believed.tool_length - real.tool_length).abs()
            + 2.0 * (believed.origin - real.origin).norm()
    }

    /// Largest distance of the tip from a rotary axis at either end: half the way to where it is
    /// half a turn further.
    fn lever(&self, segment: &Segment) -> f64 {
        let forward = |q: &AxisVector| self.real.forward(q).tip;
        let mut largest = 0.0f64;
        for q in &segment.joints {
            for axis in [3, 4] {
                let mut opposite = *q;
                opposite[axis] += PI;
                largest = largest.max(0.5 * (forward(&opposite) - forward(q)).norm());
            }
        }
        largest
    }

    /// Rapid speeds of the axes.
    pub(super) fn rapid(&self) -> AxisVector {
        self.real.machine().vector(|axis| axis.rapid)
    }

    /// The real machine.
    pub(super) fn real(&self) -> &Kinematics {
        self.real
    }

    /// A direction of the table frame in the workpiece frame.
    pub(super) fn in_workpiece(&self, axis: &UnitVector3<f64>) -> UnitVector3<f64> {
        self.believed.setup().rotation.inverse() * axis
    }

    /// What X Y Z read under TCP where a tool stands: its tip in the table frame, or where the spindle is while the
    /// tool length does not count.
    pub(super) fn reading(&self, pose: &ToolPose, length: bool) -> Point3<f64> {
        self.believed.setup().rotation * (pose.tip + pose.axis.into_inner() * self.short(length))
    }

    /// The tool where X Y Z read this, with its axis in the workpiece frame; the machine taken to be as believed.
    pub(super) fn tool_at(
        &self,
        reading: &Point3<f64>,
        axis: UnitVector3<f64>,
        length: bool,
    ) -> ToolPose {
        let place = self.believed.setup().rotation.inverse() * reading;
        ToolPose { tip: place - axis.into_inner() * self.short(length), axis }
    }

    /// From the tip to the point that X Y Z mean \[mm\].
    fn short(&self, length: bool) -> f64 {
        if length { 0.0 } else { self.believed.setup().tool_length }
    }

    pub(super) fn linear_joints(
        &self,
        tip: &Point3<f64>,
        q: &AxisVector,
        length: bool,
    ) -> Result<Vector3<f64>, VerifyError> {
        let reckons = self.reckons(length);
        let tip = reckons.setup().rotation.inverse() * tip;
        linear_joints(reckons, &tip, q).ok_or(VerifyError::LinearAxes)
    }

    /// Tip in the table frame as the control reckons it.
    fn tip(&self, q: &AxisVector, length: bool) -> Point3<f64> {
        let reckons = self.reckons(length);
        reckons.setup().rotation * reckons.forward(q).tip
    }

    /// What words of a frame are for the joints: positions, or the tip and the rotaries.
    pub(super) fn words(
        &self,
        q: &AxisVector,
        (frame, line): (Frame, u32),
    ) -> Result<AxisVector, VerifyError> {
        Ok(match self.counted(frame, line)? {
            Counted::From(shift) => q - shift,
            Counted::Tip(length) => {
                let tip = self.tip(q, length);
                AxisVector::new(tip.x, tip.y, tip.z, q[3], q[4])
            }
        })
    }

    /// Where a straight block leads to, and how.
    pub(super) fn target(
        &self,
        q: &AxisVector,
        step: &Move,
    ) -> Result<(AxisVector, Course), VerifyError> {
        match self.counted(step.frame, step.line)? {
            Counted::From(shift) => Ok((apply(*q, step, &shift), Course::Joints)),
            Counted::Tip(length) => self.to_tip(q, step, length),
        }
    }

    fn to_tip(
        &self,
        q: &AxisVector,
        step: &Move,
        length: bool,
    ) -> Result<(AxisVector, Course), VerifyError> {
        let from = self.tip(q, length);
        let here = AxisVector::new(from.x, from.y, from.z, q[3], q[4]);
        let mut there = apply(here, step, &AxisVector::zeros());
        let to = Point3::new(there[0], there[1], there[2]);
        let linear = self.linear_joints(&to, &there, length)?;
        there.fixed_rows_mut::<3>(0).copy_from(&linear);
        let course = match step.turning {
            Turning::Rotary => Course::Tip { ends: [from, to], length },
            Turning::GreatCircle => {
                Course::Circle { ends: [q, &there].map(|q| self.real.forward(q)) }
            }
        };
        Ok((there, course))
    }

    /// What the words of a frame count from.
    pub(super) fn counted(&self, frame: Frame, line: u32) -> Result<Counted, VerifyError> {
        match frame {
            Frame::Machine => Ok(Counted::From(AxisVector::zeros())),
            Frame::Work { offset: number @ 1.., .. } => {
                Err(VerifyError::WorkOffset { line, number: 54 + number })
            }
            Frame::Work { length, tcp: true, .. } => Ok(Counted::Tip(length)),
            Frame::Work { length, .. } => {
                let z = if length { self.believed.setup().tool_length } else { 0.0 };
                let shift = self.offset + Vector3::z() * z;
                Ok(Counted::From(AxisVector::new(shift.x, shift.y, shift.z, 0.0, 0.0)))
            }
        }
    }
}

/// What words count from.
pub(super) enum Counted {
    /// Joints less these.
    From(AxisVector),
    /// The tip in the table frame, and the rotaries; whether the tool length counts.
    Tip(bool),
}

/// Coordinates with a block's words put in; `shift` is what words are short of them.
pub(super) fn apply(mut q: AxisVector, step: &Move, shift: &AxisVector) -> AxisVector {
    for ((value, word), shift) in q.iter_mut().zip(step.words).zip(shift.iter()) {
        match word {
            Some(word) if step.incremental => *value += word,
            Some(word) => *value = word + shift,
            None => {}
        }
    }
    q
}

/// Linear axes that bring the tip (workpiece frame) to `tip` with the rotaries of `q`: the forward
/// map is affine in them, so four evaluations and a 3 x 3 solve give them.
fn linear_joints(
    kinematics: &Kinematics,
    tip: &Point3<f64>,
    q: &AxisVector,
) -> Option<Vector3<f64>> {
    let at = |x: f64, y: f64, z: f64| kinematics.forward(&AxisVector::new(x, y, z, q[3], q[4])).tip;
    let start = at(0.0, 0.0, 0.0);
    let columns = [at(1.0, 0.0, 0.0) - start, at(0.0, 1.0, 0.0) - start, at(0.0, 0.0, 1.0) - start];
    Matrix3::from_columns(&columns).lu().solve(&(tip - start))
}
