//! Conversion of tables row by row: bounded memory, and output written whole or not at all.

use crate::disk;
use crate::outcome::Failure;
use crate::output;
use crate::progress;
use crate::text::unreadable;
use anyhow::Context;
use std::io::{self, BufRead, BufWriter, IsTerminal, Read, Seek, Write};
use std::path::{Path, PathBuf};
use tempfile::SpooledTempFile;
use trunnion::files::table::{TableColumns, TableHeader, is_row};
use trunnion::types::{Diagnostic, Diagnostics};

/// Longest line of a table \[bytes\]; a guard against a file that is no table.
const LONGEST: u64 = 1 << 20;
/// Most faults or refusals that are listed one by one.
const MOST_LISTED: usize = 20;
/// Output up to this size waits in memory, more in a temporary file \[bytes\].
const IN_MEMORY: usize = 16 << 20;

/// Source and destination of a table.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Ends {
    /// Table to read (CSV with a header line); `-` is stdin.
    #[arg(default_value = "-")]
    input: PathBuf,
    /// File for the result; `-` is stdout.
    #[arg(short, long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
}

/// A table read whole.
#[derive(Debug)]
pub(crate) struct Rows {
    /// Columns, in the order of the values.
    pub(crate) names: Vec<String>,
    /// Line of each row.
    pub(crate) lines: Vec<u32>,
    /// Values, row by row.
    pub(crate) values: Vec<f64>,
}

/// Conversion of every row.
pub(crate) trait Work {
    /// Columns that are read.
    fn columns(&self) -> Vec<String>;
    /// Header line of the result.
    fn header(&self) -> String;
    /// Appends the result of one row, with its line end; `None` for a row without numbers.
    fn row(&mut self, values: Option<&[f64]>, out: &mut String) -> Result<(), Refusal>;
}

/// Reason why a row has no result.
#[derive(Debug)]
pub(crate) enum Refusal {
    /// The row is malformed: the table is refused.
    Malformed(String),
    /// The row has no answer, which is reported; the work continues. A row without numbers was appended.
    Unsolved(String),
}

/// Counts of a conversion.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    /// Rows read.
    pub(crate) rows: u64,
    /// Rows without an answer.
    pub(crate) unsolved: u64,
    /// The first of them, as reported on stderr.
    pub(crate) messages: Vec<String>,
}

impl Ends {
    /// Returns true if the result goes to stdout.
    pub(crate) fn to_stdout(&self) -> bool {
        is_dash(&self.output)
    }

    /// Returns the file of the table.
    pub(crate) fn input(&self) -> &Path {
        &self.input
    }

    /// Returns the file of the result.
    pub(crate) fn output(&self) -> &Path {
        &self.output
    }

    /// Runs `work` over the table. Nothing is written unless every row could be read.
    pub(crate) fn run(&self, work: &mut dyn Work) -> Result<Tally, Failure> {
        let name = self.name();
        self.protect_input()?;
        // The rows wait in a spool: one malformed row must leave no half of a table behind.
        let mut spool = BufWriter::new(self.spool()?);
        let tally = self.rows(name, work, &mut spool)?;
        let mut spool =
            spool.into_inner().map_err(|error| anyhow::Error::new(error.into_error()))?;
        spool.rewind().context("reading back the result")?;
        if self.to_stdout() {
            to_stdout(&mut spool)?;
        } else {
            // The result is complete, and the rename is moments away: Ctrl-C no longer stops it.
            progress::ignore_interrupts();
            output::file(&self.output, |out| io::copy(&mut spool, out).map(drop))?;
        }
        Ok(tally)
    }

    /// Refuses, before any work, a result that would overwrite its own input.
    fn protect_input(&self) -> Result<(), Failure> {
        output::protect(&self.output, &[&self.input])
    }

    /// Returns the name of the input for messages.
    pub(crate) fn name(&self) -> &Path {
        if is_dash(&self.input) { Path::new("stdin") } else { &self.input }
    }

    /// Reads the whole table; `choose` names the columns, in order.
    pub(crate) fn read(
        &self,
        choose: impl Fn(&TableHeader) -> Result<Vec<String>, Diagnostics>,
    ) -> Result<Rows, Failure> {
        self.protect_input()?;
        let (mut lines, mut all) = (Vec::new(), Vec::new());
        let names = each(self.name(), self.open()?, choose, |line, _, _, values| {
            lines.push(line);
            all.extend_from_slice(values);
            Ok(())
        })?;
        Ok(Rows { names, lines, values: all })
    }

    /// Writes the result whole or not at all.
    pub(crate) fn write(
        &self,
        fill: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        if !self.to_stdout() {
            return output::file(&self.output, |out| fill(out));
        }
        // Callers fill from a finished plan, which can no longer be refused.
        let mut out = BufWriter::new(io::stdout().lock());
        match fill(&mut out).and_then(|()| out.flush()) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                Err(anyhow::Error::new(error).context("writing to stdout").into())
            }
            _ => Ok(()),
        }
    }

    /// Writes the result whole or not at all, by a function that may refuse on the way.
    pub(crate) fn write_checked<T>(
        &self,
        fill: impl FnOnce(&mut dyn Write) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        if self.to_stdout() {
            // Stdout cannot be taken back: the whole result waits until nothing can refuse it.
            let mut spool = BufWriter::new(self.spool()?);
            let filled = fill(&mut spool)?;
            let mut spool =
                spool.into_inner().map_err(|error| anyhow::Error::new(error.into_error()))?;
            spool.rewind().context("reading back the result")?;
            to_stdout(&mut spool)?;
            return Ok(filled);
        }
        output::file_checked(&self.output, |out| fill(out))
    }

    /// Returns true if the table comes from stdin.
    pub(crate) fn is_stdin(&self) -> bool {
        is_dash(&self.input)
    }

    /// Returns the columns that `choose` takes from the header.
    pub(crate) fn columns(
        &self,
        choose: impl Fn(&TableHeader) -> Result<Vec<String>, Diagnostics>,
    ) -> Result<Vec<String>, Failure> {
        let name = self.name();
        first(&mut Lines { source: self.open()?, number: 0, bytes: Vec::new() }, name, choose)
            .map(|(names, _)| names)
    }

    fn open(&self) -> Result<Box<dyn BufRead>, Failure> {
        if is_dash(&self.input) {
            if io::stdin().is_terminal() {
                // Without a file the verb would seem to hang.
                eprintln!("reading a table from the terminal; Ctrl-D ends it");
            }
            return Ok(Box::new(io::stdin().lock()));
        }
        open(&self.input)
    }

    /// Opens a temporary place for the result, which vanishes with the process.
    fn spool(&self) -> Result<SpooledTempFile, Failure> {
        if self.to_stdout() {
            return Ok(tempfile::spooled_tempfile(IN_MEMORY));
        }
        if self.output.is_dir() {
            let message = format!("{}: is a folder; a file is expected", self.output.display());
            return Err(Failure::input(message));
        }
        // Beside the output, which has room for it if the output has.
        let folder = self.output.parent().filter(|folder| folder.is_dir());
        Ok(tempfile::spooled_tempfile_in(IN_MEMORY, folder.unwrap_or(Path::new("."))))
    }

    fn rows(
        &self,
        name: &Path,
        work: &mut dyn Work,
        out: &mut dyn Write,
    ) -> Result<Tally, Failure> {
        let mut lines = Lines { source: self.open()?, number: 0, bytes: Vec::new() };
        let failure = |faults: &[Diagnostic]| Failure::faults(name, faults);
        let columns = header(&mut lines, name, work)?;
        let mut tally = Tally::default();
        let mut faults = Faults::default();
        let mut values = Vec::new();
        let mut text = work.header() + "\n";
        loop {
            let (number, line) = match lines.next(name) {
                Ok(Some(line)) => line,
                Ok(None) => break,
                Err(Stop::Line(fault)) => {
                    // Not a text line: whatever follows is no table either.
                    faults.add(fault);
                    break;
                }
                Err(Stop::Failure(failure)) => return Err(failure),
            };
            tally.rows += 1;
            let row = if columns.has_none && columns.columns.are_empty(line) {
                None
            } else if let Err(fault) = columns.columns.read(number, line, &mut values) {
                faults.add(fault);
                continue;
            } else {
                Some(values.as_slice())
            };
            match work.row(row, &mut text) {
                Ok(()) => {}
                Err(Refusal::Unsolved(why)) => tally.refuse(number, &why),
                Err(Refusal::Malformed(why)) => faults.add(Diagnostic {
                    line: u32::try_from(number).unwrap_or(u32::MAX),
                    column: 1,
                    message: why,
                    help: String::new(),
                }),
            }
            // After a fault nothing will be written; the rest is read for its faults only.
            if faults.list.is_empty() {
                out.write_all(text.as_bytes()).context("writing the result")?;
            }
            text.clear();
        }
        if !faults.list.is_empty() {
            return Err(failure(&faults.listed()));
        }
        out.write_all(text.as_bytes()).context("writing the result")?;
        tally.end();
        Ok(tally)
    }
}

/// Opens a table.
fn open(path: &Path) -> Result<Box<dyn BufRead>, Failure> {
    let fault =
        |what: &dyn std::fmt::Display| Failure::input(format!("{}: {what}", path.display()));
    disk::open(path).map_err(|error| fault(&unreadable(&error)))
}

/// Hands every row of a table file to `row`: line, text, columns, and their values. `choose` names the columns,
/// in order; they are returned.
pub(crate) fn each_of(
    path: &Path,
    choose: impl Fn(&TableHeader) -> Result<Vec<String>, Diagnostics>,
    row: impl FnMut(u32, &str, &TableColumns, &[f64]) -> Result<(), Failure>,
) -> Result<Vec<String>, Failure> {
    each(path, open(path)?, choose, row)
}

fn each(
    name: &Path,
    source: Box<dyn BufRead>,
    choose: impl Fn(&TableHeader) -> Result<Vec<String>, Diagnostics>,
    mut row: impl FnMut(u32, &str, &TableColumns, &[f64]) -> Result<(), Failure>,
) -> Result<Vec<String>, Failure> {
    let mut lines = Lines { source, number: 0, bytes: Vec::new() };
    let (names, columns) = first(&mut lines, name, choose)?;
    let failure = |faults: &[Diagnostic]| Failure::faults(name, faults);
    let stop = |stop: Stop| stop.failure(name);
    let mut faults = Faults::default();
    let mut values = Vec::new();
    while let Some((number, line)) = lines.next(name).map_err(stop)? {
        match columns.read(number, line, &mut values) {
            Ok(()) if faults.is_empty() => {
                row(u32::try_from(number).unwrap_or(u32::MAX), line, &columns, &values)?;
            }
            Ok(()) => {}
            Err(fault) => faults.add(fault),
        }
    }
    if faults.is_empty() { Ok(names) } else { Err(failure(&faults.listed())) }
}

/// Reads the header line: names of the columns chosen, and where they stand.
fn first(
    lines: &mut Lines,
    name: &Path,
    choose: impl Fn(&TableHeader) -> Result<Vec<String>, Diagnostics>,
) -> Result<(Vec<String>, TableColumns), Failure> {
    let failure = |faults: &[Diagnostic]| Failure::faults(name, faults);
    let Some((number, line)) = lines.next(name).map_err(|stop| stop.failure(name))? else {
        return Err(failure(&[Diagnostic::whole("the table is empty")]));
    };
    let header = TableHeader::parse(number, line).map_err(|fault| failure(&[fault]))?;
    let names = choose(&header).map_err(|faults| failure(&faults))?;
    let wanted: Vec<&str> = names.iter().map(String::as_str).collect();
    let columns = header.columns(&wanted).map_err(|faults| failure(&faults))?;
    Ok((names, columns))
}

/// The columns that a row is read from.
struct Reading {
    columns: TableColumns,
    /// True if rows may be empty: a table that `pose inverse` wrote.
    has_none: bool,
}

fn header(lines: &mut Lines, name: &Path, work: &dyn Work) -> Result<Reading, Failure> {
    let wanted = work.columns();
    let wanted: Vec<&str> = wanted.iter().map(String::as_str).collect();
    let failure = |faults: &[Diagnostic]| Failure::faults(name, faults);
    let (number, line) = match lines.next(name) {
        Ok(Some(line)) => line,
        Ok(None) => {
            let fault = Diagnostic::whole("the table is empty");
            let help = format!("its first line names the columns: {}", wanted.join(","));
            return Err(failure(&[fault.with_help(help)]));
        }
        Err(Stop::Line(fault)) => return Err(failure(&[fault])),
        Err(Stop::Failure(failure)) => return Err(failure),
    };
    let help = |fault: Diagnostic| {
        let help = format!("for example {}", wanted.join(","));
        if fault.help.is_empty() { fault.with_help(help) } else { fault }
    };
    let header = TableHeader::parse(number, line).map_err(|fault| failure(&[help(fault)]))?;
    // Only `pose inverse` writes both columns, and empty rows for poses out of reach.
    let has_none = ["pose", "solution"].iter().all(|name| header.names().iter().any(|n| n == name));
    let columns = header.columns(&wanted).map_err(|faults| failure(&faults))?;
    Ok(Reading { columns, has_none })
}

impl Tally {
    fn refuse(&mut self, line: u64, why: &str) {
        self.unsolved += 1;
        if self.messages.len() < MOST_LISTED {
            let message = format!("pose {} (line {line}): {why}", self.rows);
            eprintln!("{message}");
            self.messages.push(message);
        }
    }

    fn end(&self) {
        // One line for the rest: a table of a million poses must not flood the terminal.
        let more = self.unsolved.saturating_sub(MOST_LISTED as u64);
        if more > 0 {
            eprintln!("and {more} more poses without an answer");
        }
    }
}

/// Faults of a table: the first few, and the number of the others.
#[derive(Default)]
pub(crate) struct Faults {
    list: Vec<Diagnostic>,
    more: u64,
}

impl Faults {
    pub(crate) fn add(&mut self, fault: Diagnostic) {
        if self.list.len() < MOST_LISTED { self.list.push(fault) } else { self.more += 1 }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    pub(crate) fn listed(mut self) -> Vec<Diagnostic> {
        if self.more > 0 {
            self.list.push(Diagnostic::whole(format!("and {} more faults", self.more)));
        }
        self.list
    }
}

/// Lines of a table with their numbers, comments left out.
struct Lines {
    source: Box<dyn BufRead>,
    number: u64,
    bytes: Vec<u8>,
}

/// Reason why there is no next line.
enum Stop {
    Line(Diagnostic),
    Failure(Failure),
}

impl Stop {
    fn failure(self, name: &Path) -> Failure {
        match self {
            Self::Line(fault) => Failure::faults(name, &[fault]),
            Self::Failure(failure) => failure,
        }
    }
}

impl Lines {
    fn next(&mut self, name: &Path) -> Result<Option<(u64, &str)>, Stop> {
        loop {
            self.bytes.clear();
            let read = (&mut self.source).take(LONGEST).read_until(b'\n', &mut self.bytes);
            let read = read.map_err(|error| {
                Stop::Failure(Failure::input(format!("{}: {error}", name.display())))
            })?;
            if read == 0 {
                return Ok(None);
            }
            self.number += 1;
            let fault = |message: String| {
                let line = u32::try_from(self.number).unwrap_or(u32::MAX);
                Stop::Line(Diagnostic { line, column: 1, message, help: String::new() })
            };
            // The line was cut off at the limit.
            if read as u64 == LONGEST {
                return Err(fault(format!(
                    "the line has more than {LONGEST} bytes: this is not a table"
                )));
            }
            // Checked twice: a borrow that is returned must not be taken before the loop goes on.
            let Ok(line) = std::str::from_utf8(&self.bytes) else {
                return Err(fault("not a text file (a byte is not UTF-8)".into()));
            };
            if is_row(line) {
                break;
            }
        }
        let line = std::str::from_utf8(&self.bytes).unwrap_or_default();
        Ok(Some((self.number, line)))
    }
}

fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Copies to stdout. A closed pipe is not an error: `head` closes it on purpose.
fn to_stdout(spool: &mut dyn Read) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match io::copy(spool, &mut out).and_then(|_| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(anyhow::Error::new(error).context("writing to stdout").into())
        }
        _ => Ok(()),
    }
}
