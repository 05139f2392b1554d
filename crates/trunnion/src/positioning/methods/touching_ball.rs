//! Ball or arc in contact with a face.

use crate::positioning::strip::MeasuredStrip;
use crate::types::ToolPose;
use nalgebra::Point3;

/// Ball or arc in contact with a face, with its strip.
pub(crate) struct TouchingBall {
    pub(crate) pose: ToolPose,
    /// Centre of the ball or arc \[mm\].
    pub(crate) center: Point3<f64>,
    pub(crate) strip: MeasuredStrip,
}
