//! Bounds of whole faces: distributes the tiles and repeats those that need more pieces or more moves.

use super::gather;
use super::margin::{MarginRule, TileBound};
use super::shape::FaceShape;
use super::survey::{MeasuredFace, TileTask};
use crate::surface::Face;
use crate::verify::deviation::chunks::MotionChunks;
use crate::verify::deviation::map::MeasuredMap;
use crate::verify::error::VerifyError;
use crate::verify::report::{ExtremeHeight, HeightBounds};

/// Most pieces of a tile at first, for each bound: several times the average of a tile on which strips of round corners
/// meet.
const FEW_PIECES: usize = 400;
/// Most pieces of all tiles that need more, together: about half a minute on one core.
///
/// The cusp that a sharp edge leaves between two moves is held only in pieces of some micrometres; a face full of those is
/// not worth hours.
const ALL_PIECES: usize = 1_500_000;
/// Most pieces of one such tile. More are needed only where the bound cannot come near the truth.
const MOST_PIECES: usize = 60_000;
/// Most broken tiles that are divided into their cells: there are more regions then than are named.
const MOST_DIVIDED: usize = 64;

/// Margins and starting points of the bounds of a set of faces.
pub(crate) struct BoundRequest {
    /// Margins of gouge and of excess.
    pub(crate) rules: [MarginRule; 2],
    /// The excess is bounded as well.
    pub(crate) excess: bool,
    /// Lowest and highest height measured \[mm\].
    pub(crate) extremes: [Option<f64>; 2],
}

/// Bounds of a set of faces, and the points that were found on the way.
pub(crate) struct FoundBounds {
    pub(crate) bounds: HeightBounds,
    /// Deepest gouge and highest excess, where they are worse than those measured.
    pub(crate) worst: [Option<ExtremeHeight>; 2],
    /// Worst points of tiles and cells that break a tolerance.
    pub(crate) broken: Vec<ExtremeHeight>,
}

/// Bounds the deviation over measured faces.
pub(crate) fn bounds(
    chunks: &MotionChunks<'_>,
    faces: &[Face],
    measured: &[MeasuredMap<'_>],
    request: &BoundRequest,
) -> Result<FoundBounds, VerifyError> {
    let BoundRequest { rules: [deep, tall], excess: bounded, extremes: [low, high] } = *request;
    // Start from the worst heights measured.
    let worst = [
        TileBound::new(low.map_or(0.0, |height| -height), deep),
        TileBound::new(high.unwrap_or(0.0), tall),
    ];
    let mut known = worst;
    let mut grounds = Vec::new();
    for (face, MeasuredMap { map, deciding, trims }) in faces.iter().zip(measured) {
        let shape = FaceShape::new(face);
        grounds.push(MeasuredFace { shape, trims, map, deciding, worst, excess: bounded });
    }
    let tasks = tasks(&grounds, chunks.scope.reach);
    let tiles = all(chunks, &grounds, tasks.clone())?;
    for [gouge, excess] in &tiles {
        known = [known[0].join(gouge), known[1].join(excess)];
    }
    let cells = cell_by_cell(chunks, &tasks, &tiles)?;
    let broken = tiles.iter().chain(&cells).flatten().filter_map(TileBound::breach).collect();
    let [gouge, excess] = known;
    let bounds = HeightBounds {
        gouge: gouge.bound(),
        excess: bounded.then(|| excess.bound()),
        open: if bounded { gouge.open.max(excess.open) } else { gouge.open },
    };
    Ok(FoundBounds { bounds, worst: [gouge.extreme, excess.extreme], broken })
}

/// Returns the tiles of all faces as tasks.
fn tasks<'a>(grounds: &'a [MeasuredFace<'a>], reach: f64) -> Vec<TileTask<'a>> {
    let of = |ground: &'a MeasuredFace<'a>| {
        ground.tiles().into_iter().map(move |cells| ground.tile_task(cells, FEW_PIECES, reach))
    };
    grounds.iter().flat_map(of).collect()
}

/// Bounds the cells of broken tiles one by one, if such tiles are few: a tile states its worst point alone.
fn cell_by_cell<'a>(
    chunks: &MotionChunks<'_>,
    tasks: &[TileTask<'a>],
    tiles: &[[TileBound; 2]],
) -> Result<Vec<[TileBound; 2]>, VerifyError> {
    let is_broken = |tile: &[TileBound; 2]| tile.iter().any(TileBound::is_broken);
    let broken = || tasks.iter().zip(tiles).filter(|(_, tile)| is_broken(tile));
    if broken().count() > MOST_DIVIDED {
        return Ok(Vec::new());
    }
    let reach = chunks.scope.reach;
    let of_tile = |(task, _): (&TileTask<'a>, _)| {
        let ground = task.ground;
        let cells = task.cells.each().filter(|cell| ground.rectangle(*cell).is_some());
        cells.map(|cell| ground.cell_task(cell, FEW_PIECES, reach))
    };
    let mut cells: Vec<TileTask<'_>> = broken().flat_map(of_tile).collect();
    bound_tiles(chunks, &mut cells)
}

/// Bounds all tiles of all faces. The tiles of a face that need many pieces share the limit of the face.
fn all<'a>(
    chunks: &MotionChunks<'_>,
    grounds: &[MeasuredFace<'a>],
    mut tasks: Vec<TileTask<'a>>,
) -> Result<Vec<[TileBound; 2]>, VerifyError> {
    let mut tiles = bound_tiles(chunks, &mut tasks)?;
    let ended = |tile: &[TileBound; 2]| tile.iter().any(|known| known.ended);
    let mut again = Vec::new();
    for ground in grounds {
        let of = |(task, tile): &(&TileTask<'_>, &[TileBound; 2])| {
            std::ptr::eq(task.ground, ground) && ended(tile)
        };
        let count = tasks.iter().zip(&tiles).filter(of).count();
        // The open tiles of a face share its limit evenly.
        let most = MOST_PIECES.min(ALL_PIECES / count.max(1));
        if most > FEW_PIECES {
            let indices = tasks.iter().zip(&tiles).enumerate().filter(|(_, pair)| of(pair));
            again.extend(indices.map(|(index, (task, _))| (index, TileTask { most, ..*task })));
        }
    }
    let (indices, mut more): (Vec<usize>, Vec<TileTask<'_>>) = again.into_iter().unzip();
    for (index, known) in indices.into_iter().zip(bound_tiles(chunks, &mut more)?) {
        if let Some(tile) = tiles.get_mut(index) {
            *tile = known;
        }
    }
    Ok(tiles)
}

/// Bounds tiles. If higher moves may count, repeats a tile with all moves within reach.
fn bound_tiles(
    chunks: &MotionChunks<'_>,
    tasks: &mut [TileTask<'_>],
) -> Result<Vec<[TileBound; 2]>, VerifyError> {
    let mut tiles = gather::each(chunks, tasks)?;
    let short = |tile: &[TileBound; 2]| tile.iter().any(|known| known.short);
    let mut higher = Vec::new();
    for (index, (task, tile)) in tasks.iter_mut().zip(&tiles).enumerate() {
        if short(tile) {
            // A tile met a hole below the gathered moves: higher ones may fill it, so it takes all within reach.
            task.top = chunks.scope.reach;
            higher.push((index, *task));
        }
    }
    let (indices, higher): (Vec<usize>, Vec<TileTask<'_>>) = higher.into_iter().unzip();
    let found = gather::each(chunks, &higher)?;
    for (index, known) in indices.into_iter().zip(found) {
        if let Some(tile) = tiles.get_mut(index) {
            *tile = known;
        }
    }
    Ok(tiles)
}
