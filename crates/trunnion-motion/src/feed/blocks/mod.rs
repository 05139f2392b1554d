//! The classical planner: straight blocks from node to node, with look-ahead.
//!
//! Many controls plan like this; it is the baseline to beat. Blocks are straight in the axes.
//! Where two meet, axis velocities step, by no more than the axes manage in a servo period. The
//! planner does not see curvature inside a block, jerk, or the tip's own feed:
//! [`FeedPlan::ratios`](super::FeedPlan::ratios) of [`blocks()`] shows what that does to the
//! limits of the path.

mod moves;
mod options;
mod path;
mod ramp;
mod window;

pub use moves::{PlannedBlock, StraightMoves, look_ahead};
pub use options::{LookAhead, LookAheadOptions, TinyBlocks};
pub use path::blocks;
pub use ramp::SpeedRamp;
