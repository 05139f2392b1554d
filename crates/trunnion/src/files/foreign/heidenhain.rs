//! Heidenhain kinematics table, as exported: from the tool reference point over the machine base to the workpiece.

use super::draft::{AxisDraft, MachineDraft, tip_format};
use super::source_value::SourceValue;
use super::source_values::SourceValues;
use super::value_origin::ValueOrigin;
use crate::machine::{AxisInterpolation, AxisKind};
use crate::types::Diagnostic;
use nalgebra::{Rotation3, Vector3};

const SIGNS: &str = "The table does not state the sense of rotation, which is a machine parameter: compare the motions that \
`machine show` lists with the machine.";

/// One row of the table.
struct TableRow {
    line: u64,
    key: String,
    axis: String,
    coordinate: Option<String>,
}

/// Place of the table: the frame that the rows up to here lead to, machine frame.
struct TablePlace {
    rotation: Rotation3<f64>,
    point: Vector3<f64>,
}

pub(super) fn read(text: &str, values: &mut SourceValues) -> Option<MachineDraft> {
    let rows = rows(text, values)?;
    let mut draft = MachineDraft::new(
        "heidenhain",
        tip_format("heidenhain-klartext", AxisInterpolation::GreatCircle),
    );
    draft.axes.clear();
    draft.notes.push(SIGNS.to_owned());
    let mut place = TablePlace { rotation: Rotation3::identity(), point: Vector3::zeros() };
    // The chain of a machine file begins at the workpiece: words are gathered from the tool, and turned round.
    let mut words = vec!["t".to_owned()];
    for row in &rows {
        match row.key.to_ascii_uppercase().as_str() {
            "TRANS" => place.advance(row, values),
            "MACHBASE" => words.push("b".to_owned()),
            "MACHAXIS" => {
                words.push(row.axis.clone());
                if let Some(axis) = place.axis(row, values) {
                    draft.axes.push(axis);
                }
            }
            "TOOLAXIS" => {
                if let Some(unit) = coordinate(&row.axis) {
                    draft.tool_axis = unit.into();
                }
            }
            // Bodies and other files do not move the chain.
            _ => {}
        }
    }
    if !words.iter().any(|word| word == "b") {
        let help =
            "enter MachBase between the axes that move the tool and those that move the workpiece";
        values.faults.push(Diagnostic::whole("the table has no row MachBase").with_help(help));
    }
    words.push("w".to_owned());
    words.reverse();
    draft.chain = Some(words);
    Some(draft)
}

impl TablePlace {
    /// Goes on by a row `Trans`: a shift along X, Y, Z or a turn about them by A, B, C in degrees.
    fn advance(&mut self, row: &TableRow, values: &mut SourceValues) {
        let value = row.coordinate.as_deref().and_then(|word| word.parse::<f64>().ok());
        let (Some(value), Some(unit)) =
            (value.filter(|value| value.is_finite()), coordinate(&row.axis))
        else {
            let word = row.coordinate.as_deref().unwrap_or_default();
            let message = format!("Trans {} {word:?} is no shift and no turn", row.axis);
            let help = "write an axis X, Y, Z, A, B or C, and a number under COORD";
            values.faults.push(Diagnostic::whole(message).with_help(help).on_line(row.line));
            return;
        };
        if matches!(row.axis.as_str(), "A" | "B" | "C") {
            self.rotation *= Rotation3::new(unit * value.to_radians());
        } else {
            self.point += self.rotation * unit * value;
        }
        let from = SourceValue {
            key: format!("Trans {}", row.axis),
            value: value.to_string(),
            line: row.line,
        };
        values.origins.push(ValueOrigin::new(&from, "points and directions behind it"));
    }

    fn axis(&self, row: &TableRow, values: &mut SourceValues) -> Option<AxisDraft> {
        let Some(unit) = coordinate(&row.axis) else {
            let message = format!("MachAxis {:?} is no axis that is read", row.axis);
            values.faults.push(
                Diagnostic::whole(message)
                    .with_help("X, Y, Z, A, B and C are read")
                    .on_line(row.line),
            );
            return None;
        };
        let dir = Vector3::from(self.rotation * unit).into();
        let from = SourceValue { key: "MachAxis".into(), value: row.axis.clone(), line: row.line };
        values.origins.push(ValueOrigin::new(&from, "chain"));
        Some(if matches!(row.axis.as_str(), "A" | "B" | "C") {
            AxisDraft::rotary(&row.axis, dir, Some(self.point.into()))
        } else {
            AxisDraft { dir: Some(dir), ..AxisDraft::new(&row.axis, AxisKind::Linear) }
        })
    }
}

fn coordinate(axis: &str) -> Option<Vector3<f64>> {
    match axis {
        "X" | "A" => Some(Vector3::x()),
        "Y" | "B" => Some(Vector3::y()),
        "Z" | "C" => Some(Vector3::z()),
        _ => None,
    }
}

/// Splits the table by the places of its column names, as it is exported in columns of fixed width.
fn rows(text: &str, values: &mut SourceValues) -> Option<Vec<TableRow>> {
    let mut lines = (1_u64..).zip(text.lines());
    let header = lines.by_ref().find(|(_, line)| line.contains("KEY") && line.contains("COORD"));
    let Some((_, header)) = header else {
        values.faults.push(
            Diagnostic::whole("the table has no header with KEY, AXIS and COORD")
                .with_help("export the description table, not the assignment table"),
        );
        return None;
    };
    let names: Vec<&str> = header.split_whitespace().collect();
    let starts: Vec<(&str, usize)> =
        names.iter().filter_map(|&name| Some((name, header.find(name)?))).collect();
    let field = |line: &str, wanted: &str| -> String {
        let at = starts.iter().position(|(name, _)| *name == wanted);
        let start = at.and_then(|at| starts.get(at)).map_or(0, |(_, start)| *start);
        let end = at.and_then(|at| starts.get(at + 1)).map_or(line.len(), |(_, end)| *end);
        line.get(start..end.min(line.len())).unwrap_or_default().trim().to_owned()
    };
    let mut rows = Vec::new();
    for (line, row) in lines {
        if row.trim_start().starts_with("[END]") {
            break;
        }
        let key = field(row, "KEY");
        if key.is_empty() {
            continue;
        }
        let coordinate = Some(field(row, "COORD")).filter(|word| !word.is_empty());
        rows.push(TableRow { line, key, axis: field(row, "AXIS"), coordinate });
    }
    Some(rows)
}
