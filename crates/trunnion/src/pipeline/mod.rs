//! The whole chain from one job: [`Job`] in, [`Outcome`] out.
//!
//! [`run`] reads like the picture on the crate's front page; each stage is one call. What a stage may
//! spend of the tolerance comes from the [`Budget`].

mod budget;
mod error;
mod estimate;
mod fixtures;
mod job;
mod material;
mod measured;
mod pace;
mod programs;
mod reach;
mod regions;
mod retracts;
mod stages;
mod summary;
mod turn_limit;

pub use budget::{Budget, BudgetError, Shares};
pub use error::PipelineError;
pub use fixtures::{Fixtures, Held, approach, collisions, nearest_fixture, too_near};
pub use job::{Job, JobError};
pub use material::{
    MOST_COLLISIONS, MOST_RAYS, Solids, collided, solids, summary as stock_summary,
};
pub use programs::Program;
pub use reach::{OutOfReach, reach};
pub use stages::{SETUP_SHOWN, SETUP_WITHIN, motion_limits};

use crate::axes::{FollowedPath, SetupSearch, TiltBounds};
use crate::cover::Covering;
use crate::feed::FeedPlan;
use crate::files::summary::Summary;
use crate::toolpath::{PathDeviation, SmoothReport, SmoothedPath};
use crate::types::{Leg, Progress, ToolPath};

/// Everything a run makes. Nothing is written anywhere.
#[derive(Debug)]
pub struct Outcome {
    /// Passes over the faces.
    pub covering: Covering,
    /// Passes with leads and links, in the order they are run.
    pub legs: Vec<Leg>,
    /// Curves through the cutter locations.
    pub tool_path: ToolPath,
    /// What smoothing them did, and along which length; empty unless the job asks for it.
    pub smoothing: (SmoothReport, Vec<(f64, PathDeviation)>),
    /// The machine's axes along them.
    pub followed: FollowedPath,
    /// Speeds.
    pub plan: FeedPlan,
    /// Programs as text, each with what its own check found.
    pub programs: Vec<Program>,
    /// Fixtures they were checked against; `None` without any.
    pub fixtures: Option<Fixtures>,
    /// Cutter locations as APT/CL text.
    pub cl: String,
    /// Setup sheet.
    pub setup: String,
    /// The numbers.
    pub summary: Summary,
}

/// Runs the whole chain.
///
/// A result that breaks a tolerance or a limit is not an error: see [`Summary::passed`].
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn run(job: &Job, progress: &dyn Progress) -> Result<Outcome, PipelineError> {
    reach(job)?;
    let solids = solids(job)?;
    let covering = covered(job, progress)?;
    let turn_limit = turn_limit::cost(job, &covering.report, progress)?;
    let legs = stages::legs(job, &covering.passes, progress)?;
    let SmoothedPath { path: tool_path, report, along } = stages::tool_path(job, &legs, progress)?;
    let followed = stages::axes(job, &tool_path, progress)?;
    let plan = stages::feed(job, &followed.path, progress)?;
    stages::rows(job, &plan)?;
    let retracts = retracts::summaries(job, &followed, &plan.schedule);
    let singular = stages::singular_gain(job, &tool_path, (&followed, &plan), progress)?;
    let moved = programs::Moved { followed: &followed, plan: &plan, retracts: &retracts, singular };
    let programs = programs::write(job, (&moved, &covering.report.rest, &solids), progress)?;
    let (cl, setup) = programs::sheets(job, &legs, &moved)?;
    let summary = summary::of(job, (&covering, turn_limit), &moved, (&programs, &solids))?;
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

/// Passes over the faces, one at least.
fn covered(job: &Job, progress: &dyn Progress) -> Result<Covering, PipelineError> {
    let covering = stages::cover(job, progress)?;
    if covering.passes.is_empty() {
        return Err(PipelineError::NothingCut { why: regions::unfinished(job, &covering) });
    }
    Ok(covering)
}

/// Passes over the faces with leads and links, as APT/CL text, without a machine's motion.
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn locations(job: &Job, progress: &dyn Progress) -> Result<String, PipelineError> {
    let covering = covered(job, progress)?;
    let legs = stages::legs(job, &covering.passes, progress)?;
    programs::cutter_locations(job, &legs)
}

/// What a search for a better setup found.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotated {
    /// The setups.
    pub search: SetupSearch,
    /// Planned time with the setup of the job and with the best \[s\]; `None` where none fits.
    pub seconds: [Option<f64>; 2],
}

/// Searches the rotation of the workpiece that keeps the job's tool path farthest from the singular
/// directions of the machine, and inside travel: [`crate::axes::setup`].
///
/// Passes and curves are those of [`run`]. A run with the setup found may place them a little
/// differently: how far the part is from the rotary axes decides what rounding the words of a
/// program may do, and so what the other stages may.
///
/// # Errors
///
/// The error of the stage that could not go on, or [`PipelineError::Cancelled`].
pub fn setup(
    job: &Job,
    bounds: &TiltBounds,
    progress: &dyn Progress,
) -> Result<Rotated, PipelineError> {
    let covering = covered(job, progress)?;
    let legs = stages::legs(job, &covering.passes, progress)?;
    let tool_path = stages::tool_path(job, &legs, progress)?.path;
    let search = stages::search(job, &tool_path, bounds, progress)?;
    let best = search.best.as_ref().map(|(_, followed)| followed);
    let seconds = |followed: Option<&FollowedPath>| {
        let plan = followed.map(|followed| stages::feed(job, &followed.path, progress));
        plan.map(|plan| plan.map(|plan| plan.schedule.duration())).transpose()
    };
    let seconds = [seconds(search.before_axes.as_ref())?, seconds(best)?];
    Ok(Rotated { search, seconds })
}
