//! `LinuxCNC`: INI file with HAL lines, kinematics `xyzac-trt-kins`, `xyzbc-trt-kins`, `xyzab_tdr_kins`, `5axiskins` and
//! `trunnionkins`.

use super::super::machine::parse;
use super::draft::{AxisDraft, MachineDraft};
use super::hal_pins::{HalPins, PinLength};
use super::source_values::SourceValues;
use crate::machine::{AxisKind, MachineSpec, ProgramFormat};
use crate::types::Diagnostic;
use std::collections::BTreeMap;

/// Files that the INI file names, by the name in it.
type Companions<'a> = BTreeMap<&'a str, &'a str>;

pub(super) fn read(
    text: &str,
    companions: &Companions<'_>,
    values: &mut SourceValues,
) -> Option<MachineDraft> {
    let mut hal = HalPins::default();
    sections(text, values, &mut hal);
    for file in values.beginning("HAL.HALFILE") {
        match companions.get(file.value.as_str()) {
            Some(text) => hal.read(&file.value, text),
            None if file.value.starts_with("LIB:") => {}
            None => {
                let message = format!("HAL file {} is not beside the INI file", file.value);
                let help = "it may set the offsets of the kinematics: put it there";
                values.faults.push(Diagnostic::whole(message).with_help(help).on_line(file.line));
            }
        }
    }
    let kinematics = values.text("KINS.KINEMATICS", "chain")?;
    let words: Vec<&str> = kinematics.split_whitespace().collect();
    let option =
        |name: &str| words.iter().find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
    let module = words.first().copied().unwrap_or_default();
    let unit = unit(values);
    let mut draft = match module {
        "trunnionkins" => trunnionkins(option("machine"), companions, values)?,
        "xyzac-trt-kins" | "xyzbc-trt-kins" => rotary_tables(module, &hal, unit, values),
        "xyzab_tdr_kins" => dual_rotary_table(&hal, unit, values),
        "5axiskins" => bridge_mill(&hal, unit, values),
        other => {
            let message = format!("KINEMATICS = {other}: this module is not read");
            values.fault(
                "KINS.KINEMATICS",
                message,
                "xyzac-trt-kins, xyzbc-trt-kins, xyzab_tdr_kins, 5axiskins and trunnionkins are read",
            );
            return None;
        }
    };
    if let Some(name) = values.text("EMC.MACHINE", "name") {
        draft.name = name;
    }
    draft.servo_period = values
        .number("EMCMOT.SERVO_PERIOD", "cycle.servo_period")
        .map(|nanoseconds| nanoseconds * 1e-9);
    let letters = option("coordinates")
        .map(str::to_owned)
        .or_else(|| values.text("TRAJ.COORDINATES", "joints"));
    limits(&mut draft, &letters.unwrap_or_default(), unit, values);
    Some(draft)
}

/// Returns the length of a unit of the configuration \[mm\].
fn unit(values: &mut SourceValues) -> f64 {
    const LINEAR: &str = "TRAJ.LINEAR_UNITS";
    const ANGULAR: &str = "TRAJ.ANGULAR_UNITS";
    if let Some(angular) = values.text(ANGULAR, "units")
        && !matches!(angular.as_str(), "deg" | "degree")
    {
        let message = format!("ANGULAR_UNITS = {angular}: only degrees are read");
        values.fault(ANGULAR, message, "convert the limits and rates of the rotary axes to degree");
    }
    match values.text(LINEAR, "units").as_deref() {
        Some("mm" | "metric") => 1.0,
        Some("in" | "inch" | "imperial") => 25.4,
        Some(other) => {
            let message = format!("LINEAR_UNITS = {other} is no unit that is read");
            values.fault(LINEAR, message, "mm and inch are read");
            1.0
        }
        None => {
            values.missing(LINEAR, "the unit of all lengths");
            1.0
        }
    }
}

/// Reads sections and keys as `SECTION.KEY`; HAL commands in the INI file are HAL lines.
fn sections(text: &str, values: &mut SourceValues, hal: &mut HalPins) {
    let mut section = String::new();
    for (line, row) in (1_u64..).zip(text.lines()) {
        let row = row.trim();
        if row.is_empty() || row.starts_with(['#', ';']) {
            continue;
        }
        if let Some(name) = row.strip_prefix('[').and_then(|row| row.split(']').next()) {
            name.trim().clone_into(&mut section);
        } else if let Some((key, value)) = row.split_once('=') {
            let (key, value) = (key.trim(), value.split(" #").next().unwrap_or_default());
            hal.keep(&section, key, value);
            match (section.as_str(), key) {
                ("HAL", "HALCMD") => hal.command(value, line, ""),
                // Several lines of a key are a list.
                ("HAL", "HALFILE") => values.add(&format!("HAL.HALFILE {line}"), value, line),
                ("EMC" | "KINS" | "TRAJ" | "EMCMOT", _) => {
                    values.add(&format!("{section}.{key}"), value, line);
                }
                _ if section.starts_with("JOINT_") || section.starts_with("AXIS_") => {
                    values.add(&format!("{section}.{key}"), value, line);
                }
                _ => {}
            }
        }
    }
}

/// Note about the linear axes.
const CARRIED: &str = "The configuration does not state which linear axes carry the table: all are written behind the bed, which \
moves the tool in place of the table and changes no position.";

/// Lengths of pins, and the reason if one is not stated.
#[derive(Debug, Default)]
struct PinVector {
    sum: [f64; 3],
    unknown: Option<String>,
}

impl PinVector {
    /// Adds the length of a pin along a coordinate.
    fn add(&mut self, coordinate: usize, length: PinLength) {
        match (length, self.sum.get_mut(coordinate)) {
            (PinLength::Known(length), Some(sum)) => *sum += length,
            (PinLength::Driven(why), _) => self.unknown = Some(why),
            (PinLength::Known(_), None) => {}
        }
    }

    /// Writes the point of an axis, if all of it is stated.
    fn become_point(self, axis: &mut AxisDraft, unit: f64) {
        axis.point = self.unknown.is_none().then(|| self.sum.map(|part| part * unit));
        axis.unknown_point = self.unknown;
    }
}

/// Returns the sum of pins of a module, each along a coordinate.
fn pins(
    module: &str,
    along: &[PinAlong],
    target: &str,
    hal: &HalPins,
    values: &mut SourceValues,
) -> PinVector {
    let mut sum = PinVector::default();
    for PinAlong { name, coordinate } in along {
        sum.add(*coordinate, hal.length(&format!("{module}.{name}"), target, 0.0, values));
    }
    sum
}

/// Pin of a length along a coordinate.
#[derive(Debug, Clone, Copy)]
struct PinAlong {
    name: &'static str,
    coordinate: usize,
}

const fn pin(name: &'static str, coordinate: usize) -> PinAlong {
    PinAlong { name, coordinate }
}

/// Pins of the point at which the rotary axes meet without offsets.
const MEETING: [PinAlong; 3] =
    [pin("x-rot-point", 0), pin("y-rot-point", 1), pin("z-rot-point", 2)];

/// Rotary C on a tilting A or B: `tip = r + Rc (o + Rt (joints - r - o))`, all angles against ISO 841 unless
/// `conventional-directions` is set.
fn rotary_tables(
    module: &str,
    hal: &HalPins,
    unit: f64,
    values: &mut SourceValues,
) -> MachineDraft {
    let (tilting, dir, across) = if module.starts_with("xyzac") {
        ("A", [1.0, 0.0, 0.0], pin("y-offset", 1))
    } else {
        ("B", [0.0, 1.0, 0.0], pin("x-offset", 0))
    };
    let [x, y, z] = MEETING;
    let tilting_pins = [x, y, z, across, pin("z-offset", 2)];
    let tilting_point = pins(module, &tilting_pins, &format!("axis.{tilting}.point"), hal, values);
    let turning_point = pins(module, &MEETING, "axis.C.point", hal, values);
    let conventional = format!("{module}.conventional-directions");
    let conventional = hal.length(&conventional, "axis.sense", 0.0, values);
    let mut tilting_axis = AxisDraft::rotary(tilting, dir, None);
    let mut turning_axis = AxisDraft::rotary("C", [0.0, 0.0, 1.0], None);
    tilting_point.become_point(&mut tilting_axis, unit);
    turning_point.become_point(&mut turning_axis, unit);
    let mut draft = MachineDraft::new("linuxcnc", ProgramFormat::linuxcnc());
    let sense = match conventional {
        PinLength::Known(on) if on > 0.0 => 1.0,
        PinLength::Known(_) => -1.0,
        PinLength::Driven(why) => {
            draft.notes.push(format!("{why}: the rotary axes are taken to count against ISO 841, as they do while it is 0"));
            -1.0
        }
    };
    for axis in [tilting_axis, turning_axis] {
        draft.axes.push(AxisDraft { sense, ..axis });
    }
    draft.set_chain(&["w", "C", tilting, "b", "X", "Y", "Z", "t"]);
    draft.notes.push(CARRIED.to_owned());
    draft
}

/// Rotary B on a rotary A, both below the part: `tip = r + o + Ra (Rb (joints - r) - o)`, angles as ISO 841 has them.
fn dual_rotary_table(hal: &HalPins, unit: f64, values: &mut SourceValues) -> MachineDraft {
    const MODULE: &str = "xyzab_tdr_kins";
    let [x, y, z] = MEETING;
    let outer = [x, y, z, pin("x-offset", 0), pin("z-offset", 2)];
    let mut first = AxisDraft::rotary("A", [1.0, 0.0, 0.0], None);
    let mut second = AxisDraft::rotary("B", [0.0, 1.0, 0.0], None);
    pins(MODULE, &outer, "axis.A.point", hal, values).become_point(&mut first, unit);
    pins(MODULE, &MEETING, "axis.B.point", hal, values).become_point(&mut second, unit);
    let mut draft = MachineDraft::new("linuxcnc", ProgramFormat::linuxcnc());
    draft.axes.extend([first, second]);
    draft.set_chain(&["w", "A", "B", "b", "X", "Y", "Z", "t"]);
    draft.notes.push(CARRIED.to_owned());
    draft
}

/// Pivot length of `5axiskins` to which nothing is connected \[units of the configuration\].
const PIVOT_LENGTH: f64 = 250.0;

/// Head C that carries B: `tip = joints + P z + (P + tool) Rc (sin B, 0, -cos B)`, so that B counts against ISO 841.
fn bridge_mill(hal: &HalPins, unit: f64, values: &mut SourceValues) -> MachineDraft {
    let pin = "5axiskins.pivot-length";
    let mut draft = MachineDraft::new("linuxcnc", ProgramFormat::linuxcnc());
    for (name, dir, sense) in [("B", [0.0, 1.0, 0.0], -1.0), ("C", [0.0, 0.0, 1.0], 1.0)] {
        let mut pivot = PinVector::default();
        let target = format!("axis.{name}.point");
        pivot.add(2, hal.length(pin, &target, PIVOT_LENGTH, values));
        let mut axis = AxisDraft { sense, ..AxisDraft::rotary(name, dir, None) };
        pivot.become_point(&mut axis, unit);
        draft.axes.push(axis);
    }
    draft.set_chain(&["w", "b", "X", "Y", "Z", "C", "B", "t"]);
    draft.notes.push(
        "5axiskins counts the pivot length to the tool tip if the tool length is added to the pin, and to the spindle nose if W has \
         it: the points of B and C must be at the height above the nose (0, 0, pivot length without a tool)."
            .into(),
    );
    draft
}

/// The configuration names a machine file: it is read, and the limits of the INI file are put into it.
fn trunnionkins(
    name: Option<&str>,
    companions: &Companions<'_>,
    values: &mut SourceValues,
) -> Option<MachineDraft> {
    let text = name.and_then(|name| companions.get(name));
    let Some(text) = text else {
        let message = format!(
            "the machine file {} of KINEMATICS is not beside the INI file",
            name.unwrap_or("machine=")
        );
        values.fault("KINS.KINEMATICS", message, "put it there: it holds the chain");
        return None;
    };
    match parse(text) {
        Ok(file) => Some(from_spec(file.spec)),
        Err(faults) => {
            let message = format!("{} of KINEMATICS: {faults}", name.unwrap_or_default());
            values.fault("KINS.KINEMATICS", message, "correct the machine file first");
            None
        }
    }
}

fn from_spec(spec: MachineSpec) -> MachineDraft {
    let axis = |axis: &crate::machine::AxisSpec| {
        let unit = if axis.kind == AxisKind::Rotary { 1.0_f64.to_degrees() } else { 1.0 };
        AxisDraft {
            name: axis.name.clone(),
            kind: axis.kind,
            dir: Some(axis.dir),
            point: axis.point,
            unknown_point: None,
            sense: axis.sense,
            limits: axis.limits.map(|limits| limits.ends().map(|end| end * unit)),
            endless: axis.cyclic.is_some() && axis.limits.is_none(),
            home: axis.home.map(|home| home * unit),
            rates: [axis.vel, axis.acc, axis.jerk].map(|rate| Some(rate * unit)),
        }
    };
    MachineDraft {
        name: spec.name,
        chain: Some(spec.chain),
        tool_axis: spec.tool_axis,
        gauge: spec.gauge,
        axes: spec.axes.iter().map(axis).collect(),
        dialect: spec.dialect,
        servo_period: spec.cycle.servo_period,
        notes: Vec::new(),
    }
}

/// Reads travel and rates of the joints, which are numbered in the order of the letters.
fn limits(draft: &mut MachineDraft, letters: &str, unit: f64, values: &mut SourceValues) {
    let letters: Vec<String> = letters
        .chars()
        .filter(char::is_ascii_alphabetic)
        .map(|c| c.to_ascii_uppercase().to_string())
        .collect();
    for axis in &mut draft.axes {
        let Some(number) = letters.iter().position(|letter| *letter == axis.name) else { continue };
        let scale = if axis.kind == AxisKind::Linear { unit } else { 1.0 };
        let name = axis.name.clone();
        let mut get = |key: &str, field: &str| {
            let target = format!("axis.{name}.{field}");
            values.number(&format!("JOINT_{number}.{key}"), &target).map(|value| value * scale)
        };
        if let (Some(low), Some(high)) = (get("MIN_LIMIT", "limits"), get("MAX_LIMIT", "limits")) {
            axis.limits = Some([low, high]);
        }
        for (rate, (key, field)) in axis.rates.iter_mut().zip([
            ("MAX_VELOCITY", "vel"),
            ("MAX_ACCELERATION", "acc"),
            ("MAX_JERK", "jerk"),
        ]) {
            *rate = get(key, field).or(*rate);
        }
        axis.home = get("HOME", "home").or(axis.home);
        axis.endless |= values
            .number(&format!("AXIS_{name}.WRAPPED_ROTARY"), "cyclic")
            .is_some_and(|on| on > 0.0);
    }
}
