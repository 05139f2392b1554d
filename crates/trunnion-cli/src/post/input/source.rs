//! Text file that is posted, and the selection from it.

use crate::outcome::Failure;
use crate::path::lines::{self, Lines};
use crate::program_files::ProgramFileArgs;
use anyhow::Context;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use trunnion::nc::control::NumberedLength;
use trunnion::nc::read::Dialect;
use trunnion::types::{Progress, Stage};

/// Lines between two checks for cancellation.
const LINES_A_STEP: u64 = 4096;

/// Chord tolerance of arcs \[mm\].
pub(super) const ARC_TOLERANCE: f64 = 1e-3;

/// Text file that is read line by line.
pub(super) struct Source<'a> {
    pub(super) path: PathBuf,
    pub(super) lines: Lines<Box<dyn BufRead>>,
    pub(super) size: u64,
    pub(super) count: u64,
    pub(super) bars: &'a dyn Progress,
}

impl Source<'_> {
    /// Returns the next line without its line break.
    pub(super) fn line(&mut self) -> Result<Option<std::borrow::Cow<'_, str>>, Failure> {
        self.count += 1;
        // Reporting every line would cost more than reading it.
        if self.count.is_multiple_of(LINES_A_STEP) && self.size > 0 {
            let on = self.bars.report(Stage::Program, self.lines.bytes, self.size);
            if on.is_break() {
                return Err(Failure::Stopped);
            }
        }
        let unread = || format!("reading {}", self.path.display());
        Ok(self.lines.next().with_context(unread)?.map(lines::text))
    }
}

/// Selection from the input, and options of the program reader.
pub(crate) struct InputOptions {
    /// Its dialect.
    pub(crate) from: Option<Dialect>,
    /// Moves of this tool only.
    pub(crate) tool: Option<u32>,
    /// Lengths of several tools that a program assumes, by number \[mm\].
    pub(crate) lengths: Vec<NumberedLength>,
    /// Values of parameters.
    pub(crate) parameters: Vec<(String, f64)>,
    /// True runs the lines that begin with /, false skips them.
    pub(crate) block_delete: Option<bool>,
    /// Files of the control.
    pub(crate) files: ProgramFileArgs,
}

/// Returns the name of the input.
pub(super) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
