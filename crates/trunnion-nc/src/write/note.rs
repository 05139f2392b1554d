//! Facts about the job that programs carry as comments.

use crate::words::Coolant;

/// Facts about the job besides its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Note<'a> {
    /// Name of the job.
    pub name: &'a str,
    /// Tool in the spindle.
    pub tool: ToolNote,
    /// Spindle speed, clockwise \[1/min\].
    pub spindle: f64,
    /// Coolant of the cuts.
    pub coolant: Coolant,
    /// Programmed feed \[mm/s\].
    pub feed: f64,
    /// Parts of the tolerance budget: what for, and how much \[mm\].
    pub budget: &'a [(String, f64)],
    /// Planned time \[s\].
    pub duration: f64,
    /// Events that a reader of the program would not expect, in order of blocks.
    pub remarks: &'a [Remark],
}

/// A comment in a program, and a line of the setup sheet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Index of the block it stands before.
    pub block: usize,
    /// Text of the comment.
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

impl std::fmt::Display for ToolNote {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { number, major, minor } = self;
        write!(f, "tool T{number}, R {major:.4} r {minor:.4} mm")
    }
}

/// Returns a text that can stand inside a `( )` comment: one line, printable ASCII, no parentheses.
pub(super) fn comment(text: &str) -> String {
    let plain = |c: char| match c {
        '(' => '[',
        ')' => ']',
        ' '..='~' => c,
        _ => '?',
    };
    text.chars().map(plain).collect()
}
