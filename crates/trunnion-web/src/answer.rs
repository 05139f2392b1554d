//! Result of a verb, as a page shows it.

use serde::Serialize;
use trunnion_cli::Failure;
use trunnion_cli::calls::exit_code;

/// Result of a verb. The files that it wrote stay in the engine.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct PageAnswer {
    /// Exit code that the process would have: 0 kept, 1 broken, 2 bad input, 3 internal, 130 stopped.
    pub code: u8,
    /// Errors, each complete in itself, with `path:line:column:` in front where a file is the cause.
    pub messages: Vec<String>,
    /// Warnings that the command line prints beside the result.
    pub warnings: Vec<String>,
    /// Table for people; empty after an error.
    pub table: String,
    /// Names of the files that were written, with their folder.
    pub files: Vec<String>,
}

impl PageAnswer {
    /// A result that was computed: `passed` as the summary has it.
    pub(crate) fn done(table: String, verdict: Verdict) -> Self {
        let code = match verdict {
            Verdict::Kept => 0,
            Verdict::Broken => 1,
        };
        Self { code, table, ..Self::default() }
    }

    /// A failure, in the words of the command line.
    pub(crate) fn refused(failure: &Failure) -> Self {
        Self { code: exit_code(failure), messages: failure.messages(), ..Self::default() }
    }
}

/// Verdict of a run or check.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    Kept,
    Broken,
}

impl Verdict {
    pub(crate) fn of(passed: bool) -> Self {
        if passed { Self::Kept } else { Self::Broken }
    }
}
