//! The result of reading a part file, and the trait of its readers.

use super::error::ImportError;
use crate::surface::Face;
use crate::types::Progress;
use std::fmt;

/// A part as read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Faces in file order, lengths in mm; numbers start at 1 and leave out what was lost.
    pub faces: Vec<Face>,
    /// Everything the file holds and `faces` does not, and everything doubtful.
    pub warnings: Vec<Warning>,
}

/// Something that a reader left out or doubts.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Warning {
    /// Number of the face it concerns.
    pub face: Option<usize>,
    /// Entity of a STEP file.
    pub entity: Option<u64>,
    /// Line of the file, from 1.
    pub line: Option<usize>,
    /// Thing left out, and the reason.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}, ")?;
        }
        if let Some(entity) = self.entity {
            write!(f, "#{entity}: ")?;
        }
        if let Some(face) = self.face {
            write!(f, "face {face}: ")?;
        }
        f.write_str(&self.message)
    }
}

/// Reads one format.
pub trait Reader {
    /// Returns the name of the format.
    fn format(&self) -> &'static str;

    /// Returns `true` if the content begins like this format.
    fn recognises(&self, bytes: &[u8]) -> bool;

    /// Reads a whole file. Reports [`crate::types::Stage::Import`] face by face.
    ///
    /// # Errors
    ///
    /// [`ImportError`] if not one face could be read, with the reason, or if the caller asked for a
    /// stop.
    fn read(&self, bytes: &[u8], progress: &dyn Progress) -> Result<Part, ImportError>;
}
