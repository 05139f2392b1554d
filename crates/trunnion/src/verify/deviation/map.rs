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

/// Face under measurement.
pub(crate) struct FaceField<'a> {
    face: &'a Face,
    grid: FaceGrid,
    trims: TrimSegments,
    tiles: Vec<GridTile>,
    /// Number of points without a normal.
    bare: usize,
}

/// Face that is divided into tiles.
struct TiledFace<'a> {
    face: &'a Face,
    trims: &'a TrimSegments,
    grid: &'a FaceGrid,
}

/// Points of a face by their indices in the map, with the lowest entry over each.
struct GridTile {
    indices: Vec<usize>,
    /// Rules for the depth of a gouge at each of them.
    rules: Vec<DepthRule>,
    lowest: Vec<LowestEntry>,
    /// Nearest cutting end within the tolerance, where nothing cuts along the normal.
    nearest: Vec<LowestEntry>,
    /// Box around all rays, and as far beside them as a tool counts.
    region: BoundingBox,
}

/// Deviation map of a face with the tool poses that decide its heights.
pub(crate) struct MeasuredMap {
    pub(crate) map: FaceMap,
    /// Deciding pose at each point of the map.
    pub(crate) deciding: Vec<Option<DecidingPose>>,
    /// Border of the face.
    pub(crate) trims: TrimSegments,
}

/// Measures faces at the points of their grids; `advance` receives the share done.
pub(crate) fn maps(
    chunks: &MotionChunks<'_>,
    faces: &[Face],
    grids: Vec<FaceGrid>,
    advance: &mut dyn FnMut(f64) -> Result<(), Cancelled>,
) -> Result<Vec<MeasuredMap>, VerifyError> {
    let fields = faces.iter().zip(grids);
    let mut fields: Vec<FaceField<'_>> = fields
        .map(|(face, grid)| FaceField::new(face, grid, &chunks.scope))
        .collect::<Result<_, _>>()?;
    let all: usize = fields.iter().map(|field| field.tiles.len()).sum();
    chunks.each(&BoundingBox::everywhere(), |chunk, [from, to]| {
        let mut done = 0;
        for field in &mut fields {
            let FaceField { face, grid, tiles, .. } = field;
            for batch in tiles.chunks_mut(BATCH) {
                batch.par_iter_mut().for_each(|tile| tile.take(chunk, face, grid));
                done += batch.len();
                // Within a chunk the progress goes by tiles.
                advance(from + (to - from) * done as f64 / all as f64)?;
            }
        }
        Ok(())
    })?;
    let moves = chunks.scope.moves;
    Ok(fields.into_iter().map(|field| field.finish(moves)).collect())
}

/// Returns the ray from a point of a face, if the face has a normal there.
fn ray(face: &Face, [u, v]: [f64; 2], below: f64) -> Option<NormalRay> {
    let normal = face.normal(u, v)?.into_inner();
    Some(NormalRay { origin: face.point(u, v), normal, below, rule: DepthRule::AlongNormal })
}

impl<'a> FaceField<'a> {
    fn new(face: &'a Face, grid: FaceGrid, scope: &MeasureScope) -> Result<Self, VerifyError> {
        let [rows, columns] = grid.size();
        let trims = TrimSegments::over(face, [&grid.u, &grid.v])?;
        let corners: Vec<[usize; 2]> = (0..rows)
            .step_by(TILE)
            .flat_map(|i| (0..columns).step_by(TILE).map(move |j| [i, j]))
            .collect();
        let whole = TiledFace { face, trims: &trims, grid: &grid };
        let tile = |&corner| GridTile::new(&whole, corner, scope);
        let (tiles, bare): (Vec<GridTile>, Vec<usize>) = corners.par_iter().map(tile).unzip();
        Ok(Self { face, tiles, bare: bare.iter().sum(), grid, trims })
    }

    fn finish(self, moves: MoveKind) -> MeasuredMap {
        let Self { face, grid, trims, tiles, bare: mut unmeasured } = self;
        let [rows, columns] = grid.size();
        let mut samples = vec![None; rows * columns];
        let mut deciding = vec![None; rows * columns];
        for tile in tiles {
            let entries = tile.lowest.into_iter().zip(tile.nearest);
            // At an edge the tool that cuts the next face may be nearer than what cuts along the normal.
            let entries = entries.map(|(lowest, nearest)| lowest.or_nearer(nearest));
            for (index, lowest) in tile.indices.into_iter().zip(entries) {
                // A search that was given up may have missed a lower entry: its point counts as unmeasured.
                unmeasured += usize::from(lowest.unresolved);
                if let (Some(sample), Some(by)) = (samples.get_mut(index), deciding.get_mut(index))
                {
                    let dog_leg = moves == MoveKind::DogLegs;
                    *sample = self::sample(face, &grid, index, &lowest)
                        .map(|sample| HeightSample { dog_leg, ..sample });
                    *by = lowest.by;
                }
            }
        }
        let FaceGrid { u, v } = grid;
        let unfinished = Vec::new();
        let map = FaceMap { face: face.number, u, v, samples, unmeasured, unfinished };
        MeasuredMap { map, deciding, trims }
    }
}

fn sample(
    face: &Face,
    grid: &FaceGrid,
    index: usize,
    lowest: &LowestEntry,
) -> Option<HeightSample> {
    let (uv, cell) = at(grid, index)?;
    let [u, v] = uv;
    let jet = face.surface.jet1(u, v);
    // |S_u x S_v| du dv.
    let area = Vector3::cross(&jet.su, &jet.sv).norm() * cell;
    let height = lowest.line.map(|_| lowest.s);
    Some(HeightSample {
        uv: uv.into(),
        point: face.point(u, v),
        height,
        line: lowest.line,
        dog_leg: false,
        area,
        rest: false,
    })
}

/// Returns the parameters of a grid point, and the area of (u, v) it represents.
fn at(grid: &FaceGrid, index: usize) -> Option<([f64; 2], f64)> {
    let columns = grid.size()[1];
    let [i, j] = [index / columns, index % columns];
    Some((grid.at(i, j)?, grid.cell(i, j)))
}

impl GridTile {
    /// Collects the points of a tile that are on the face, and counts those without a normal.
    fn new(
        whole: &TiledFace<'_>,
        [row, column]: [usize; 2],
        scope: &MeasureScope,
    ) -> (Self, usize) {
        let TiledFace { face, trims, grid } = *whole;
        let [rows, columns] = grid.size();
        let (mut indices, mut region, mut bare) = (Vec::new(), BoundingBox::empty(), 0);
        let mut rules = Vec::new();
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
            }
        }
        let lowest = vec![LowestEntry::none(scope.top()); indices.len()];
        let nearest = vec![LowestEntry::none(scope.total); indices.len()];
        let region = region.grown(scope.aside());
        (Self { indices, rules, lowest, nearest, region }, bare)
    }

    /// Lowers the entries of the tile by the moves of a chunk.
    fn take(&mut self, chunk: &MotionChunk, face: &Face, grid: &FaceGrid) {
        let Self { indices, rules, lowest, nearest, region } = self;
        if !chunk.tree.meets(region) {
            return;
        }
        let MeasureScope { reach, tolerance, total, .. } = chunk.parts.scope;
        let points = indices.iter().zip(rules.iter());
        let rays = points.filter_map(|(&index, &rule)| {
            Some(NormalRay { rule, ..ray(face, at(grid, index)?.0, reach)? })
        });
        let rays: Vec<NormalRay> = rays.collect();
        let Some(middle) = rays.get(rays.len() / 2) else { return };
        let around = chunk.around(region, middle.origin);
        let bundle = RayBundle::around(middle, &rays);
        let aside: Vec<f64> = rays.iter().map(|ray| (ray.origin - middle.origin).norm()).collect();
        for (clearance, part) in &around {
            // Only moves below the highest entry so far can lower any ray of the tile.
            let top = lowest.iter().map(|lowest| lowest.s).fold(f64::NEG_INFINITY, f64::max);
            // The list is sorted, and distances change by at most 1 per mm: none of the rest can reach the rays.
            if *clearance > bundle.radius + bundle.bulge + reach.max(top) {
                break;
            }
            if part.piece.keeps_off_rays(part.body, &bundle, [reach, top]) > 0.0 {
                continue;
            }
            for ((ray, aside), lowest) in rays.iter().zip(&aside).zip(lowest.iter_mut()) {
                if *clearance <= aside + reach.max(lowest.s) {
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
