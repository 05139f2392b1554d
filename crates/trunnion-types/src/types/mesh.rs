//! Triangle meshes.

use nalgebra::{Isometry3, Point3};

/// A triangle mesh \[mm\].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub vertices: Vec<Point3<f64>>,
    /// Corners of each triangle as indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Returns the mesh in other coordinates.
    #[must_use]
    pub fn moved(mut self, to_from: &Isometry3<f64>) -> Self {
        // The identity would still round.
        if *to_from != Isometry3::identity() {
            for vertex in &mut self.vertices {
                *vertex = to_from * *vertex;
            }
        }
        self
    }
}
