//! Cost of the limit on the turn of the tool axis.

use super::error::PipelineError;
use super::job::Job;
use super::stages;
use crate::cover::CoverReport;
use crate::files::job::{JobArea, JobPlacement};
use crate::files::summary::TurnLimitSummary;
use crate::types::Progress;

/// Turn limit of a free axis \[rad/mm\]: no pass comes near it.
const FREE: f64 = 10.0;

/// Work of passes up to which the comparison runs unasked: some seconds, if there are no other faces to avoid.
const LITTLE: u64 = 15_000;

/// Covers the faces again with the axis free to turn, and compares both.
///
/// `None` at a fixed inclination, without an effective limit, and if it takes long and was not asked for.
pub(super) fn cost(
    job: &Job,
    report: &CoverReport,
    progress: &dyn Progress,
) -> Result<Option<TurnLimitSummary>, PipelineError> {
    let strategy = &job.file.strategy;
    let wanted = strategy.turn_cost.unwrap_or(report.work <= LITTLE && job.others.is_empty());
    // Passes over a rest are at a fixed inclination.
    // A barrel keeps its inclination.
    let is_widest = strategy.method == JobPlacement::Widest
        && strategy.area == JobArea::Whole
        && !job.cutter.is_barrel();
    if !is_widest || strategy.max_axis_turn >= FREE || !wanted {
        return Ok(None);
    }
    let free = stages::cover_turning(job, FREE, progress)?;
    let over = |limited: f64, free: f64| limited / free.max(f64::MIN_POSITIVE) - 1.0;
    Ok(Some(TurnLimitSummary {
        free_passes: free.passes.len(),
        free_length: free.report.length,
        length: over(report.length, free.report.length),
        time: over(report.cost, free.report.cost),
    }))
}
