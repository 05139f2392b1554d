//! Operations of a job: the passes of each, on what those before have left.

use super::error::PipelineError;
use super::job::Job;
use super::leftover::Leftover;
use super::planned_motion::PlannedMotion;
use super::{pass_order, regions, retracts, stages, turn_limit};
use crate::axes::FollowedPath;
use crate::cover::{Covering, LeftArea};
use crate::feed::FeedPlan;
use crate::files::job::JobArea;
use crate::files::summary::{RetractSummary, SingularSummary, TurnLimitSummary};
use crate::toolpath::{PathDeviation, SmoothReport, SmoothedPath};
use crate::types::{Leg, Progress, ToolPath};

/// Passes of one operation, in the order they are run.
pub(super) struct OperationPasses<'a> {
    pub(super) job: &'a Job,
    pub(super) covering: Covering,
    pub(super) legs: Vec<Leg>,
}

/// Passes of all operations.
pub(super) struct JobPasses<'a> {
    /// Operations that cut something, at least one.
    pub(super) operations: Vec<OperationPasses<'a>>,
    /// Regions that all of them leave.
    pub(super) left: Leftover,
    /// Operations that cut nothing, one sentence each.
    pub(super) idle: Vec<String>,
}

/// Places the passes of all operations, one after the other.
///
/// # Errors
///
/// [`PipelineError::NothingCut`] if no operation cuts anything; the error of the stage that could not go on.
pub(super) fn passes<'a>(
    job: &'a Job,
    progress: &dyn Progress,
) -> Result<JobPasses<'a>, PipelineError> {
    let mut left = Leftover::default();
    let (mut operations, mut idle) = (Vec::new(), Vec::new());
    for job in job.operations() {
        let covering = match job.file.strategy.area {
            JobArea::Whole => {
                let covering = stages::cover(job, progress)?;
                left.cut_whole(job, &covering);
                covering
            }
            JobArea::Rest => {
                let regions = left.on(job);
                let cut = left.cut_faces();
                if regions.is_empty()
                    && job.faces.iter().all(|face| cut.contains(&face.face().number))
                {
                    idle.push(format!("{}: nothing is left for it to cut", job.name));
                    continue;
                }
                let area = LeftArea { cut: &cut, regions: &regions };
                let covering = stages::cover_left(job, area, progress)?;
                left.cut_rest(job, &covering);
                covering
            }
        };
        if covering.passes.is_empty() {
            idle.push(format!("{}: no pass with this tool finishes anything", job.name));
            continue;
        }
        let passes = pass_order::shorten_links(&job.kinematics, covering.passes);
        let covering = Covering { passes, ..covering };
        let legs = stages::legs(job, &covering.passes, progress)?;
        operations.push(OperationPasses { job, covering, legs });
    }
    if operations.is_empty() {
        return Err(PipelineError::NothingCut { why: regions::unfinished(job, &left) });
    }
    Ok(JobPasses { operations, left, idle })
}

/// Motion of one operation.
#[derive(Debug)]
#[non_exhaustive]
pub struct PlannedOperation {
    /// Name; empty in a job of one operation.
    pub name: String,
    /// Index among the operations of the job.
    pub index: usize,
    /// Passes over the faces.
    pub covering: Covering,
    /// Passes with leads and links, in the order they are run.
    pub legs: Vec<Leg>,
    /// Curves through the cutter locations.
    pub tool_path: ToolPath,
    /// Report of their smoothing, and deviations by path length \[mm\]; empty unless the job asks for smoothing.
    pub smoothing: (SmoothReport, Vec<(f64, PathDeviation)>),
    /// Axes of the machine along them.
    pub followed: FollowedPath,
    /// Speeds.
    pub plan: FeedPlan,
}

/// Motion of one operation, with what the summary reports about it.
pub(super) struct OperationMotion<'a> {
    pub(super) job: &'a Job,
    pub(super) covering: Covering,
    pub(super) turn_limit: Option<TurnLimitSummary>,
    pub(super) legs: Vec<Leg>,
    tool_path: SmoothedPath,
    followed: FollowedPath,
    plan: FeedPlan,
    retracts: Vec<RetractSummary>,
    singular: Option<SingularSummary>,
}

impl<'a> OperationMotion<'a> {
    /// Runs passes on the machine: curves, axes and speeds.
    pub(super) fn plan(
        passes: OperationPasses<'a>,
        progress: &dyn Progress,
    ) -> Result<Self, PipelineError> {
        let OperationPasses { job, covering, legs } = passes;
        let turn_limit = turn_limit::cost(job, &covering.report, progress)?;
        let tool_path = stages::tool_path(job, &legs, progress)?;
        let followed = stages::axes(job, &tool_path.path, progress)?;
        let plan = stages::feed(job, &followed.path, progress)?;
        stages::rows(job, &plan)?;
        let retracts = retracts::summaries(job, &followed, &plan.schedule);
        let singular = stages::singular_gain(job, &tool_path.path, &followed, &plan, progress)?;
        Ok(Self { job, covering, turn_limit, legs, tool_path, followed, plan, retracts, singular })
    }

    /// Returns the motion of the machine.
    pub(super) fn motion(&self) -> PlannedMotion<'_> {
        let Self { followed, plan, retracts, singular, .. } = self;
        PlannedMotion { followed, plan, retracts, singular: *singular }
    }

    /// Returns the result for the outcome.
    pub(super) fn result(self) -> PlannedOperation {
        let Self { job, covering, legs, tool_path, followed, plan, .. } = self;
        let SmoothedPath { path: tool_path, report, along } = tool_path;
        let (name, index, smoothing) = (job.name.clone(), job.index, (report, along));
        PlannedOperation { name, index, covering, legs, tool_path, smoothing, followed, plan }
    }
}
