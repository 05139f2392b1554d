//! Axis positions and tool poses while a control runs a program.

use crate::machine::{Axis, FIRST_ROTARY, Kinematics, RotaryPair, Setup};
use crate::nc::control::{
    BlockEnd, ControlKinematics, RotaryRequest, TipTarget, ToolLength, WordFrame, block_end,
};
use crate::nc::read::{Move, Turning};
use crate::types::TRAVEL_ROUNDING;
use crate::types::{AxisVector, ToolPose};
use crate::verify::error::VerifyError;
use crate::verify::replay::orient::{self, RotaryBranch, TurnRequest, Turned};
use crate::verify::replay::segment::{Course, Segment, on_circle};
use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};
use std::f64::consts::PI;

/// A control: its model of the machine, and the machine as it is.
pub(crate) struct Control {
    /// The control's model, with the tool length.
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

    /// Length of the tool in the spindle \[mm\].
    pub(crate) fn tool_length(&self) -> f64 {
        self.believed.setup().tool_length
    }

    /// Returns the origin of a work offset in the table frame \[mm\].
    pub(crate) fn in_table(&self, offset: &Vector3<f64>) -> Vector3<f64> {
        origin(&self.bare, offset)
    }

    /// The kinematics that the control computes with.
    pub(crate) fn model(&self, length: ToolLength) -> &Kinematics {
        match length {
            ToolLength::Active => &self.believed,
            ToolLength::Cancelled => &self.bare,
        }
    }

    /// Joints of a segment at `t` in 0..=1.
    pub(crate) fn joints(&self, segment: &Segment, t: f64) -> Result<AxisVector, VerifyError> {
        let [from, to] = segment.joints;
        let mut q = from + (to - from) * t;
        // With tool-centre-point control the tip moves straight in the table frame, and the linear axes
        // follow it while the rotaries turn.
        let linear = match &segment.course {
            Course::Tip { ends: [from, to], length } => {
                let point = from + (to - from) * t;
                self.linear_axes(&TipTarget { point, length: *length }, &q, segment.line)?
            }
            Course::Circle { ends } if t > 0.0 && t < 1.0 => {
                let pose = on_circle(ends, t, segment.line)?;
                // Between its ends a great circle takes the rotaries nearest to the chord of both ends, in their solution.
                let anywhere = |_: [f64; 2]| true;
                let request = TurnRequest {
                    direction: pose.axis,
                    near: &q,
                    keeps: self.shared_branch(segment),
                    line: segment.line,
                };
                let turned = orient::turned(&self.real, &request, &anywhere)?;
                q.fixed_rows_mut::<2>(FIRST_ROTARY).copy_from_slice(&turned.rotaries);
                linear_joints(&self.real, &pose.tip, &q).ok_or(VerifyError::LinearAxes)?
            }
            _ => return Ok(q),
        };
        q.fixed_rows_mut::<3>(0).copy_from(&linear);
        Ok(q)
    }

    /// Returns the solution of the rotaries at both ends of a segment, if it is the same.
    fn shared_branch(&self, segment: &Segment) -> Option<RotaryBranch> {
        let [from, to] = segment.joints.map(|joints| orient::branch_at(&self.real, &joints));
        // Where the tool stands along the first rotary's axis, both solutions are the same.
        match (from, to) {
            (Some(from), Some(to)) => (from == to).then_some(from),
            (one, None) | (None, one) => one,
        }
    }

    /// Returns the pose of the real tool at `t` in 0..=1.
    pub(crate) fn pose(&self, segment: &Segment, t: f64) -> Result<ToolPose, VerifyError> {
        Ok(self.real.forward(&self.joints(segment, t)?))
    }

    /// Bounds how far the tip of the control's model is from the real one, up to a constant shift \[mm\]:
    /// the difference of tool lengths and origins.
    pub(crate) fn error_lever(&self, length: ToolLength) -> f64 {
        let [believed, real] = [self.model(length).setup(), self.real.setup()];
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
                // The tip moves by twice its distance from the axis.
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

    /// Returns the end of a straight block, and the interpolation up to there.
    pub(crate) fn target(
        &self,
        q: &AxisVector,
        block: &Move,
        frame: &WordFrame,
    ) -> Result<(BlockEnd<Turned>, Course), VerifyError> {
        let end = block_end(self, q, block, frame)?;
        let course = match (end.tip, block.turning) {
            (None, _) => Course::Joints,
            (Some(TipTarget { point, length }), Turning::Rotary) => {
                Course::Tip { ends: [self.tip(q, length), point], length }
            }
            (Some(_), Turning::GreatCircle) => {
                Course::Circle { ends: [q, &end.axes].map(|q| self.real.forward(q)) }
            }
        };
        Ok((end, course))
    }

    /// X, Y, Z are in their travel where the tip is at its goal, with these rotaries.
    fn reaches(&self, target: &TipTarget, rotaries: [f64; 2], line: u32) -> bool {
        // X, Y, Z follow from tip and rotaries alone.
        let mut axes = AxisVector::zeros();
        axes.fixed_rows_mut::<2>(FIRST_ROTARY).copy_from_slice(&rotaries);
        let inside =
            |(value, axis): (&f64, &Axis)| axis.limits.widened(TRAVEL_ROUNDING).contains(*value);
        let linear = self.linear_axes(target, &axes, line);
        linear.is_ok_and(|linear| linear.iter().zip(&self.real.machine().axes).all(inside))
    }
}

impl ControlKinematics for Control {
    type Error = VerifyError;
    type Rotaries = Turned;

    fn tip(&self, axes: &AxisVector, length: ToolLength) -> Point3<f64> {
        let model = self.model(length);
        model.setup().rotation * model.forward(axes).tip
    }

    fn axis(&self, axes: &AxisVector) -> UnitVector3<f64> {
        self.believed.setup().rotation * self.believed.forward(axes).axis
    }

    fn linear_axes(
        &self,
        target: &TipTarget,
        axes: &AxisVector,
        _line: u32,
    ) -> Result<Vector3<f64>, VerifyError> {
        let model = self.model(target.length);
        let tip = model.setup().rotation.inverse() * target.point;
        linear_joints(model, &tip, axes).ok_or(VerifyError::LinearAxes)
    }

    fn rotaries(&self, request: &RotaryRequest<'_>) -> Result<Turned, VerifyError> {
        let reaches = |rotaries| {
            request.tip.is_none_or(|target| self.reaches(&target, rotaries, request.line))
        };
        let RotaryRequest { near, line, .. } = *request;
        // Along a great circle the rotaries come to the other solution only through the direction of the first.
        let keeps = match request.turning {
            Turning::Rotary => None,
            Turning::GreatCircle => orient::branch_at(&self.real, near),
        };
        let direction = self.in_workpiece(&request.direction);
        let turn = TurnRequest { direction, near, keeps, line };
        orient::turned(&self.real, &turn, &reaches)
    }

    fn positions(&self, rotaries: &Turned) -> RotaryPair {
        RotaryPair::from(rotaries.rotaries)
    }
}

/// Linear axes that bring the tip (workpiece frame) to `tip` with the rotaries of `q`: the forward
/// map is affine in them, so four evaluations and a 3 x 3 solve give them.
fn linear_joints(
    kinematics: &Kinematics,
    tip: &Point3<f64>,
    q: &AxisVector,
) -> Option<Vector3<f64>> {
    let at = |x: f64, y: f64, z: f64| kinematics.forward(&AxisVector::new(x, y, z, q[3], q[4])).tip;
    // tip(x, y, z) = tip(0) + J (x, y, z), with J constant while the rotaries stand.
    let start = at(0.0, 0.0, 0.0);
    let columns = [at(1.0, 0.0, 0.0) - start, at(0.0, 1.0, 0.0) - start, at(0.0, 0.0, 1.0) - start];
    Matrix3::from_columns(&columns).lu().solve(&(tip - start))
}

/// Returns the origin of a work offset in the table frame \[mm\]: the gauge point with the rotaries at zero.
pub(crate) fn origin(bare: &Kinematics, joints: &Vector3<f64>) -> Vector3<f64> {
    let q = crate::types::AxisVector::new(joints.x, joints.y, joints.z, 0.0, 0.0);
    let place: Point3<f64> = bare.forward(&q).tip;
    bare.setup().rotation * place.coords
}
