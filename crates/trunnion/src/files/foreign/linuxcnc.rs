//! `LinuxCNC`: INI file with HAL lines, kinematics `xyzac-trt-kins`, `xyzbc-trt-kins` and `trunnionkins`.

use super::super::machine::parse;
use super::draft::{AxisDraft, MachineDraft};
use super::source_value::SourceValue;
use super::source_values::SourceValues;
use super::value_origin::ValueOrigin;
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
            Some(text) => hal.read(text, 0),
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
    let mut draft = match module {
        "trunnionkins" => trunnionkins(option("machine"), companions, values)?,
        "xyzac-trt-kins" | "xyzbc-trt-kins" => rotary_tables(module, &hal, values),
        other => {
            let message = format!("KINEMATICS = {other}: this module is not read");
            values.fault(
                "KINS.KINEMATICS",
                message,
                "xyzac-trt-kins, xyzbc-trt-kins and trunnionkins are read",
            );
            return None;
        }
    };
    let unit = match values.text("TRAJ.LINEAR_UNITS", "units").as_deref() {
        Some("inch" | "in") => 25.4,
        _ => 1.0,
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
            match (section.as_str(), key) {
                ("HAL", "HALCMD") => hal.command(value, line),
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

/// Values of HAL pins: set directly, or by a signal.
#[derive(Debug, Default)]
struct HalPins {
    pins: BTreeMap<String, SourceValue>,
    signals: BTreeMap<String, SourceValue>,
    nets: BTreeMap<String, String>,
}

impl HalPins {
    fn read(&mut self, text: &str, line: u64) {
        for row in text.lines() {
            self.command(row, line);
        }
    }

    fn command(&mut self, row: &str, line: u64) {
        let words: Vec<&str> =
            row.split('#').next().unwrap_or_default().split_whitespace().collect();
        match words.as_slice() {
            [command @ ("setp" | "sets"), name, value, ..] => {
                let found =
                    SourceValue { key: (*name).to_owned(), value: (*value).to_owned(), line };
                let map = if *command == "setp" { &mut self.pins } else { &mut self.signals };
                map.insert((*name).to_owned(), found);
            }
            ["net", signal, pins @ ..] => {
                for pin in pins.iter().filter(|pin| pin.contains('.')) {
                    self.nets.insert((*pin).to_owned(), (*signal).to_owned());
                }
            }
            _ => {}
        }
    }

    /// Returns the value of a pin; a pin that nothing sets is 0 in HAL.
    fn number(&self, pin: &str, target: &str, values: &mut SourceValues) -> f64 {
        let by_signal = || self.signals.get(self.nets.get(pin)?);
        let Some(found) = self.pins.get(pin).or_else(by_signal) else {
            let from = SourceValue { key: pin.to_owned(), value: "0 (not set)".into(), line: 0 };
            values.origins.push(ValueOrigin::new(&from, target));
            return 0.0;
        };
        let key = format!("{pin} ({})", found.key);
        values.add(&key, &found.value, found.line);
        values.number(&key, target).unwrap_or(0.0)
    }
}

/// Rotary C on a tilting A or B: `tip = r + Rc (o + Rt (joints - r - o))`, all angles against ISO 841 unless
/// `conventional-directions` is set.
fn rotary_tables(module: &str, hal: &HalPins, values: &mut SourceValues) -> MachineDraft {
    let mut pin =
        |name: &str, target: &str| hal.number(&format!("{module}.{name}"), target, values);
    let meeting =
        ["x-rot-point", "y-rot-point", "z-rot-point"].map(|name| pin(name, "axis.C.point"));
    let (tilting, dir, across) = if module.starts_with("xyzac") {
        ("A", [1.0, 0.0, 0.0], [0.0, pin("y-offset", "axis.A.point"), 0.0])
    } else {
        ("B", [0.0, 1.0, 0.0], [pin("x-offset", "axis.B.point"), 0.0, 0.0])
    };
    let up = pin("z-offset", &format!("axis.{tilting}.point"));
    let conventional = pin("conventional-directions", "axis.sense");
    let [x, y, z] = meeting;
    let [dx, dy, _] = across;
    let mut draft = MachineDraft::new("linuxcnc", ProgramFormat::linuxcnc());
    draft.axes.push(AxisDraft::rotary(tilting, dir, Some([x + dx, y + dy, z + up])));
    draft.axes.push(AxisDraft::rotary("C", [0.0, 0.0, 1.0], Some(meeting)));
    let sense = if conventional > 0.0 { 1.0 } else { -1.0 };
    for axis in draft.axes.iter_mut().filter(|axis| axis.kind == AxisKind::Rotary) {
        axis.sense = sense;
    }
    draft.set_chain(&["w", "C", tilting, "b", "X", "Y", "Z", "t"]);
    draft.notes.push(
        "The configuration does not state which linear axes carry the table: all are written behind the bed, which \
         moves the tool in place of the table and changes no position."
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
