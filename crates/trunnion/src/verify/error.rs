//! Errors of checks.

use super::tools;
use crate::types::Cancelled;

/// Why a program cannot be checked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VerifyError {
    /// The caller asked for a stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// An option that is not a usable number.
    #[error("option {name} is {value}; it must be {must}")]
    Option {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// The tool cuts the faces from their backs.
    #[error(
        "the tool cuts the faces from behind, at {from_back} of {examined} points that were examined; turn the faces over"
    )]
    FromBehind {
        /// Points that the tool reaches from the back alone.
        from_back: usize,
        /// All points that were examined.
        examined: usize,
    },
    /// The program moves nothing.
    #[error("the program has no moves")]
    NoMotion,
    /// More than one tool, and no table of them.
    #[error(
        "line {line}: tool {} after tool {}: say what each is, --cutter {}=R=..,r=.. and --tool-length {}=L, and so on", numbers[1], numbers[0], numbers[0], numbers[0]
    )]
    Tools {
        /// Line of the program.
        line: u32,
        /// The first, and that of the line.
        numbers: [u32; 2],
    },
    /// A tool that the table does not have.
    #[error(
        "line {line}: tool {number} is not known; say what it is: --cutter {number}=R=..,r=.. --tool-length {number}=L"
    )]
    UnknownTool {
        /// Line of the program.
        line: u32,
        /// What the program calls it.
        number: u32,
    },
    /// A cut before the first of several tools.
    #[error(
        "line {line}: a move before the program calls a tool; call it before (T.. M6, TOOL CALL, LOADTL)"
    )]
    NoTool {
        /// Line of the program.
        line: u32,
    },
    /// A work offset that the table does not have.
    #[error("line {line}: work offset {} is not known; say where it is, --offset {}=X,Y,Z, or that it is where G54 is, --offset {}=G54", tools::name(*number), tools::plain_name(*number), tools::plain_name(*number))]
    WorkOffset {
        /// Line of the program.
        line: u32,
        /// 0 for `G54`, 1 for `G55` and so on.
        number: u8,
    },
    /// A work offset that the program writes in a way that is not followed.
    #[error(
        "line {line}: {what} is not followed; write X, Y and Z of the offset as axis positions (G10 L2), and rotaries as 0"
    )]
    Offset {
        /// Line of the program.
        line: u32,
        /// What it is.
        what: &'static str,
    },
    /// A direction that no position of the rotaries gives the tool.
    #[error("line {line}: no position of the rotary axes turns the tool along {:.6}, {:.6}, {:.6} (workpiece); check the vector or plane, and machine and rotation of the setup", axis[0], axis[1], axis[2])]
    OutOfReach {
        /// Line of the program.
        line: u32,
        /// Tool axis, workpiece frame.
        axis: [f64; 3],
    },
    /// A step that is read, but not replayed.
    #[error(
        "line {line}: {what} is not replayed; post the program with straight moves of five axes"
    )]
    Special {
        /// Line of the program.
        line: u32,
        /// What it is.
        what: &'static str,
    },
    /// A cut from a place that is not known.
    #[error(
        "line {line}: where X, Y and Z stand after the tool change is the machine's own, and this cut cannot be followed; \
         put rapid moves before it that name X, Y and Z"
    )]
    Unfollowed {
        /// Line of the program.
        line: u32,
    },
    /// X, Y and Z do not span space.
    #[error("the linear axes do not reach every position")]
    LinearAxes,
    /// A block that turns so far that its motion cannot be followed.
    #[error("line {line}: the block turns too far to be followed; break it up")]
    TurnsTooFar {
        /// Line of the program.
        line: u32,
    },
    /// Stock or a fixture that cannot be worked with.
    #[error("the solid {what}")]
    Stock {
        /// What is wrong with it.
        what: String,
    },
    /// The grid is too fine.
    #[error("face {face} would have {points:.0} grid points, more than {most}; use a coarser grid")]
    TooManyPoints {
        /// Number of the face.
        face: usize,
        /// Points asked for.
        points: f64,
        /// Points allowed.
        most: usize,
    },
}
