//! Where the keys of a file stand.

use crate::types::Diagnostic;
use std::collections::BTreeMap;

/// A position in a text file, both counted from 1; columns count characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// Line.
    pub line: u32,
    /// Column.
    pub column: u32,
}

/// Where each key of a file stands, by dotted path (`tool.minor_radius`, `axis.B.limits`), so that
/// what a later stage finds wrong can still be blamed on a line.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Places {
    keys: BTreeMap<String, Place>,
}

impl Places {
    /// Place of a key; of the nearest table around it where the key itself was left out.
    pub fn get(&self, path: &str) -> Place {
        let mut path = path;
        loop {
            if let Some(place) = self.keys.get(path) {
                return *place;
            }
            match path.rsplit_once('.') {
                Some((around, _)) => path = around,
                None => return Place { line: 1, column: 1 },
            }
        }
    }

    /// A fault at a key.
    pub fn fault(&self, path: &str, message: impl Into<String>) -> Diagnostic {
        let Place { line, column } = self.get(path);
        Diagnostic { line, column, message: message.into(), help: String::new() }
    }
}

impl FromIterator<(String, Place)> for Places {
    fn from_iter<I: IntoIterator<Item = (String, Place)>>(keys: I) -> Self {
        Self { keys: keys.into_iter().collect() }
    }
}
