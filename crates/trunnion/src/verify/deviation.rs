//! Material left over the faces: the lowest the tool ever gets on the normal of each grid point.

use super::body::{self, Body, Ray};
use super::grid::Grid;
use super::index::{Bounds, Item, Tree};
use super::ray::{Deciding, Lowest, Part};
use super::replay::{Mover, Segment};
use super::report::{FaceMap, Sample};
use super::sweep::{self, Piece};
use super::{Options, VerifyError};
use crate::cutter::Cutter;
use crate::surface::Face;
use crate::types::Cancelled;
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Grid points along the side of a tile: points that share one look into the tree.
const TILE: usize = 8;
/// Tiles worked on between two looks at the progress.
const BATCH: usize = 128;

/// The moving tool, ready to be measured against.
pub(super) struct Sweep {
    pieces: Vec<Piece>,
    bodies: Vec<Body>,
    pub(super) tree: Tree,
    reach: f64,
    tolerance: f64,
}

impl Sweep {
    /// Cuts all moves into pieces and sorts them by place.
    pub(super) fn new(
        mover: &Mover<'_>,
        segments: &[Segment],
        cutter: &Cutter,
        options: &Options,
    ) -> Result<Self, VerifyError> {
        let bodies = body::bodies(cutter);
        let size = cutter.length().hypot(widest(&bodies));
        let error = ERROR_SHARE * options.ray_tolerance;
        let mut pieces = Vec::with_capacity(segments.len());
        for segment in segments {
            sweep::pieces(mover, segment, size + options.reach, error, &mut pieces)?;
        }
        let mut items = Vec::new();
        for (index, piece) in pieces.iter().enumerate() {
            for (part, body) in bodies.iter().enumerate() {
                let content = (narrow(index), narrow(part));
                for bounds in boxes(piece, *body) {
                    items.push(Item { bounds: bounds.grown(error), content });
                }
            }
        }
        let tree = Tree::new(items);
        let (reach, tolerance) = (options.reach, options.ray_tolerance);
        Ok(Self { pieces, bodies, tree, reach, tolerance })
    }

    /// Lowest entry for every ray of a tile.
    fn measure(&self, rays: &[Ray]) -> Vec<Lowest> {
        let Some(centre) = rays.get(rays.len() / 2).map(|ray| ray.origin) else {
            return Vec::new();
        };
        let region = rays.iter().fold(Bounds::empty(), |all, ray| {
            let [a, b] = [ray.at(-self.reach), ray.at(self.reach)];
            all.join(&Bounds { low: a.inf(&b), high: a.sup(&b) })
        });
        let around = self.around(&region, centre);
        rays.iter().map(|ray| self.lowest(&around, ray)).collect()
    }

    /// What can come near a region, by distance from a centre: what cuts lowest comes early, and most
    /// of the rest is refused at a glance.
    pub(super) fn around(&self, region: &Bounds, centre: Point3<f64>) -> Around<'_> {
        let mut near = Vec::new();
        self.tree.near(region, &mut near);
        let mut parts = Vec::with_capacity(near.len());
        for &numbers in &near {
            if let Some(part) = self.part(numbers) {
                parts.push((part.piece.clearance(part.body, &centre), part));
            }
        }
        // Stable: equal distances keep the order of the program.
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        Around { centre, parts }
    }

    /// A body in motion by its numbers.
    pub(super) fn part(&self, numbers: (u32, u32)) -> Option<Part<'_>> {
        let piece = self.pieces.get(numbers.0 as usize)?;
        let body = *self.bodies.get(numbers.1 as usize)?;
        Some(Part { piece, body, numbers })
    }

    /// Lowest entry of a ray.
    pub(super) fn lowest(&self, around: &Around<'_>, ray: &Ray) -> Lowest {
        let mut lowest = Lowest { s: self.reach, line: None, by: None, unresolved: false };
        let aside = (ray.origin - around.centre).norm();
        for (clearance, part) in &around.parts {
            // Distances change by at most 1 a millimetre, and the rest is farther still.
            if *clearance > aside + self.reach.max(lowest.s) {
                break;
            }
            lowest.search(part, ray, self.tolerance);
        }
        lowest
    }

    /// Tool axis at the instant that decided.
    pub(super) fn axis(&self, by: &Deciding) -> Option<Vector3<f64>> {
        let piece = self.pieces.get(by.piece as usize)?;
        Some(piece.instant(by.u).stand.axis)
    }

    /// Lowest entry of a ray into some of the bodies in motion.
    pub(super) fn lowest_of(&self, numbers: impl Iterator<Item = (u32, u32)>, ray: &Ray) -> Lowest {
        let mut lowest = Lowest { s: self.reach, line: None, by: None, unresolved: false };
        for part in numbers.filter_map(|numbers| self.part(numbers)) {
            lowest.search(&part, ray, self.tolerance);
        }
        lowest
    }

    /// How far along a normal is looked \[mm\].
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// How far the tool may be from where the pieces have it \[mm\].
    pub(super) fn error(&self) -> f64 {
        ERROR_SHARE * self.tolerance
    }
}

/// Share of the ray tolerance that replacing moves by quadratics may take.
const ERROR_SHARE: f64 = 0.1;

/// Bodies in motion with what at least lies between them and a centre \[mm\], nearest first.
pub(super) struct Around<'a> {
    centre: Point3<f64>,
    parts: Vec<(f64, Part<'a>)>,
}

fn narrow(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

fn widest(bodies: &[Body]) -> f64 {
    bodies.iter().map(|body| body.radius()).fold(0.0, f64::max)
}

/// Boxes round a body over a piece, about as high as the body is wide, so that a slender tilted
/// tool does not claim all the space beside it.
fn boxes(piece: &Piece, body: Body) -> impl Iterator<Item = Bounds> {
    let [low, high] = body.heights();
    let radius = body.radius();
    let count = ((high - low) / (2.0 * radius)).ceil().clamp(1.0, 64.0);
    let mut index = 0.0;
    std::iter::from_fn(move || {
        if index >= count {
            return None;
        }
        let [from, to] = [index, index + 1.0].map(|i| low + (high - low) * i / count);
        index += 1.0;
        let [low, high] = piece.axis_box([from, to]);
        Some(Bounds { low, high }.grown(radius))
    })
}

/// Measures a face at the points of a grid; `advance` is told how many points are done.
pub(super) fn map(
    sweep: &Sweep,
    face: &Face,
    grid: &Grid,
    advance: &mut dyn FnMut(usize) -> Result<(), Cancelled>,
) -> Result<(FaceMap, Vec<Option<Deciding>>), VerifyError> {
    let [rows, columns] = grid.size();
    let mut samples = vec![None; rows * columns];
    let mut deciding = vec![None; rows * columns];
    let mut unmeasured = 0;
    let tiles: Vec<[usize; 2]> = (0..rows)
        .step_by(TILE)
        .flat_map(|i| (0..columns).step_by(TILE).map(move |j| [i, j]))
        .collect();
    for batch in tiles.chunks(BATCH) {
        let results: Vec<Tile> = batch.par_iter().map(|&at| tile(sweep, face, grid, at)).collect();
        for tile in results {
            unmeasured += tile.unmeasured;
            for (place, sample, by) in tile.samples {
                if let (Some(found), Some(decided)) =
                    (samples.get_mut(place), deciding.get_mut(place))
                {
                    (*found, *decided) = (Some(sample), by);
                }
            }
        }
        advance(batch.len() * TILE * TILE)?;
    }
    let Grid { u, v } = grid.clone();
    Ok((FaceMap { face: face.number, u, v, samples, unmeasured, unfinished: Vec::new() }, deciding))
}

/// Samples of a tile with their places in the map.
struct Tile {
    samples: Vec<(usize, Sample, Option<Deciding>)>,
    unmeasured: usize,
}

fn tile(sweep: &Sweep, face: &Face, grid: &Grid, [row, column]: [usize; 2]) -> Tile {
    let [rows, columns] = grid.size();
    let mut rays = Vec::with_capacity(TILE * TILE);
    let mut places = Vec::with_capacity(TILE * TILE);
    let mut unmeasured = 0;
    for i in row..(row + TILE).min(rows) {
        for j in column..(column + TILE).min(columns) {
            let Some([u, v]) = grid.at(i, j).filter(|&[u, v]| face.contains(u, v)) else {
                continue;
            };
            let origin = face.point(u, v);
            let Some(normal) = face.normal(u, v) else {
                unmeasured += 1;
                continue;
            };
            let jet = face.surface.jet1(u, v);
            let area = Vector3::cross(&jet.su, &jet.sv).norm() * grid.cell(i, j);
            rays.push(Ray { origin, normal: normal.into_inner(), below: sweep.reach });
            places.push((i * columns + j, [u, v], area));
        }
    }
    let lowest = sweep.measure(&rays);
    unmeasured += lowest.iter().filter(|lowest| lowest.unresolved).count();
    let samples = rays.iter().zip(places).zip(lowest).map(|((ray, (place, uv, area)), lowest)| {
        let height = lowest.line.map(|_| lowest.s);
        let (point, line) = (ray.origin, lowest.line);
        (place, Sample { uv, point, height, line, area, rest: false }, lowest.by)
    });
    Tile { samples: samples.collect(), unmeasured }
}
