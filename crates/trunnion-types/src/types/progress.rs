//! Progress and cancellation of long loops.

use super::tool_path::Pass;
use std::ops::ControlFlow;
use std::sync::Arc;

/// The stages a user waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Stage {
    /// Reading and converting the part.
    Import,
    /// Placing passes.
    Cover,
    /// Fitting curves through cutter locations.
    ToolPath,
    /// Solving for the machine's axes.
    Axes,
    /// Planning speeds.
    Feed,
    /// Sampling the schedule at the servo period.
    Setpoints,
    /// Breaking the path into blocks and writing programs.
    Program,
    /// Replaying the program and measuring the part.
    Verify,
}

/// Observer of a long loop, which it may stop. Called from any thread.
pub trait Progress: Sync {
    /// Receives that `done` of about `total` steps of `stage` are finished.
    ///
    /// `Break` stops the loop soon, and the stage returns its `Cancelled` error.
    fn report(&self, stage: Stage, done: u64, total: u64) -> ControlFlow<()>;

    /// Receives the passes over the face of that number as far as they are placed, in cutting order.
    ///
    /// They may still give way to better ones: each call replaces all that those before have said about the face. A pass
    /// that stays is the same allocation as before. Ignores them unless an observer says otherwise.
    fn report_passes(&self, face: usize, passes: &[Arc<Pass>]) {
        let _ = (face, passes);
    }
}

/// Observer that ignores every report and never stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _: Stage, _: u64, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Error of a stage that the caller stopped through [`Progress`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("stopped on request")]
pub struct Cancelled;

impl dyn Progress + '_ {
    /// Reports like [`Progress::report`], and returns a `Result`, for `?`.
    ///
    /// # Errors
    ///
    /// [`Cancelled`] if the caller asked for a stop.
    pub fn step(&self, stage: Stage, done: u64, total: u64) -> Result<(), Cancelled> {
        match self.report(stage, done, total) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Cancelled),
        }
    }
}
