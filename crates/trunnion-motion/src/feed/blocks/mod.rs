//! The classical planner: straight blocks from node to node, with look-ahead.

mod moves;
mod options;
mod path;
mod ramp;
mod window;

pub use moves::{PlannedBlock, StraightMoves, look_ahead};
pub use options::{LookAhead, LookAheadOptions, TinyBlocks};
pub use path::blocks;
pub use ramp::SpeedRamp;
