//! The chain from a job to its programs.

use super::error::PipelineError;
use super::job::Job;
use super::outcome::Outcome;
use super::planned_motion::PlannedMotion;
use super::programs::{self, ProgramInputs};
use super::reach::reach;
use super::regions;
use super::retracts;
use super::sheets::{Sheets, cutter_locations, sheets};
use super::solids::solids;
use super::stages;
use super::summary::{StageResults, summary};
use super::turn_limit;
use crate::cover::Covering;
use crate::toolpath::SmoothedPath;
use crate::types::Progress;

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
    let SmoothedPath { path: tool_path, report, along } = stages::tool_path(job, &legs, progress)?;
    // Step 3: axes and speeds.
    let followed = stages::axes(job, &tool_path, progress)?;
    let plan = stages::feed(job, &followed.path, progress)?;
    stages::rows(job, &plan)?;
    let retracts = retracts::summaries(job, &followed, &plan.schedule);
    let singular = stages::singular_gain(job, &tool_path, &followed, &plan, progress)?;
    let motion = PlannedMotion { followed: &followed, plan: &plan, retracts: &retracts, singular };
    // Step 4: programs with their check, sheets, summary.
    let inputs = ProgramInputs { motion: &motion, uncut: &covering.report.rest, solids: &solids };
    let programs = programs::write(job, inputs, progress)?;
    let Sheets { cl, setup } = sheets(job, &legs, &motion)?;
    let results = StageResults {
        covering: &covering,
        turn_limit,
        motion: &motion,
        programs: &programs,
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
        fixtures: solids.fixtures,
        cl,
        setup,
        summary,
    })
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
