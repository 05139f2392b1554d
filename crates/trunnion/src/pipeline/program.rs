//! A program of a job, with the results of its check.

use super::error::PipelineError;
use crate::nc::write::OutputFormat;
use crate::types::{Block, Diagnostic};
use crate::verify::{self, BodyReport, ClearanceReport, CutStock, OtherFaces};

/// Program of the job that was not written, because its text would not mean what is intended or cannot be checked.
#[derive(Debug)]
#[non_exhaustive]
pub struct LeftOutProgram {
    /// Format.
    pub format: OutputFormat,
    /// File name that it would have.
    pub file: &'static str,
    /// Error of its blocks, its text or its check.
    pub why: Box<PipelineError>,
}

/// Program as text, with the results of its check.
#[derive(Debug)]
#[non_exhaustive]
pub struct CheckedProgram {
    /// Name of the dialect.
    pub dialect: &'static str,
    /// File name.
    pub file: &'static str,
    /// Text of the program.
    pub text: String,
    /// Blocks that the text expresses.
    pub blocks: Vec<Block>,
    /// Upper bound on the cutter movement caused by rounding the words \[mm\].
    pub rounding: f64,
    /// First text that the reader does not understand, such as strings of the machine file.
    ///
    /// `None`: every block was read back from the text and found to mean what was intended.
    pub unread: Option<Diagnostic>,
    /// Result of replaying the text; `None` if another program has the same blocks.
    pub check: Option<verify::Report>,
    /// Dialect of the program with the same blocks, whose check holds for this one too.
    pub same_as: Option<&'static str>,
    /// Result on the faces that are not cut; its finding, if any, is among those of the check.
    pub others: OtherFaces,
    /// Removal of the stock of the job, and the stock that remains; `None` without stock, or if another program has
    /// the same blocks.
    pub carving: Option<CutStock>,
    /// Clearance from the fixtures of the job; `None` without any, or if another program has the same blocks.
    pub clearance: Option<ClearanceReport>,
    /// Distances of the machine's bodies; `None` without any, or if another program has the same blocks.
    pub bodies: Option<BodyReport>,
    /// Programs of single operations, in their order; empty unless the job asks for them.
    pub parts: Vec<OperationProgram>,
    /// Kinds of moves that come nearer to a fixture than the required clearance.
    pub too_near: NearMoves,
    /// Kinds of moves on which bodies of the machine do.
    pub bodies_near: NearMoves,
}

/// Kinds of moves that come nearer to something than the required clearance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NearMoves {
    /// True if links do.
    pub links: bool,
    /// True if cuts or their leads do.
    pub cuts: bool,
}

impl NearMoves {
    /// Returns true if any moves do.
    pub fn any(self) -> bool {
        self.links || self.cuts
    }

    /// Returns the kinds of moves that do in one or the other.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { links: self.links || other.links, cuts: self.cuts || other.cuts }
    }
}

/// Program of one operation. Its blocks are those of the program of all operations, whose check holds for it; its text was
/// read back as well.
#[derive(Debug)]
#[non_exhaustive]
pub struct OperationProgram {
    /// Name of the operation.
    pub operation: String,
    /// File name.
    pub file: String,
    /// Text of the program.
    pub text: String,
    /// Number of its blocks.
    pub blocks: usize,
}
