//! The job file (`trunnion-job/1`): part, tool, tolerance, strategy and machine.

mod cutting;
mod data;
mod layout;
mod operation;
mod part;
pub(super) mod raw;
mod read;
mod solid;
mod strategy;
pub(super) mod tool;
mod tool_side;

pub use data::{
    CuttingData, FaceSelection, FeedReference, HolderFile, JobArea, JobContactSide, JobCutPattern,
    JobFeedDirection, JobFile, JobLead, JobLinkBlocks, JobLinks, JobOperation, JobPart,
    JobPlacement, JobPrismatic, JobPrograms, JobSetup, JobStrategy, JobTolerance, JobTool,
    MotionMethod, MotionSettings, ToleranceSplit, ToolConstruction, ToolKind, ToolSide,
};
pub use layout::LAYOUT;
pub use read::parse;
pub use solid::{JobFixture, JobSolid, JobStock, STEP_CHORD, placement};
