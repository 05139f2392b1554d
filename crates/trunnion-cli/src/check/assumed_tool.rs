//! The tool of a job that is checked in place of the one that the program calls.

use crate::table_tool::DescribedTool;
use trunnion::cutter::Cutter;
use trunnion::nc::read::ToolRow;

/// The only tool of a job, taken for another number.
pub(super) struct AssumedTool<'a> {
    /// Number that the program calls, and that of the job.
    pub(super) number: u32,
    pub(super) own: u32,
    pub(super) cutter: &'a Cutter,
}

impl AssumedTool<'_> {
    /// Says which tool is taken.
    pub(super) fn warning(&self) -> String {
        let Self { number, own, .. } = self;
        let tool = self.words();
        format!(
            "the program calls tool {number}, but the job describes tool {own}: the check uses the tool of the job{tool}"
        )
    }

    /// Says in what the tool table of the control has another tool under the number that the program calls.
    pub(super) fn contradiction(&self, table: &[ToolRow]) -> Option<String> {
        let row = described(self.number, self.cutter).other_row(table)?;
        let [length, diameter] = [row.offset[2], row.diameter];
        let (number, tool) = (self.number, self.words());
        Some(format!(
            "tool {number} of the tool table has length {length} mm and diameter {diameter} mm: it is not the tool of \
             the job{tool}; call that tool, or describe tool {number} (--cutter {number}=.. --tool-length {number}=L)"
        ))
    }

    /// Diameter and length of the tool that is taken.
    fn words(&self) -> String {
        format!(", diameter {} mm, length {} mm", diameter_of(self.cutter), self.cutter.length())
    }
}

/// Returns a cutter as the tool that a program calls by `number`.
pub(super) fn described(number: u32, cutter: &Cutter) -> DescribedTool {
    DescribedTool { number, length: cutter.length(), diameter: Some(diameter_of(cutter)) }
}

/// Diameter of the cutting part \[mm\].
fn diameter_of(cutter: &Cutter) -> f64 {
    2.0 * cutter.radius()
}
