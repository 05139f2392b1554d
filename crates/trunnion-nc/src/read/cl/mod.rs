//! APT/CL files as CAM systems write them: statements to cutter locations, line by line.

mod cycle;
mod known;
mod motion;
mod reader;
mod setting;
mod statement;
mod tally;
mod way;

pub use reader::ClReader;
pub use tally::ClTally;
pub use way::{ClArc, ClHole, ClWay};

use crate::types::{Diagnostic, Diagnostics, ToolPose};
use nalgebra::Isometry3;

/// A CL file, in mm, rad, s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClFile {
    /// Cutter locations in order, all in the coordinates of the first `MSYS`.
    pub records: Vec<ClRecord>,
    /// The last `CUTTER` or `TLDATA`: diameter and corner radius \[mm\].
    pub cutter: Option<[f64; 2]>,
    /// Number of the last tool loaded.
    pub tool: Option<u32>,
    /// Which tool is at the locations, from each change on; empty if the file loads none before one.
    pub tools: Vec<ClTool>,
    /// What was kept but not understood, or looks like a slip.
    pub warnings: Vec<Diagnostic>,
}

/// A tool from a location on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClTool {
    /// Index of the first location.
    pub record: usize,
    /// Line of that location.
    pub line: u32,
    /// Number of the tool.
    pub number: u32,
}

/// One location: a `GOTO`, `GODLTA` or `TLON`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClRecord {
    /// Line, counted from 1.
    pub line: u32,
    /// Tip and tool axis.
    pub pose: ToolPose,
    /// How fast the tool gets there; of a hole, the feed in it.
    pub motion: ClMotion,
    /// On which way.
    pub way: ClWay,
}

/// How a cutter location is approached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClMotion {
    /// After `RAPID`, and to the first location of a file that does not say.
    Rapid,
    /// At this tip speed \[mm/s\].
    Feed(f64),
}

/// What a statement is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClItem {
    /// Moves the tool.
    Location(ClRecord),
    /// Says how the next locations are reached: `RAPID`, `FEDRAT`, `CIRCLE`, `MOVARC`, `INDIRV`, `AUTOPS`.
    Manner,
    /// Says nothing about motion or machine: a comment, an empty line, `PAINT`.
    Remark,
    /// Anything else, with its effect taken in where it has one: units, frames, tools, cycles, spindle.
    Words,
}

/// Reads an APT/CL file whole; see [`ClReader`] for what is understood.
///
/// # Errors
///
/// Every fault found, up to `most_faults`.
pub fn cl(text: &str, most_faults: usize) -> Result<ClFile, Diagnostics> {
    let mut records = cl_records(text.lines(), most_faults);
    let mut file = ClFile::default();
    for record in &mut records {
        file.records.push(record?);
    }
    Ok(ClFile { records: file.records, ..records.finish()? })
}

/// Cutter locations of lines that come one by one; in memory at a time is one statement.
///
/// The iterator ends after the first error, which has all faults found up to there.
pub fn cl_records<I>(lines: I, most_faults: usize) -> ClRecords<I>
where
    I: Iterator<Item: AsRef<str>>,
{
    let reader = ClReader::new(most_faults);
    ClRecords { lines, reader, done: false, count: 0, tools: Vec::new() }
}

/// See [`cl_records`].
#[derive(Debug)]
pub struct ClRecords<I> {
    lines: I,
    reader: ClReader,
    done: bool,
    /// Locations so far, and their tools.
    count: usize,
    tools: Vec<ClTool>,
}

impl<I> ClRecords<I> {
    /// Counts a location, and notes a new tool.
    fn count_in(&mut self, line: u32) {
        if let Some(number) = self.reader.tool()
            && self.tools.last().is_none_or(|last| last.number != number)
        {
            self.tools.push(ClTool { record: self.count, line, number });
        }
        self.count += 1;
    }

    /// Ends the file: all that it says but the locations.
    ///
    /// # Errors
    ///
    /// All faults; a file that was cut has one.
    pub(in crate::read) fn finish(self) -> Result<ClFile, Diagnostics> {
        let reader = self.reader;
        let (cutter, tool) = (reader.cutter(), reader.tool());
        let warnings = reader.finish()?;
        Ok(ClFile { records: Vec::new(), cutter, tool, tools: self.tools, warnings })
    }
}

impl<I> Iterator for ClRecords<I>
where
    I: Iterator<Item: AsRef<str>>,
{
    type Item = Result<ClRecord, Diagnostics>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.done {
            let Some(line) = self.lines.next() else {
                self.done = true;
                let faults = self.reader.faults_at_end();
                return (!faults.is_empty()).then_some(Err(faults.into()));
            };
            let item = self.reader.line(line.as_ref());
            if self.reader.is_full() {
                self.done = true;
                return Some(Err(self.reader.faults().to_vec().into()));
            }
            // After a fault the places are not to be trusted; the faults of the rest still are.
            if let (Some(ClItem::Location(record)), true) = (item, self.reader.faults().is_empty())
            {
                self.count_in(record.line);
                return Some(Ok(record.moved(&self.reader.first_from_written())));
            }
        }
        None
    }
}

impl ClRecord {
    /// The same in other coordinates.
    #[must_use]
    pub fn moved(mut self, to_from: &Isometry3<f64>) -> Self {
        // The identity would still round.
        if *to_from == Isometry3::identity() {
            return self;
        }
        self.pose.tip = to_from * self.pose.tip;
        self.pose.axis = to_from.rotation * self.pose.axis;
        if let ClWay::Arc(arc) = &mut self.way {
            arc.start = to_from * arc.start;
            arc.center = to_from * arc.center;
            arc.normal = to_from.rotation * arc.normal;
        }
        self
    }
}
