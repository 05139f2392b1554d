//! Search for a better setup of a job.

use super::error::PipelineError;
use super::job::Job;
use super::run::covered;
use super::stages;
use crate::axes::{FollowedPath, SetupSearch, TiltBounds};
use crate::types::Progress;

/// Result of a search for a better setup.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SetupResult {
    /// The setups.
    pub search: SetupSearch,
    /// Planned time with the setup of the job and with the best \[s\]; `None` where none fits.
    pub seconds: [Option<f64>; 2],
}

/// Searches the rotation of the workpiece that keeps the job's tool path farthest from the singular
/// directions of the machine, and inside travel: [`crate::axes::setup`].
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
    let covering = covered(job, progress)?;
    let legs = stages::legs(job, &covering.passes, progress)?;
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
