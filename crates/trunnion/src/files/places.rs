//! Where the keys of a file stand.

use crate::types::Diagnostic;
use std::collections::BTreeMap;

/// A position in a text file, both counted from 1; columns count characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextPosition {
    /// Line.
    pub line: u32,
    /// Column.
    pub column: u32,
}

/// Where each key of a file stands, by dotted path (`tool.minor_radius`, `axis.B.limits`), so that
/// what a later stage finds wrong can still be blamed on a line.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct KeyPositions {
    keys: BTreeMap<String, TextPosition>,
}

impl KeyPositions {
    /// Place of a key; of the nearest table around it where the key itself was left out.
    pub fn get(&self, path: &str) -> TextPosition {
        let mut path = path;
        loop {
            if let Some(place) = self.keys.get(path) {
                return *place;
            }
            match path.rsplit_once('.') {
                Some((around, _)) => path = around,
                None => return TextPosition { line: 1, column: 1 },
            }
        }
    }

    /// Records the position of a key.
    pub(super) fn insert(&mut self, path: String, position: TextPosition) {
        self.keys.insert(path, position);
    }

    /// A fault at a key.
    pub fn fault(&self, path: &str, message: impl Into<String>) -> Diagnostic {
        let TextPosition { line, column } = self.get(path);
        Diagnostic { line, column, message: message.into(), help: String::new() }
    }
}
