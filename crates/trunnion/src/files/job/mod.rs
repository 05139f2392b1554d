//! The job file (`trunnion-job/1`): what to machine, with what, how well and on which machine.

mod data;
mod layout;
pub(super) mod raw;
mod read;
mod solid;
mod strategy;
mod tool;

pub use data::{
    CuttingData, FaceSelection, FeedReference, JobContactSide, JobCutPattern, JobFeedDirection,
    JobFile, JobLead, JobLinks, JobPart, JobPlacement, JobSetup, JobStrategy, JobTolerance,
    JobTool, MotionMethod, MotionSettings, ToleranceSplit, ToolConstruction, ToolKind,
};
pub use layout::LAYOUT;
pub use read::parse;
pub use solid::{JobFixture, JobSolid, JobStock, STEP_CHORD, placement};
