//! The stock of a job under its programs.

use super::error::PipelineError;
use super::fixtures::{self, Fixtures};
use super::job::Job;
use super::programs::Program;
use crate::files::job;
use crate::files::summary::{
    CollisionSummary, FixturesSummary, KindSummary, LinesSummary, StockSummary, UndecidedSummary,
};
use crate::surface::{Face, FaceMesh};
use crate::types::Mesh;
use crate::verify::{
    Collision, CollisionKind, Lines, Solid, Stock, StockReport, UndecidedCollision,
};
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
    match stock {
        job::Stock::Offset { thickness } => Some(Solid::Mesh(skin(faces, *thickness)?)),
        job::Stock::Solid(solid) => plain(solid),
    }
}

/// A solid as it is checked with, but for what is in a file.
pub(super) fn plain(solid: &job::Solid) -> Option<Solid> {
    match *solid {
        job::Solid::Box { min, max } => Some(Solid::Box { low: min, high: max }),
        job::Solid::Cylinder { base, radius, height } => {
            Some(Solid::Cylinder { base, radius, height })
        }
        job::Solid::Stl { .. } | job::Solid::Step { .. } => None,
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

/// What the programs of a job are checked with beside the part.
#[derive(Debug)]
pub struct Solids {
    /// Material of the stock, uncut; `None` if it is not known as a solid.
    pub stock: Option<Stock>,
    /// `None` without any.
    pub fixtures: Option<Fixtures>,
}

/// Stock and fixtures of a job.
///
/// # Errors
///
/// [`PipelineError::Solids`] with all that are without volume, not closed, or of too many rays, each at its line of the job.
pub fn solids(job: &Job) -> Result<Solids, PipelineError> {
    let (file, mut faults) = (&job.file, Vec::new());
    let mut refuse = |path: &str, what: String| faults.push(file.places.fault(path, what));
    let stock = job.stock.as_ref().and_then(|solid| {
        let cell = file.stock_cell.unwrap_or_else(|| solid.usual_cell());
        let refused = |error| refuse(stock_key(file, solid), format!("the stock: {error}"));
        Stock::new(solid, cell, MOST_RAYS).map_err(refused).ok()
    });
    let mut fixtures = Fixtures::new(job.budget.total, file.fixture_clearance);
    for (number, held) in job.fixtures.iter().enumerate() {
        if let Err(error) = fixtures.add(held) {
            let path = format!("fixture.{number}.file");
            refuse(&path, format!("fixture {}: {error}", held.name));
        }
    }
    if !faults.is_empty() {
        return Err(PipelineError::Solids(faults.into()));
    }
    Ok(Solids { stock, fixtures: Some(fixtures).filter(|all| !all.all().is_empty()) })
}

/// Key of the job that a stock which cannot be worked with is told at: how near its rays are, if it is sound with
/// others.
fn stock_key(file: &job::JobFile, solid: &Solid) -> &'static str {
    let sound = || Stock::new(solid, solid.usual_cell(), MOST_RAYS).is_ok();
    if file.stock_cell.is_some() && sound() { "verify.stock_cell" } else { "stock.file" }
}

/// The numbers of a stock that was cut.
pub fn summary(carving: &StockReport, left: &Stock) -> StockSummary {
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
        undecided: carving.undecided.map(|UndecidedCollision { kind, line, depth }| {
            UndecidedSummary { kind: word(kind), line, depth }
        }),
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
pub(super) fn lines(Lines { count, first, last }: Lines) -> LinesSummary {
    LinesSummary { count, first, last }
}

/// Collisions in words, `fixtures` by their names: the first of those that are kept, and how many more of `count`.
pub fn collided(
    (kept, count): (&[Collision], usize),
    fixtures: Option<&FixturesSummary>,
) -> Vec<String> {
    let one = |hit: &Collision| fixtures::told(hit, fixtures);
    let mut told: Vec<String> = kept.iter().take(TOLD).map(one).collect();
    if count > told.len() {
        told.push(format!("and {} more lines that run into something", count - told.len()));
    }
    told
}

/// What a program runs into, and what fixtures it comes too near.
pub(super) fn failures(program: &Program, solids: &Solids) -> Vec<String> {
    let carving = program.carving.as_ref().map(|stock| &stock.report);
    let (kept, count) = fixtures::collisions(carving, program.clearance.as_ref());
    let summary = fixtures_summary(program, solids);
    let near = summary.iter().flat_map(fixtures::too_near);
    let told = collided((&kept, count), summary.as_ref()).into_iter().chain(near);
    told.map(|what| format!("{}: {what}", program.file)).collect()
}

/// How near a program comes to the fixtures.
pub(super) fn fixtures_summary(program: &Program, solids: &Solids) -> Option<FixturesSummary> {
    Some(solids.fixtures.as_ref()?.summary(program.clearance.as_ref()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{CylinderSurface, Surface, SurfaceFrame, TrimCurve, TrimLoop};
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
            let face = Face::new(1, surface, vec![trim], flip).unwrap();
            let stock = job::Stock::Offset { thickness: 2.0 };
            let solid = solid(&stock, std::iter::once(&face)).unwrap();
            let volume = Stock::new(&solid, 0.1, 1_000_000).unwrap().volume();
            let exact = 0.5 * 1.6 * 8.0 * (radii[1] * radii[1] - radii[0] * radii[0]);
            assert!((volume / exact - 1.0).abs() < SKIN_SHARE, "{volume} {exact}");
        }
    }
}
