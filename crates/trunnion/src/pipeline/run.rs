//! The chain from a job to its programs.

use super::error::PipelineError;
use super::job::Job;
use super::outcome::Outcome;
use super::planned_motion::PlannedMotion;
use super::programs::{self, ProgramInputs, Programs};
use super::reach::reach;
use super::regions;
use super::retracts;
use super::sheets::{Sheets, cutter_locations, sheets};
use super::solids::{Solids, solids};
use super::stages;
use super::summary::{StageResults, summary};
use super::turn_limit;
use crate::cover::Covering;
use crate::files::summary::TurnLimitSummary;
use crate::nc::write::OutputFormat;
use crate::toolpath::SmoothedPath;
use crate::types::{Leg, Progress};

/// Runs the whole chain.
///
/// A result that breaks a tolerance or a limit is not an error: see [`Summary::passed`](crate::files::summary::Summary::passed).
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn run(job: &Job, progress: &dyn Progress) -> Result<Outcome, PipelineError> {
    // Step 1: refuse what cannot work, before the long stages.
    reach(job)?;
    let solids = solids(job)?;
    // Step 2: passes, and curves through their cutter locations.
    let covering = covered(job, progress)?;
    let turn_limit = turn_limit::cost(job, &covering.report, progress)?;
    let legs = stages::legs(job, &covering.passes, progress)?;
    let run = PlannedPasses { job, covering, turn_limit, legs, solids };
    // From here on work is not lost: what cannot become a program remains as cutter locations.
    let cl = cutter_locations(job, &run.legs)?;
    run.programs(progress).map_err(|error| match error {
        PipelineError::Cancelled(_) => error,
        error => PipelineError::AfterPasses { why: Box::new(error), cl },
    })
}

/// Passes of a job, in the order they are run.
struct PlannedPasses<'a> {
    job: &'a Job,
    covering: Covering,
    turn_limit: Option<TurnLimitSummary>,
    legs: Vec<Leg>,
    solids: Solids,
}

impl PlannedPasses<'_> {
    /// Runs the passes on the machine, and writes the programs.
    fn programs(self, progress: &dyn Progress) -> Result<Outcome, PipelineError> {
        let Self { job, covering, turn_limit, legs, solids } = self;
        let SmoothedPath { path: tool_path, report, along } =
            stages::tool_path(job, &legs, progress)?;
        // Step 3: axes and speeds.
        let followed = stages::axes(job, &tool_path, progress)?;
        let plan = stages::feed(job, &followed.path, progress)?;
        stages::rows(job, &plan)?;
        let retracts = retracts::summaries(job, &followed, &plan.schedule);
        let singular = stages::singular_gain(job, &tool_path, &followed, &plan, progress)?;
        let motion =
            PlannedMotion { followed: &followed, plan: &plan, retracts: &retracts, singular };
        // Step 4: programs with their check, sheets, summary.
        let inputs =
            ProgramInputs { motion: &motion, uncut: &covering.report.rest, solids: &solids };
        let Programs { checked: programs, left_out } = programs::write(job, inputs, progress)?;
        let formats: Vec<OutputFormat> = job
            .file
            .dialects
            .iter()
            .copied()
            .filter(|format| left_out.iter().all(|left| left.format != *format))
            .collect();
        let Sheets { cl, setup } = sheets(job, &legs, &motion, &formats)?;
        let results = StageResults {
            covering: &covering,
            turn_limit,
            motion: &motion,
            programs: &programs,
            left_out: &left_out,
            solids: &solids,
        };
        let summary = summary(job, &results)?;
        Ok(Outcome {
            covering,
            legs,
            tool_path,
            smoothing: (report, along),
            followed,
            plan,
            programs,
            left_out,
            fixtures: solids.fixtures,
            cl,
            setup,
            summary,
        })
    }
}

/// Places the passes over the faces; at least one must exist.
pub(super) fn covered(job: &Job, progress: &dyn Progress) -> Result<Covering, PipelineError> {
    let covering = stages::cover(job, progress)?;
    if covering.passes.is_empty() {
        return Err(PipelineError::NothingCut { why: regions::unfinished(job, &covering) });
    }
    Ok(covering)
}

/// Returns the passes over the faces with leads and links as APT/CL text, without the motion of a machine.
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn locations(job: &Job, progress: &dyn Progress) -> Result<String, PipelineError> {
    let covering = covered(job, progress)?;
    let legs = stages::legs(job, &covering.passes, progress)?;
    cutter_locations(job, &legs)
}
