//! `trunnion feed`: a speed schedule for a table of axis positions.

mod args;
mod layout;
mod path;
mod plan;
mod refusal;
mod run;
mod schedule;
mod streamed;
mod summary;

pub(crate) use args::FeedArgs;
pub use run::{AxisColumn, AxisTable, PlanAnswer, PlanFigures, PlannedMotion};
pub(crate) use run::{answer, run};
