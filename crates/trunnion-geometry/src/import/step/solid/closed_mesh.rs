//! Triangles of all faces, joined to one closed mesh.

use super::super::super::error::ImportError;
use super::super::chart::SurfaceChart;
use super::super::model::{Read, loss};
use super::super::part21::StepExchange;
use super::super::reader::{self, StepReader};
use super::super::topology::{self, FaceOutline};
use super::corner::PointTriangle;
use super::{ears, refine, ring, unroll};
use crate::types::{Mesh, Progress, Stage};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

impl StepReader {
    /// Reads the solids of a file as one closed mesh, triangles counter-clockwise seen from
    /// outside. Its corners lie on the file's edges and faces; edges are within about `chord`
    /// \[mm\] of their curves, and triangles of their faces, as sampled between corners. Reports
    /// [`Stage::Import`] face by face.
    ///
    /// # Errors
    ///
    /// As [`Reader::read`](crate::import::Reader::read), and [`ImportError::NotClosed`] where faces
    /// are lost or do not share edges.
    pub fn mesh(
        &self,
        bytes: &[u8],
        chord: f64,
        progress: &dyn Progress,
    ) -> Result<Mesh, ImportError> {
        let exchange = self.exchange(bytes)?;
        if !(chord > 0.0 && chord.is_finite()) {
            return Err(ImportError::Tolerance { name: "chord of the mesh", value: chord });
        }
        let (outlines, _) = topology::outlines(&exchange);
        let done = AtomicU64::new(0);
        let one = |(index, outline): (usize, &FaceOutline)| {
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            progress.step(Stage::Import, count, outlines.len() as u64)?;
            let triangles = self.triangles(&exchange, outline, chord);
            triangles.map_err(|lost| {
                let reason = reader::warning(&exchange, Some(index + 1), &lost).to_string();
                ImportError::NotClosed { reason }
            })
        };
        let all: Result<Vec<Vec<PointTriangle>>, ImportError> =
            outlines.par_iter().enumerate().map(one).collect();
        let all = all?;
        if all.iter().all(Vec::is_empty) {
            return Err(ImportError::NoFaces { reason: reader::reason(&exchange, &[]) });
        }
        closed(&all)
    }

    fn triangles(
        &self,
        exchange: &StepExchange,
        outline: &FaceOutline,
        chord: f64,
    ) -> Read<Vec<PointTriangle>> {
        let (skin, shape, surface) = self.geometry(exchange, outline)?;
        let index = reader::index(&shape, &surface, skin.surface)?;
        let chart = SurfaceChart::new(&shape, &surface, index, self.same);
        let mut rings = Vec::new();
        for boundary in &skin.boundaries {
            rings.extend(ring::ring(&chart, boundary, [chord, self.same])?);
        }
        let polygons = unroll::polygons(&chart, rings, chord);
        let scale = refine::scale(&chart, &polygons, chord);
        let mut all = Vec::new();
        for polygon in polygons {
            let Some(plain) = ears::cut(&polygon, scale) else {
                return loss(outline.id, "its edges cross each other, or leave it no inside");
            };
            all.extend(refine::refine(&chart, plain, chord));
        }
        // Counter-clockwise about the normal of the surface, which points inwards here.
        if skin.same_sense == outline.reversed {
            for triangle in &mut all {
                triangle.swap(1, 2);
            }
        }
        Ok(all)
    }
}

/// Joins triangles at equal corners, and checks that every edge is used as often one way as the
/// other.
fn closed(faces: &[Vec<PointTriangle>]) -> Result<Mesh, ImportError> {
    let mut mesh = Mesh::default();
    let mut known = BTreeMap::new();
    // How often edges are run through one way more than the other, and by which face first.
    let mut edges: BTreeMap<(u32, u32), (i32, usize)> = BTreeMap::new();
    for (index, triangle) in
        faces.iter().enumerate().flat_map(|(index, face)| face.iter().map(move |t| (index, t)))
    {
        let corners = triangle.map(|point| {
            // -0 is 0.
            let key = [point.x, point.y, point.z].map(|x| (x + 0.0).to_bits());
            *known.entry(key).or_insert_with(|| {
                mesh.vertices.push(point);
                u32::try_from(mesh.vertices.len() - 1).unwrap_or(u32::MAX)
            })
        });
        let [a, b, c] = corners;
        // Two corners of a sliver may be one vertex of the file; its neighbours then meet directly.
        if a == b || b == c || c == a {
            continue;
        }
        mesh.triangles.push(corners);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            // In a closed mesh neighbours run through their edge in opposite directions.
            let way = if from < to { 1 } else { -1 };
            edges.entry((from.min(to), from.max(to))).or_insert((0, index)).0 += way;
        }
    }
    let open = edges.iter().filter(|(_, (count, _))| *count != 0);
    let Some((&(corner, _), &(_, face))) = open.clone().next() else { return Ok(mesh) };
    let p = mesh.vertices.get(corner as usize).copied().unwrap_or_default();
    let reason = format!(
        "{} edges have a face on one side only, the first of face {} at X {:.3} Y {:.3} Z {:.3}",
        open.count(),
        face + 1,
        p.x,
        p.y,
        p.z
    );
    Err(ImportError::NotClosed { reason })
}
