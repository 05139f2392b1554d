//! Programs and CL files from text: every word with its place, all faults at once.
//!
//! [`read`] takes a program whole, [`steps`] line by line with memory for its longest loop or
//! subprogram, [`ProgramText`] keeps the text to read it again and again; all give [`Step`]s, whatever the [`Dialect`]. [`cl`](cl()) reads APT/CL files. What is
//! not understood is a [`Diagnostic`], never skipped motion; words that cannot move anything are kept
//! ([`Step::Words`]). Kinematics is not applied here, only units, signs, modal state and arithmetic.
//!
//! # From steps to joints
//!
//! A consumer remembers where the control stands, starting from the machine's home, and takes step by step:
//!
//! * [`Move::words`] are the axes that change, [`Move::frame`] is the frame they count from: axis positions
//!   ([`Frame::Machine`]), axis positions less work offset and tool length (no TCP), or the tip in the table
//!   frame (TCP; see [`nc`](super)). Axes without a word keep their value *in that frame*.
//! * [`Move::axis`] stands in place of the rotary words: the consumer's inverse finds them.
//! * [`Move::plane`]: X Y Z are the tip in that plane's coordinates; [`Step::Plane`] came before and has its frame.
//! * [`Move::way`]: a straight line, or an arc that [`Arc::at`] and [`Arc::parts`] chop up.
//! * [`Move::turning`] and the frame define what is linear: without TCP all axes; with TCP the tip, and the rotary
//!   axes ([`Turning::Rotary`]) or the tool axis on its great circle.
//! * [`Step::Offset`] moves a work offset. A consumer that keeps none has to refuse it, not skip it.
//!
//! [`Move::special`] names what a consumer of plain five-axis words has to refuse.
//!
//! [`Diagnostic`]: crate::types::Diagnostic

mod arc;
mod arithmetic;
mod cl;
mod control;
mod dialect;
mod emitted;
mod gcode;
mod go;
mod heidenhain;
mod ini;
mod log;
mod mapped_words;
mod number;
mod options;
mod passive;
mod positions;
mod reader;
mod remedy;
#[cfg(test)]
mod samples;
mod siemens;
mod source;
mod state;
mod step;
mod steps;
mod tally;
mod tape;
mod tilt;
mod tool_table;
mod word_map;

pub use super::words::{AxisWord, AxisWords, Coolant};
pub use cl::{
    ClArc, ClFile, ClHole, ClItem, ClMotion, ClPath, ClReader, ClRecord, ClRecords, ClTally,
    ClTool, cl, cl_records,
};
pub use dialect::Dialect;
pub use gcode::subprogram_calls;
pub use ini::{IniFile, ini_file};
pub use options::{CodeRemap, ReadOptions, SubprogramFile, ToolRow};
pub use remedy::ReadRemedy;
pub use source::{ClSource, ClText, ProgramSource, ProgramText};
pub use step::{
    Arc, Frame, LengthEntry, Move, Offset, OffsetKind, Pace, Plane, Program, Smoothing, Step,
    Turning, Way,
};
pub use steps::{LineReader, Steps, read, steps};
pub use tally::Tally;
pub use tool_table::tool_rows;
