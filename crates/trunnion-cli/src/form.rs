//! Form of the output: words for people, or JSON for scripts.

use crate::outcome::{Done, Failure};
use crate::text;

/// Form of the result on stdout.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OutputForm {
    /// Words and tables for people.
    Text,
    /// One JSON document for scripts (`--json`), and nothing else on stdout.
    Json,
}

impl OutputForm {
    /// Returns true if stdout belongs to the JSON document.
    pub(crate) fn is_json(self) -> bool {
        self == Self::Json
    }

    /// Prints a summary: as JSON, or in the words of `describe`.
    pub(crate) fn print<S: serde::Serialize>(
        self,
        summary: &S,
        describe: impl FnOnce(&S) -> String,
    ) -> Result<Done, Failure> {
        match self {
            Self::Text => text::print(&describe(summary)),
            Self::Json => text::print_json(summary),
        }
    }
}
