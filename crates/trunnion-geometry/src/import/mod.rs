//! Bytes to surfaces: STEP (feature `step`), surface JSON; to meshes: STL.
//!
//! A format enters through the narrow trait [`Reader`] and leaves as the project's own [`Face`]s at
//! once: nothing of a file's structure reaches another module.

pub mod inspect;
#[cfg(feature = "step")]
pub mod step;
pub mod stl;
pub mod surface_json;

use crate::surface::Face;
use crate::types::Cancelled;
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

/// What a reader left out or doubts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Number of the face it concerns.
    pub face: Option<usize>,
    /// Entity of a STEP file.
    pub entity: Option<u64>,
    /// Line of the file, from 1.
    pub line: Option<usize>,
    /// What and why.
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
    /// Name of the format.
    fn format(&self) -> &'static str;

    /// Whether the content begins like this format.
    fn recognises(&self, bytes: &[u8]) -> bool;

    /// Reads a whole file. Reports [`crate::types::Stage::Import`] face by face.
    ///
    /// # Errors
    ///
    /// [`ImportError`]: not one face could be read, and why; or the caller asked for a stop.
    fn read(&self, bytes: &[u8], progress: &dyn Progress) -> Result<Part, ImportError>;
}

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

/// The bytes after a byte order mark of UTF-8, which some editors put in front.
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// What the first bytes look like, in words.
pub fn looks_like(bytes: &[u8]) -> &'static str {
    /// Beginnings by which formats are told apart.
    const BEGINNINGS: [(&[u8], &str); 14] = [
        (b"ISO-10303-21", "STEP"),
        (b"solid", "STL (text)"),
        (b"{", "JSON"),
        (b"[", "JSON"),
        (b"PK\x03\x04", "a ZIP archive (3MF, FreeCAD and others)"),
        (b"<?xml", "XML"),
        (b"<", "XML or HTML"),
        (b"%PDF", "PDF"),
        (b"CASCADE Topology", "an OCCT BREP file"),
        (b"DBRep_DrawableShape", "an OCCT BREP file"),
        (b"**ABCDEF", "Parasolid"),
        (b"%", "an NC program"),
        (b"PARTNO", "an APT/CL file"),
        (b"\x1f\x8b", "a gzip archive"),
    ];
    let start = bytes.trim_ascii_start();
    if start.is_empty() {
        return "an empty file";
    }
    // A binary STL may begin with anything, `solid` included: its length tells.
    let triangles = bytes.get(80..84).and_then(|count| <[u8; 4]>::try_from(count).ok());
    let length = triangles.map(|count| 84 + 50 * u64::from(u32::from_le_bytes(count)));
    if length == Some(bytes.len() as u64) {
        return "STL (binary)";
    }
    if let Some((_, name)) = BEGINNINGS.iter().find(|(begin, _)| start.starts_with(begin)) {
        return name;
    }
    // IGES: fixed records of 80 columns with the letter of their section in column 73.
    if bytes.get(72).is_some_and(|byte| *byte == b'S') && bytes.get(73..80).is_some_and(digits) {
        return "IGES";
    }
    let head = bytes.get(..512.min(bytes.len())).unwrap_or_default();
    if head.contains(&0) { "binary data" } else { "some other text" }
}

fn digits(column: &[u8]) -> bool {
    column.iter().all(|byte| byte.is_ascii_digit() || *byte == b' ')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_apart() {
        assert_eq!(looks_like(b" \n"), "an empty file");
        assert_eq!(looks_like(b"solid part\nfacet"), "STL (text)");
        assert_eq!(looks_like(b"\n{ \"degree\": 1 }"), "JSON");
        let mut stl = b"solid in name only".to_vec();
        stl.resize(80, 0);
        stl.extend(1_u32.to_le_bytes());
        stl.resize(134, 0);
        assert_eq!(looks_like(&stl), "STL (binary)");
        let iges = format!("{:72}S      1\n", "part");
        assert_eq!(looks_like(iges.as_bytes()), "IGES");
        assert_eq!(looks_like(b"\x00\x01"), "binary data");
    }
}
