//! APT/CL files as CAM systems write them: statements to cutter locations, line by line.

use super::file::{ClFile, ClItem, ClRecord, ClTool};
use super::reader::ClReader;
use crate::types::Diagnostics;

/// Reads an APT/CL file whole; see [`ClReader`] for what is understood.
///
/// # Example
///
/// ```
/// use trunnion_nc::read::cl;
///
/// let file = cl("UNITS/INCHES\nGOTO/1,2,3,0,0,1\nFINI\n", 10)?;
/// assert_eq!(file.records[0].pose.tip.x, 25.4);
/// # Ok::<(), trunnion_types::types::Diagnostics>(())
/// ```
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

/// Reads the cutter locations of lines that come one by one; in memory at a time is one statement.
///
/// The iterator ends after the first error, which has all faults found up to there.
pub fn cl_records<I>(lines: I, most_faults: usize) -> ClRecords<I>
where
    I: Iterator<Item: AsRef<str>>,
{
    let reader = ClReader::new(most_faults);
    ClRecords { lines, reader, done: false, count: 0, tools: Vec::new() }
}

/// Iterator over cutter locations; see [`cl_records`].
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

    /// Ends the file, and returns all of it but the locations.
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
            // One line makes one location at most.
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
