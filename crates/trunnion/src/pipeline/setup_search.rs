//! Search for a better setup of a job.

use super::error::{PipelineError, unless_stopped};
use super::job::Job;
use super::keep_clear::PlanChange;
use super::operations::{OperationMotion, OperationPasses, join, passes};
use super::programs::{self, ProgramInputs, TooNear};
use super::rotary_half::RotaryHalf;
use super::run::covered;
use super::solids::{Solids, solids};
use super::stages;
use crate::axes::{EvaluatedSetup, FollowedPath, SetupSearch, TiltBounds};
use crate::machine::{Kinematics, Setup};
use crate::types::{Leg, Motion, Progress, Station, ToolPath};

/// Most setups in which the distances of the machine's bodies are measured.
const MOST_MEASURED: usize = 12;

/// Result of a search for a better setup.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SetupResult {
    /// The setups; the best is the best of those in which bodies of the machine keep clear, if there is one.
    pub search: SetupSearch,
    /// Planned time with the setup of the job and with the best \[s\]; `None` where none fits.
    pub seconds: [Option<f64>; 2],
    /// Distances of the machine's bodies; `None` if the machine has none, or no setup fits.
    pub bodies: Option<BodiesInSetups>,
}

/// Distances of the machine's bodies in setups.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct BodiesInSetups {
    /// Setups in which bodies, fixtures or stock come too near on every branch, and which are otherwise better.
    pub passed_over: usize,
    /// Rotary travel within which all keep clear in the best setup; `None` where they do on the quickest branch.
    pub branch: Option<String>,
    /// True if all keep clear in the best setup; if not, it is the best without regard to them.
    pub clear: bool,
}

/// Searches the rotation of the workpiece that keeps the tool path of all operations farthest from the singular
/// directions of the machine, and inside travel: [`crate::axes::setup`]. On a machine with bodies, setups in which they
/// come too near, on every branch of the rotary axes that is tried, are passed over.
///
/// Operations follow each other by links without a change of tool, which times do not include anyway.
///
/// Passes and curves are those of [`run`](super::run()). A run with the new setup may place them a little differently:
/// the distance of the part from the rotary axes decides the effect of rounding, and so the shares of the other stages.
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn setup(
    job: &Job,
    bounds: &TiltBounds,
    progress: &dyn Progress,
) -> Result<SetupResult, PipelineError> {
    let operations = if job.following.is_empty() {
        let covering = covered(job, progress)?;
        vec![join(job, None, covering, progress)?.passes]
    } else {
        passes(job, progress)?.operations
    };
    let tool_path = stages::tool_path(job, &joined(job, &operations), progress)?.path;
    let mut search = stages::search(job, &tool_path, bounds, progress)?;
    let task = BodiesTask { job, operations: &operations, path: &tool_path };
    let bodies = task.pass_over(&mut search, progress)?;
    // Both are planned with the same speeds, so that the times compare.
    let best = search.best.as_ref().map(|(_, followed)| followed);
    let seconds = |followed: Option<&FollowedPath>| {
        let plan = followed.map(|followed| stages::feed(job, &followed.path, progress));
        plan.map(|plan| plan.map(|plan| plan.schedule.duration())).transpose()
    };
    let seconds = [seconds(search.before_axes.as_ref())?, seconds(best)?];
    Ok(SetupResult { search, seconds, bodies })
}

/// Measurement of the distances of the machine's bodies in setups.
struct BodiesTask<'a> {
    job: &'a Job,
    operations: &'a [OperationPasses<'a>],
    path: &'a ToolPath,
}

impl BodiesTask<'_> {
    /// Makes the best setup of those in which the bodies of the machine keep clear the best of all.
    fn pass_over(
        &self,
        search: &mut SetupSearch,
        progress: &dyn Progress,
    ) -> Result<Option<BodiesInSetups>, PipelineError> {
        if self.job.kinematics.machine().bodies.is_empty() {
            return Ok(None);
        }
        let Some((best, _)) = &search.best else { return Ok(None) };
        let solids = solids(self.job)?;
        let others = search.others.iter().filter(|other| other.verdict.fits().is_some());
        let fitting: Vec<EvaluatedSetup> =
            std::iter::once(best).chain(others).take(MOST_MEASURED).cloned().collect();
        for (passed_over, candidate) in fitting.iter().enumerate() {
            let job = placed(self.job, &candidate.setup);
            let Some((followed, half)) = self.clear_branch(&job, &solids, progress)? else {
                continue;
            };
            search.others.retain(|other| other.setup != candidate.setup);
            let best = search.best.replace((candidate.clone(), followed));
            // Those that are passed over stay the first of the others.
            let before = best.filter(|(best, _)| best.setup != candidate.setup);
            if let Some((before, _)) = before {
                search.others.insert(0, before);
            }
            let branch = half.map(|half| half.describe(job.kinematics.machine()));
            return Ok(Some(BodiesInSetups { passed_over, branch, clear: true }));
        }
        let passed_over = fitting.len();
        Ok(Some(BodiesInSetups { passed_over, branch: None, clear: false }))
    }

    /// Finds the quickest branch, or else another one, on which everything keeps clear. Returns the axes, and the half of
    /// rotary travel of another branch.
    fn clear_branch(
        &self,
        job: &Job,
        solids: &Solids,
        progress: &dyn Progress,
    ) -> Result<Option<(FollowedPath, Option<RotaryHalf>)>, PipelineError> {
        let halves = RotaryHalf::all(job.kinematics.machine()).into_iter().map(Some);
        for half in std::iter::once(None).chain(halves) {
            let on_branch = half.map(|half| PlanChange::Branch(half).job(job));
            let job = on_branch.as_ref().unwrap_or(job);
            let motions = self.motions(job, progress);
            let Some(operations) = unless_stopped(motions)? else { continue };
            let inputs = ProgramInputs { operations: &operations, uncut: &[], solids };
            match unless_stopped(programs::too_near(job, inputs, progress))? {
                Some(TooNear::Nothing) => {}
                // The tool stands before the fixtures in the same way on every branch.
                Some(TooNear::Fixtures) => return Ok(None),
                Some(TooNear::Bodies) | None => continue,
            }
            if let Some(followed) = unless_stopped(stages::axes(job, self.path, progress))? {
                return Ok(Some((followed, half)));
            }
        }
        Ok(None)
    }

    /// Plans the motion of the operations of a job that is placed elsewhere.
    fn motions<'j>(
        &self,
        job: &'j Job,
        progress: &dyn Progress,
    ) -> Result<Vec<OperationMotion<'j>>, PipelineError> {
        let motion = |(job, one): (&'j Job, &OperationPasses<'_>)| {
            let OperationPasses { covering, legs, .. } = one;
            let passes = OperationPasses { job, covering: covering.clone(), legs: legs.clone() };
            OperationMotion::plan(passes, progress)
        };
        let of =
            |one: &OperationPasses<'_>| job.operations().find(|job| job.index == one.job.index);
        self.operations.iter().filter_map(|one| Some((of(one)?, one))).map(motion).collect()
    }
}

/// Returns the job with its workpiece in another place.
fn placed(job: &Job, at: &Setup) -> Job {
    let mut job = job.clone();
    let place = |job: &mut Job| {
        let setup = Setup { tool_length: job.kinematics.setup().tool_length, ..*at };
        job.kinematics = Kinematics::new(job.kinematics.machine(), &setup);
    };
    place(&mut job);
    job.following.iter_mut().for_each(place);
    job
}

/// Joins the legs of all operations. Those of other tools are rewritten for the first tool: the machine moves in the same way.
fn joined(job: &Job, operations: &[OperationPasses<'_>]) -> Vec<Leg> {
    let mut all: Vec<Leg> = Vec::new();
    for OperationPasses { job: of, legs, .. } in operations {
        // Only the gauge point counts for the axes. It is the tool length off the tip, along the tool axis.
        let longer = of.cutter.length() - job.cutter.length();
        let moved = |station: &Station| {
            let mut station = *station;
            station.pose.tip += station.pose.axis.scale(longer);
            station
        };
        for leg in legs {
            let stations: Vec<Station> = leg.stations.iter().map(moved).collect();
            let last = all.last().and_then(|leg| leg.stations.last()).copied();
            if let (Some(last), Some(first)) = (last, stations.first())
                && last.pose != first.pose
            {
                all.push(Leg { motion: Motion::Link, stations: vec![last, *first] });
            }
            all.push(Leg { motion: leg.motion, stations });
        }
    }
    all
}
