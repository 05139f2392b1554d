//! The moves of a program, for pictures.

use super::args::CheckArgs;
use super::page;
use super::subject::{CheckedMotion, Subject};
use super::timed_stock::{StockSource, stock_source};
use crate::outcome::Failure;
use trunnion::machine::Kinematics;
use trunnion::types::Progress;
use trunnion::verify::TimelinePoint;

/// Moves of a program for callers that draw them.
#[derive(Debug)]
#[non_exhaustive]
pub struct ReplayAnswer {
    /// Machine and tool over time.
    pub points: Vec<TimelinePoint>,
    /// Machine and setup; `None` for a CL file.
    pub kinematics: Option<Kinematics>,
    /// Outline of each tool: radius and height above the tip \[mm\], from the tip up.
    pub tools: Vec<Vec<[f64; 2]>>,
    /// Origin of the stock that [`timed_stock`](crate::calls::timed_stock) cuts; `None` without one.
    pub stock: Option<StockSource>,
}

/// Runs a program without a check. Nothing is written.
pub(crate) fn replay(args: &CheckArgs, progress: &dyn Progress) -> Result<ReplayAnswer, Failure> {
    let subject = Subject::load(args, progress)?;
    let points = subject.timeline()?;
    let tools = page::outlines(&subject);
    let stock = stock_source(&subject);
    let kinematics = match subject.motion {
        CheckedMotion::Program(_, kinematics) => Some(*kinematics),
        CheckedMotion::Locations(_) => None,
    };
    Ok(ReplayAnswer { points, kinematics, tools, stock })
}
