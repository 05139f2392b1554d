//! Stock and fixtures of a job as solids.

use crate::files::job;
use crate::surface::{Face, FaceMesh};
use crate::types::Mesh;
use crate::verify::Solid;
use std::collections::BTreeSet;

/// Returns the stock of a job as a solid; `None` if it is in a file. `faces` are those of the part.
pub(super) fn stock_solid<'a>(
    stock: &job::JobStock,
    faces: impl Iterator<Item = &'a Face>,
) -> Option<Solid> {
    match stock {
        job::JobStock::Offset { thickness } => Some(Solid::Mesh(skin(faces, *thickness)?)),
        job::JobStock::Solid(solid) => plain_solid(solid),
    }
}

/// Returns a solid as the check needs it; `None` if it is in a file.
pub(super) fn plain_solid(solid: &job::JobSolid) -> Option<Solid> {
    match *solid {
        job::JobSolid::Box { min, max } => Some(Solid::Box { low: min, high: max }),
        job::JobSolid::Cylinder { base, radius, height } => {
            Some(Solid::Cylinder { base, radius, height })
        }
        job::JobSolid::Stl { .. } | job::JobSolid::Step { .. } => None,
    }
}

/// Chord tolerance of a skin, as a share of its thickness.
const SKIN_SHARE: f64 = 0.01;

/// Returns material of even thickness \[mm\] on faces, along their normals.
///
/// It is a closed mesh on each face; they overlap where faces meet in a hollow. The gap between two skins outside a
/// sharp edge is left out, and below the faces is the part.
fn skin<'a>(faces: impl Iterator<Item = &'a Face>, thickness: f64) -> Option<Mesh> {
    let mut all = Mesh::default();
    for face in faces {
        let FaceMesh { mesh, normals, .. } = face.tessellate(SKIN_SHARE * thickness).ok()?;
        let [first, count] = [all.vertices.len(), mesh.vertices.len()].map(u32::try_from);
        let (first, count) = (first.ok()?, count.ok()?);
        let outer = mesh.vertices.iter().zip(&normals).map(|(p, n)| p + n.scale(thickness));
        all.vertices.extend(outer);
        all.vertices.extend(&mesh.vertices);
        // An edge of one triangle alone is on the border.
        let mut border = BTreeSet::new();
        for &[a, b, c] in &mesh.triangles {
            // The outer skin keeps the orientation of the face; the inner one is its mirror.
            all.triangles.push([a, b, c].map(|corner| first + corner));
            all.triangles.push([a, c, b].map(|corner| first + count + corner));
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if !border.remove(&(to, from)) {
                    border.insert((from, to));
                }
            }
        }
        for (from, to) in border {
            let [a, b] = [from, to].map(|corner| first + corner);
            // Two triangles close the wall between both skins along the border.
            all.triangles.extend([[a, a + count, b + count], [a, b + count, b]]);
        }
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{CylinderSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};
    use crate::verify::Stock;
    use nalgebra::{Point3, Vector3};

    /// A skin on an arc of a cylinder has the volume of what is between two radii, inside as outside.
    #[test]
    fn what_stands_on_a_face_has_its_volume() {
        let frame =
            SurfaceFrame::new(Point3::new(1.0, 2.0, 3.0), Vector3::z(), Vector3::x()).unwrap();
        let corners = [[0.3, 1.0], [1.9, 1.0], [1.9, 9.0], [0.3, 9.0], [0.3, 1.0]];
        for (flip, radii) in [(false, [10.0, 12.0]), (true, [8.0, 10.0])] {
            let curve = TrimCurve::polyline(&corners).unwrap();
            let trim = TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap();
            let surface = Surface::Cylinder(CylinderSurface::new(frame, 10.0).unwrap());
            let face = Face { flip, ..Face::new(1, surface, vec![trim]).unwrap() };
            let stock = job::JobStock::Offset { thickness: 2.0 };
            let solid = stock_solid(&stock, std::iter::once(&face)).unwrap();
            let volume = Stock::new(&solid, 0.1, 1_000_000).unwrap().volume();
            let exact = 0.5 * 1.6 * 8.0 * (radii[1] * radii[1] - radii[0] * radii[0]);
            assert!((volume / exact - 1.0).abs() < SKIN_SHARE, "{volume} {exact}");
        }
    }
}
