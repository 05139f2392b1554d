//! The tool of a job that is checked in place of the one that the program calls.

use trunnion::cutter::Cutter;
use trunnion::nc::read::ToolRow;

/// Difference up to which two lengths of a tool are the same \[mm\]: tables have three or four decimals.
const SAME: f64 = 5e-4;

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
        let row = table.iter().rev().find(|row| row.number == self.number)?;
        let cutter = self.cutter;
        // A table without a value leaves it open.
        let differs = |of: f64, taken: f64| of.abs() > 0.0 && (of.abs() - taken).abs() > SAME;
        let [length, diameter] = [row.offset[2], row.diameter];
        if !differs(length, cutter.length()) && !differs(diameter, diameter_of(cutter)) {
            return None;
        }
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

/// Diameter of the cutting part \[mm\].
fn diameter_of(cutter: &Cutter) -> f64 {
    2.0 * cutter.radius()
}
