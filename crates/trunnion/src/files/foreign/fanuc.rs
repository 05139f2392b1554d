//! Fanuc parameters 19680 to 19714 as punched out: `N19680 P12`, axes as `N01320 A1 P500.0 A2 P400.0`.

use super::draft::{AxisDraft, MachineDraft, tip_format};
use super::source_values::SourceValues;
use crate::machine::{AxisInterpolation, AxisKind, MovedBody};
use crate::math;
use crate::types::Diagnostic;

pub(super) fn read(text: &str, values: &mut SourceValues) -> Option<MachineDraft> {
    for (line, row) in (1_u64..).zip(text.lines()) {
        punched(row, line, values);
    }
    let inch = values.number("1001", "units").is_some_and(|bits| bits % 10.0 > 0.0);
    let unit = if inch { 25.4 } else { 1.0 };
    let kind = values.needed("19680", "chain")?;
    let table_first = [19700, 19701, 19702];
    let mut draft =
        MachineDraft::new("fanuc", tip_format("fanuc-30i", AxisInterpolation::RotaryLinear));
    tool(&mut draft, values);
    hypothetical(values);
    let mut point = |numbers: [u32; 3], target: &str| {
        let found = values.vector(&numbers.map(|number| number.to_string()), target)?;
        Some(found.map(|part| part * unit))
    };
    let target = "axis.point";
    let holder = [0.0; 3];
    let (points, heads) = match kind {
        2.0 => {
            let slave = sum(holder, point([19709, 19710, 19711], target)?);
            ([sum(slave, point([19712, 19713, 19714], target)?), slave], [MovedBody::Tool; 2])
        }
        12.0 => {
            let master = point(table_first, target)?;
            ([master, sum(master, point([19703, 19704, 19705], target)?)], [MovedBody::Part; 2])
        }
        21.0 => (
            [point([19709, 19710, 19711], target)?, point(table_first, target)?],
            [MovedBody::Tool, MovedBody::Part],
        ),
        other => {
            let message = format!("parameter 19680 = {other}: no machine with two rotary axes");
            values.fault("19680", message, "2 (head), 12 (table) and 21 (head and table) are read");
            return None;
        }
    };
    let first = rotary(values, [19681, 19682, 19684], heads[0], points[0])?;
    let second = rotary(values, [19686, 19687, 19689], heads[1], points[1])?;
    let (one, two) = (first.name.clone(), second.name.clone());
    // The master is nearest to the bed.
    match kind {
        2.0 => draft.set_chain(&["w", "b", "X", "Y", "Z", &one, &two, "t"]),
        12.0 => draft.set_chain(&["w", &two, &one, "b", "X", "Y", "Z", "t"]),
        _ => draft.set_chain(&["w", &two, "b", "X", "Y", "Z", &one, "t"]),
    }
    let numbers = ["19681", "19686"].map(|key| values.find(key).map(|found| found.value.clone()));
    draft.axes.extend([first, second]);
    for (index, axis) in draft.axes.iter_mut().enumerate() {
        let number = match index {
            0..=2 => Some((index + 1).to_string()),
            _ => numbers.get(index - 3).cloned().flatten(),
        };
        limits(axis, &number.unwrap_or_default(), unit, values);
    }
    Some(draft)
}

/// Splits a punched line: `N19680 P12` has the key 19680, `N01320 A1 P5. A2 P6.` the keys 1320A1 and 1320A2.
fn punched(row: &str, line: u64, values: &mut SourceValues) {
    let row = row.split('(').next().unwrap_or_default();
    let mut words: Vec<String> = Vec::new();
    for c in row.chars().filter(|c| !c.is_whitespace()) {
        if c.is_ascii_alphabetic() {
            words.push(c.to_string());
        } else if let Some(word) = words.last_mut() {
            word.push(c);
        }
    }
    let Some(number) = words.first().and_then(|word| word.strip_prefix('N')) else { return };
    let number = number.trim_start_matches('0').to_owned();
    let mut part = String::new();
    for word in words.iter().skip(1) {
        match word.split_at(1) {
            ("A", axis) => part = format!("A{axis}"),
            ("P", value) => values.add(&format!("{number}{part}"), value, line),
            // They select what the file has once.
            ("Q" | "L" | "S" | "T", _) => {}
            _ => {
                let message = format!("{word} is no word of a parameter");
                let help = "a line is N with a number, A with an axis, P with a value";
                values.faults.push(Diagnostic::whole(message).with_help(help).on_line(line));
            }
        }
    }
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|part| {
        a.get(part).copied().unwrap_or(0.0) + b.get(part).copied().unwrap_or(0.0)
    })
}

/// Sets the tool axis: parameter 19697 names the coordinate that it points along.
fn tool(draft: &mut MachineDraft, values: &mut SourceValues) {
    match values.needed("19697", "tool_axis") {
        Some(1.0) => draft.tool_axis = [1.0, 0.0, 0.0],
        Some(2.0) => draft.tool_axis = [0.0, 1.0, 0.0],
        Some(3.0) | None => {}
        Some(other) => {
            let message = format!("parameter 19697 = {other} names no direction of the tool");
            values.fault("19697", message, "1 is X, 2 is Y, 3 is Z");
        }
    }
    for key in ["19698", "19699"] {
        if let Some(angle) = values.number(key, "must be 0").filter(|angle| angle.abs() > 0.0) {
            let message =
                format!("parameter {key} = {angle}: the tool is tilted at the zero of the axes");
            values.fault(key, message, "leave the parameter out, and give tool_axis");
        }
    }
}

/// Refuses imaginary axes.
fn hypothetical(values: &mut SourceValues) {
    let Some(bits) = values.number("19696", "hypothetical axes") else { return };
    // Bits are punched as digits: the last two are those of the axes.
    if bits % 100.0 > 0.0 {
        let message = format!("parameter 19696 = {bits:08}: a rotary axis is hypothetical");
        values.fault("19696", message, "machines with two real rotary axes are read");
    }
}

/// Reads a rotary axis by the parameters of its number, direction and sense.
fn rotary(
    values: &mut SourceValues,
    numbers: [u32; 3],
    body: MovedBody,
    point: [f64; 3],
) -> Option<AxisDraft> {
    let [number, direction, sense] = numbers.map(|number| number.to_string());
    let controlled = values.needed(&number, "axis names")?;
    let along = values.needed(&direction, "axis.dir")?;
    let tilt = (numbers[1] + 1).to_string();
    // A direction that is not tilted has no angle.
    let inclination = if along > 3.0 { values.needed(&tilt, "axis.dir")? } else { 0.0 };
    let Some((dir, letter)) = direction_of(along, inclination) else {
        let message = format!("parameter {direction} = {along} names no direction");
        values.fault(&direction, message, "1 to 3 are X, Y and Z, 4 to 6 are tilted from these");
        return None;
    };
    // 0 turns the body right-handed about the direction; a table that does turns the tool the other way.
    let left = values.needed(&sense, "axis.sense")? > 0.0;
    let name = axis_name(values, controlled).unwrap_or_else(|| letter.to_owned());
    let mut axis = AxisDraft::rotary(&name, dir, Some(point));
    axis.sense = if left == (body == MovedBody::Tool) { -1.0 } else { 1.0 };
    Some(axis)
}

/// Returns a direction, and the letter of an axis that turns about it.
fn direction_of(number: f64, degrees: f64) -> Option<([f64; 3], &'static str)> {
    let (sin, cos) = math::sin_cos(degrees.to_radians());
    match number {
        1.0 => Some(([1.0, 0.0, 0.0], "A")),
        2.0 => Some(([0.0, 1.0, 0.0], "B")),
        3.0 => Some(([0.0, 0.0, 1.0], "C")),
        4.0 => Some(([cos, sin, 0.0], "A")),
        5.0 => Some(([0.0, cos, sin], "B")),
        6.0 => Some(([sin, 0.0, cos], "C")),
        _ => None,
    }
}

/// Returns the name of a controlled axis: parameter 1020 has the code of its letter.
fn axis_name(values: &mut SourceValues, controlled: f64) -> Option<String> {
    let code = values.number(&format!("1020A{controlled}"), "axis names")?;
    ('A'..='Z').find(|letter| (f64::from(u32::from(*letter)) - code).abs() < 0.5).map(String::from)
}

fn limits(axis: &mut AxisDraft, number: &str, unit: f64, values: &mut SourceValues) {
    let scale = if axis.kind == AxisKind::Linear { unit } else { 1.0 };
    let name = axis.name.clone();
    let mut get = |parameter: u32, field: &str| {
        let found =
            values.number(&format!("{parameter}A{number}"), &format!("axis.{name}.{field}"));
        found.map(|value| value * scale)
    };
    if let (Some(high), Some(low)) = (get(1320, "limits"), get(1321, "limits")) {
        axis.limits = Some([low, high]);
    }
    axis.rates = [get(1430, "vel").map(|velocity| velocity / 60.0), get(1660, "acc"), None];
}
