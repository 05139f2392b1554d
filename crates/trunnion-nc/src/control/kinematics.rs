//! The machine as a control knows it, behind a trait: the check and the makers each bring their own.

use super::word_frame::ToolLength;
use crate::machine::RotaryPair;
use crate::read::Turning;
use crate::types::AxisVector;
use nalgebra::{Point3, UnitVector3, Vector3};

/// The machine as a control knows it.
pub trait ControlKinematics {
    /// Error of the caller.
    type Error;
    /// Rotary axes for a tool direction, with what else the caller notes of them.
    type Rotaries: Copy;

    /// Returns the tool tip, or without tool length the gauge point, in the table frame \[mm\].
    fn tip(&self, axes: &AxisVector, length: ToolLength) -> Point3<f64>;

    /// Returns the tool axis, from tip to spindle, in the table frame.
    fn axis(&self, axes: &AxisVector) -> UnitVector3<f64>;

    /// Returns X, Y, Z that bring the tip to a point of the table frame with the rotaries of `axes` \[mm\].
    ///
    /// # Errors
    ///
    /// The linear axes cannot bring the tip to every point.
    fn linear_axes(
        &self,
        target: &TipTarget,
        axes: &AxisVector,
        line: u32,
    ) -> Result<Vector3<f64>, Self::Error>;

    /// Returns the rotary axes that turn the tool into a direction.
    ///
    /// # Errors
    ///
    /// No position of the rotaries turns the tool there.
    fn rotaries(&self, request: &RotaryRequest<'_>) -> Result<Self::Rotaries, Self::Error>;

    /// Returns the positions of two rotaries \[rad\].
    fn positions(&self, rotaries: &Self::Rotaries) -> RotaryPair;
}

/// A point of the table frame that the tool has to reach.
#[derive(Debug, Clone, Copy)]
pub struct TipTarget {
    /// The point \[mm\].
    pub point: Point3<f64>,
    /// The tip goes there, or the gauge point.
    pub length: ToolLength,
}

/// A tool direction for which the control chooses the rotary axes. Begin with [`RotaryRequest::new`] and change the
/// rest by struct update.
#[derive(Debug, Clone, Copy)]
pub struct RotaryRequest<'a> {
    /// Line of the program.
    pub line: u32,
    /// From tip to spindle, table frame.
    pub direction: UnitVector3<f64>,
    /// Axes before the block \[mm, rad\].
    pub near: &'a AxisVector,
    /// Goal of the tip under tool-centre-point control; otherwise X, Y, Z keep their positions.
    pub tip: Option<TipTarget>,
    /// Path of the tool axis to that direction: on a great circle the rotaries stay with their solution.
    pub turning: Turning,
}

impl<'a> RotaryRequest<'a> {
    /// Requests the rotary axes for a direction, while X, Y and Z keep their positions and the rotaries turn steadily.
    pub const fn new(line: u32, direction: UnitVector3<f64>, near: &'a AxisVector) -> Self {
        Self { line, direction, near, tip: None, turning: Turning::Rotary }
    }
}
