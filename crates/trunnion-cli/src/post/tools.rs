//! Tool lengths from the command line.

use crate::option_values::finite;
use trunnion::nc::control::NumberedLength;

/// Tool length: `120`, or `2=120` for tool 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ToolLength {
    /// Length of the only tool \[mm\].
    Only(f64),
    /// Number of a tool, and its length \[mm\].
    Of(u32, f64),
}

/// Reads a length.
pub(crate) fn length(text: &str) -> Result<ToolLength, String> {
    let Some((number, length)) = text.split_once('=') else {
        return not_below_zero(text).map(ToolLength::Only);
    };
    // Tool tables write T2 as well as 2.
    let number = number.trim().trim_start_matches(['T', 't']).parse();
    let number = number.map_err(|_| "write the tool's number and its length, such as 2=95")?;
    not_below_zero(length).map(|length| ToolLength::Of(number, length))
}

/// Reads a length from the gauge point to the tip, which lies on the side of the tool.
fn not_below_zero(text: &str) -> Result<f64, String> {
    match finite(text)? {
        length if length >= 0.0 => Ok(length),
        length => Err(format!(
            "{length} is below 0; write the distance from the gauge point to the tip in mm, such as 120"
        )),
    }
}

/// Tool lengths in the program to write and in the input program \[mm\].
#[derive(Debug, Clone)]
pub(super) struct Tools {
    /// Length of the first or only tool in the program to write.
    pub(super) length: f64,
    /// The same in the input program.
    pub(super) from_length: f64,
    by_number: Vec<NumberedLength>,
    from_by_number: Vec<NumberedLength>,
}

impl Tools {
    /// Creates the lengths; `only` is a tool that is posted alone.
    pub(super) fn new(to: &[ToolLength], from: &[ToolLength], only: Option<u32>) -> Self {
        let by_number = numbered(to);
        // The input has the same lengths where no other is given.
        let mut from_by_number = by_number.clone();
        for tool in numbered(from) {
            put(&mut from_by_number, tool);
        }
        let of = |list: &[NumberedLength], number| {
            list.iter().find(|tool| Some(tool.number) == number).map(|tool| tool.length)
        };
        let first = |list: &[NumberedLength]| list.first().map(|tool| tool.length);
        let length = of(&by_number, only).or(plain(to)).or(first(&by_number)).unwrap_or(0.0);
        let from_length = of(&from_by_number, only).or(plain(from));
        let from_length = from_length.or(first(&from_by_number)).unwrap_or(length);
        // A tool that is posted alone makes a program with one tool.
        let several = only.is_none();
        Self {
            length,
            from_length,
            by_number: if several { by_number } else { Vec::new() },
            from_by_number: if several { from_by_number } else { Vec::new() },
        }
    }

    pub(super) fn are_several(&self) -> bool {
        !self.by_number.is_empty()
    }

    /// Returns the lengths of the tools to be written, for the setup sheet.
    pub(super) fn lengths(&self) -> &[NumberedLength] {
        &self.by_number
    }

    /// Returns the lengths that the input assumes for the tools to be written.
    pub(super) fn assumed(&self) -> Vec<NumberedLength> {
        let known =
            |tool: &&NumberedLength| self.by_number.iter().any(|known| known.number == tool.number);
        self.from_by_number.iter().filter(known).copied().collect()
    }

    pub(super) fn length_of(&self, number: Option<u32>) -> f64 {
        let found = self.by_number.iter().find(|tool| Some(tool.number) == number);
        found.map_or(self.length, |tool| tool.length)
    }
}

/// Returns the lengths with a number; the last one of equal numbers.
pub(crate) fn numbered(lengths: &[ToolLength]) -> Vec<NumberedLength> {
    let mut all = Vec::new();
    for length in lengths {
        if let ToolLength::Of(number, length) = *length {
            put(&mut all, NumberedLength { number, length });
        }
    }
    all
}

/// Adds the length of a tool, in place of one of the same number.
fn put(all: &mut Vec<NumberedLength>, tool: NumberedLength) {
    all.retain(|known| known.number != tool.number);
    all.push(tool);
}

/// Returns the length without a number.
pub(crate) fn plain(lengths: &[ToolLength]) -> Option<f64> {
    lengths.iter().rev().find_map(|length| match length {
        ToolLength::Only(length) => Some(*length),
        ToolLength::Of(..) => None,
    })
}
