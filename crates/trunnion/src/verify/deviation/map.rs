//! Deviation maps: the lowest point that the tool ever reaches on the normal of each grid point.

use super::bounds::trim_segments::TrimSegments;
use super::chunks::{MeasureScope, MotionChunk, MotionChunks, MoveKind};
use super::grid::FaceGrid;
use super::ray::{DecidingPose, LowestEntry};
use crate::surface::Face;
use crate::types::Cancelled;
use crate::verify::error::VerifyError;
use crate::verify::report::{FaceMap, HeightSample};
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::rays::RayBundle;
use crate::verify::swept::tool::{DepthRule, NormalRay};
use nalgebra::Vector3;
use rayon::prelude::*;

/// Grid points along the side of a tile; the points of a tile share one query of the tree.
const TILE: usize = 8;
/// Tiles processed between two reports of progress.
const BATCH: usize = 128;

/// Points of a face that are measured, with all that does not depend on the motion.
pub(crate) struct FacePoints<'a> {
    face: &'a Face,
    grid: FaceGrid,
    /// Border of the face.
    trims: TrimSegments,
    tiles: Vec<TilePoints>,
    /// Number of points without a normal.
    bare: usize,
}

/// Samples of a grid of points, by their indices; `None` outside the face.
pub(crate) type GridSamples = Vec<Option<HeightSample>>;

/// Face that is divided into tiles.
struct TiledFace<'a> {
    face: &'a Face,
    trims: &'a TrimSegments,
    grid: &'a FaceGrid,
}

/// Points of a tile by their indices in the map.
struct TilePoints {
    indices: Vec<usize>,
    /// Rules for the depth of a gouge at each of them.
    rules: Vec<DepthRule>,
    /// Box around all rays, and as far beside them as a tool counts.
    region: BoundingBox,
}

/// Entries over the points of a tile.
struct TileEntries {
    /// Lowest entry over each.
    lowest: Vec<LowestEntry>,
    /// Nearest cutting end within the tolerance, where nothing cuts along the normal.
    nearest: Vec<LowestEntry>,
}

/// Deviation map of a face with the tool poses that decide its heights.
pub(crate) struct MeasuredMap<'a> {
    pub(crate) map: FaceMap,
    /// Deciding pose at each point of the map.
    pub(crate) deciding: Vec<Option<DecidingPose>>,
    /// Border of the face.
    pub(crate) trims: &'a TrimSegments,
}

/// Measures faces at their points; `advance` receives the share done. The samples have no heights before.
pub(crate) fn maps<'a>(
    chunks: &MotionChunks<'_>,
    faces: &'a [FacePoints<'_>],
    samples: Vec<GridSamples>,
    advance: &mut dyn FnMut(f64) -> Result<(), Cancelled>,
) -> Result<Vec<MeasuredMap<'a>>, VerifyError> {
    let empty = |face: &FacePoints<'_>| -> Vec<TileEntries> {
        face.tiles.iter().map(|tile| TileEntries::none(tile, &chunks.scope)).collect()
    };
    let mut fields: Vec<(&FacePoints<'_>, Vec<TileEntries>)> =
        faces.iter().map(|face| (face, empty(face))).collect();
    let all: usize = faces.iter().map(|face| face.tiles.len()).sum();
    chunks.each(&BoundingBox::everywhere(), |chunk, [from, to]| {
        let mut done = 0;
        for (face, entries) in &mut fields {
            let tiles = face.tiles.chunks(BATCH).zip(entries.chunks_mut(BATCH));
            for (tiles, entries) in tiles {
                let pairs = tiles.par_iter().zip(&mut *entries);
                pairs.for_each(|(tile, entries)| entries.take(chunk, face, tile));
                done += tiles.len();
                // Within a chunk the progress goes by tiles.
                advance(from + (to - from) * done as f64 / all as f64)?;
            }
        }
        Ok(())
    })?;
    let moves = chunks.scope.moves;
    let measured = fields.into_iter().zip(samples);
    Ok(measured.map(|((face, entries), samples)| face.map(entries, samples, moves)).collect())
}

/// Returns samples as they were before anything was measured.
pub(crate) fn unmeasured(map: &FaceMap) -> GridSamples {
    let bare = |sample: &HeightSample| HeightSample {
        height: None,
        line: None,
        dog_leg: false,
        rest: false,
        ..*sample
    };
    map.samples.iter().map(|sample| sample.as_ref().map(bare)).collect()
}

/// Returns the ray from a point of a face, if the face has a normal there.
fn ray(face: &Face, [u, v]: [f64; 2], below: f64) -> Option<NormalRay> {
    let normal = face.normal(u, v)?.into_inner();
    Some(NormalRay { origin: face.point(u, v), normal, below, rule: DepthRule::AlongNormal })
}

impl<'a> FacePoints<'a> {
    /// Collects the points of a grid that are on a face, and their samples without heights.
    pub(crate) fn new(
        face: &'a Face,
        grid: FaceGrid,
        scope: &MeasureScope,
    ) -> Result<(Self, GridSamples), VerifyError> {
        let [rows, columns] = grid.size();
        let trims = TrimSegments::over(face, [&grid.u, &grid.v])?;
        let corners: Vec<[usize; 2]> = (0..rows)
            .step_by(TILE)
            .flat_map(|i| (0..columns).step_by(TILE).map(move |j| [i, j]))
            .collect();
        let whole = TiledFace { face, trims: &trims, grid: &grid };
        let tile = |&corner| TilePoints::new(&whole, corner, scope);
        let found: Vec<(TilePoints, Vec<HeightSample>, usize)> =
            corners.par_iter().map(tile).collect();
        let (mut tiles, mut bare) = (Vec::with_capacity(found.len()), 0);
        let mut samples = vec![None; rows * columns];
        for (points, of_tile, without) in found {
            for (&index, sample) in points.indices.iter().zip(of_tile) {
                if let Some(slot) = samples.get_mut(index) {
                    *slot = Some(sample);
                }
            }
            tiles.push(points);
            bare += without;
        }
        Ok((Self { face, grid, trims, tiles, bare }, samples))
    }

    /// Sets the heights of the samples.
    fn map(
        &self,
        entries: Vec<TileEntries>,
        mut samples: GridSamples,
        moves: MoveKind,
    ) -> MeasuredMap<'_> {
        let Self { face, grid, trims, tiles, bare } = self;
        let (mut deciding, mut unmeasured) = (vec![None; samples.len()], *bare);
        let dog_leg = moves == MoveKind::DogLegs;
        for (tile, TileEntries { lowest, nearest }) in tiles.iter().zip(entries) {
            // At an edge the tool that cuts the next face may be nearer than what cuts along the normal.
            let entries = lowest.into_iter().zip(nearest);
            let entries = entries.map(|(lowest, nearest)| lowest.or_nearer(nearest));
            for (&index, lowest) in tile.indices.iter().zip(entries) {
                // A search that was given up may have missed a lower entry: its point counts as unmeasured.
                unmeasured += usize::from(lowest.unresolved);
                if let (Some(Some(sample)), Some(by)) =
                    (samples.get_mut(index), deciding.get_mut(index))
                {
                    sample.height = lowest.line.map(|_| lowest.s);
                    (sample.line, sample.dog_leg, *by) = (lowest.line, dog_leg, lowest.by);
                }
            }
        }
        let FaceGrid { u, v } = grid.clone();
        let unfinished = Vec::new();
        let map = FaceMap { face: face.number, u, v, samples, unmeasured, unfinished };
        MeasuredMap { map, deciding, trims }
    }
}

/// Returns the sample of a grid point without a height.
fn sample(face: &Face, [u, v]: [f64; 2], cell: f64) -> HeightSample {
    let jet = face.surface.jet1(u, v);
    // |S_u x S_v| du dv.
    let area = Vector3::cross(&jet.su, &jet.sv).norm() * cell;
    HeightSample {
        uv: [u, v].into(),
        point: face.point(u, v),
        height: None,
        line: None,
        dog_leg: false,
        area,
        rest: false,
    }
}

/// Returns the parameters of a grid point.
fn at(grid: &FaceGrid, index: usize) -> Option<[f64; 2]> {
    let columns = grid.size()[1];
    grid.at(index / columns, index % columns)
}

impl TilePoints {
    /// Collects the points of a tile that are on the face, with their samples, and counts those without a normal.
    fn new(
        whole: &TiledFace<'_>,
        [row, column]: [usize; 2],
        scope: &MeasureScope,
    ) -> (Self, Vec<HeightSample>, usize) {
        let TiledFace { face, trims, grid } = *whole;
        let [rows, columns] = grid.size();
        let (mut indices, mut region, mut bare) = (Vec::new(), BoundingBox::empty(), 0);
        let (mut rules, mut samples) = (Vec::new(), Vec::new());
        for i in row..(row + TILE).min(rows) {
            for j in column..(column + TILE).min(columns) {
                let Some(uv) = grid.at(i, j).filter(|&[u, v]| face.contains(u, v)) else {
                    continue;
                };
                let Some(ray) = ray(face, uv, scope.reach) else {
                    bare += 1;
                    continue;
                };
                // The ray itself, from the deepest gouge that is searched to the highest excess.
                let [a, b] = [ray.at(-scope.reach), ray.at(scope.top())];
                region = region.join(&BoundingBox { low: a.inf(&b), high: a.sup(&b) });
                indices.push(i * columns + j);
                rules.push(trims.depth_rule(face, uv, [0.0; 2]));
                samples.push(sample(face, uv, grid.cell(i, j)));
            }
        }
        let region = region.grown(scope.aside());
        (Self { indices, rules, region }, samples, bare)
    }
}

impl TileEntries {
    /// Returns the state before any entry.
    fn none(tile: &TilePoints, scope: &MeasureScope) -> Self {
        let count = tile.indices.len();
        Self {
            lowest: vec![LowestEntry::none(scope.top()); count],
            nearest: vec![LowestEntry::none(scope.total); count],
        }
    }

    /// Lowers the entries of the tile by the moves of a chunk.
    fn take(&mut self, chunk: &MotionChunk, of: &FacePoints<'_>, tile: &TilePoints) {
        let Self { lowest, nearest } = self;
        let TilePoints { indices, rules, region } = tile;
        let FacePoints { face, grid, .. } = of;
        if !chunk.tree.meets(region) {
            return;
        }
        let MeasureScope { reach, tolerance, total, .. } = chunk.parts.scope;
        let points = indices.iter().zip(rules.iter());
        let rays = points.filter_map(|(&index, &rule)| {
            Some(NormalRay { rule, ..ray(face, at(grid, index)?, reach)? })
        });
        let rays: Vec<NormalRay> = rays.collect();
        let Some(middle) = rays.get(rays.len() / 2) else { return };
        let around = chunk.around(region, middle.origin);
        let bundle = RayBundle::around(middle, &rays);
        let aside: Vec<f64> = rays.iter().map(|ray| (ray.origin - middle.origin).norm()).collect();
        for (clearance, part) in &around {
            // Only moves below the highest entry so far can lower any ray of the tile.
            let top = lowest.iter().map(|lowest| lowest.s).fold(f64::NEG_INFINITY, f64::max);
            // An entry counts only at the surface and above, or where the surface itself is inside the tool: a body that gets
            // no nearer to the origin of a ray than its lowest entry is high leaves it. The list is sorted, and distances
            // change by at most 1 per mm: none of the rest can lower any ray.
            if *clearance > bundle.radius + bundle.bulge + top.max(0.0) {
                break;
            }
            if part.piece.keeps_off_rays(part.body, &bundle, [reach, top]) > 0.0 {
                continue;
            }
            for ((ray, aside), lowest) in rays.iter().zip(&aside).zip(lowest.iter_mut()) {
                if *clearance <= aside + lowest.s.max(0.0) {
                    lowest.search(part, ray, tolerance);
                }
            }
        }
        for (((ray, aside), lowest), nearest) in
            rays.iter().zip(&aside).zip(lowest.iter()).zip(nearest.iter_mut())
        {
            if lowest.line.is_some() && lowest.s <= total {
                continue;
            }
            for (clearance, part) in &around {
                if *clearance > aside + nearest.s {
                    break;
                }
                nearest.approach(part, &ray.origin);
            }
        }
    }
}
