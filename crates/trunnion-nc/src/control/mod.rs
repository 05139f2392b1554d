//! The control that runs a program: what a block's words count from, where the block ends, and how
//! work offsets, tilted planes, arcs and tools take part in it.
//!
//! Posting and checking run programs through these same rules. Each brings its own machine model as a
//! [`ControlKinematics`], above all its own choice of rotary axes for a tool direction, so that a
//! check does not repeat a maker's mistake.

mod arc_chords;
mod blend_clock;
mod block_end;
mod block_frames;
mod kinematics;
mod offset_write;
mod tool_change;
mod tools;
mod word_frame;
mod words;
mod work_offsets;

pub use arc_chords::ArcChords;
pub use blend_clock::{BlendClock, BlendTolerance, ClockedBlock, ClockedKind};
pub use block_end::{BlockEnd, BlockStart, block_end, block_end_from, read_words, tip_target};
pub use block_frames::{BlockFrames, UnknownOffset};
pub use kinematics::{ControlKinematics, RotaryRequest, TipTarget};
pub use offset_write::{OffsetFault, OffsetReading};
pub use tool_change::keeps_xy;
pub use tools::{NumberedLength, position_of};
pub use word_frame::{TipFrame, ToolLength, WordFrame};
pub use words::{STANDING, end_words, path_length};
pub use work_offsets::{NO_OFFSET, WorkOffset, WorkOffsets};
