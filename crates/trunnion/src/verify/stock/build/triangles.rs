//! Triangulates plain solids.

use crate::types::Mesh;
use crate::verify::stock::build::solid::Solid;
use nalgebra::{Point3, Vector3};
use std::f64::consts::{PI, TAU};

/// Least and most sides of a prism for a cylinder: at a radius of a metre, 1e5 sides are 0.5 nm off.
const SIDES: [f64; 2] = [8.0, 1e5];

impl Solid {
    /// Triangulates the solid; a cylinder becomes a prism around it, at most `tolerance` \[mm\] off.
    pub(crate) fn triangles(&self, tolerance: f64) -> Mesh {
        match self {
            Self::Box { low, high } => cuboid(low, high),
            Self::Cylinder { base, radius, height } => {
                // From the axis, half a side subtends the angle whose cosine is the radius over the corner distance.
                let half = (radius / (radius + tolerance)).acos();
                let sides = (PI / half).ceil().clamp(SIDES[0], SIDES[1]);
                prism(base, radius / (PI / sides).cos(), *height, sides)
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

/// Returns an upright prism with corners at `radius`.
fn prism(base: &Point3<f64>, radius: f64, height: f64, sides: f64) -> Mesh {
    let up = Vector3::z() * height;
    let mut mesh = Mesh { vertices: vec![*base, base + up], triangles: Vec::new() };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let count = sides as u32;
    for k in 0..count {
        // Corners of both ends alternate: k-th lower corner 2 + 2 k, upper corner 3 + 2 k.
        let angle = TAU * f64::from(k) / sides;
        let rim = base + Vector3::new(angle.cos(), angle.sin(), 0.0) * radius;
        mesh.vertices.extend([rim, rim + up]);
        let [a, b] = [2 + 2 * k, 2 + 2 * ((k + 1) % count)];
        mesh.triangles.extend([[0, b, a], [1, a + 1, b + 1], [a, b, b + 1], [a, b + 1, a + 1]]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

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
