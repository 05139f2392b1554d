//! Verbs as functions, for shells in other languages: the same work and the same messages, without a terminal.
//!
//! Options are those of the command line, as words: `["part.ngc", "--machine", "bc-trunnion"]`. Nothing is printed;
//! warnings come back as values.

mod files;
mod job;
mod verbs;

pub use crate::check::{CheckAnswer, ReplayAnswer, StockSource, TimedStockAnswer};
pub use crate::disk::{MemoryFiles, in_memory};
pub use crate::feed::{AxisColumn, AxisTable, PlanAnswer, PlanFigures, PlannedMotion};
pub use crate::init::ProposalAnswer;
pub use crate::machine::{CalibrationAnswer, CalibrationSummary, ImportAnswer, ImportSummary};
pub use crate::outcome::exit_code;
pub use crate::post::{MovesAnswer, PostAnswer};
pub use crate::progress::stage_words;
pub use crate::setup::SetupAnswer;
pub use files::{library, machine, machine_text, mesh, part, part_of_bytes};
pub use job::{JobAnswer, LoadedJob, load_job, load_job_text, run_job};
pub use verbs::{
    calibrate, check, import, moves, plan, post, propose, replay, setup, subprograms, timed_stock,
};
