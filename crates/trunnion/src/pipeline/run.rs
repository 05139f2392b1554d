//! The chain from a job to its programs.

use super::error::PipelineError;
use super::fit::fit;
use super::job::Job;
use super::leftover::Leftover;
use super::operations::{JobPasses, OperationMotion, OperationPasses, passes};
use super::outcome::Outcome;
use super::programs::{self, ProgramInputs, Programs};
use super::reach::reach;
use super::regions;
use super::sheets::{LegsOf, Sheets, cutter_locations, sheets};
use super::solids::{Solids, solids};
use super::stages;
use super::summary::{StageResults, summary};
use crate::cover::Covering;
use crate::nc::write::OutputFormat;
use crate::types::Progress;

/// Runs the whole chain, operation by operation.
///
/// A result that breaks a tolerance or a limit is not an error: see [`Summary::passed`](crate::files::summary::Summary::passed).
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn run(job: &Job, progress: &dyn Progress) -> Result<Outcome, PipelineError> {
    // Step 1: refuse what cannot work, before the long stages.
    job.operations().try_for_each(reach)?;
    let too_concave = fit(job)?;
    let solids = solids(job)?;
    // Step 2: passes, and curves through their cutter locations.
    let passes = passes(job, progress)?;
    // From here on work is not lost: what cannot become a program remains as cutter locations.
    let cl = cutter_locations(&legs_of(&passes.operations))?;
    programs(JobRun { job, passes, too_concave, solids }, progress).map_err(|error| match error {
        PipelineError::Cancelled(_) => error,
        error => PipelineError::AfterPasses { why: Box::new(error), cl },
    })
}

fn legs_of<'a>(operations: &'a [OperationPasses<'_>]) -> Vec<LegsOf<'a>> {
    operations.iter().map(|one| LegsOf { job: one.job, legs: &one.legs }).collect()
}

/// Job with the passes of its operations.
struct JobRun<'a> {
    job: &'a Job,
    passes: JobPasses<'a>,
    /// Warnings about faces that the cutters fit in part.
    too_concave: Vec<String>,
    solids: Solids,
}

/// Runs the passes on the machine, and writes the programs.
fn programs(run: JobRun<'_>, progress: &dyn Progress) -> Result<Outcome, PipelineError> {
    let JobRun { job, passes, too_concave, solids } = run;
    let JobPasses { operations, left, idle } = passes;
    let warnings = [too_concave, idle].concat();
    // Step 3: axes and speeds.
    let operations = operations.into_iter().map(|passes| OperationMotion::plan(passes, progress));
    let operations = operations.collect::<Result<Vec<OperationMotion<'_>>, _>>()?;
    // Step 4: programs with their check, sheets, summary.
    let inputs = ProgramInputs { operations: &operations, uncut: &left.regions, solids: &solids };
    let Programs { checked: programs, left_out } = programs::write(job, inputs, progress)?;
    let is_written = |format: &OutputFormat| left_out.iter().all(|left| left.format != *format);
    let formats: Vec<OutputFormat> = job.file.dialects.iter().copied().filter(is_written).collect();
    let Sheets { cl, setup } = sheets(&operations, &formats)?;
    let results = StageResults {
        operations: &operations,
        left: &left,
        warnings: &warnings,
        programs: &programs,
        left_out: &left_out,
        solids: &solids,
    };
    let summary = summary(job, &results)?;
    Ok(Outcome {
        operations: operations.into_iter().map(OperationMotion::result).collect(),
        programs,
        left_out,
        fixtures: solids.fixtures,
        cl,
        setup,
        summary,
    })
}

/// Places the passes of the first operation over its faces; at least one must exist.
pub(super) fn covered(job: &Job, progress: &dyn Progress) -> Result<Covering, PipelineError> {
    let covering = stages::cover(job, progress)?;
    if covering.passes.is_empty() {
        let left = Leftover::of(job, &covering);
        return Err(PipelineError::NothingCut { why: regions::unfinished(job, &left) });
    }
    Ok(covering)
}

/// Returns the passes over the faces with leads and links as APT/CL text, without the motion of a machine.
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn locations(job: &Job, progress: &dyn Progress) -> Result<String, PipelineError> {
    let passes = passes(job, progress)?;
    cutter_locations(&legs_of(&passes.operations))
}
