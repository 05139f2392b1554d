//! Errors of reading a part file.

use crate::types::Cancelled;

/// Why a part file gives no faces. One message, with the place where there is one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportError {
    /// The content is another format than expected.
    #[error("this is not a {expected} file: it looks like {found}")]
    WrongFormat {
        /// What was expected.
        expected: &'static str,
        /// What the first bytes look like.
        found: &'static str,
    },
    /// The text breaks the grammar of the format.
    #[error("line {line}, column {column}: {message}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column in bytes, from 1.
        column: usize,
        /// What is wrong.
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
        /// What was found instead.
        reason: String,
    },
    /// A file of which a solid was wanted.
    #[error(
        "the solid is not closed: {reason}; heal it in the CAD system and export it as a solid, or as STL"
    )]
    NotClosed {
        /// What is wrong, and where.
        reason: String,
    },
    /// A tolerance of the reader is not a positive length.
    #[error("the tolerance `{name}` is {value} mm; it must be positive")]
    Tolerance {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Stopped through [`Progress`].
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
