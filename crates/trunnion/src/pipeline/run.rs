//! The chain from a job to its programs.

use super::body_advice::near_at_home;
use super::error::{PipelineError, unless_stopped};
use super::fit::fit;
use super::job::Job;
use super::keep_clear::{NearThings, PlanChange, nearest};
use super::leftover::Leftover;
use super::operations::{JobPasses, OperationMotion, OperationPasses, passes};
use super::outcome::Outcome;
use super::programs::{self, ProgramInputs, Programs, TooNear};
use super::reach::reach;
use super::regions;
use super::sheets::{LegsOf, Sheets, cutter_locations, sheets};
use super::solids::{Solids, solids};
use super::stages;
use super::summary::{StageResults, summary};
use crate::cover::{Covering, JoinedPasses};
use crate::nc::write::OutputFormat;
use crate::types::Progress;

/// Runs the whole chain, operation by operation.
///
/// Where fixtures or bodies of the machine come too near in the programs, other plans are tried: branches of the rotary
/// axes, links, inclinations. The first that keeps all of them clear is the result.
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
    let planned = PlannedJob::plan(PassesOfJob { job, passes }, too_concave, progress)?;
    let written = planned.write(&solids, progress)?;
    // Other plans, where something comes too near.
    let near = NearThings::of(&written.checked);
    let mut clear = None;
    if near.any() && near_at_home(job, &written.checked, &solids).is_none() {
        let first = FirstPlan { planned: &planned, written: &written, solids: &solids };
        for change in near.changes(job) {
            clear = first.changed(change, progress)?;
            if clear.is_some() {
                break;
            }
        }
    }
    let outcome = match clear {
        Some(outcome) => outcome,
        None => planned.outcome(written, &solids)?,
    };
    Ok(Outcome { fixtures: solids.fixtures, ..outcome })
}

/// Passes of the operations of a job.
struct PassesOfJob<'a> {
    job: &'a Job,
    passes: JobPasses<'a>,
}

/// Job with the motion of its operations.
struct PlannedJob<'a> {
    job: &'a Job,
    operations: Vec<OperationMotion<'a>>,
    left: Leftover,
    warnings: Vec<String>,
}

impl<'a> PlannedJob<'a> {
    /// Plans axes and speeds.
    fn plan(
        passes: PassesOfJob<'a>,
        warnings: Vec<String>,
        progress: &dyn Progress,
    ) -> Result<Self, PipelineError> {
        let PassesOfJob { job, passes: JobPasses { operations, left, mut notes } } = passes;
        notes.retain(|line| !warnings.contains(line));
        let planned = operations.into_iter().map(|passes| OperationMotion::plan(passes, progress));
        let operations = planned.collect::<Result<Vec<_>, _>>()?;
        Ok(Self { job, operations, left, warnings: [warnings, notes].concat() })
    }

    fn inputs<'s>(&'s self, solids: &'s Solids) -> ProgramInputs<'s> {
        ProgramInputs { operations: &self.operations, uncut: &self.left.regions, solids }
    }

    /// Writes the programs, and checks them.
    fn write(&self, solids: &Solids, progress: &dyn Progress) -> Result<Programs, PipelineError> {
        programs::write(self.job, self.inputs(solids), progress)
    }

    /// Returns the planned time \[s\].
    fn duration(&self) -> f64 {
        self.operations.iter().map(|one| one.motion().plan.schedule.duration()).sum()
    }

    /// Returns the number of faults of the programs and of regions that they leave, beside what they come too near.
    fn faults(&self, written: &Programs) -> usize {
        let checks = written.checked.iter().filter_map(|program| program.check.as_ref());
        let findings: usize = checks.map(|check| check.findings.len()).sum();
        findings + regions::unfinished(self.job, &self.left).len()
    }

    /// Returns sheets and summary with the programs; the fixtures are left out.
    fn outcome(self, written: Programs, solids: &Solids) -> Result<Outcome, PipelineError> {
        let Self { job, operations, left, warnings } = self;
        let Programs { checked: programs, left_out } = written;
        let is_written = |format: &OutputFormat| left_out.iter().all(|left| left.format != *format);
        let formats: Vec<OutputFormat> =
            job.file.dialects.iter().copied().filter(is_written).collect();
        let Sheets { cl, setup } = sheets(&operations, &formats)?;
        let results = StageResults {
            operations: &operations,
            left: &left,
            warnings: &warnings,
            programs: &programs,
            left_out: &left_out,
            solids,
        };
        let summary = summary(job, &results)?;
        Ok(Outcome {
            operations: operations.into_iter().map(OperationMotion::result).collect(),
            programs,
            left_out,
            fixtures: None,
            cl,
            setup,
            summary,
        })
    }

    /// Returns the passes of a changed job, as they are but for what the change moves.
    fn passes_for<'b>(
        &self,
        changed: &'b Job,
        change: PlanChange,
        progress: &dyn Progress,
    ) -> Result<JobPasses<'b>, PipelineError> {
        if change.moves_passes() {
            changed.operations().try_for_each(reach)?;
            return passes(changed, progress);
        }
        let kept = |job: &'b Job| {
            self.operations.iter().find(|one| one.job.index == job.index).map(|one| (job, one))
        };
        let operations = changed.operations().filter_map(kept).map(|(job, one)| {
            let covering = one.covering.clone();
            let legs = if change.moves_links() {
                let JoinedPasses { legs, left_out } =
                    stages::join(job, &covering.passes, progress)?;
                if let Some(one) = left_out.into_iter().next() {
                    return Err(one.why.into());
                }
                legs
            } else {
                one.legs.clone()
            };
            Ok(OperationPasses { job, covering, legs })
        });
        let operations = operations.collect::<Result<Vec<_>, PipelineError>>()?;
        Ok(JobPasses { operations, left: self.left.clone(), notes: Vec::new() })
    }
}

/// Quickest plan of a job, in whose programs something comes too near.
struct FirstPlan<'a> {
    planned: &'a PlannedJob<'a>,
    written: &'a Programs,
    solids: &'a Solids,
}

impl FirstPlan<'_> {
    /// Plans the job with a change; `None` if it cannot be planned so, or if not all keeps clear then.
    fn changed(
        &self,
        change: PlanChange,
        progress: &dyn Progress,
    ) -> Result<Option<Outcome>, PipelineError> {
        // What is out of reach, or out of travel, cannot be planned with this change.
        Ok(unless_stopped(self.outcome_of(change, progress))?.flatten())
    }

    fn outcome_of(
        &self,
        change: PlanChange,
        progress: &dyn Progress,
    ) -> Result<Option<Outcome>, PipelineError> {
        let Self { planned: first, written, solids } = self;
        let job = change.job(first.job);
        let passes = first.passes_for(&job, change, progress)?;
        let passes = PassesOfJob { job: &job, passes };
        let mut planned = PlannedJob::plan(passes, first.warnings.clone(), progress)?;
        // The motion alone is judged first: it takes a small part of the whole check.
        if programs::too_near(&job, planned.inputs(solids), progress)? != TooNear::Nothing {
            return Ok(None);
        }
        let text = planned.write(solids, progress)?;
        let times = [first.duration(), planned.duration()];
        planned.warnings.push(change.describe(
            first.job,
            &nearest(&written.checked, solids),
            times,
        ));
        let is_clear = text.left_out.is_empty() && !NearThings::of(&text.checked).any();
        // What keeps clear may not be worse elsewhere.
        if !is_clear || planned.faults(&text) > first.faults(written) {
            return Ok(None);
        }
        Ok(Some(planned.outcome(text, solids)?))
    }
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
