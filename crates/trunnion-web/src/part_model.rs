//! The faces of a part as triangles and edges, for a picture in which faces are picked.

use nalgebra::Point3;
use serde::Serialize;
use std::collections::BTreeMap;
use trunnion::import::Part;
use trunnion::import::inspect;
use trunnion::surface::Face;
use trunnion::types::Mesh;

/// Largest distance of a drawn triangle from its surface, in diagonals of the part.
const CHORD_SHARE: f64 = 5e-4;

/// Face of a part, with the figures of `trunnion inspect`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FaceModel {
    /// Number by which a job names it.
    pub number: usize,
    /// Kind of the surface, such as `plane`.
    pub kind: &'static str,
    /// Area \[mm^2\].
    pub area: f64,
    /// Radius of its tightest hollow \[mm\]; `None` where it is nowhere concave.
    pub concave_radius: Option<f64>,
    /// First of its triangles, and their number.
    pub triangles: [usize; 2],
}

/// Part as flat arrays.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct PartModel {
    /// Faces in file order.
    pub faces: Vec<FaceModel>,
    /// Vertices \[mm\], three numbers each.
    pub positions: Vec<f32>,
    /// Triangles, three indices each, face by face.
    pub triangles: Vec<u32>,
    /// Edges of the faces \[mm\]: lines of two points each.
    pub edges: Vec<f32>,
    /// What the file holds and the faces do not, in words.
    pub warnings: Vec<String>,
}

impl PartModel {
    /// Draws every face; one that cannot be drawn becomes a warning.
    pub(crate) fn of(part: &Part) -> Self {
        let warnings = part.warnings.iter().map(ToString::to_string).collect();
        let mut model = Self { warnings, ..Self::default() };
        let chord = CHORD_SHARE * diagonal(&part.faces);
        for face in &part.faces {
            match face.tessellate(chord) {
                Ok(made) => model.add(face, &made.mesh),
                Err(error) => {
                    model.warnings.push(format!("face {} is not drawn: {error}", face.number));
                }
            }
        }
        model
    }

    fn add(&mut self, face: &Face, mesh: &Mesh) {
        let summary = inspect::summary(face);
        // Indices of a page's picture: a part of 2^32 vertices has no memory there.
        let first = u32::try_from(self.positions.len() / 3).unwrap_or(u32::MAX);
        self.faces.push(FaceModel {
            number: face.number,
            kind: summary.kind,
            area: summary.area,
            concave_radius: summary.concave_radius,
            triangles: [self.triangles.len() / 3, mesh.triangles.len()],
        });
        self.positions.extend(mesh.vertices.iter().flat_map(drawn));
        let indices = mesh.triangles.iter().flatten();
        self.triangles.extend(indices.map(|index| first.saturating_add(*index)));
        self.edges.extend(outline(mesh).iter().flat_map(drawn));
    }
}

/// Returns the ends of all sides that belong to a single triangle.
fn outline(mesh: &Mesh) -> Vec<Point3<f64>> {
    let mut uses: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *uses.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    let single = uses.into_iter().filter(|(_, count)| *count == 1);
    let ends = single.flat_map(|(side, _)| side);
    ends.filter_map(|index| mesh.vertices.get(index as usize).copied()).collect()
}

/// Returns the length of the diagonal of the box around all faces \[mm\].
fn diagonal(faces: &[Face]) -> f64 {
    let corners = faces.iter().flat_map(|face| inspect::summary(face).bounds);
    let around = corners.fold(None, |around: Option<[Point3<f64>; 2]>, corner| {
        Some(around.map_or([corner; 2], |[low, high]| [low.inf(&corner), high.sup(&corner)]))
    });
    around.map_or(1.0, |[low, high]| (high - low).norm()).max(f64::MIN_POSITIVE)
}

#[expect(clippy::cast_possible_truncation, reason = "for a picture")]
fn drawn(point: &Point3<f64>) -> [f32; 3] {
    [point.x, point.y, point.z].map(|value| value as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_of_one_triangle_are_the_outline() {
        let corner = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let vertices = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        let square = Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]] };
        let ends = outline(&square);
        assert_eq!(ends.len(), 8);
        let apart = |a: f64, b: f64| (a - b).abs() > 1e-9;
        let is_diagonal =
            |pair: &[Point3<f64>]| apart(pair[0].x, pair[1].x) && apart(pair[0].y, pair[1].y);
        assert!(!ends.chunks(2).any(is_diagonal), "{ends:?}");
    }

    #[test]
    fn triangles_are_divided_by_face() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/corpus/gate/key_slot.step");
        let part = trunnion_cli::calls::part(path.as_ref(), &trunnion::types::Silent).unwrap();
        let model = PartModel::of(&part);
        assert_eq!(model.faces.len(), part.faces.len());
        let mut next = 0;
        for face in &model.faces {
            let [first, count] = face.triangles;
            assert_eq!(first, next);
            next += count;
            let area: f64 = (first..next).map(|at| area(&model, at)).sum();
            assert!((area / face.area - 1.0).abs() < 0.01, "{face:?}: {area} mm2 are drawn");
        }
        assert_eq!(3 * next, model.triangles.len());
    }

    fn area(model: &PartModel, triangle: usize) -> f64 {
        let corner = |k: usize| {
            let vertex = 3 * model.triangles[3 * triangle + k] as usize;
            Point3::from([0, 1, 2].map(|axis| f64::from(model.positions[vertex + axis])))
        };
        let [a, b, c] = [0, 1, 2].map(corner);
        0.5 * (b - a).cross(&(c - a)).norm()
    }
}
