//! Siemens machine data: TRAORI with transformation types 24, 40 and 56.
//!
//! Vectors are those of the swivel data record, whose relation to the machine data the commissioning manual tabulates
//! (`docs/sources.md`, machine descriptions): each points from one reference to the next, and the chain closes. They hold where
//! the rotary axes stand at their offsets (`neutral`), and are carried from there to all axes at zero.

use super::draft::{AxisDraft, MachineDraft, tip_format};
use super::neutral::carry_to_zero;
use super::source_values::SourceValues;
use crate::machine::{AxisInterpolation, AxisKind};

/// Note about the sign of the offsets.
const SIGNS: &str = "The manuals leave open whether every control counts the offset vectors in the direction of its swivel data \
record, and the senses of rotation: jog and compare (`machine show`), or measure (`machine calibrate`).";

pub(super) fn read(text: &str, values: &mut SourceValues) -> Option<MachineDraft> {
    for (line, row) in (1_u64..).zip(text.lines()) {
        let row = row.split(';').next().unwrap_or_default().trim();
        // A block number may stand in front: N24100 $MC_...
        let Some((_, row)) = row.split_once('$') else { continue };
        if let Some((key, value)) = row.split_once('=') {
            values.add(&format!("${}", key.trim()), value, line);
        }
    }
    let kind = values.needed("$MC_TRAFO_TYPE_1", "chain")?;
    let mut draft =
        MachineDraft::new("siemens", tip_format("siemens-840d", AxisInterpolation::GreatCircle));
    draft.notes.push(SIGNS.to_owned());
    let [first, second] = rotary_names(values)?;
    let [v1, v2] = ["AXIS1", "AXIS2"].map(|name| data(values, name, "axis.dir"));
    // The vector is that of the moving body: a table turns against the count of ISO 841.
    let head = |v: [f64; 3]| v;
    let table = |v: [f64; 3]| v.map(|part| 0.0 - part);
    let (points, dirs, chain): ([[f64; 3]; 2], [[f64; 3]; 2], [&str; 8]) = match kind {
        24.0 => {
            let [to_second, to_flange] =
                [data(values, "JOINT_OFFSET", "points")?, data(values, "BASE_TOOL", "points")?];
            let second_point = to_flange.map(|part| 0.0 - part);
            let first_point = sum(second_point, to_second.map(|part| 0.0 - part));
            (
                [first_point, second_point],
                [head(v1?), head(v2?)],
                ["w", "b", "X", "Y", "Z", "1", "2", "t"],
            )
        }
        40.0 => {
            let [to_first, to_second] =
                [data(values, "BASE_TOOL", "points")?, data(values, "JOINT_OFFSET", "points")?];
            (
                [to_first, sum(to_first, to_second)],
                [table(v1?), table(v2?)],
                ["w", "2", "1", "b", "X", "Y", "Z", "t"],
            )
        }
        56.0 => {
            let [to_flange, to_table] = [
                data(values, "BASE_TOOL", "points")?,
                data(values, "JOINT_OFFSET_PART", "points")?,
            ];
            let head_point = to_flange.map(|part| 0.0 - part);
            (
                [head_point, to_table],
                [head(v1?), table(v2?)],
                ["w", "2", "b", "X", "Y", "Z", "1", "t"],
            )
        }
        other => {
            let message =
                format!("$MC_TRAFO_TYPE_1 = {other}: this type of transformation is not read");
            values.fault(
                "$MC_TRAFO_TYPE_1",
                message,
                "24 (head), 40 (table) and 56 (head and table) are read",
            );
            return None;
        }
    };
    for ((name, point), dir) in [&first, &second].into_iter().zip(points).zip(dirs) {
        draft.axes.push(AxisDraft::rotary(name, dir, Some(point)));
    }
    let named = chain.map(|word| match word {
        "1" => first.as_str(),
        "2" => second.as_str(),
        other => other,
    });
    draft.set_chain(&named);
    closed(values, kind);
    offsets(&mut draft, values, &[first, second]);
    limits(&mut draft, values);
    Some(draft)
}

fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|part| {
        a.get(part).copied().unwrap_or(0.0) + b.get(part).copied().unwrap_or(0.0)
    })
}

fn key(name: &str, index: usize) -> String {
    format!("$MC_TRAFO5_{name}_1[{index}]")
}

fn data(values: &mut SourceValues, name: &str, target: &str) -> Option<[f64; 3]> {
    values.vector(&[0, 1, 2].map(|index| key(name, index)), target)
}

/// Returns the names of the two rotary axes of the transformation.
fn rotary_names(values: &mut SourceValues) -> Option<[String; 2]> {
    let names = [3, 4].map(|index| {
        let number = values.needed(&format!("$MC_TRAFO_AXES_IN_1[{index}]"), "chain")?;
        // Channel axes are counted from 1, the table of their names from 0.
        let entry = format!("$MC_AXCONF_CHANAX_NAME_TAB[{}]", number - 1.0);
        let name = values.text(&entry, "chain");
        if name.is_none() {
            values.missing(&entry, "the name of a rotary axis");
        }
        name
    });
    match names {
        [Some(first), Some(second)] => Some([first, second]),
        _ => None,
    }
}

/// Reports a chain of vectors that does not close: the parts of a machine that is fixed must.
fn closed(values: &mut SourceValues, kind: f64) {
    // Resolution of machine data.
    const CLOSED: f64 = 1e-3;
    if kind < 56.0 {
        let parts = ["PART_OFFSET", "BASE_TOOL", "JOINT_OFFSET"];
        for index in 0..3 {
            let keys = parts.map(|name| key(name, index));
            if keys.iter().any(|key| values.find(key).is_none()) {
                return;
            }
            let numbers = keys
                .each_ref()
                .map(|key| values.number(key, "closure of the vectors").unwrap_or_default());
            let open: f64 = numbers.iter().sum();
            if open.abs() > CLOSED {
                let [part, base, joint] = numbers;
                let message = format!(
                    "the offsets contradict each other in coordinate {index}: {part} is not the negative sum of {base} and {joint} (off by {open:.4} mm)"
                );
                values.fault(&key("PART_OFFSET", index), message, "correct the vector that is wrong, or leave PART_OFFSET out if the machine is not fixed");
            }
        }
    }
}

/// Note about the sign of the angles.
const ANGLES: &str = "The angle offsets are read as the positions of the axes at which the vectors hold; the manuals leave open whether \
every control counts them so: bring the axes there, and compare the direction of tool and table.";

/// Reads the senses of the rotary axes, and the positions at which their vectors hold.
fn offsets(draft: &mut MachineDraft, values: &mut SourceValues, names: &[String; 2]) {
    let mut angles = [0.0; 2];
    for (index, (name, angle)) in names.iter().zip(&mut angles).enumerate() {
        let sign = format!("$MC_TRAFO5_ROT_SIGN_IS_PLUS_1[{index}]");
        let target = format!("axis.{name}.sense");
        let against = values.number(&sign, &target).is_some_and(|plus| plus < 1.0);
        let offset = key("ROT_AX_OFFSET", index);
        *angle = values.number(&offset, "position at which the vectors hold").unwrap_or(0.0);
        if against && angle.abs() > 0.0 {
            let message = format!(
                "{offset} = {angle} deg and {sign} = 0: no manual states if the offset of an axis that counts the other way is turned too"
            );
            let help = format!("turn the vector of {name} round, and write {sign} = 1");
            values.fault(&offset, message, &help);
        }
        for axis in draft.axes.iter_mut().filter(|axis| against && axis.name == *name) {
            axis.sense = -1.0;
        }
    }
    if angles.iter().any(|angle| angle.abs() > 0.0) {
        draft.notes.push(ANGLES.to_owned());
        carry_to_zero(draft, names, angles);
    }
}

/// Reads travel and rates of axis machine data, which are named by machine axes such as `X1` or `AX1`.
fn limits(draft: &mut MachineDraft, values: &mut SourceValues) {
    // Velocities are per minute, accelerations in m or revolutions.
    for axis in &mut draft.axes {
        let rotary = axis.kind == AxisKind::Rotary;
        let machine_axis = format!("{}1", axis.name);
        let name = axis.name.clone();
        let mut get = |data: &str, target: &str| {
            let target = format!("axis.{name}.{target}");
            values
                .number(&format!("$MA_{data}[{machine_axis}]"), &target)
                .or_else(|| values.number(&format!("$MA_{data}[{name}]"), &target))
        };
        if let (Some(low), Some(high)) =
            (get("POS_LIMIT_MINUS", "limits"), get("POS_LIMIT_PLUS", "limits"))
        {
            axis.limits = Some([low, high]);
        }
        axis.endless = get("ROT_IS_MODULO", "cyclic").is_some_and(|modulo| modulo > 0.0);
        let (per_minute, large) = if rotary { (360.0 / 60.0, 360.0) } else { (1.0 / 60.0, 1000.0) };
        axis.rates = [
            get("MAX_AX_VELO", "vel").map(|velocity| velocity * per_minute),
            get("MAX_AX_ACCEL", "acc").map(|acceleration| acceleration * large),
            get("MAX_AX_JERK", "jerk").map(|jerk| jerk * large),
        ];
    }
}
