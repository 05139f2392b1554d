//! Haas settings: machine rotary zero point, as a list of numbers, names and values.

use super::draft::{AxisDraft, MachineDraft, tip_format};
use super::source_values::SourceValues;
use crate::machine::AxisInterpolation;

const SIGNS: &str = "The settings state neither the sense of rotation nor which axis carries which; B tilts and C turns are the \
axes of this maker's trunnions. Compare the motions that `machine show` lists with the machine.";

pub(super) fn read(text: &str, values: &mut SourceValues) -> Option<MachineDraft> {
    for (line, row) in (1_u64..).zip(text.lines()) {
        setting(row, line, values);
    }
    let unit = units(values)?;
    let mut draft =
        MachineDraft::new("haas", tip_format("haas-ngc", AxisInterpolation::RotaryLinear));
    draft.notes.push(SIGNS.to_owned());
    // Settings 300 to 305 hold master and slave apart; 255 to 257 are where both lines meet.
    let apart = values.find("300").is_some();
    let [tilting, turning] = if apart {
        [point(values, 300, unit, "axis.B.point")?, point(values, 303, unit, "axis.C.point")?]
    } else {
        [point(values, 255, unit, "axis.B.point, axis.C.point")?; 2]
    };
    draft.axes.push(AxisDraft::rotary("B", [0.0, 1.0, 0.0], Some(tilting)));
    draft.axes.push(AxisDraft::rotary("C", [0.0, 0.0, 1.0], Some(turning)));
    Some(draft)
}

/// Splits a line into the number of the setting and the last word: `255 MRZP X OFFSET -381.000`, or with commas.
fn setting(row: &str, line: u64, values: &mut SourceValues) {
    let words: Vec<&str> = row
        .split([',', ';', '\t', ' '])
        .filter(|word| !word.is_empty() && *word != "MM" && *word != "IN")
        .collect();
    let (Some(first), Some(last)) = (words.first(), words.last()) else { return };
    let number = first.trim_start_matches(['S', 's', '#']);
    if words.len() > 1 && number.parse::<u32>().is_ok() {
        // The unit of setting 9 is its value.
        let value =
            if number == "9" { row.split([',', ' ']).next_back().unwrap_or(last) } else { last };
        values.add(number, value, line);
    }
}

/// Returns the factor to mm: setting 9 states the unit, and lengths of two units look alike.
fn units(values: &mut SourceValues) -> Option<f64> {
    match values.text("9", "units").map(|value| value.to_ascii_uppercase()).as_deref() {
        Some("MM" | "METRIC") => Some(1.0),
        Some("INCH" | "IN") => Some(25.4),
        Some(other) => {
            let message = format!("setting 9 = {other} is no unit");
            values.fault("9", message, "write 9 DIMENSIONING MM, or INCH");
            None
        }
        None => {
            values.missing("9", "the unit of all lengths");
            None
        }
    }
}

fn point(values: &mut SourceValues, first: u32, unit: f64, target: &str) -> Option<[f64; 3]> {
    let keys = [0, 1, 2].map(|part| (first + part).to_string());
    Some(values.vector(&keys, target)?.map(|part| part * unit))
}
