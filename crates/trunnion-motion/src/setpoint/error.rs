//! Errors of sampling a schedule.

use crate::types::ScheduleError;

/// Reason why a schedule cannot be sampled.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SetpointError {
    /// The servo period is not a positive time.
    #[error("servo period is {value} s; it must be finite and positive, for instance 0.001")]
    BadPeriod {
        /// Value given \[s\].
        value: f64,
    },
    /// The schedule does not belong to the path.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
}
