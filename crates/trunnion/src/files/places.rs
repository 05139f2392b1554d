//! Positions of the keys of a file.

use crate::types::Diagnostic;
use std::collections::BTreeMap;

/// Position in a text file. Line and column count from 1; columns count characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextPosition {
    /// Line.
    pub line: u32,
    /// Column.
    pub column: u32,
}

/// Position of each key of a file by dotted path (`tool.minor_radius`, `axis.B.limits`), so that later
/// stages can still report a line.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct KeyPositions {
    keys: BTreeMap<String, TextPosition>,
}

impl KeyPositions {
    /// Returns the position of a key; if it is absent, that of the nearest table around it.
    pub fn get(&self, path: &str) -> TextPosition {
        let mut path = path;
        loop {
            if let Some(place) = self.keys.get(path) {
                return *place;
            }
            match path.rsplit_once('.') {
                Some((around, _)) => path = around,
                // Not even the table is there: the file as a whole is meant.
                None => return TextPosition { line: 1, column: 1 },
            }
        }
    }

    /// Records the position of a key.
    pub(super) fn insert(&mut self, path: String, position: TextPosition) {
        self.keys.insert(path, position);
    }

    /// Returns a diagnostic at a key.
    pub fn fault(&self, path: &str, message: impl Into<String>) -> Diagnostic {
        let TextPosition { line, column } = self.get(path);
        Diagnostic { line, column, message: message.into(), help: String::new() }
    }
}
