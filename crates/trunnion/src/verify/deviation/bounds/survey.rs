//! Faces and tiles whose deviation is bounded, with the moves that come to them.

use super::margin::TileBound;
use super::shape::{FaceShape, UvRectangle, quarters};
use super::trim_segments::{TrimCrossing, TrimSegments};
use crate::verify::deviation::chunks::ChunkMotion;
use crate::verify::deviation::ray::DecidingPose;
use crate::verify::report::{FaceMap, HeightSample};
use crate::verify::swept::rays::RayBundle;
use crate::verify::swept::tool::DepthRule;

/// Grid cells along the side of a tile.
const TILE: usize = 8;

/// Most quarterings of cells whose middle has no normal.
const NO_NORMAL: u32 = 3;

/// Square of grid cells, by the first of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileCells {
    pub(super) at: [usize; 2],
    /// Cells along its side.
    pub(super) size: usize,
}

impl TileCells {
    /// Returns the square of some cells each way that holds these, among those into which `whole` is divided.
    pub(super) fn within(self, whole: Self, size: usize) -> Self {
        let first = |k: usize| whole.at[k] + (self.at[k] - whole.at[k]) / size * size;
        Self { at: [first(0), first(1)], size }
    }

    /// Returns the cells one by one.
    pub(super) fn each(self) -> impl Iterator<Item = Self> {
        let [i, j] = self.at;
        let row = move |i| (j..j + self.size).map(move |j| Self { at: [i, j], size: 1 });
        (i..i + self.size).flat_map(row)
    }
}

/// Face with its measured heights.
pub(super) struct MeasuredFace<'a> {
    pub(super) shape: FaceShape<'a>,
    pub(super) trims: &'a TrimSegments,
    pub(super) map: &'a FaceMap,
    pub(super) deciding: &'a [Option<DecidingPose>],
    /// Worst gouge and worst excess of all faces.
    pub(super) worst: [TileBound; 2],
    pub(super) excess: bool,
}

/// Cells to be bounded.
#[derive(Clone, Copy)]
pub(super) struct TileTask<'a> {
    pub(super) ground: &'a MeasuredFace<'a>,
    pub(super) cells: TileCells,
    /// Gouge and excess from which the search starts.
    pub(super) start: [TileBound; 2],
    /// Largest number of pieces.
    pub(super) most: usize,
    /// Height above which moves are ignored until they turn out to count \[mm\].
    pub(super) top: f64,
}

/// Tile of a face, with the moves that come to it.
pub(super) struct TileSurvey<'a> {
    pub(super) task: TileTask<'a>,
    pub(super) parts: ChunkMotion,
}

impl<'a> std::ops::Deref for TileSurvey<'a> {
    type Target = MeasuredFace<'a>;

    fn deref(&self) -> &MeasuredFace<'a> {
        self.task.ground
    }
}

/// Location of a piece of the face relative to its trims.
pub(super) enum CellLocation {
    Inside,
    Outside,
    /// These trim segments cross it.
    Border(Vec<u32>),
}

impl MeasuredFace<'_> {
    /// Locates a rectangle; `among` are the trim segments that may touch it, `None` if none does.
    pub(super) fn locate(&self, rectangle: &UvRectangle, among: Option<&[u32]>) -> CellLocation {
        let Some(among) = among else { return CellLocation::Inside };
        let [u, v] = rectangle.map(|[low, high]| 0.5 * (low + high));
        match self.trims.side(rectangle, Some(among)) {
            TrimCrossing::Border(segments) => CellLocation::Border(segments),
            // No trim crosses the rectangle, so its middle decides for all of it.
            TrimCrossing::Clear if self.shape.face.contains(u, v) => CellLocation::Inside,
            TrimCrossing::Clear => CellLocation::Outside,
        }
    }

    /// Locates a rectangle about which nothing is known.
    pub(super) fn locate_any(&self, rectangle: &UvRectangle) -> CellLocation {
        if self.shape.face.loops.is_empty() {
            return CellLocation::Inside;
        }
        match self.trims.side(rectangle, None) {
            TrimCrossing::Border(segments) => CellLocation::Border(segments),
            TrimCrossing::Clear => self.locate(rectangle, Some(&[])),
        }
    }

    /// Returns the rule for the depth of a gouge at all points within `half` \[mm\] of a point, along u and along v.
    pub(super) fn depth_rule(&self, uv: [f64; 2], half: [f64; 2]) -> DepthRule {
        self.trims.depth_rule(self.shape.face, uv, half)
    }

    /// Tests if the middle of a rectangle is on the face.
    pub(super) fn holds_middle(&self, rectangle: &UvRectangle, locate: &CellLocation) -> bool {
        let [u, v] = rectangle.map(|[low, high]| 0.5 * (low + high));
        match locate {
            CellLocation::Inside => true,
            CellLocation::Outside => false,
            CellLocation::Border(_) => self.shape.face.contains(u, v),
        }
    }

    pub(super) fn tiles(&self) -> Vec<TileCells> {
        // Cells are one fewer than grid lines.
        let [rows, columns] = [self.map.u.len(), self.map.v.len()].map(|n| n.saturating_sub(1));
        let along = |i: usize| {
            (0..columns).step_by(TILE).map(move |j| TileCells { at: [i, j], size: TILE })
        };
        (0..rows).step_by(TILE).flat_map(along).collect()
    }

    /// Returns the parameter rectangle of cells; `None` beyond the grid.
    pub(super) fn rectangle(&self, cells: TileCells) -> Option<UvRectangle> {
        let TileCells { at: [i, j], size } = cells;
        let range = |values: &[f64], first: usize| {
            let last = (first + size).min(values.len().saturating_sub(1));
            (first < last).then_some([*values.get(first)?, *values.get(last)?])
        };
        Some([range(&self.map.u, i)?, range(&self.map.v, j)?])
    }
}

impl MeasuredFace<'_> {
    /// Returns the task to bound a tile with at most `most` pieces.
    ///
    /// If all points keep a tolerance, it starts from the worst of them: it is proven that nothing is much worse. Otherwise
    /// it starts from its own, so that every tile that breaks the tolerance is found.
    pub(super) fn tile_task(&self, cells: TileCells, most: usize, reach: f64) -> TileTask<'_> {
        let [gouge, excess] = self.worst;
        let own = self.own(cells);
        let start = [(gouge, own[0]), (excess, own[1])]
            .map(|(worst, own)| if worst.is_broken() { own } else { worst });
        self.task(cells, start, most, reach)
    }

    /// Returns the task to find what breaks a tolerance in a cell.
    pub(super) fn cell_task(&self, cell: TileCells, most: usize, reach: f64) -> TileTask<'_> {
        self.task(cell, self.own(cell), most, reach)
    }

    fn task(
        &self,
        cells: TileCells,
        start: [TileBound; 2],
        most: usize,
        reach: f64,
    ) -> TileTask<'_> {
        let [_, excess] = &start;
        // Gouges need moves below the face alone; excess those up to the bound that is tried, with some room.
        let top = if self.excess { reach.min(2.0 * excess.aim() + excess.margin()) } else { 0.0 };
        TileTask { ground: self, cells, start, most, top }
    }

    /// Returns what is known of some cells by themselves: the tolerance, or the worst of their points beyond it.
    fn own(&self, cells: TileCells) -> [TileBound; 2] {
        let mut own = self.worst;
        for (known, way) in own.iter_mut().zip([-1.0, 1.0]) {
            let counts = |sample: &&HeightSample| way < 0.0 || !sample.rest;
            let heights = self.samples(cells).filter(counts).filter_map(|sample| sample.height);
            let tolerance = known.room.tolerance;
            known.worst = heights.map(|height| way * height).fold(tolerance, f64::max);
        }
        own
    }

    /// Returns the samples at the corners of the cells of a tile.
    fn samples(&self, cells: TileCells) -> impl Iterator<Item = &HeightSample> {
        let TileCells { at: [i, j], size } = cells;
        let columns = self.map.v.len();
        let rows = i..(i + size + 1).min(self.map.u.len());
        let row = move |i: usize| i * columns + j..i * columns + (j + size + 1).min(columns);
        let samples = rows.map(row).filter_map(|row| self.map.samples.get(row));
        samples.flatten().flatten()
    }
}

impl MeasuredFace<'_> {
    /// Returns ray bundles that cover some cells.
    pub(super) fn bundles(&self, cells: TileCells) -> Vec<RayBundle> {
        let mut bundles = Vec::new();
        for part in self.rectangle(cells).iter().flat_map(|&whole| self.shape.smooth_parts(whole)) {
            self.bundle(part, 0, &mut bundles);
        }
        bundles
    }

    fn bundle(&self, rectangle: UvRectangle, level: u32, bundles: &mut Vec<RayBundle>) {
        if let Some(cell) = self.shape.cell(&rectangle) {
            bundles.push(cell.bundle());
        } else if level < NO_NORMAL {
            for quarter in quarters(rectangle) {
                self.bundle(quarter, level + 1, bundles);
            }
        }
    }
}

impl TileTask<'_> {
    /// Returns the state of a tile that more moves come to than can be inspected.
    pub(super) fn crowded(&self) -> [TileBound; 2] {
        let Self { ground, cells, start, .. } = *self;
        let area = |rectangle: &UvRectangle| ground.shape.cell(rectangle).map_or(0.0, |c| c.area());
        let parts = ground.rectangle(cells).map(|whole| ground.shape.smooth_parts(whole));
        let area = parts.iter().flatten().map(area).sum();
        start.map(|mut known| {
            known.end(area);
            known
        })
    }
}
