//! Motion of a program that arrives block by block, planned as `trunnion-rt` plans it inside a control.
//!
//! ```text
//! block          blocks, as a control hands them over
//! leg, kernel    their curves; the kernel that rounds corners
//! pace           speed of blocks with a time of their own
//! leg_speeds     speeds of curves beside each other
//! corner         a corner, and what its kernel adds
//! rounded_path   the smooth path through them
//! joints         joints along it, by the kinematics
//! run            one run from rest to rest, planned by `feed::JerkStream`
//! plan_limit     limit that binds
//! duration       time of a program
//! ```

mod block;
mod corner;
mod duration;
mod joints;
mod kernel;
mod leg;
mod leg_speeds;
mod pace;
mod plan_limit;
mod rounded_path;
mod run;

pub use block::{
    BlockCoordinates, BlockEnding, BlockKind, BlockShape, BlockStart, LETTERS, MotionBlock,
};
pub use duration::{DurationFault, ProgramDuration};
pub use joints::{WordJoints, WordsFault};
pub use leg::LetterVector;
pub use plan_limit::PlanLimit;
pub use rounded_path::PathNode;
pub use run::{ProgramRun, RunFault, planned_limits};
