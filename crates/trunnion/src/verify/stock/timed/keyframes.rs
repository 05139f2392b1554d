//! Stock after some of the moves, kept so that going back is quick.

use crate::verify::stock::dexel::RaySpans;
use crate::verify::stock::material::Stock;
use std::collections::BTreeMap;

/// Most keyframes beside the uncut stock.
const MOST: usize = 16;

/// States of the stock by the number of moves that have cut.
pub(super) struct Keyframes {
    kept: BTreeMap<usize, Stock>,
    /// Moves from one to the next.
    spacing: usize,
    /// Moves of the program; its end needs no keyframe.
    moves: usize,
}

impl Keyframes {
    /// Divides a program of `moves` moves by as many keyframes as `memory` \[bytes\] has room for.
    pub(super) fn new(uncut: Stock, moves: usize, memory: usize) -> Self {
        let count = (memory / size(&uncut).max(1)).min(MOST);
        let spacing = moves.div_ceil(count + 1).max(1);
        Self { kept: BTreeMap::from([(0, uncut)]), spacing, moves }
    }

    /// Returns the number of moves up to the next place of a keyframe.
    pub(super) fn distance(&self, done: usize) -> usize {
        self.spacing - done % self.spacing
    }

    /// Keeps the stock after `done` moves if that is the place of a keyframe.
    pub(super) fn offer(&mut self, done: usize, stock: &Stock) {
        if done < self.moves && done.is_multiple_of(self.spacing) {
            self.kept.entry(done).or_insert_with(|| stock.clone());
        }
    }

    /// Returns the latest one after at most `moves` moves.
    pub(super) fn before(&self, moves: usize) -> Option<(usize, &Stock)> {
        self.kept.range(..=moves).next_back().map(|(done, stock)| (*done, stock))
    }

    #[cfg(test)]
    pub(super) fn count(&self) -> usize {
        self.kept.len()
    }
}

/// Returns the memory of a stock whose rays have one interval each \[bytes\].
pub(super) fn size(stock: &Stock) -> usize {
    stock.rays() * size_of::<RaySpans>()
}
