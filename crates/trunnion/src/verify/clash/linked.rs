//! Bodies as closed meshes on a link.

use crate::machine::LINKS;
use crate::types::{AXES, Mesh};
use crate::verify::stock::build::solid::Solid;
use crate::verify::swept::mesh::ClosedMesh;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

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

/// Returns triangles around a frustum between two points, larger by at most `tolerance` \[mm\].
pub(crate) fn cylinder([from, to]: [&Point3<f64>; 2], radii: [f64; 2], tolerance: f64) -> Mesh {
    let way = to - from;
    let base = Point3::origin();
    let radius = radii[0].max(radii[1]);
    let upright = Solid::Cylinder { base, radius, height: way.norm() }.triangles(tolerance);
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &way).unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    });
    let place = Isometry3::from_parts(from.coords.into(), turn);
    // A cone: each end shrinks to its own radius.
    let shaped = upright.vertices.iter().map(|p| {
        let share = if p.z > 0.5 * way.norm() { radii[1] } else { radii[0] } / radius;
        place * Point3::new(p.x * share, p.y * share, p.z)
    });
    Mesh { vertices: shaped.collect(), triangles: upright.triangles }
}

/// Number of the link that carries the workpiece.
pub(crate) const WORKPIECE: usize = 0;

/// Number of the link that carries the tool.
pub(crate) const TOOL: usize = LINKS - 1;

const _: () = assert!(TOOL == AXES);
