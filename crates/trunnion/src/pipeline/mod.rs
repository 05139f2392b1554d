//! The whole chain from one job.

mod budget;
mod job;

pub use budget::{Budget, BudgetError, Shares};
pub use job::{Job, JobError};
