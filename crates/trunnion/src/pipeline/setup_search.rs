//! Search for a better setup of a job.

use super::error::PipelineError;
use super::job::Job;
use super::operations::{OperationPasses, passes};
use super::run::covered;
use super::stages;
use crate::axes::{FollowedPath, SetupSearch, TiltBounds};
use crate::types::{Leg, Motion, Progress, Station};

/// Result of a search for a better setup.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SetupResult {
    /// The setups.
    pub search: SetupSearch,
    /// Planned time with the setup of the job and with the best \[s\]; `None` where none fits.
    pub seconds: [Option<f64>; 2],
}

/// Searches the rotation of the workpiece that keeps the tool path of all operations farthest from the singular
/// directions of the machine, and inside travel: [`crate::axes::setup`].
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
    let legs = if job.following.is_empty() {
        let covering = covered(job, progress)?;
        stages::legs(job, &covering.passes, progress)?
    } else {
        joined(job, passes(job, progress)?.operations)
    };
    let tool_path = stages::tool_path(job, &legs, progress)?.path;
    let search = stages::search(job, &tool_path, bounds, progress)?;
    // Both are planned with the same speeds, so that the times compare.
    let best = search.best.as_ref().map(|(_, followed)| followed);
    let seconds = |followed: Option<&FollowedPath>| {
        let plan = followed.map(|followed| stages::feed(job, &followed.path, progress));
        plan.map(|plan| plan.map(|plan| plan.schedule.duration())).transpose()
    };
    let seconds = [seconds(search.before_axes.as_ref())?, seconds(best)?];
    Ok(SetupResult { search, seconds })
}

/// Joins the legs of all operations. Those of other tools are rewritten for the first tool: the machine moves in the same way.
fn joined(job: &Job, operations: Vec<OperationPasses<'_>>) -> Vec<Leg> {
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
