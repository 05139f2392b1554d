//! Planning of a program that arrives block by block, beside the servo cycle that plays it.
//!
//! ```text
//! servo thread                                planning thread
//! PlannerServo::push ──── blocks ───────────▶ program_motion: rounded path ─▶ joints ─▶ feed::JerkStream
//! PlannerServo::cycle ◀── pieces, offers ──── pieces
//! ```
//!
//! The plan that the servo thread holds always ends at rest, so that a late planner ends in a stop within the limits. The
//! planner replaces the part behind what is committed: it writes pieces into the ring and offers to go on with them. The
//! servo thread takes an offer unless it is past that place already. Feed override, feed hold and abort are such
//! replacements as well. Neither side waits for the other.

mod block;
mod core;
mod numbers;
mod piece;
mod pieces;
mod servo;
mod shared;
mod thread;

pub use core::{PlannerCore, PlannerOptions};
pub use servo::{PlannerServo, ServoSample, ServoSpeeds};
pub use shared::{PlannerFault, PlannerState};
pub use thread::{PlannerThread, planner};
pub use trunnion::program_motion::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, LETTERS, MotionBlock,
    PlanLimit,
};
