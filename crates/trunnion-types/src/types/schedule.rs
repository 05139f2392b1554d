//! Speed schedules of axis paths.

use super::axis_path::AxisPath;

/// Reason why a schedule does not belong to a path. Pieces count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScheduleError {
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
}

/// Acceleration between two rows of a [`SchedulePiece`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AccelerationProfile {
    /// `d²s/dt²` is constant from each row to the next, and steps at rows.
    #[default]
    Constant,
    /// `d²s/dt²` is continuous: linear in `s` between rows, and jerk is constant in time between a
    /// row at rest (no speed, no acceleration) and its neighbour, where `s` goes with `t³`.
    Linear,
}

/// Times at which the nodes of one [`AxisPiece`](super::AxisPiece) are passed.
///
/// All vectors have one entry per row; rows are the nodes, and any the planner inserted.
///
/// # Example
///
/// ```
/// use trunnion_types::types::{AccelerationProfile, SchedulePiece};
///
/// // 1 s from rest at 2 mm/s², then 1 s at 2 mm/s.
/// let piece = SchedulePiece {
///     s: vec![0.0, 1.0, 3.0],
///     t: vec![0.0, 1.0, 2.0],
///     speed: vec![0.0, 2.0, 2.0],
///     acceleration: vec![2.0, 0.0, 0.0],
///     profile: AccelerationProfile::Constant,
/// };
/// assert_eq!(piece.at_time(0.5).map(|state| (state.s, state.speed)), Some((0.25, 1.0)));
/// assert_eq!(piece.time_at(2.0), 1.5);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SchedulePiece {
    /// Path parameter of each row.
    pub s: Vec<f64>,
    /// Time since the start of the schedule \[s\].
    pub t: Vec<f64>,
    /// `ds/dt` at each row.
    pub speed: Vec<f64>,
    /// `d²s/dt²`: from this row to the next under [`AccelerationProfile::Constant`] (the last entry repeats), at the row
    /// under [`AccelerationProfile::Linear`].
    pub acceleration: Vec<f64>,
    /// Acceleration between rows.
    pub profile: AccelerationProfile,
}

/// A speed schedule for an axis path, piece by piece.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Schedule {
    /// One per piece of the axis path.
    pub pieces: Vec<SchedulePiece>,
}

impl Schedule {
    /// Checks that the schedule belongs to `path`: piece by piece, every list as long as the others.
    ///
    /// # Errors
    ///
    /// [`ScheduleError`] of the first piece that does not fit.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_types::types::{AxisPath, Schedule, SchedulePiece};
    ///
    /// let path: AxisPath = AxisPath::default();
    /// assert!(Schedule::default().check_against(&path).is_ok());
    /// let longer = Schedule { pieces: vec![SchedulePiece::default()] };
    /// let error = longer.check_against(&path).unwrap_err();
    /// assert!(error.to_string().starts_with("the path has 0 pieces, the schedule 1"));
    /// ```
    pub fn check_against<const N: usize>(&self, path: &AxisPath<N>) -> Result<(), ScheduleError> {
        let [count, schedule] = [path.pieces.len(), self.pieces.len()];
        if count != schedule {
            return Err(ScheduleError::PieceCount { path: count, schedule });
        }
        for (piece, (of_path, rows)) in path.pieces.iter().zip(&self.pieces).enumerate() {
            let count = rows.s.len();
            // Every list has one entry a row, and an interval needs two rows.
            let equal = [rows.t.len(), rows.speed.len(), rows.acceleration.len()] == [count; 3];
            if of_path.nodes.len() < 2 || count < 2 || !equal {
                return Err(ScheduleError::BadPiece { piece });
            }
        }
        Ok(())
    }

    /// Returns the time at the end of the last piece \[s\].
    pub fn duration(&self) -> f64 {
        self.pieces.last().and_then(|piece| piece.t.last()).copied().unwrap_or(0.0)
    }
}
