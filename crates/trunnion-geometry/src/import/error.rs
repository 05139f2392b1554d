//! Errors of reading a part file.

use crate::types::Cancelled;

/// Error of reading a part file: one message, with line and column if there are any.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The content is another format than expected.
    #[error("this is not a {expected} file: it looks like {found}")]
    WrongFormat {
        /// Name of the format expected.
        expected: &'static str,
        /// Format that the first bytes look like, in words.
        found: &'static str,
    },
    /// The text breaks the grammar of the format.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column in bytes, from 1.
        column: usize,
        /// Description of the error.
        message: String,
    },
    /// The file stops in the middle.
    #[error(
        "line {line}: the file is cut short, it ends before `END-ISO-10303-21;`; copy or export it \
         again"
    )]
    Truncated {
        /// Last line.
        line: usize,
    },
    /// The file was read, but holds no face that can be machined.
    #[error("the file gives no face: {reason}")]
    NoFaces {
        /// Contents of the file, or the first warning.
        reason: String,
    },
    /// The faces of the file do not enclose a solid.
    #[error(
        "the solid is not closed: {reason}; heal it in the CAD system and export it as a solid, or as STL"
    )]
    NotClosed {
        /// Defect and its position.
        reason: String,
    },
    /// A tolerance of the reader is not a positive length.
    #[error("the tolerance `{name}` is {value} mm; it must be positive")]
    Tolerance {
        /// Name of the tolerance.
        name: &'static str,
        /// Value given \[mm\].
        value: f64,
    },
    /// Stopped through [`Progress`](crate::types::Progress).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
