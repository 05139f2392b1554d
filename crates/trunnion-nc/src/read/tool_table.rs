//! Tool table of the control, as it is given and as the program changes it.

use super::options::ToolRow;
use crate::types::{Diagnostic, Diagnostics};
use std::collections::BTreeMap;

/// Largest length in a tool table \[mm\]; beyond it is a slip.
const LONGEST: f64 = 1e6;

/// Reads a tool table of `LinuxCNC`: lines such as `T1 P1 Z20.5 D6 ; end mill`.
///
/// `unit` is the length of the table's unit \[mm\]: that of the machine, 1 or 25.4.
///
/// # Errors
///
/// Every line that is none, with its place.
///
/// # Example
///
/// ```
/// use trunnion_nc::read::tool_rows;
///
/// let rows = tool_rows("T1 P1 D0.5 Z+2 ;end mill\n", 25.4)?;
/// assert_eq!((rows[0].number, rows[0].offset[2], rows[0].diameter), (1, 50.8, 12.7));
/// # Ok::<(), trunnion_types::types::Diagnostics>(())
/// ```
pub fn tool_rows(text: &str, unit: f64) -> Result<Vec<ToolRow>, Diagnostics> {
    let mut rows = Vec::new();
    let mut faults = Vec::new();
    for (line, text) in (1_u32..).zip(text.lines()) {
        let words = text.split(';').next().unwrap_or_default();
        if words.trim().is_empty() {
            continue;
        }
        match tool_row(words, unit) {
            Ok(row) => rows.push(row),
            Err(message) => faults.push(Diagnostic {
                line,
                column: 1,
                message,
                help: "lines of a tool table are T1 P1 Z20.5 D6".to_owned(),
            }),
        }
    }
    if faults.is_empty() { Ok(rows) } else { Err(Diagnostics::from(faults)) }
}

/// Reads a line of a tool table without its comment.
fn tool_row(words: &str, unit: f64) -> Result<ToolRow, String> {
    let mut number = None;
    let mut row = ToolRow { number: 0, offset: [0.0; 3], diameter: 0.0, corner: 0 };
    // Words may stand without blanks between them, as everywhere in RS274/NGC.
    let mut rest = words.trim();
    while let Some(letter) = rest.chars().next() {
        let behind = rest.get(letter.len_utf8()..).unwrap_or_default();
        let end = behind.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(behind.len());
        let text = behind.get(..end).unwrap_or_default().trim();
        let value: f64 =
            text.parse().map_err(|_| format!("{letter}{text} is no word of a tool table"))?;
        if !value.is_finite() {
            return Err(format!("{letter}{text} is not finite"));
        }
        let length = unit * value;
        if matches!(letter.to_ascii_uppercase(), 'X' | 'Y' | 'Z' | 'D') && length.abs() > LONGEST {
            return Err(format!("{letter}{text} is beyond {LONGEST} mm"));
        }
        match letter.to_ascii_uppercase() {
            'T' => number = Some(count(value).ok_or_else(|| format!("T{text} is no tool"))?),
            'Q' => {
                row.corner = count(value)
                    .filter(|q| *q < 10)
                    .ok_or_else(|| format!("Q{text} is no corner"))?;
            }
            'X' => row.offset[0] = length,
            'Y' => row.offset[1] = length,
            'Z' => row.offset[2] = length,
            'D' => row.diameter = length,
            // Pocket, offsets of further axes, angles of the tool: no word of a program counts from them.
            'P' | 'A' | 'B' | 'C' | 'U' | 'V' | 'W' | 'I' | 'J' => {}
            _ => return Err(format!("{letter} is no word of a tool table")),
        }
        rest = behind.get(end..).unwrap_or_default();
    }
    row.number = number.ok_or("a tool without its number T")?;
    Ok(row)
}

fn count(value: f64) -> Option<u32> {
    let whole = value >= 0.0 && value <= f64::from(u32::MAX) && value.fract().abs() <= 0.0;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    whole.then_some(value as u32)
}

/// Tools by their numbers.
#[derive(Debug, Default)]
pub(super) struct ToolTable {
    rows: BTreeMap<u32, KnownTool>,
}

/// A tool of the table.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnownTool {
    /// Length as given, which is that of the tool on the machine \[mm\].
    pub(super) length: f64,
    /// Offsets along X Y Z as they are now \[mm\].
    pub(super) offset: [f64; 3],
    /// \[mm\]
    pub(super) diameter: f64,
    /// Corner of a turning tool that its offsets are of, 1 to 8; 0 and 9 are its middle.
    pub(super) corner: u32,
}

impl ToolTable {
    /// Enters the row of an empty spindle, unless the table has a tool 0.
    pub(super) fn empty_spindle(&mut self) {
        let none = KnownTool { length: 0.0, offset: [0.0; 3], diameter: 0.0, corner: 0 };
        self.rows.entry(0).or_insert(none);
    }

    pub(super) fn new(rows: &[ToolRow]) -> Self {
        let known = |row: &ToolRow| {
            let ToolRow { number, offset, diameter, corner } = *row;
            (number, KnownTool { length: offset[2], offset, diameter, corner })
        };
        Self { rows: rows.iter().map(known).collect() }
    }

    pub(super) fn get(&self, number: u32) -> Option<KnownTool> {
        self.rows.get(&number).copied()
    }

    /// Returns a row to change it.
    pub(super) fn row(&mut self, number: u32) -> Option<&mut KnownTool> {
        self.rows.get_mut(&number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_as_linuxcnc_writes_them() {
        let text = "T1 P1 D0.125 Z+0.511 ;1/8 end mill\n\n; comment\nt20p3x-1.5 z2Q2 I95 J155\n";
        let rows = tool_rows(text, 25.4).unwrap();
        assert_eq!(rows.len(), 2);
        assert!(
            (rows[0].offset[2] - 12.9794).abs() < 1e-12 && (rows[0].diameter - 3.175).abs() < 1e-12
        );
        assert_eq!((rows[1].number, rows[1].corner), (20, 2));
        assert!((rows[1].offset[0] + 38.1).abs() < 1e-12);
        for (text, part) in
            [("P1 Z3", "without its number"), ("T1 Zx", "no word"), ("T1.5", "no tool")]
        {
            let faults = tool_rows(text, 1.0).unwrap_err();
            assert!(faults[0].message.contains(part), "{text}: {}", faults[0]);
        }
    }
}
