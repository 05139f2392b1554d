//! Triangulates plain solids.

use crate::types::Mesh;
use crate::verify::stock::build::solid::Solid;
use crate::verify::swept::revolved::revolved;
use nalgebra::{Point3, Vector3};

impl Solid {
    /// Triangulates the solid; a cylinder becomes a prism around it, at most `tolerance` \[mm\] off.
    pub(crate) fn triangles(&self, tolerance: f64) -> Mesh {
        match self {
            Self::Box { low, high } => cuboid(low, high),
            Self::Cylinder { base, radius, height } => {
                let profile = [[*radius, 0.0], [*radius, *height]];
                revolved(base, &Vector3::z_axis(), &profile, tolerance)
            }
            Self::Mesh(mesh) => mesh.clone(),
        }
    }
}

fn cuboid(low: &Point3<f64>, high: &Point3<f64>) -> Mesh {
    let corner = |k: u32| {
        let end = |axis: usize| if k >> axis & 1 == 0 { low[axis] } else { high[axis] };
        Point3::new(end(0), end(1), end(2))
    };
    let faces =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices: (0..8).map(corner).collect(), triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn volume(mesh: &Mesh) -> f64 {
        let at = |corner: u32| mesh.vertices[corner as usize].coords;
        let cones = mesh.triangles.iter().map(|&[a, b, c]| at(a).dot(&at(b).cross(&at(c))) / 6.0);
        cones.sum()
    }

    #[test]
    fn triangles_enclose_their_solids() {
        let [low, high] = [Point3::new(-1.0, 2.0, 3.0), Point3::new(1.0, 5.0, 10.0)];
        assert!((volume(&Solid::Box { low, high }.triangles(1.0)) - 42.0).abs() < 1e-12);
        let solid = Solid::Cylinder { base: low, radius: 50.0, height: 4.0 };
        let prism = solid.triangles(1e-3);
        let exact = PI * 2500.0 * 4.0;
        // Between the cylinder and one larger by the tolerance.
        let share = volume(&prism) / exact;
        assert!(share > 1.0 && share < (1.0 + 2e-5f64).powi(2), "{share}");
        for p in &prism.vertices {
            assert!((p - low).xy().norm() <= 50.001 + 1e-12);
        }
    }
}
