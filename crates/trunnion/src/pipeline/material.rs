//! The stock of a job under its programs.

use super::error::PipelineError;
use super::job::Job;
use super::programs::Program;
use crate::files::job;
use crate::files::summary::{CollisionSummary, KindSummary, LinesSummary, StockSummary};
use crate::surface::{Face, FaceMesh};
use crate::types::Mesh;
use crate::verify::{Carving, Collision, CollisionKind, Lines, Solid, Stock};
use std::collections::BTreeSet;

/// Rays of one stock at most: some gigabytes.
pub const MOST_RAYS: usize = 30_000_000;

/// Lines in collision of each kind that are kept: some hundreds of kilobytes.
pub const MOST_COLLISIONS: usize = 1000;

/// Collisions of a program that are told one by one.
const TOLD: usize = 10;

/// What a job says of its stock as a solid, but for what is in a file; `faces` are those of the part.
pub(super) fn solid<'a>(
    stock: &job::Stock,
    faces: impl Iterator<Item = &'a Face>,
) -> Option<Solid> {
    match *stock {
        job::Stock::Box { min, max } => Some(Solid::Box { low: min, high: max }),
        job::Stock::Cylinder { base, radius, height } => {
            Some(Solid::Cylinder { base, radius, height })
        }
        job::Stock::Offset { thickness } => Some(Solid::Mesh(skin(faces, thickness)?)),
        job::Stock::Stl { .. } | job::Stock::Step { .. } => None,
    }
}

/// Share of a skin's thickness by which its triangles may be off the faces.
const SKIN_SHARE: f64 = 0.01;

/// Material that stands on faces, `thickness` \[mm\] along their normals: a closed mesh on each face, overlapping where
/// faces meet in a hollow. What would be between two skins outside a sharp edge is left out, and what lies under the
/// faces is the part.
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
            all.triangles.extend([[a, a + count, b + count], [a, b + count, b]]);
        }
    }
    Some(all)
}

/// Material of the job's stock, uncut; `None` if it is not known as a solid.
///
/// # Errors
///
/// [`PipelineError::Verify`] for a stock without volume, one that is not closed, or one with too many rays.
pub fn stock(job: &Job) -> Result<Option<Stock>, PipelineError> {
    let Some(solid) = &job.stock else { return Ok(None) };
    let cell = job.file.stock_cell.unwrap_or_else(|| solid.usual_cell());
    Ok(Some(Stock::new(solid, cell, MOST_RAYS)?))
}

/// The numbers of a stock that was cut.
pub fn summary(carving: &Carving, left: &Stock) -> StockSummary {
    let collision = |collision: &Collision| CollisionSummary {
        kind: word(collision.kind),
        line: collision.line,
        depth: collision.depth,
        point: collision.point.coords.into(),
    };
    StockSummary {
        cell: left.cell(),
        removed: carving.removed,
        left: carving.left,
        collisions: carving.collisions.iter().map(collision).collect(),
        collision_lines: carving
            .lines
            .iter()
            .map(|(kind, all)| KindSummary { kind: word(*kind), lines: lines(*all) })
            .collect(),
    }
}

fn word(kind: CollisionKind) -> String {
    match kind {
        CollisionKind::Rapid => "rapid",
        CollisionKind::Holder => "holder",
        CollisionKind::Fixture => "fixture",
    }
    .to_owned()
}

/// Lines as a summary has them.
pub fn lines(Lines { count, first, last }: Lines) -> LinesSummary {
    LinesSummary { count, first, last }
}

/// Collisions in words: the first of those that are kept, and how many more of `count`.
pub fn collided(kept: &[Collision], count: usize) -> Vec<String> {
    let mut told: Vec<String> = kept.iter().take(TOLD).map(ToString::to_string).collect();
    if count > told.len() {
        told.push(format!("and {} more lines that run into something", count - told.len()));
    }
    told
}

/// Collisions of a program.
pub(super) fn failures(program: &Program) -> Vec<String> {
    let told =
        program.carving.as_ref().map(|(carving, _)| collided(&carving.collisions, carving.count()));
    let name = program.file;
    told.into_iter().flatten().map(|what| format!("{name}: {what}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Cylinder, Frame, Surface, TrimCurve, TrimLoop};
    use nalgebra::{Point3, Vector3};

    /// A skin on an arc of a cylinder has the volume of what is between two radii, inside as outside.
    #[test]
    fn what_stands_on_a_face_has_its_volume() {
        let frame = Frame::new(Point3::new(1.0, 2.0, 3.0), Vector3::z(), Vector3::x()).unwrap();
        let corners = [[0.3, 1.0], [1.9, 1.0], [1.9, 9.0], [0.3, 9.0], [0.3, 1.0]];
        for (flip, radii) in [(false, [10.0, 12.0]), (true, [8.0, 10.0])] {
            let curve = TrimCurve::polyline(&corners).unwrap();
            let trim = TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap();
            let surface = Surface::Cylinder(Cylinder::new(frame, 10.0).unwrap());
            let face = Face::new(1, surface, vec![trim], flip).unwrap();
            let stock = job::Stock::Offset { thickness: 2.0 };
            let solid = solid(&stock, std::iter::once(&face)).unwrap();
            let volume = Stock::new(&solid, 0.1, 1_000_000).unwrap().volume();
            let exact = 0.5 * 1.6 * 8.0 * (radii[1] * radii[1] - radii[0] * radii[0]);
            assert!((volume / exact - 1.0).abs() < SKIN_SHARE, "{volume} {exact}");
        }
    }
}
