//! What the machine does when a control runs a program: joints, tool, time.

use crate::machine::{Axis, FIRST_ROTARY, Kinematics, Setup};
use crate::nc::read::{Move, Turning};
use crate::types::TRAVEL_ROUNDING;
use crate::types::{AxisVector, ToolPose};
use crate::verify::error::VerifyError;
use crate::verify::replay::orient::{self, Turned};
use crate::verify::replay::segment::{Course, Segment, on_circle};
use nalgebra::{Isometry3, Matrix3, Point3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// A control's belief about the machine, and the machine.
pub(crate) struct Control {
    /// As the control believes it to be, with the tool length.
    believed: Kinematics,
    /// The same without a tool length, for `G49`.
    bare: Kinematics,
    /// As it is.
    real: Kinematics,
    /// Work offset `G54`.
    offset: Vector3<f64>,
}

impl Control {
    /// A control with one tool.
    pub(crate) fn new(believed: Kinematics, real: Kinematics) -> Result<Self, VerifyError> {
        let setup = Setup { tool_length: 0.0, ..*believed.setup() };
        let bare = Kinematics::new(believed.machine(), &setup);
        // The work offset puts the gauge point on the workpiece origin, rotaries at zero.
        let joints = linear_joints(&bare, &Point3::origin(), &AxisVector::zeros());
        let offset = joints.ok_or(VerifyError::LinearAxes)?;
        Ok(Self { believed, bare, real, offset })
    }

    /// `G54` of the setup \[mm\].
    pub(crate) fn offset(&self) -> Vector3<f64> {
        self.offset
    }

    /// What the tool length adds to Z \[mm\].
    pub(crate) fn length(&self, counts: bool) -> f64 {
        if counts { self.believed.setup().tool_length } else { 0.0 }
    }

    /// Where an offset puts the origin in the table frame \[mm\].
    pub(crate) fn in_table(&self, offset: &Vector3<f64>) -> Vector3<f64> {
        origin(&self.bare, offset)
    }

    /// The kinematics a control reckons with.
    pub(crate) fn reckons(&self, length: bool) -> &Kinematics {
        if length { &self.believed } else { &self.bare }
    }

    /// Joints of a segment at `t` in 0..=1.
    pub(crate) fn joints(&self, segment: &Segment, t: f64) -> Result<AxisVector, VerifyError> {
        let [from, to] = segment.joints;
        let mut q = from + (to - from) * t;
        let linear = match &segment.course {
            Course::Tip { ends: [from, to], length } => {
                self.linear_joints(&(from + (to - from) * t), &q, *length)?
            }
            Course::Circle { ends } if t > 0.0 && t < 1.0 => {
                let pose = on_circle(ends, t, segment.line)?;
                let anywhere = |_: [f64; 2]| false;
                let turned = orient::turned(&self.real, &pose.axis, (&q, segment.line), &anywhere)?;
                q.fixed_rows_mut::<2>(FIRST_ROTARY).copy_from_slice(&turned.rotaries);
                linear_joints(&self.real, &pose.tip, &q).ok_or(VerifyError::LinearAxes)?
            }
            _ => return Ok(q),
        };
        q.fixed_rows_mut::<3>(0).copy_from(&linear);
        Ok(q)
    }

    /// The tool as it really stands at `t` in 0..=1.
    pub(crate) fn pose(&self, segment: &Segment, t: f64) -> Result<ToolPose, VerifyError> {
        Ok(self.real.forward(&self.joints(segment, t)?))
    }

    /// Largest distance between the tip a control reckons with and the real one, up to a constant
    /// shift \[mm\]: what tool length and origin can differ by.
    pub(crate) fn error_lever(&self, length: bool) -> f64 {
        let [believed, real] = [self.reckons(length).setup(), self.real.setup()];
        (believed.tool_length - real.tool_length).abs()
            + 2.0 * (believed.origin - real.origin).norm()
    }

    /// Largest distance of the tip from a rotary axis at either end: half the way to where it is
    /// half a turn further.
    pub(crate) fn lever(&self, segment: &Segment) -> f64 {
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
    pub(crate) fn rapid(&self) -> AxisVector {
        self.real.machine().vector(|axis| axis.rapid)
    }

    /// The real machine.
    pub(crate) fn real(&self) -> &Kinematics {
        &self.real
    }

    /// A direction of the table frame in the workpiece frame.
    fn in_workpiece(&self, axis: &UnitVector3<f64>) -> UnitVector3<f64> {
        self.believed.setup().rotation.inverse() * axis
    }

    pub(crate) fn linear_joints(
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

    /// What words are for the joints: positions, or the tip and the rotaries.
    pub(crate) fn words(&self, q: &AxisVector, counted: &Counted) -> AxisVector {
        match counted {
            Counted::From(shift) => q - shift,
            Counted::Tip(frame) => {
                let tip = frame.read(&self.tip(q, frame.length));
                AxisVector::new(tip.x, tip.y, tip.z, q[3], q[4])
            }
        }
    }

    /// Where a straight block leads to, and how.
    pub(crate) fn target(
        &self,
        q: &AxisVector,
        (step, counted): (&Move, &Counted),
    ) -> Result<(AxisVector, Course, Option<Turned>), VerifyError> {
        let turned = match step.axis {
            Some(axis) => Some(self.turned(&axis, (q, step), counted)?),
            None => None,
        };
        let put = |mut words: AxisVector| {
            if let Some(Turned { rotaries, .. }) = turned {
                words.fixed_rows_mut::<2>(FIRST_ROTARY).copy_from_slice(&rotaries);
            }
            words
        };
        let (to, course) = match counted {
            Counted::From(shift) => (put(apply(*q, step, shift)), Course::Joints),
            Counted::Tip(frame) => {
                let words = apply(self.words(q, counted), step, &AxisVector::zeros());
                self.to_tip(q, (&put(words), step.turning), frame)?
            }
        };
        Ok((to, course, turned))
    }

    /// The rotaries for a direction in the table frame. Where the tip is told, X, Y and Z are to be in their travel
    /// there.
    pub(crate) fn turned(
        &self,
        axis: &UnitVector3<f64>,
        (near, step): (&AxisVector, &Move),
        counted: &Counted,
    ) -> Result<Turned, VerifyError> {
        let slides = |rotaries: [f64; 2]| {
            let Counted::Tip(frame) = counted else { return true };
            let mut words = apply(self.words(near, counted), step, &AxisVector::zeros());
            words.fixed_rows_mut::<2>(FIRST_ROTARY).copy_from_slice(&rotaries);
            let tip = frame.place(&Point3::new(words[0], words[1], words[2]));
            let linear = self.linear_joints(&tip, &words, frame.length);
            let inside = |(value, axis): (&f64, &Axis)| {
                axis.limits[0] - TRAVEL_ROUNDING <= *value
                    && *value <= axis.limits[1] + TRAVEL_ROUNDING
            };
            linear.is_ok_and(|linear| linear.iter().zip(&self.real.machine().axes).all(inside))
        };
        orient::turned(&self.real, &self.in_workpiece(axis), (near, step.line), &slides)
    }

    /// To the tip and the rotaries that words say.
    fn to_tip(
        &self,
        q: &AxisVector,
        (words, turning): (&AxisVector, Turning),
        frame: &TipFrame,
    ) -> Result<(AxisVector, Course), VerifyError> {
        let (mut there, length) = (*words, frame.length);
        let from = self.tip(q, length);
        let to = frame.place(&Point3::new(words[0], words[1], words[2]));
        let linear = self.linear_joints(&to, &there, length)?;
        there.fixed_rows_mut::<3>(0).copy_from(&linear);
        let course = match turning {
            Turning::Rotary => Course::Tip { ends: [from, to], length },
            Turning::GreatCircle => {
                Course::Circle { ends: [q, &there].map(|q| self.real.forward(q)) }
            }
        };
        Ok((there, course))
    }
}

/// What words count from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Counted {
    /// Joints less these.
    From(AxisVector),
    /// The tip, and the rotaries.
    Tip(TipFrame),
}

/// Coordinates of the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TipFrame {
    /// Whether the tool length counts.
    pub(crate) length: bool,
    /// From the coordinates of X Y Z to the table frame; `None` where they are that.
    pub(crate) table_from_words: Option<Isometry3<f64>>,
}

impl TipFrame {
    /// From the words to the table frame.
    pub(crate) fn place(&self, words: &Point3<f64>) -> Point3<f64> {
        self.table_from_words.map_or(*words, |frame| frame * words)
    }

    /// And back.
    fn read(&self, place: &Point3<f64>) -> Point3<f64> {
        self.table_from_words.map_or(*place, |frame| frame.inverse_transform_point(place))
    }
}

/// Coordinates with a block's words put in; `shift` is what words are short of them.
pub(crate) fn apply(mut q: AxisVector, step: &Move, shift: &AxisVector) -> AxisVector {
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

/// Where an offset puts the origin in the table frame: the gauge point, with the rotaries at zero.
pub(crate) fn origin(bare: &Kinematics, joints: &Vector3<f64>) -> Vector3<f64> {
    let q = crate::types::AxisVector::new(joints.x, joints.y, joints.z, 0.0, 0.0);
    let place: Point3<f64> = bare.forward(&q).tip;
    bare.setup().rotation * place.coords
}
