//! Tools and work offsets as a control has them in its tables, beyond those of the setup.

use crate::cutter::Cutter;
use crate::nc::control::WorkOffset;

/// Entries in the tables of a control beside the setup's own tool and `G54`.
#[derive(Debug, Clone, Copy)]
pub struct Tables<'a> {
    /// Tools of a program that calls several; empty: it has one, whatever its number.
    pub tools: &'a [Tool<'a>],
    /// Work offsets; `G54` is that of the setup if it is not here.
    pub offsets: &'a [WorkOffset],
}

impl Tables<'_> {
    /// One tool, and `G54`.
    pub const NONE: Tables<'static> = Tables { tools: &[], offsets: &[] };
}

/// A tool by its number.
#[derive(Debug, Clone, Copy)]
pub struct Tool<'a> {
    /// Number that the program calls.
    pub number: u32,
    /// The tool, from tip to gauge point: its length is the tool length.
    pub cutter: &'a Cutter,
}

/// Tool changes, and the rapid moves that they leave unknown.
///
/// The machine decides where a change leaves Z, and with a leaning tool X and Y; they are known again once the program
/// states them. The rotaries are taken to stand as before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Changes {
    /// Tools put in after the first move.
    pub count: usize,
    /// Line of the first.
    pub line: u32,
    /// Rapid moves that were not measured: before X, Y and Z were stated, or before the first tool.
    pub unmeasured: usize,
    /// Line of the first of them.
    pub first: Option<u32>,
}
