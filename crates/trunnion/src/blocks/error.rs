//! Errors of breaking a path into blocks.

use crate::types::{Cancelled, ScheduleError};

/// Reasons why a path was not broken into blocks. Pieces count from 0.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BlocksError {
    /// An option is out of range.
    #[error("{name} is {value}; it must be {must} (mm, rad, s)")]
    BadOption {
        /// Name of the field of [`BlockOptions`](super::BlockOptions).
        name: &'static str,
        /// Value given.
        value: f64,
        /// Range it must be in.
        must: &'static str,
    },
    /// The schedule does not belong to the path.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
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
    /// The caller cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
