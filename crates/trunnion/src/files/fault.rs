//! What is wrong with a file, and where.

use std::collections::BTreeMap;
use std::fmt;

/// A position in a text file, both counted from 1; columns count characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Place {
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// One thing that is wrong with a file, with a remedy where there is one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong, with the offending value.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Fault {
    /// A fault at a place.
    pub fn new(place: Place, message: impl Into<String>) -> Self {
        let Place { line, column } = place;
        Self { line, column, message: message.into(), help: None }
    }

    /// Adds the remedy.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// `line:column: message`, the remedy on a line of its own; a shell puts `file:` in front.
impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}", self.line, self.column, self.message)?;
        match &self.help {
            Some(help) => write!(f, "\n  help: {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Fault {}

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

    /// A fault at a key, for what only a later stage can know.
    pub fn fault(&self, path: &str, message: impl Into<String>) -> Fault {
        Fault::new(self.get(path), message)
    }
}

impl FromIterator<(String, Place)> for Places {
    fn from_iter<I: IntoIterator<Item = (String, Place)>>(keys: I) -> Self {
        Self { keys: keys.into_iter().collect() }
    }
}
