//! Pieces of the bodies that come near a tile, numbered in sequence.

use crate::verify::stock::broad_phase::{BodyPiece, MovingPart};

/// Pieces of some bodies in sequence: piece `k` lasts from `2 k - 1` to `2 k + 1`.
pub(crate) struct PieceChain<'a> {
    pub(crate) parts: &'a [&'a MovingPart],
    /// Number of the first piece of each body.
    first: Vec<usize>,
    pub(crate) pieces: Vec<BodyPiece<'a>>,
}

impl<'a> PieceChain<'a> {
    pub(super) fn new(parts: &'a [&'a MovingPart]) -> Self {
        let mut first = Vec::with_capacity(parts.len());
        let mut pieces = Vec::with_capacity(2 * parts.len());
        for part in parts {
            // The pieces of a body are consecutive, so the first of the next body ends their range.
            first.push(pieces.len());
            pieces.extend(part.straight.iter().map(|bounded| BodyPiece { part, bounded }));
        }
        Self { parts, first, pieces }
    }

    /// Returns the numbers of the pieces of a body.
    pub(crate) fn of(&self, part: usize) -> std::ops::Range<usize> {
        let first = self.first.get(part).copied().unwrap_or(0);
        first..self.first.get(part + 1).copied().unwrap_or(self.pieces.len())
    }
}
