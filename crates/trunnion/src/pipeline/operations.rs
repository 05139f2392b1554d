//! Operations of a job: the passes of each, on what those before have left.

use super::error::PipelineError;
use super::job::Job;
use super::leftover::Leftover;
use super::planned_motion::PlannedMotion;
use super::wording::counted;
use super::{pass_order, regions, retracts, stages, turn_limit};
use crate::axes::FollowedPath;
use crate::cover::{Covering, JoinedPasses, LeftArea};
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
    /// Operations that cut nothing, and passes that are left out, one sentence each.
    pub(super) notes: Vec<String>,
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
    let (mut operations, mut notes) = (Vec::new(), Vec::new());
    for job in job.operations() {
        let is_rest = job.file.strategy.area == JobArea::Rest;
        let (regions, cut) = (left.on(job), left.cut_faces());
        if is_rest
            && regions.is_empty()
            && job.faces.iter().all(|face| cut.contains(&face.face().number))
        {
            notes.push(format!("{}: nothing is left for it to cut", job.name));
            continue;
        }
        let area = is_rest.then_some(LeftArea { cut: &cut, regions: &regions });
        let covering = match area {
            None => stages::cover(job, progress)?,
            Some(area) => stages::cover_left(job, area, progress)?,
        };
        let take_in = |left: &mut Leftover, covering: &Covering| {
            if is_rest { left.cut_rest(job, covering) } else { left.cut_whole(job, covering) }
        };
        if covering.passes.is_empty() {
            take_in(&mut left, &covering);
            notes.push(format!("{}: no pass with this tool finishes anything", job.name));
            continue;
        }
        let passes = pass_order::shorten_links(&job.kinematics, covering.passes);
        let covering = Covering { passes, ..covering };
        let JoinedOperation { passes, note } = join(job, area, covering, progress)?;
        take_in(&mut left, &passes.covering);
        operations.push(passes);
        notes.extend(note);
    }
    if operations.is_empty() {
        return Err(PipelineError::NothingCut { why: regions::unfinished(job, &left) });
    }
    Ok(JobPasses { operations, left, notes })
}

/// Passes of an operation with leads and links.
pub(super) struct JoinedOperation<'a> {
    pub(super) passes: OperationPasses<'a>,
    /// Passes that are left out, in a sentence.
    pub(super) note: Option<String>,
}

/// Adds leads and links to the passes of an operation. Passes that no lead or link connects are left out, and what they
/// leave is measured.
///
/// # Errors
///
/// The reason of the first pass, if none can be joined; [`PipelineError::Cancelled`].
pub(super) fn join<'a>(
    job: &'a Job,
    left: Option<LeftArea<'_>>,
    covering: Covering,
    progress: &dyn Progress,
) -> Result<JoinedOperation<'a>, PipelineError> {
    let JoinedPasses { legs, left_out } = stages::join(job, &covering.passes, progress)?;
    let Some(first) = left_out.first() else {
        let passes = OperationPasses { job, covering, legs };
        return Ok(JoinedOperation { passes, note: None });
    };
    if left_out.len() == covering.passes.len() {
        return Err(first.why.clone().into());
    }
    let passes = counted(left_out.len(), "pass");
    let note =
        format!("{passes} left out, what only they would finish is not finished: {}", first.why);
    let note = if job.name.is_empty() { note } else { format!("{}: {note}", job.name) };
    let indices: Vec<usize> = left_out.iter().map(|one| one.index).collect();
    let covering = stages::cover_without(job, left, covering, &indices);
    let passes = OperationPasses { job, covering, legs };
    Ok(JoinedOperation { passes, note: Some(note) })
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
