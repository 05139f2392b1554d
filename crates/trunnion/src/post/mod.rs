//! Posts cutter locations or a program for a machine, move by move, with feeds that its axes can follow.
//!
//! ```text
//! replay            turns the steps of a program into moves
//! filter            smooths moves, or leaves out moves that a longer one replaces
//! smoothing_choice  keeps smoothing where the cut becomes quicker
//! rotaries          chooses the rotary solutions ahead, so that a cut stays inside travel
//! subdivision       divides moves until the target control stays within tolerance
//! rounded_words     plans with the lengths and times that rounded words can express
//! timing            times the axis points, window by window
//! poster            writes the program
//! read_back         reads every written block back and compares it with what was meant
//! conservation      counts what is read and what is written, and compares them line by line
//! ```
//!
//! Memory is bounded by the look-ahead window, however long the input is.
//!
//! # Example
//!
//! ```
//! use trunnion::post::{PostFilter, control_of, smoothing_tolerance};
//!
//! // Half of a 0.02 mm share moves the tip, the other half turns the axis at a lever of 10 mm.
//! assert_eq!(smoothing_tolerance(0.02, 10.0).tip, 0.01);
//! assert_eq!(smoothing_tolerance(0.02, 10.0).axis, 0.001);
//! # let _ = (PostFilter::None, control_of);
//! ```

mod axis_point;
mod conservation;
mod constants;
mod control;
mod error;
mod filter;
mod motion_stream;
mod options;
mod poster;
mod read_back;
mod refusal;
mod replay;
mod report;
mod rotaries;
mod rounded_words;
mod smoothing;
mod smoothing_choice;
mod subdivision;
mod timing;

pub use conservation::MotionCount;
pub use constants::MOST_FAULTS;
pub use control::{control_of, smoothing_bound};
pub use error::{PostError, PostRemedy, ReadBackError};
pub use options::{
    POST_WINDOW, PostFilter, PostMethod, PostMove, PostOptions, PostPace, PostSource, ProgramHead,
};
pub use poster::Poster;
pub use read_back::{WrittenSection, WrittenText, read_back, read_back_sections};
pub use replay::{LeftOut, ProgramMoves};
pub use report::{AxisLoadRatios, FastRapid, InputOutput, PostChoice, PostReport, SlowedMove};
pub use smoothing::{CORNER, LARGEST_BLEND, STEP_RATIO, WINDOW_STATIONS, smoothing_tolerance};
