//! Programs that can be run from their first step as often as it takes.

use super::options::ReadOptions;
use super::step::{Program, Step};
use super::steps::steps;
use crate::read::cl::cl_records;
use crate::read::cl::{ClFile, ClRecord, ClTool};
use crate::types::{AxisVector, Diagnostic, Diagnostics};
use std::fmt::Debug;

/// A program, as its steps ([`Program`]) or as the text that they are read from ([`ProgramText`]).
pub trait ProgramSource: Debug + Sync {
    /// Iterates over all steps, from the start.
    fn steps(&self) -> Box<dyn Iterator<Item = Step> + '_>;

    /// Returns the number of steps.
    fn count(&self) -> usize;

    /// Returns the largest rounding error of each axis word, see [`Program::rounding`] \[mm, rad\].
    fn rounding(&self) -> &AxisVector;

    /// Returns half of the last digit of the feed words, in their own unit.
    fn feed_rounding(&self) -> f64;

    /// Returns the numbers of the tools called, in order.
    fn tools(&self) -> &[u32];
}

impl ProgramSource for Program {
    fn steps(&self) -> Box<dyn Iterator<Item = Step> + '_> {
        Box::new(self.steps.iter().cloned())
    }

    fn count(&self) -> usize {
        self.steps.len()
    }

    fn rounding(&self) -> &AxisVector {
        &self.rounding
    }

    fn feed_rounding(&self) -> f64 {
        self.feed_rounding
    }

    fn tools(&self) -> &[u32] {
        &self.tools
    }
}

/// A program kept as its text: some tens of bytes a block, where a [`Step`] takes some hundreds. Its steps are
/// read anew whenever they are asked for.
#[derive(Debug, Clone)]
pub struct ProgramText {
    text: String,
    options: ReadOptions,
    /// The program without its steps.
    summary: Program,
    count: usize,
}

impl ProgramText {
    /// Reads a program once, to know that it is one.
    ///
    /// # Errors
    ///
    /// Every fault found, up to `options.most_faults`.
    pub fn new(text: String, options: ReadOptions) -> Result<Self, Diagnostics> {
        // One pass finds all faults and counts the steps; the steps themselves are dropped.
        let mut stream = steps(text.lines(), &options);
        let mut count = 0;
        for step in &mut stream {
            step?;
            count += 1;
        }
        let summary = Program {
            steps: Vec::new(),
            rounding: stream.rounding(),
            feed_rounding: stream.feed_rounding(),
            tools: stream.tools().to_vec(),
            warnings: stream.warnings().to_vec(),
        };
        Ok(Self { text, options, summary, count })
    }

    /// Returns the warnings: words kept but not understood, and likely slips.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.summary.warnings
    }
}

impl ProgramSource for ProgramText {
    fn steps(&self) -> Box<dyn Iterator<Item = Step> + '_> {
        // The same text was read without a fault.
        Box::new(steps(self.text.lines(), &self.options).map_while(Result::ok))
    }

    fn count(&self) -> usize {
        self.count
    }

    fn rounding(&self) -> &AxisVector {
        &self.summary.rounding
    }

    fn feed_rounding(&self) -> f64 {
        self.summary.feed_rounding
    }

    fn tools(&self) -> &[u32] {
        &self.summary.tools
    }
}

/// Cutter locations, as records ([`ClFile`]) or as the text that they are read from ([`ClText`]).
pub trait ClSource: Debug + Sync {
    /// Iterates over all locations, from the start.
    fn records(&self) -> Box<dyn Iterator<Item = ClRecord> + '_>;

    /// Returns the number of locations.
    fn count(&self) -> usize;

    /// Returns the tool of the locations, from each change on.
    fn tools(&self) -> &[ClTool];
}

impl ClSource for ClFile {
    fn records(&self) -> Box<dyn Iterator<Item = ClRecord> + '_> {
        Box::new(self.records.iter().copied())
    }

    fn count(&self) -> usize {
        self.records.len()
    }

    fn tools(&self) -> &[ClTool] {
        &self.tools
    }
}

/// A CL file kept as its text, its locations read anew whenever they are asked for.
#[derive(Debug, Clone)]
pub struct ClText {
    text: String,
    most_faults: usize,
    /// The file without its locations.
    summary: ClFile,
    count: usize,
}

impl ClText {
    /// Reads a file once, to know that it is one.
    ///
    /// # Errors
    ///
    /// Every fault found, up to `most_faults`.
    pub fn new(text: String, most_faults: usize) -> Result<Self, Diagnostics> {
        // One pass finds all faults and counts the locations; these are dropped.
        let mut records = cl_records(text.lines(), most_faults);
        let mut count = 0;
        for record in &mut records {
            record?;
            count += 1;
        }
        let summary = records.finish()?;
        Ok(Self { text, most_faults, summary, count })
    }

    /// Returns the warnings: words kept but not understood, and likely slips.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.summary.warnings
    }
}

impl ClSource for ClText {
    fn records(&self) -> Box<dyn Iterator<Item = ClRecord> + '_> {
        // The same text was read without a fault.
        Box::new(cl_records(self.text.lines(), self.most_faults).map_while(Result::ok))
    }

    fn count(&self) -> usize {
        self.count
    }

    fn tools(&self) -> &[ClTool] {
        &self.summary.tools
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::samples::options;
    use crate::read::{Dialect, read};

    #[test]
    fn a_text_has_the_locations_of_its_file() {
        let text = "UNITS/INCHES\nLOADTL/3\nRAPID\nGOTO/1,2,3,0,0,1\nFEDRAT/60,IPM\nGOTO/2,2,3\nODD/1\nLOADTL/4\nGOTO/2,2,9\nFINI\n";
        let file = crate::read::cl(text, 5).unwrap();
        let kept = ClText::new(text.to_owned(), 5).unwrap();
        for _ in 0..2 {
            assert_eq!(kept.records().collect::<Vec<_>>(), file.records);
        }
        assert_eq!((kept.count(), kept.warnings()), (3, &file.warnings[..]));
        let tools = [(0, 4, 3), (2, 9, 4)];
        let tools = tools.map(|(record, line, number)| ClTool { record, line, number });
        assert_eq!((kept.tools(), &file.tools[..]), (&tools[..], &tools[..]));
        assert!(ClText::new(text.replace("FINI", ""), 5).is_err());
    }

    #[test]
    fn a_text_has_the_steps_of_its_program() {
        let text = "#1=3\nG21 G90\nT1 M6\nG0 X0 Y0 Z0 A0.25\nO100 repeat [#1]\nG1 F60 X[#1*2]\nO100 endrepeat\nM2\n";
        let options = options(Dialect::LinuxCnc);
        let program = read(text, &options).unwrap();
        let kept = ProgramText::new(text.to_owned(), options).unwrap();
        for _ in 0..2 {
            assert_eq!(ProgramSource::steps(&kept).collect::<Vec<_>>(), program.steps);
        }
        let of = |source: &dyn ProgramSource| {
            (source.count(), *source.rounding(), source.feed_rounding(), source.tools().to_vec())
        };
        assert_eq!(of(&kept), of(&program));
        assert_eq!(kept.warnings(), program.warnings);
    }
}
