//! Collects the moves that come to each tile, from programs of any length.

use super::margin::TileBound;
use super::survey::{TileSurvey, TileTask};
use super::{excess, gouge};
use crate::verify::deviation::chunks::{ChunkMotion, MotionChunk, MotionChunks};
use crate::verify::error::VerifyError;
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::quadratic::MotionPiece;
use crate::verify::swept::rays::RayBundle;
use rayon::prelude::*;

/// Moves that come to some tiles.
struct GatheredMoves {
    /// Number of tiles served.
    count: usize,
    pieces: Vec<MotionPiece>,
    /// Numbers of pieces, by tile.
    lists: Vec<Vec<u32>>,
    /// Even the only tile served has more moves than can be kept.
    crowded: bool,
}

/// Bounds each tile with the moves that come to it below `task.top`, running the program as often as memory requires.
pub(crate) fn each(
    chunks: &MotionChunks<'_>,
    tasks: &[TileTask<'_>],
) -> Result<Vec<[TileBound; 2]>, VerifyError> {
    let mut done: Vec<[TileBound; 2]> = Vec::with_capacity(tasks.len());
    let mut count = tasks.len();
    // Each round replays the program for as many tiles as fit into memory. A round that served fewer sets the
    // number for the next.
    while let Some(left) = tasks.get(done.len()..).filter(|left| !left.is_empty()) {
        let some = left.get(..count).unwrap_or(left);
        let GatheredMoves { count: taken, pieces, lists, crowded } = gather(chunks, some)?;
        count = taken;
        let bound = |(task, list): (&TileTask<'_>, &Vec<u32>)| {
            if crowded {
                return task.crowded();
            }
            let of = list.iter().filter_map(|&number| pieces.get(number as usize));
            let parts = ChunkMotion { pieces: of.copied().collect(), scope: chunks.scope.clone() };
            TileSurvey { task: *task, parts }.tile()
        };
        done.par_extend(some.par_iter().zip(&lists).map(bound));
    }
    Ok(done)
}

/// Collects the moves of some tiles, or of the first of them if those are too many.
fn gather(chunks: &MotionChunks<'_>, tasks: &[TileTask<'_>]) -> Result<GatheredMoves, VerifyError> {
    let tiles: Vec<(Vec<RayBundle>, f64)> =
        tasks.par_iter().map(|task| (task.ground.bundles(task.cells), task.top)).collect();
    let count = tasks.len();
    let mut all =
        GatheredMoves { count, pieces: Vec::new(), lists: vec![Vec::new(); count], crowded: false };
    // Moves outside the box around all bundles need no place in the trees.
    let boxes = tiles
        .iter()
        .flat_map(|(bundles, top)| bundles.iter().map(|bundle| chunks.scope.around(bundle, *top)));
    let within = boxes.fold(BoundingBox::empty(), |all, each| all.join(&each));
    chunks.each(&within, |chunk, _| {
        if all.crowded {
            return Ok(());
        }
        let coming =
            tiles.par_iter().take(all.count).map(|(bundles, top)| chunk.coming(bundles, *top));
        let coming: Vec<Vec<u32>> = coming.collect();
        all.take(chunk, &coming, chunks.kept());
        Ok(())
    })?;
    Ok(all)
}

impl GatheredMoves {
    /// Adds the moves of a chunk that come to the tiles, keeping `most` pieces at most.
    fn take(&mut self, chunk: &MotionChunk, coming: &[Vec<u32>], most: usize) {
        let mut numbers = vec![None; chunk.parts.pieces.len()];
        for (list, coming) in self.lists.iter_mut().zip(coming) {
            for &index in coming {
                let (Some(number), Some(piece)) =
                    (numbers.get_mut(index as usize), chunk.parts.pieces.get(index as usize))
                else {
                    continue;
                };
                let next = u32::try_from(self.pieces.len()).unwrap_or(u32::MAX);
                // A piece that comes to several tiles is stored once.
                let number = *number.get_or_insert(next);
                if number == next {
                    self.pieces.push(*piece);
                }
                list.push(number);
            }
        }
        // Too many pieces: serve half of the tiles, and drop the pieces that only the others need.
        while self.pieces.len() > most && self.count > 1 {
            self.count = self.count.div_ceil(2);
            self.shrink();
        }
        if self.pieces.len() > most {
            (self.crowded, self.pieces) = (true, Vec::new());
        }
    }

    /// Keeps only the moves of the tiles served, in order.
    fn shrink(&mut self) {
        self.lists.truncate(self.count);
        let mut wanted = vec![false; self.pieces.len()];
        for &number in self.lists.iter().flatten() {
            if let Some(wanted) = wanted.get_mut(number as usize) {
                *wanted = true;
            }
        }
        // Compact the pieces in order, and renumber the lists alike.
        let mut next = 0;
        let renumbered: Vec<u32> = wanted
            .iter()
            .map(|wanted| {
                let number = next;
                next += u32::from(*wanted);
                number
            })
            .collect();
        let mut kept = wanted.iter();
        self.pieces.retain(|_| kept.next().is_some_and(|wanted| *wanted));
        for number in self.lists.iter_mut().flatten() {
            *number = renumbered.get(*number as usize).copied().unwrap_or(*number);
        }
    }
}

impl TileSurvey<'_> {
    fn tile(&self) -> [TileBound; 2] {
        let excess = if self.excess { excess::tile(self) } else { self.task.start[1] };
        [gouge::tile(self), excess]
    }
}
