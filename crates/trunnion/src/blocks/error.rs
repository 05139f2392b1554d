//! What can be wrong with what blocks are made of.

use super::BlockOptions;
use crate::types::{AxisPath, Cancelled, Schedule};

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

pub(super) fn validate(
    path: &AxisPath,
    schedule: &Schedule,
    options: &BlockOptions,
) -> Result<(), BlocksError> {
    let positive = [
        ("tolerance", options.tolerance),
        ("link_tolerance", options.link_tolerance),
        ("max_step", options.max_step),
        ("max_turn", options.max_turn),
        ("max_axis_turn", options.max_axis_turn),
        ("max_duration", options.max_duration),
    ];
    for (name, value) in positive {
        if value.is_nan() || value <= 0.0 {
            return Err(BlocksError::BadOption { name, value, must: "positive" });
        }
    }
    for (name, value) in [("lever", options.lever), ("min_duration", options.min_duration)] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(BlocksError::BadOption { name, value, must: "finite and not negative" });
        }
    }
    let counts = [path.pieces.len(), schedule.pieces.len()];
    if counts[0] != counts[1] {
        return Err(BlocksError::PieceCount { path: counts[0], schedule: counts[1] });
    }
    for (index, (piece, rows)) in path.pieces.iter().zip(&schedule.pieces).enumerate() {
        let count = rows.s.len();
        let equal = [rows.t.len(), rows.speed.len(), rows.acceleration.len()] == [count; 3];
        if piece.nodes.len() < 2 || count < 2 || !equal {
            return Err(BlocksError::BadPiece { piece: index });
        }
    }
    Ok(())
}
