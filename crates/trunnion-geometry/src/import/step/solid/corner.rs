//! Corners and triangles in space and in parameters.

use nalgebra::Point3;

/// A corner of a polygon in a surface's parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeshCorner {
    pub(super) uv: [f64; 2],
    /// The same to the last bit for all faces that meet there.
    pub(super) point: Point3<f64>,
}

/// Corners of a triangle, counter-clockwise seen from outside.
pub(super) type PointTriangle = [Point3<f64>; 3];
