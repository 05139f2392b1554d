//! Points of a surface with their parameters.

use crate::surface::FootPoint;
use crate::types::Uv;
use nalgebra::Point3;

/// Point of a surface, with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Parameters `(u, v)` on the face.
    pub uv: Uv,
    /// The point \[mm\].
    pub point: Point3<f64>,
}

impl From<&FootPoint> for SurfacePoint {
    fn from(foot: &FootPoint) -> Self {
        Self { uv: foot.uv, point: foot.point }
    }
}
