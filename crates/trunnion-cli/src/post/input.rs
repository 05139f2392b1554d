//! Moves of a CL file or a program, one by one.

mod cl;
mod program;

use super::Head;
use crate::inspect;
use crate::outcome::Failure;
use crate::path::lines::{self, Lines};
use crate::progress::Bars;
use anyhow::Context;
use cl::Locations;
use program::Program;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};
use trunnion::machine::Kinematics;
use trunnion::nc::read::{AxisWords, Dialect};
use trunnion::post::{PostError, PostMove, PostRemedy, PostSource};
use trunnion::types::{Diagnostic, Progress, Stage};

/// Bytes read at a time, and those of the beginning by which a dialect is known.
const BUFFER: usize = 1 << 16;

/// Lines between two checks for cancellation.
const LINES_A_STEP: u64 = 4096;

/// Chord tolerance of arcs \[mm\].
pub(super) const ARC_TOLERANCE: f64 = 1e-3;

/// A text file that is read line by line.
pub(super) struct Source<'a> {
    pub(super) path: PathBuf,
    lines: Lines<Box<dyn BufRead>>,
    size: u64,
    count: u64,
    bars: &'a Bars,
}

impl Source<'_> {
    /// The next line, without its line break.
    pub(super) fn line(&mut self) -> Result<Option<std::borrow::Cow<'_, str>>, Failure> {
        self.count += 1;
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
pub(super) struct Taken {
    /// Its dialect.
    pub(super) from: Option<Dialect>,
    /// Moves of this tool only.
    pub(super) tool: Option<u32>,
    /// Lengths of several tools that a program assumes, by number \[mm\].
    pub(super) lengths: Vec<(u32, f64)>,
    /// Values of parameters.
    pub(super) parameters: Vec<(String, f64)>,
    /// True runs the lines that begin with /, false skips them.
    pub(super) block_delete: Option<bool>,
}

/// Input of one of both kinds.
pub(super) enum Input<'a> {
    Locations(Box<Locations<'a>>),
    Program(Box<Program<'a>>),
}

impl<'a> Input<'a> {
    /// Opens a file; a program is read for `machine` and its axis `words`.
    pub(super) fn open(
        path: &Path,
        machine: &Kinematics,
        words: AxisWords,
        taken: &Taken,
        bars: &'a Bars,
    ) -> Result<Self, Failure> {
        let (mut file, size): (Box<dyn BufRead>, u64) = if path == Path::new("-") {
            (Box::new(std::io::stdin().lock()), 0)
        } else {
            let fault = |what: String| Failure::input(format!("{}: {what}", path.display()));
            let size = std::fs::metadata(path).map_err(|error| fault(error.to_string()))?;
            if size.is_dir() {
                return Err(fault("is a folder; a file is expected".into()));
            }
            let file = File::open(path).map_err(|error| fault(error.to_string()))?;
            (Box::new(BufReader::with_capacity(BUFFER, file)), size.len())
        };
        let mut head = Vec::new();
        let unread = || format!("reading {}", path.display());
        file.by_ref().take(BUFFER as u64).read_to_end(&mut head).with_context(unread)?;
        let dialect = taken.from.unwrap_or_else(|| {
            let text = String::from_utf8_lossy(&head);
            if inspect::is_cl(path) { Dialect::Apt } else { Dialect::guess(text.lines()) }
        });
        let lines: Box<dyn BufRead> = Box::new(Cursor::new(head).chain(file));
        let source =
            Source { path: path.to_owned(), lines: Lines::new(lines), size, count: 0, bars };
        if dialect == Dialect::Apt {
            return Ok(Self::Locations(Box::new(Locations::new(source, taken))));
        }
        Ok(Self::Program(Box::new(Program::new(source, dialect, machine, words, taken)?)))
    }

    /// Returns the source of the moves, with the tool in the spindle.
    pub(super) fn source(&self) -> PostSource {
        match self {
            Self::Locations(_) => PostSource::Locations,
            Self::Program(of) => PostSource::Program(Box::new(of.kinematics().clone())),
        }
    }

    /// The tool of the last move.
    pub(super) fn tool(&self) -> Option<u32> {
        match self {
            Self::Locations(of) => of.tool(),
            Self::Program(of) => of.tool(),
        }
    }

    /// The next move; `None` at the end.
    pub(super) fn next(&mut self) -> Result<Option<PostMove>, Failure> {
        match self {
            Self::Locations(of) => of.next(),
            Self::Program(of) => of.next(),
        }
    }

    /// Adds tool and spindle of the input so far.
    pub(super) fn head(&self, head: &mut Head) {
        match self {
            Self::Locations(of) => of.head(head),
            Self::Program(of) => of.head(head),
        }
    }

    fn path(&self) -> &Path {
        match self {
            Self::Locations(of) => &of.source.path,
            Self::Program(of) => of.path(),
        }
    }

    /// A message with the place in the file.
    pub(super) fn failure(&self, error: &PostError) -> Failure {
        failure(self.path(), error)
    }
}

/// A message with the place in a file.
fn failure(path: &Path, error: &PostError) -> Failure {
    let fault = Diagnostic {
        line: error.line(),
        column: 0,
        message: error.to_string(),
        help: help(error.remedy()).to_owned(),
    };
    Failure::faults(path, &[fault])
}

/// Words a remedy with the flags of this command line.
fn help(remedy: PostRemedy) -> &'static str {
    match remedy {
        PostRemedy::MoveOrRotatePart => {
            "clamp the part elsewhere (--origin), or turn it (--rotation)"
        }
        PostRemedy::RotatePart => "turn the part (--rotation), or post it for another machine",
        PostRemedy::UnwindOrRotatePart => {
            "let the rotaries unwind off the part (--unwind), divide the cut by a rapid move before this line, or turn \
             the part (--rotation)"
        }
        PostRemedy::ToolLengths => {
            "give the length of each tool, --tool-length NUMBER=L; or post one tool: --tool NUMBER"
        }
        PostRemedy::ToolLength => {
            "give its length: --tool-length NUMBER=L, and --from-tool-length where it differs"
        }
        PostRemedy::InspectInput => {
            "`trunnion inspect` lists the contents of the file; with --tool, check which tools it calls"
        }
        PostRemedy::Advice(advice) => advice,
        _ => "",
    }
}

/// Returns the name of the input.
fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
