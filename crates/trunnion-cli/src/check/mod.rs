//! `trunnion check`: a program against the part, and against the machine; or a table of setpoints.

mod args;
mod assumed_tool;
mod assumptions;
mod control_model;
mod creeping;
mod export;
mod limit_ratio;
mod named;
mod offset;
mod page;
mod planner_time;
mod remedy;
mod replay;
mod run;
mod setpoints;
mod setting;
mod smoothing;
mod stock;
mod subject;
mod summary;
mod timed_stock;
mod tool;
mod what_if;

pub(crate) use args::CheckArgs;
pub use replay::ReplayAnswer;
pub(crate) use replay::replay;
pub use run::CheckAnswer;
pub(crate) use run::{answer, run, subprograms};
pub(crate) use timed_stock::timed_stock;
pub use timed_stock::{StockSource, TimedStockAnswer};
pub(crate) use tool::ToolDescription;
