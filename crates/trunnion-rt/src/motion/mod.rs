//! Evaluation of a planned motion in the servo cycle, always able to stop.
//!
//! A planning thread hands pieces of a motion over ([`PieceSender`]), a servo cycle plays them ([`MotionPlayer`]). The
//! queue between them is lock-free and has a fixed size. The player runs the time of the plan at a rate between 0 and
//! 1: feed override, feed hold and a late planner change this rate within stated bounds, never the path. It keeps so
//! much of the plan ahead that it can come to rest inside it. A late planner slows the tool down; the tool never
//! leaves the plan, never jumps, and never reaches the end of the queue at speed.

mod piece;
mod player;
mod queue;
mod rate;

pub(crate) use piece::COEFFICIENTS;
pub use piece::{LETTERS, MotionPiece, PieceError};
pub use player::{MotionPlayer, MotionSample};
pub use queue::{PieceReceiver, PieceSender, piece_queue};
pub use rate::{PlanRate, RateBounds, RateError};
