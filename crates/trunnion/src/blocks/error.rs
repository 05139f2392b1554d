//! Errors of breaking a path into blocks.

use crate::types::Cancelled;

/// Why a path was not broken into blocks. Pieces count from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BlocksError {
    /// An option is out of range.
    #[error("{name} is {value}; it must be {must} (mm, rad, s)")]
    BadOption {
        /// Name of the field of [`BlockOptions`].
        name: &'static str,
        /// Value given.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Path and schedule have different numbers of pieces.
    #[error("the path has {path} pieces, the schedule {schedule}; plan the path again")]
    PieceCount {
        /// Pieces of the path.
        path: usize,
        /// Pieces of the schedule.
        schedule: usize,
    },
    /// A piece of the path or of the schedule has less than two rows, or its lists differ in length.
    #[error("piece {piece} of path or schedule has less than two rows or lists of unequal length")]
    BadPiece {
        /// Index of the piece.
        piece: usize,
    },
    /// The deviation does not fall below the tolerance however short the block.
    #[error(
        "piece {piece}: at s = {s} the shortest block still deviates by {deviation:.3e} mm, \
         more than the tolerance of {tolerance:.3e} mm; the path is not smooth there, \
         or the tolerance is below rounding"
    )]
    Tolerance {
        /// Index of the piece.
        piece: usize,
        /// Path parameter where the block starts.
        s: f64,
        /// Deviation of the shortest block tried \[mm\].
        deviation: f64,
        /// Tolerance \[mm\].
        tolerance: f64,
    },
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
