//! A position to be written.

use crate::types::{AxisVector, ToolPose};

/// Position that a program writes: the same one as axis positions and as a tool pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrittenPosition<'a> {
    /// Axis positions \[mm, rad\].
    pub q: &'a AxisVector,
    /// Tool pose in the workpiece frame \[mm\].
    pub pose: &'a ToolPose,
}
