//! Bodies as closed meshes on a link.

use crate::machine::LINKS;
use crate::math;
use crate::types::{AXES, Mesh};
use crate::verify::swept::mesh::ClosedMesh;
use nalgebra::{Isometry3, Point3};
use std::f64::consts::FRAC_PI_2;

/// Body on a link, in the machine frame with all axes at zero.
#[derive(Debug)]
pub(crate) struct LinkedBody {
    pub(crate) name: String,
    pub(crate) link: usize,
    pub(crate) shell: ClosedMesh,
    /// Distance by which the real body may stand out beyond its triangles \[mm\].
    pub(crate) allowance: f64,
    /// Middle of the mesh, and the largest distance of its points from there \[mm\].
    pub(crate) middle: Point3<f64>,
    pub(crate) reach: f64,
}

impl LinkedBody {
    /// Takes triangles in the machine frame; `None` without a triangle.
    pub(crate) fn new(name: String, link: usize, mesh: Mesh, allowance: f64) -> Option<Self> {
        let [low, high] = mesh.vertices.iter().fold(
            [Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3])],
            |[low, high], p| [low.inf(p), high.sup(p)],
        );
        let middle = nalgebra::center(&low, &high);
        let reach = mesh.vertices.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
        Some(Self { name, link, shell: ClosedMesh::new(mesh)?, allowance, middle, reach })
    }
}

/// Returns triangles moved to a place.
pub(crate) fn placed(mesh: &Mesh, place: &Isometry3<f64>) -> Mesh {
    let vertices = mesh.vertices.iter().map(|p| place * p).collect();
    Mesh { vertices, triangles: mesh.triangles.clone() }
}

/// Chords of the corner of a cutter.
const CORNER: u32 = 16;

/// Returns radii and heights round the cutting end of a tool and its flank: tangents of its corner.
pub(crate) fn nose_profile([major, minor, top]: [f64; 3]) -> Vec<[f64; 2]> {
    let step = FRAC_PI_2 / f64::from(CORNER);
    let out = minor / math::cos(0.5 * step);
    let corner = |k: u32| {
        let (sin, cos) = math::sin_cos((f64::from(k) + 0.5) * step);
        [major + out * sin, minor - out * cos]
    };
    let mut profile = vec![[major, 0.0]];
    if minor > 0.0 {
        profile.extend((0..CORNER).map(corner).map(|[radius, height]| [radius, height.max(0.0)]));
    }
    profile.extend([[major + minor, minor], [major + minor, top]]);
    profile
}

/// Number of the link that carries the workpiece.
pub(crate) const WORKPIECE: usize = 0;

/// Number of the link that carries the tool.
pub(crate) const TOOL: usize = LINKS - 1;

const _: () = assert!(TOOL == AXES);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::swept::revolved::revolved;
    use nalgebra::{UnitVector3, Vector3};
    use std::f64::consts::PI;

    /// The mesh of a bull-nose end is outside the cutter, and near it.
    #[test]
    fn a_tool_is_enclosed_tightly() {
        let [major, minor, top] = [4.0, 2.0, 30.0];
        let along = UnitVector3::new_normalize(Vector3::new(0.3, -0.2, -1.0));
        let from = Point3::new(1.0, 2.0, 3.0);
        let mesh = revolved(&from, &along, &nose_profile([major, minor, top]), 1e-3);
        let shell = ClosedMesh::new(mesh.clone()).unwrap();
        for p in &mesh.vertices {
            let height = (p - from).dot(&along);
            let radius = (p - from - along.scale(height)).norm();
            let [out, down] = [radius - major, minor - height];
            let off = out.max(0.0).hypot(down.max(0.0)) - minor;
            let corner = minor * ((0.25 * PI / f64::from(CORNER)).cos().recip() - 1.0);
            assert!(off <= corner + 1e-3 + 1e-9, "{off}");
        }
        let across = along.cross(&Vector3::x()).normalize();
        for k in 0..=40 {
            let angle = f64::from(k) / 40.0 * FRAC_PI_2;
            let radius = major + minor * angle.sin() - 1e-6;
            let height = minor - (minor - 1e-6) * angle.cos();
            assert!(shell.holds(&(from + along.scale(height) + across * radius)), "{k}");
        }
    }
}
