//! Faces and tiles whose deviation is bounded, with the moves that come to them.

use super::margin::TileBound;
use super::shape::{FaceShape, TrimCrossing, TrimSegments, UvRectangle};
use crate::verify::deviation::chunks::ChunkMotion;
use crate::verify::deviation::ray::DecidingPose;
use crate::verify::report::FaceMap;

/// Grid cells along the side of a tile.
pub(super) const TILE: usize = 8;

/// Face with its measured heights.
pub(super) struct MeasuredFace<'a> {
    pub(super) shape: FaceShape<'a>,
    pub(super) trims: TrimSegments,
    pub(super) map: &'a FaceMap,
    pub(super) deciding: &'a [Option<DecidingPose>],
    /// Worst gouge and worst excess known at the start.
    pub(super) start: [TileBound; 2],
    pub(super) excess: bool,
}

/// Tile of a face, with the moves that come to it.
pub(super) struct TileSurvey<'a> {
    pub(super) ground: &'a MeasuredFace<'a>,
    pub(super) parts: ChunkMotion,
    /// Moves that get no lower than this over the face may be missing \[mm\].
    pub(super) top: f64,
}

impl<'a> std::ops::Deref for TileSurvey<'a> {
    type Target = MeasuredFace<'a>;

    fn deref(&self) -> &MeasuredFace<'a> {
        self.ground
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

    /// Tests if the middle of a rectangle is on the face.
    pub(super) fn holds_middle(&self, rectangle: &UvRectangle, locate: &CellLocation) -> bool {
        let [u, v] = rectangle.map(|[low, high]| 0.5 * (low + high));
        match locate {
            CellLocation::Inside => true,
            CellLocation::Outside => false,
            CellLocation::Border(_) => self.shape.face.contains(u, v),
        }
    }

    pub(super) fn tiles(&self) -> Vec<[usize; 2]> {
        // Cells are one fewer than grid lines.
        let [rows, columns] = [self.map.u.len(), self.map.v.len()].map(|n| n.saturating_sub(1));
        let along = |i: usize| (0..columns).step_by(TILE).map(move |j| [i, j]);
        (0..rows).step_by(TILE).flat_map(along).collect()
    }

    /// Returns the parameter rectangle of a range of cells.
    pub(super) fn rectangle(&self, [i, j]: [usize; 2], count: usize) -> Option<UvRectangle> {
        let range = |values: &[f64], first: usize| {
            let last = (first + count).min(values.len().saturating_sub(1));
            Some([*values.get(first)?, *values.get(last)?])
        };
        Some([range(&self.map.u, i)?, range(&self.map.v, j)?])
    }
}

/// Tile to be bounded: its face and position, its limit of pieces, and the height up to which moves count.
#[derive(Clone, Copy)]
pub(super) struct TileTask<'a> {
    pub(super) ground: &'a MeasuredFace<'a>,
    pub(super) at: [usize; 2],
    pub(super) most: usize,
    pub(super) top: f64,
}

impl MeasuredFace<'_> {
    /// Returns the height above which moves are ignored until they turn out to count \[mm\].
    pub(super) fn top(&self, reach: f64) -> f64 {
        let start = &self.start[1];
        // Gouges need moves below the face alone; excess those up to the bound that is tried, with some room.
        if self.excess { reach.min(2.0 * start.aim() + start.margin()) } else { 0.0 }
    }

    /// Returns the state of a tile that more moves come to than can be inspected.
    pub(super) fn crowded(&self, at: [usize; 2]) -> [TileBound; 2] {
        let area = |rectangle: &UvRectangle| self.shape.cell(rectangle).map_or(0.0, |c| c.area());
        let parts = self.rectangle(at, TILE).map(|whole| self.shape.smooth_parts(whole));
        let area = parts.iter().flatten().map(area).sum();
        self.start.map(|mut known| {
            known.end(area);
            known
        })
    }
}
