//! Moves of a CL file or a program, one by one.

use super::cl::Locations;
use super::program::Program;
use super::refusal::failure;
use super::source::{InputOptions, Source, stem};
use crate::inspect;
use crate::outcome::Failure;
use crate::path::lines::Lines;
use crate::post::head::HeadState;
use crate::post::summary::LeftOutCount;
use crate::text::unreadable;
use anyhow::Context;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::Path;
use trunnion::machine::Kinematics;
use trunnion::nc::read::{AxisWords, Dialect};
use trunnion::post::{PostError, PostMove, PostSource};
use trunnion::types::Progress;

/// Bytes read at a time, and those of the beginning by which a dialect is known.
const BUFFER: usize = 1 << 16;

/// Input of either kind.
pub(crate) enum Input<'a> {
    Locations(Box<Locations<'a>>),
    Program(Box<Program<'a>>),
}

impl<'a> Input<'a> {
    /// Opens a file; a program is read for `machine` and its axis `words`.
    pub(crate) fn open(
        path: &Path,
        machine: &Kinematics,
        words: AxisWords,
        options: &InputOptions,
        bars: &'a dyn Progress,
    ) -> Result<Self, Failure> {
        let (mut file, size): (Box<dyn BufRead>, u64) = if path == Path::new("-") {
            // Without a size there is no progress to show.
            (Box::new(std::io::stdin().lock()), 0)
        } else {
            let fault = |what: String| Failure::input(format!("{}: {what}", path.display()));
            let size = std::fs::metadata(path).map_err(|error| fault(unreadable(&error)))?;
            if size.is_dir() {
                return Err(fault("is a folder; a file is expected".into()));
            }
            let file = File::open(path).map_err(|error| fault(unreadable(&error)))?;
            (Box::new(BufReader::with_capacity(BUFFER, file)), size.len())
        };
        // Stdin cannot be read twice: the beginning that shows the dialect is put back in front.
        let mut head = Vec::new();
        let unread = || format!("reading {}", path.display());
        file.by_ref().take(BUFFER as u64).read_to_end(&mut head).with_context(unread)?;
        let dialect = options.from.unwrap_or_else(|| {
            let text = String::from_utf8_lossy(&head);
            // CL files are known by name; programs share extensions, so their text decides.
            if inspect::is_cl(path) { Dialect::Apt } else { Dialect::guess(text.lines()) }
        });
        let lines: Box<dyn BufRead> = Box::new(Cursor::new(head).chain(file));
        let source =
            Source { path: path.to_owned(), lines: Lines::new(lines), size, count: 0, bars };
        if dialect == Dialect::Apt {
            return Ok(Self::Locations(Box::new(Locations::new(source, options))));
        }
        Ok(Self::Program(Box::new(Program::new(source, dialect, machine, words, options)?)))
    }

    /// Returns the source of the moves, with the tool in the spindle.
    pub(crate) fn source(&self) -> PostSource {
        match self {
            Self::Locations(_) => PostSource::Locations,
            Self::Program(of) => PostSource::Program(Box::new(of.kinematics().clone())),
        }
    }

    /// Returns the tool of the last move.
    pub(crate) fn tool(&self) -> Option<u32> {
        match self {
            Self::Locations(of) => of.tool(),
            Self::Program(of) => of.tool(),
        }
    }

    /// Returns the next move; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<PostMove>, Failure> {
        match self {
            Self::Locations(of) => of.next(),
            Self::Program(of) => of.next(),
        }
    }

    /// Adds the warnings of the whole input, once it was read to its end and its moves were taken.
    pub(crate) fn warn(&mut self) {
        if let Self::Program(of) = self {
            of.warn();
        }
    }

    /// Returns the warnings so far; each once.
    pub(crate) fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(match self {
            Self::Locations(of) => &mut of.warnings,
            Self::Program(of) => &mut of.warnings,
        })
    }

    /// Returns the name of the input.
    pub(crate) fn name(&self) -> String {
        stem(self.path())
    }

    /// Returns tool, spindle speed and coolant at the last move.
    pub(in crate::post) fn state(&self) -> HeadState {
        match self {
            Self::Locations(of) => of.state(),
            Self::Program(of) => of.state(),
        }
    }

    /// Returns what the input has beside the motion that is posted.
    pub(crate) fn left_out(&self) -> LeftOutCount {
        match self {
            Self::Locations(of) => of.left_out(),
            Self::Program(of) => of.left_out(),
        }
    }

    /// Returns the tools that the tool table of the input's control has otherwise.
    pub(crate) fn contradictions(&self) -> &[String] {
        match self {
            Self::Locations(_) => &[],
            Self::Program(of) => of.contradictions(),
        }
    }

    fn path(&self) -> &Path {
        match self {
            Self::Locations(of) => &of.source.path,
            Self::Program(of) => of.path(),
        }
    }

    /// Returns an error with its line in the file.
    pub(crate) fn failure(&mut self, error: &PostError) -> Failure {
        if let Self::Program(of) = self {
            of.explain_refusal(error.line());
        }
        failure(self.path(), error)
    }
}
