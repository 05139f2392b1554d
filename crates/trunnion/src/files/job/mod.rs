//! The job file (`trunnion-job/1`): what to machine, with what, how well and on which machine.

mod data;
mod raw;
mod read;
mod solid;
mod strategy;
mod tool;

pub use data::{
    Along, Construction, Cutting, Direction, Faces, JobFile, LeadKind, Links, Method, Motion,
    MotionMethod, Part, Reference, Setup, Side, Split, Strategy, Tolerance, Tool, ToolKind,
};
pub(super) use raw::RawJob;
pub use read::parse;
pub use solid::{Fixture, STEP_CHORD, Solid, Stock, placement};

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-job/1";
