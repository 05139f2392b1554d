//! Programs, CL files and the setup sheet as text.
//!
//! [`ProgramWriter`] writes blocks one by one in any [`Dialect`], [`program`] all of them; see [`nc`](super) for what
//! X Y Z mean in each. Positions are rounded to nearest; [`rounding`] bounds what that does at the tool. Feeds are
//! rounded down, so that a block takes no less time than planned; feeds of the tip up to a whole number of mm/min where a
//! last digit is missing.

mod apt;
mod dialect;
mod error_bound;
mod head;
mod number;
mod program;
mod sheet;
mod template;
mod whole;
mod words_of;

pub use super::words::{AxisWord, AxisWords, WordsError};
pub use apt::apt;
pub use dialect::{DIALECTS, Dialect};
pub use error_bound::{Coordinates, rounding};
pub use program::{BRIEFEST_BLOCK, BlockPace, ProgramWriter, Style};
pub use sheet::{program_sheet, setup_sheet, work_offset};
pub use template::{Template, TemplateError};
pub use whole::pace;
pub use whole::program;
pub use words_of::PlaceWords;

use std::fmt;

/// What the texts say about the job besides its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Note<'a> {
    /// Name of the job.
    pub name: &'a str,
    /// Tool in the spindle.
    pub tool: ToolNote,
    /// Spindle speed, clockwise \[1/min\].
    pub spindle: f64,
    /// Coolant on.
    pub coolant: bool,
    /// Programmed feed \[mm/s\].
    pub feed: f64,
    /// Parts of the tolerance budget: what for, and how much \[mm\].
    pub budget: &'a [(String, f64)],
    /// Planned time \[s\].
    pub duration: f64,
    /// What happens where that a reader of the program would not expect, in order of blocks.
    pub remarks: &'a [Remark],
}

/// A comment in a program, and a line of the setup sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Index of the block it stands before.
    pub block: usize,
    /// What it says.
    pub text: String,
}

/// The tool as the texts name it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolNote {
    /// Number in the magazine, and of its length in the tool table.
    pub number: u32,
    /// Radius of the centre circle of the rounding \[mm\].
    pub major: f64,
    /// Radius of the rounding \[mm\].
    pub minor: f64,
}

/// Why a text cannot be written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The receiver of the text failed.
    #[error("the text cannot be stored")]
    Store(#[from] fmt::Error),
    /// Nothing to write.
    #[error("there is no motion to write")]
    Empty,
    /// A number that no program can hold.
    #[error("block {block}: {value} cannot be written with {decimals} decimals")]
    Number {
        /// Index of the block.
        block: usize,
        /// The number, in mm, degrees or 1/min.
        value: f64,
        /// Decimals asked for.
        decimals: u8,
    },
    /// A block that moves in no time, or in so much that its feed word would be 0.
    #[error("block {block} takes {duration} s, which no inverse-time feed word can say")]
    Duration {
        /// Index of the block.
        block: usize,
        /// Its time \[s\].
        duration: f64,
    },
    /// A template that cannot be filled.
    #[error(transparent)]
    Template(#[from] TemplateError),
    /// A second tool, and a template that does not say how it is changed.
    #[error("the template has no block `toolchange`, which a program with several tools needs")]
    NoToolChange,
    /// X, Y and Z do not span space.
    #[error("the linear axes do not reach every position, so there is no work offset")]
    WorkOffset,
}

/// A text that can stand inside a `( )` comment: one line, printable ASCII, no parentheses.
fn comment(text: &str) -> String {
    let plain = |c: char| match c {
        '(' => '[',
        ')' => ']',
        ' '..='~' => c,
        _ => '?',
    };
    text.chars().map(plain).collect()
}
