//! Tools of the control's own table, beside those that a program is read with.

use trunnion::nc::read::ToolRow;

/// Difference up to which two lengths of a tool are the same \[mm\]: tables have three or four decimals.
const SAME: f64 = 5e-4;

/// Tool that the command line or the job describes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DescribedTool {
    /// Number under which the program calls it.
    pub(crate) number: u32,
    /// Length from the gauge point to the tip \[mm\].
    pub(crate) length: f64,
    /// Diameter of the cutting part \[mm\], where the tool has a shape.
    pub(crate) diameter: Option<f64>,
}

impl DescribedTool {
    /// Returns the row of the table that has another length or diameter under the number of this tool.
    pub(crate) fn other_row<'a>(&self, table: &'a [ToolRow]) -> Option<&'a ToolRow> {
        let row = table.iter().rev().find(|row| row.number == self.number)?;
        // A table without a value leaves it open.
        let differs = |of: f64, taken: f64| of.abs() > 0.0 && (of.abs() - taken).abs() > SAME;
        let is_wider = self.diameter.is_some_and(|taken| differs(row.diameter, taken));
        (differs(row.offset[2], self.length) || is_wider).then_some(row)
    }

    /// States the difference from the table, if there is one, and the options that settle it.
    pub(crate) fn contradiction(&self, table: &[ToolRow], option: &str) -> Option<String> {
        let Self { number, length: taken, diameter } = *self;
        let row = self.other_row(table)?;
        let length = row.offset[2].abs();
        let [has, with] = match diameter {
            None => [String::new(), String::new()],
            Some(own) => {
                [format!(" and diameter {} mm", row.diameter), format!(" and diameter {own} mm")]
            }
        };
        Some(format!(
            "tool {number} of the tool table has length {length} mm{has}, but the program is read with length {taken} \
             mm{with}; give the tool that is in the machine ({option} {number}={length}), or mend the table"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion::nc::read::tool_rows;

    #[test]
    fn a_row_without_a_value_contradicts_nothing() {
        let table = tool_rows("T1 P1 Z130 D6\nT2 P2 D6\nT3 P3 Z-100\n", 1.0).unwrap();
        let tool = |number, length| DescribedTool { number, length, diameter: None };
        assert!(tool(1, 100.0).other_row(&table).is_some());
        assert!(tool(1, 130.0004).other_row(&table).is_none());
        assert!(tool(2, 100.0).other_row(&table).is_none());
        // Some tables count lengths downwards.
        assert!(tool(3, 100.0).other_row(&table).is_none());
        assert!(tool(4, 100.0).other_row(&table).is_none());
        let wide = DescribedTool { diameter: Some(10.0), ..tool(1, 130.0) };
        assert!(wide.other_row(&table).is_some());
    }
}
