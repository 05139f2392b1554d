//! The whole chain from one job.

mod budget;

pub use budget::{Budget, BudgetError, Shares};
