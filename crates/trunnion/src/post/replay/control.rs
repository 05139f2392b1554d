//! The machine model of a program that is posted: the makers' inverse, with the tool and without.

use super::only_tool::ToolMotion;
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics, RotaryPair, Setup};
use crate::nc::control::{ControlKinematics, RotaryRequest, TipTarget, ToolLength};
use crate::post::axis_point::AxesPose;
use crate::post::error::PostError;
use crate::types::{AxisVector, ToolPose};
use nalgebra::{Point3, UnitVector3, Vector3};

/// Control of the machine for which a program was made.
#[derive(Debug)]
pub(super) struct PostControl {
    with_tool: Inverse,
    /// Without tool length, for `G49`.
    bare: Inverse,
    pub(super) motion: ToolMotion,
    /// Axis positions to which a block led, and the tool there: the next block begins with both.
    stands: AxesPose,
}

impl PostControl {
    pub(super) fn new(kinematics: &Kinematics) -> Result<Self, PostError> {
        let bare = Setup { tool_length: 0.0, ..*kinematics.setup() };
        let bare = Kinematics::new(kinematics.machine(), &bare);
        let inverse =
            |of: &Kinematics| Inverse::new(of).map_err(|error| PostError::reach(0, error));
        let (with_tool, bare) = (inverse(kinematics)?, inverse(&bare)?);
        let home = kinematics.machine().home();
        let stands = AxesPose { q: home, pose: kinematics.forward(&home) };
        Ok(Self { with_tool, bare, motion: ToolMotion::Unplaced, stands })
    }

    /// Keeps the tool at axis positions, which will be asked for again.
    pub(super) fn stand(&mut self, q: AxisVector) {
        self.stands = AxesPose { q, pose: self.kinematics().forward(&q) };
    }

    /// Returns the tool at axis positions.
    pub(super) fn pose(&self, q: &AxisVector) -> ToolPose {
        if self.stands.q == *q { self.stands.pose } else { self.kinematics().forward(q) }
    }

    /// The machine with the tool that is in the spindle.
    pub(super) fn kinematics(&self) -> &Kinematics {
        self.with_tool.kinematics()
    }

    pub(super) fn tool_length(&self) -> f64 {
        self.kinematics().setup().tool_length
    }

    fn inverse(&self, length: ToolLength) -> &Inverse {
        match length {
            ToolLength::Active => &self.with_tool,
            ToolLength::Cancelled => &self.bare,
        }
    }
}

impl ControlKinematics for PostControl {
    type Error = PostError;
    type Rotaries = [f64; 2];

    fn tip(&self, axes: &AxisVector, length: ToolLength) -> Point3<f64> {
        let kinematics = self.inverse(length).kinematics();
        let tip = match length {
            ToolLength::Active => self.pose(axes).tip,
            ToolLength::Cancelled => kinematics.forward(axes).tip,
        };
        kinematics.setup().rotation * tip
    }

    fn axis(&self, axes: &AxisVector) -> UnitVector3<f64> {
        let kinematics = self.kinematics();
        kinematics.setup().rotation * kinematics.forward(axes).axis
    }

    fn linear_axes(
        &self,
        target: &TipTarget,
        axes: &AxisVector,
        line: u32,
    ) -> Result<Vector3<f64>, PostError> {
        let inverse = self.inverse(target.length);
        let tip = inverse.kinematics().setup().rotation.inverse() * target.point;
        let rotaries = RotaryPair::new(axes[FIRST_ROTARY], axes[FIRST_ROTARY + 1]);
        let found = inverse.at_rotaries(&tip, rotaries);
        let at = found.map_err(|error| PostError::reach(line, error))?;
        Ok(at.fixed_rows::<3>(0).into())
    }

    fn rotaries(&self, request: &RotaryRequest<'_>) -> Result<[f64; 2], PostError> {
        // Rotary positions do not depend on the tool length; only the travel of X, Y, Z does.
        let inverse = request.tip.map_or(&self.with_tool, |target| self.inverse(target.length));
        let back = inverse.kinematics().setup().rotation.inverse();
        let axis = UnitVector3::new_normalize(back * request.direction.into_inner());
        let tip = match request.tip {
            Some(target) => Point3::from(back * target.point.coords),
            None => inverse.kinematics().forward(request.near).tip,
        };
        let pose = ToolPose { tip, axis };
        // Travel counts only where the tip really goes: not in a turn of the rotaries alone, and not
        // before the program has stated a position, when the tool may stand anywhere.
        let keeps_travel = request.tip.is_some() && self.motion == ToolMotion::Moved;
        let found = match inverse.near_inside(&pose, request.near) {
            Err(_) if !keeps_travel => inverse.near(&pose, request.near),
            found => found,
        };
        let axes = found.map_err(|error| PostError::reach(request.line, error))?;
        Ok([axes[FIRST_ROTARY], axes[FIRST_ROTARY + 1]])
    }

    fn positions(&self, rotaries: &[f64; 2]) -> RotaryPair {
        RotaryPair::from(*rotaries)
    }
}
