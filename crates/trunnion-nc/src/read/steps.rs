//! A program as a stream of steps.

use super::options::ReadOptions;
use super::reader::ProgramReader;
use super::step::{Program, Step};
use crate::types::AxisVector;
use crate::types::{Diagnostic, Diagnostics};

/// Reads a program whole; see [`steps`].
///
/// # Example
///
/// ```
/// use trunnion_nc::read::{AxisWord, AxisWords, Dialect, ReadOptions, Step, read};
///
/// let word = |letter: char| {
///     AxisWord { letter, rotary: "AC".contains(letter), decimals: 3, reversed: false }
/// };
/// let axes = AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word));
/// let options = ReadOptions::new(Dialect::LinuxCnc, axes, 10);
/// let program = read("G21 G90 G94\nG0 X1 Y2 Z3\nM2\n", &options)?;
/// let moves = program.steps.iter().filter(|step| matches!(step, Step::Move(_)));
/// assert_eq!(moves.count(), 1);
/// # Ok::<(), trunnion_types::types::Diagnostics>(())
/// ```
///
/// # Errors
///
/// Every fault found, up to `options.most_faults`.
pub fn read(text: &str, options: &ReadOptions) -> Result<Program, Diagnostics> {
    let mut stream = steps(text.lines(), options);
    let mut steps = Vec::new();
    for step in &mut stream {
        steps.push(step?);
    }
    Ok(Program {
        steps,
        rounding: stream.rounding(),
        feed_rounding: stream.feed_rounding(),
        tools: stream.tools().to_vec(),
        warnings: stream.warnings().to_vec(),
    })
}

/// A program that is handed in line by line, for one that is read while it is written; see [`steps`].
///
/// # Example
///
/// ```
/// use trunnion_nc::read::{AxisWord, AxisWords, Dialect, LineReader, ReadOptions};
///
/// let word = |letter: char| {
///     AxisWord { letter, rotary: "AC".contains(letter), decimals: 3, reversed: false }
/// };
/// let axes = AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word));
/// let mut reader = LineReader::new(&ReadOptions::new(Dialect::Fanuc, axes, 10));
/// let mut steps = Vec::new();
/// for line in ["G0 X1. Y2.", "G1 X3. F600.", "M30"] {
///     reader.line(line, &mut steps)?;
/// }
/// reader.finish()?;
/// assert_eq!(steps.len(), 2);
/// # Ok::<(), trunnion_types::types::Diagnostics>(())
/// ```
#[derive(Debug)]
pub struct LineReader {
    reader: ProgramReader,
}

impl LineReader {
    /// Starts a program.
    pub fn new(options: &ReadOptions) -> Self {
        Self { reader: ProgramReader::new(options) }
    }

    /// Takes in a line, without its line break; the steps it makes are appended.
    ///
    /// # Errors
    ///
    /// Every fault so far.
    pub fn line(&mut self, line: &str, out: &mut Vec<Step>) -> Result<(), Diagnostics> {
        if !self.reader.is_over() {
            self.reader.line(line);
        }
        loop {
            // Lines that loops and calls run again come before the next line of the file.
            out.extend(std::iter::from_fn(|| self.reader.pop()));
            if !self.reader.is_busy() {
                break;
            }
            self.reader.advance();
        }
        let faults = self.reader.faults();
        if faults.is_empty() { Ok(()) } else { Err(faults.to_vec().into()) }
    }

    /// Appends the step of the last line that waits for the next one, which might round its end (`RND`, `CHF`).
    ///
    /// For texts in which no such line follows.
    pub fn release_element(&mut self, out: &mut Vec<Step>) {
        self.reader.release_element();
        out.extend(std::iter::from_fn(|| self.reader.pop()));
    }

    /// Returns the warnings so far: words kept but not understood, and likely slips.
    pub fn warnings(&self) -> &[Diagnostic] {
        self.reader.warnings()
    }

    /// Ends the program.
    ///
    /// # Errors
    ///
    /// Every fault.
    pub fn finish(mut self) -> Result<(), Diagnostics> {
        let faults = self.reader.finish();
        if faults.is_empty() { Ok(()) } else { Err(faults.into()) }
    }
}

/// Reads a program whose lines come one by one. In memory is the longest loop or subprogram; the
/// rest
/// of the program, too, once a subprogram is called that stands behind its call.
///
/// Reading ends at `M2` or `M30`: a control stops there. The iterator ends after the first error, which
/// has every fault of the program, up to `options.most_faults`.
pub fn steps<I>(lines: I, options: &ReadOptions) -> Steps<I>
where
    I: Iterator<Item: AsRef<str>>,
{
    Steps { lines, reader: ProgramReader::new(options), done: false }
}

/// Iterator over the steps of a program; see [`steps`].
#[derive(Debug)]
pub struct Steps<I> {
    lines: I,
    reader: ProgramReader,
    done: bool,
}

impl<I> Steps<I> {
    /// Returns half of the last digit of each axis word so far \[mm, rad\].
    pub fn rounding(&self) -> AxisVector {
        self.reader.rounding()
    }

    /// Returns half of the last digit of the feed words so far, in their own unit.
    pub fn feed_rounding(&self) -> f64 {
        self.reader.feed_rounding()
    }

    /// Returns the numbers of the tools called so far.
    pub fn tools(&self) -> &[u32] {
        self.reader.tools()
    }

    /// Returns the warnings so far: words kept but not understood, and likely slips.
    pub fn warnings(&self) -> &[Diagnostic] {
        self.reader.warnings()
    }
}

impl<I> Iterator for Steps<I>
where
    I: Iterator<Item: AsRef<str>>,
{
    type Item = Result<Step, Diagnostics>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            // Queued steps first, then lines that run again, then the next line of the file: so no
            // more than the steps of one block is in memory.
            if let Some(step) = self.reader.pop() {
                return Some(Ok(step));
            }
            if self.done {
                return None;
            }
            if self.reader.is_busy() {
                self.reader.advance();
                continue;
            }
            // Behind the end of the program a control reads nothing, and a full list takes no more
            // faults.
            let line = if self.reader.is_over() { None } else { self.lines.next() };
            if let Some(line) = line {
                self.reader.line(line.as_ref());
            } else {
                self.done = true;
                let faults = self.reader.finish();
                if !faults.is_empty() {
                    return Some(Err(faults.into()));
                }
            }
        }
    }
}
