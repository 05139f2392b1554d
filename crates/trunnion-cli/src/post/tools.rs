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
        return finite(text).map(ToolLength::Only);
    };
    // Tool tables write T2 as well as 2.
    let number = number.trim().trim_start_matches(['T', 't']).parse();
    let number = number.map_err(|_| "write the tool's number and its length, such as 2=95")?;
    finite(length).map(|length| ToolLength::Of(number, length))
}

/// Tool lengths in the program to write and in the input program \[mm\].
#[derive(Debug, Clone)]
pub(super) struct Tools {
    /// Length of the first or only tool in the program to write.
    pub(super) length: f64,
    /// The same in the input program.
    pub(super) from_length: f64,
    by_number: Vec<(u32, f64)>,
    from_by_number: Vec<(u32, f64)>,
}

impl Tools {
    /// Creates the lengths; `only` is a tool that is posted alone.
    pub(super) fn new(to: &[ToolLength], from: &[ToolLength], only: Option<u32>) -> Self {
        let by_number = numbered(to);
        // The input has the same lengths where no other is given.
        let mut from_by_number = by_number.clone();
        for (number, length) in numbered(from) {
            from_by_number.retain(|(known, _)| *known != number);
            from_by_number.push((number, length));
        }
        let of = |list: &[(u32, f64)], number| {
            list.iter().find(|(known, _)| Some(*known) == number).map(|(_, length)| *length)
        };
        let first = |list: &[(u32, f64)]| list.first().map(|(_, length)| *length);
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
    pub(super) fn lengths(&self) -> Vec<NumberedLength> {
        let length = |&(number, length): &(u32, f64)| NumberedLength { number, length };
        self.by_number.iter().map(length).collect()
    }

    /// Returns the lengths that the input assumes for the tools to be written.
    pub(super) fn assumed(&self) -> Vec<(u32, f64)> {
        let known = |number: &u32| self.by_number.iter().any(|(known, _)| known == number);
        self.from_by_number.iter().filter(|(number, _)| known(number)).copied().collect()
    }

    pub(super) fn length_of(&self, number: Option<u32>) -> f64 {
        let found = self.by_number.iter().find(|(known, _)| Some(*known) == number);
        found.map_or(self.length, |(_, length)| *length)
    }
}

/// Returns the lengths with a number; the last one of equal numbers.
pub(crate) fn numbered(lengths: &[ToolLength]) -> Vec<(u32, f64)> {
    let mut all: Vec<(u32, f64)> = Vec::new();
    for length in lengths {
        if let ToolLength::Of(number, length) = *length {
            all.retain(|(known, _)| *known != number);
            all.push((number, length));
        }
    }
    all
}

/// Returns the length without a number.
pub(crate) fn plain(lengths: &[ToolLength]) -> Option<f64> {
    lengths.iter().rev().find_map(|length| match length {
        ToolLength::Only(length) => Some(*length),
        ToolLength::Of(..) => None,
    })
}
