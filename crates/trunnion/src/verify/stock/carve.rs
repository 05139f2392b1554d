//! Material under a moving tool.

use super::super::body::{self, Body};
use super::super::replay::{self, Control, Mover, Segment};
use super::super::sweep::{self, Piece};
use super::super::{CHORD_SHARE, ClInput, Input, VerifyError};
use super::Stock;
use super::cut::Tool;
use super::dexel::{Lattice, TILE, Tile, across, subtract, unit};
use crate::cutter::Cutter;
use crate::types::{Progress, Stage};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What went wrong between tool and material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum CollisionKind {
    /// The tool cuts at rapid speed.
    Rapid,
    /// Shank or holder run into material.
    Holder,
    /// The tool runs into a fixture.
    Fixture,
}

/// One line of a program that does it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collision {
    /// What.
    pub kind: CollisionKind,
    /// Line of the program.
    pub line: u32,
    /// How deep, on the rays looked at \[mm\].
    pub depth: f64,
    /// Where \[mm\].
    pub point: Point3<f64>,
}

/// What a program does to the stock.
#[derive(Debug, Clone, PartialEq)]
pub struct Carving {
    /// Volume taken away \[mm³\].
    pub removed: f64,
    /// Volume left \[mm³\].
    pub left: f64,
    /// Lines that run into something, in order; the deepest place of each kind on each.
    pub collisions: Vec<Collision>,
}

/// Moves worked off at a time: enough for threads to share, little to remember.
const BATCH: usize = 128;

/// Runs a program through stock and fixtures. `tolerance` \[mm\] is how exactly rays are cut.
///
/// # Errors
///
/// [`VerifyError`].
pub fn simulate(
    input: &Input<'_>,
    stock: &mut Stock,
    fixtures: &[Stock],
    tolerance: f64,
    progress: &dyn Progress,
) -> Result<Carving, VerifyError> {
    let control = Control::new(input)?;
    let segments = replay::replay(&control, input)?;
    let mover = Mover::Machine(&control);
    let mut carver = Carver::new(stock, fixtures, input.cutter, tolerance);
    carver.run(&mover, &segments, progress)
}

/// Runs cutter locations through stock and fixtures.
///
/// # Errors
///
/// [`VerifyError`].
pub fn simulate_cl(
    input: &ClInput<'_>,
    stock: &mut Stock,
    fixtures: &[Stock],
    tolerance: f64,
    progress: &dyn Progress,
) -> Result<Carving, VerifyError> {
    let segments = replay::locations(input.file, CHORD_SHARE * tolerance)?;
    let mut carver = Carver::new(stock, fixtures, input.cutter, tolerance);
    carver.run(&Mover::Locations, &segments, progress)
}

/// A tool in stock.
struct Carver<'a> {
    stock: &'a mut Stock,
    fixtures: &'a [Stock],
    bodies: Vec<Body>,
    size: f64,
    tolerance: f64,
    found: BTreeMap<(u32, CollisionKind), Collision>,
}

/// Pieces of one batch with what they are.
struct Batch {
    pieces: Vec<Piece>,
    rapid: bool,
}

impl<'a> Carver<'a> {
    fn new(stock: &'a mut Stock, fixtures: &'a [Stock], cutter: &Cutter, tolerance: f64) -> Self {
        let bodies = body::bodies(cutter);
        let widest = bodies.iter().map(|body| body.radius()).fold(0.0, f64::max);
        let size = cutter.length().hypot(widest);
        Self { stock, fixtures, bodies, size, tolerance, found: BTreeMap::new() }
    }

    fn run(
        &mut self,
        mover: &Mover<'_>,
        segments: &[Segment],
        progress: &dyn Progress,
    ) -> Result<Carving, VerifyError> {
        let before = self.stock.volume();
        let mut done = 0;
        for run in segments.chunk_by(|a, b| a.rapid == b.rapid) {
            for part in run.chunks(BATCH) {
                let mut batch = Batch { pieces: Vec::new(), rapid: part.iter().any(|s| s.rapid) };
                for segment in part {
                    let (size, tolerance) = (self.size, self.tolerance);
                    sweep::straight_pieces(mover, segment, size, tolerance, &mut batch.pieces)?;
                }
                self.batch(&batch);
                done += part.len();
                progress.step(Stage::Verify, done as u64, segments.len() as u64)?;
            }
        }
        let left = self.stock.volume();
        let collisions = self.found.values().copied().collect();
        Ok(Carving { removed: before - left, left, collisions })
    }

    /// Cuts one batch.
    fn batch(&mut self, batch: &Batch) {
        let Self { stock, fixtures, bodies, tolerance, .. } = self;
        let (bodies, tolerance) = (&*bodies, *tolerance);
        let lattice = stock.lattice;
        let mut hits = Vec::new();
        for family in &mut stock.families {
            let along = family.along;
            let work = |tile: &mut Tile| {
                Work { lattice, along, bodies, batch, tolerance, fixture: false }.tile(tile)
            };
            hits.extend(family.tiles.par_iter_mut().flat_map_iter(work).collect::<Vec<_>>());
        }
        for fixture in *fixtures {
            let lattice = fixture.lattice;
            for family in &fixture.families {
                let along = family.along;
                let work = |tile: &Tile| {
                    let work = Work { lattice, along, bodies, batch, tolerance, fixture: true };
                    work.look(tile)
                };
                hits.extend(family.tiles.par_iter().flat_map_iter(work).collect::<Vec<_>>());
            }
        }
        for hit in hits {
            let worst = self.found.entry((hit.line, hit.kind)).or_insert(hit);
            if hit.depth > worst.depth {
                *worst = hit;
            }
        }
    }
}

/// One batch against one tile.
struct Work<'a> {
    lattice: Lattice,
    along: usize,
    bodies: &'a [Body],
    batch: &'a Batch,
    tolerance: f64,
    fixture: bool,
}

/// A body over a piece: which, whether it cuts, and what lies between it and the tile.
#[derive(Clone, Copy)]
struct Near<'a> {
    piece: &'a Piece,
    body: Body,
    cuts: bool,
    clearance: f64,
}

impl<'a> Work<'a> {
    /// Box of a tile's material.
    fn bounds(&self, tile: &Tile) -> Option<[Point3<f64>; 2]> {
        let [low, high] = tile.range;
        if low >= high {
            return None;
        }
        let mut corners = [Point3::origin(); 2];
        for (k, axis) in across(self.along).into_iter().enumerate() {
            corners[0][axis] = self.lattice.at(axis, tile.first[k]);
            corners[1][axis] = self.lattice.at(axis, tile.first[k] + tile.size[k] - 1);
        }
        (corners[0][self.along], corners[1][self.along]) = (low, high);
        Some(corners)
    }

    /// Distance of a body over a piece from a tile's material, at least.
    fn clearance(&self, bounds: &[Point3<f64>; 2], piece: &Piece, body: Body) -> f64 {
        let [low, high] = bounds;
        let mut at = nalgebra::center(low, high);
        let tip = piece.middle().stand.tip[self.along];
        at[self.along] = tip.clamp(low[self.along], high[self.along]);
        piece.clears(body, bounds, &at)
    }

    /// What comes near a tile, in the order of the program.
    fn near(&self, tile: &Tile) -> Vec<Near<'a>> {
        let Some(bounds) = self.bounds(tile) else { return Vec::new() };
        let mut near = Vec::new();
        for piece in &self.batch.pieces {
            for (index, &body) in self.bodies.iter().enumerate() {
                let clearance = self.clearance(&bounds, piece, body);
                if clearance <= 0.0 {
                    near.push(Near { piece, body, cuts: index == 0, clearance });
                }
            }
        }
        near
    }

    /// Cuts a tile.
    fn tile(&self, tile: &mut Tile) -> Vec<Collision> {
        let mut near = self.near(tile);
        if near.is_empty() {
            return Vec::new();
        }
        // What cuts lowest first: most of the rest is refused at a glance. The order matters only to
        // what is told of shank, holder and rapid moves.
        if !self.batch.rapid && near.iter().all(|near| near.cuts) {
            near.sort_by(|a, b| a.clearance.total_cmp(&b.clearance));
        }
        let mut hits = Vec::new();
        let mut changed = false;
        for part in near {
            if std::mem::take(&mut changed) {
                tile.measure();
            }
            let Some(bounds) = self.bounds(tile) else { break };
            if self.clearance(&bounds, part.piece, part.body) > 0.0 {
                continue;
            }
            changed = self.part(tile, &part, &mut hits);
        }
        tile.measure();
        hits
    }

    /// Cuts all rays of a tile by one body over one piece; whether anything was cut.
    fn part(&self, tile: &mut Tile, part: &Near<'_>, hits: &mut Vec<Collision>) -> bool {
        let way = unit(self.along);
        let mut changed = false;
        for index in 0..tile.rays.len() {
            let ray = self.ray(tile, index);
            let Some(spans) = tile.rays.get_mut(index) else { continue };
            let mut at = spans.len();
            while let Some(&span) = at.checked_sub(1).and_then(|last| spans.get(last)) {
                at -= 1;
                let Some(cut) = self.tool(part).swept(&ray, &way, span) else { continue };
                hits.extend(self.hit(part, (&ray, &way), cut));
                if part.cuts {
                    subtract(spans, at, cut);
                    changed = true;
                }
            }
        }
        changed
    }

    /// Looks for what runs into a fixture.
    fn look(&self, tile: &Tile) -> Vec<Collision> {
        let way = unit(self.along);
        let mut hits = Vec::new();
        for part in self.near(tile) {
            for (index, spans) in tile.rays.iter().enumerate() {
                let ray = self.ray(tile, index);
                for &span in spans {
                    let cut = self.tool(&part).swept(&ray, &way, span);
                    hits.extend(cut.and_then(|cut| self.hit(&part, (&ray, &way), cut)));
                }
            }
        }
        hits
    }

    fn tool(&self, part: &Near<'a>) -> Tool<'a> {
        Tool { piece: part.piece, body: part.body, tolerance: self.tolerance }
    }

    fn ray(&self, tile: &Tile, index: usize) -> Point3<f64> {
        let [i, j] = [index / tile.size[1].max(1), index % tile.size[1].max(1)];
        self.lattice.ray(self.along, [tile.first[0] + i, tile.first[1] + j])
    }

    /// What a cut tells, if it is one that should not be.
    fn hit(
        &self,
        part: &Near<'_>,
        (ray, way): (&Point3<f64>, &Vector3<f64>),
        cut: [f64; 2],
    ) -> Option<Collision> {
        let kind = match (self.fixture, self.batch.rapid, part.cuts) {
            (true, _, _) => CollisionKind::Fixture,
            (_, true, true) => CollisionKind::Rapid,
            (_, _, false) => CollisionKind::Holder,
            (_, false, true) => return None,
        };
        let tool = Tool { piece: part.piece, body: part.body, tolerance: self.tolerance };
        let depth = tool.depth(ray, way, cut);
        let point = ray + way * (0.5 * (cut[0] + cut[1]));
        (depth > self.tolerance).then_some(Collision { kind, line: part.piece.line, depth, point })
    }
}

/// Tiles hold this many rays at most.
const _: () = assert!(TILE * TILE == 256);
