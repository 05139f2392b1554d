//! Values that the caller gives for what a file does not state, and the complete machine.

use super::super::walk::nearest;
use super::draft::{AxisDraft, MachineDraft, RATES};
use crate::machine::{
    AxisKind, AxisSpec, ControlLimits, MachineSpec, RetractPolicy, SingularPolicy,
};
use crate::types::{Diagnostic, Interval};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Keys of an axis that can be given.
const AXIS_KEYS: [&str; 7] = ["dir", "point", "limits", "sense", "vel", "acc", "jerk"];

/// Puts the given values into a draft.
pub(super) fn give(
    draft: &mut MachineDraft,
    given: &BTreeMap<String, String>,
    faults: &mut Vec<Diagnostic>,
) {
    for (key, value) in given {
        if let Err(what) = give_one(draft, key, value) {
            faults.push(Diagnostic::whole(format!("{key} = {value}: {what}")));
        }
    }
}

fn give_one(draft: &mut MachineDraft, key: &str, value: &str) -> Result<(), String> {
    let parts: Vec<&str> = key.split('.').collect();
    match parts.as_slice() {
        ["name"] => value.clone_into(&mut draft.name),
        ["chain"] => draft.chain = Some(value.split(',').map(|word| word.trim().to_owned()).collect()),
        ["gauge"] => draft.gauge = numbers(value)?,
        ["tool_axis"] => draft.tool_axis = numbers(value)?,
        ["axis", name, field] => {
            let names: Vec<String> = draft.axes.iter().map(|axis| axis.name.clone()).collect();
            let axis = draft.axes.iter_mut().find(|axis| axis.name == *name);
            let axis = axis.ok_or_else(|| format!("there is no axis {name}; there are {}", names.join(", ")))?;
            give_axis(axis, field, value)?;
        }
        [group @ ("linear" | "rotary"), field] => {
            let kind = if *group == "linear" { AxisKind::Linear } else { AxisKind::Rotary };
            for axis in draft.axes.iter_mut().filter(|axis| axis.kind == kind) {
                give_axis(axis, field, value)?;
            }
        }
        _ => return Err("the keys are name, chain, gauge, tool_axis, axis.NAME.FIELD, linear.FIELD and rotary.FIELD".into()),
    }
    Ok(())
}

fn give_axis(axis: &mut AxisDraft, field: &str, value: &str) -> Result<(), String> {
    match field {
        "dir" => axis.dir = Some(numbers(value)?),
        "point" => axis.point = Some(numbers(value)?),
        "limits" if value.trim() == "endless" => axis.endless = true,
        "limits" => axis.limits = Some(numbers(value)?),
        "sense" => [axis.sense] = numbers(value)?,
        _ => {
            let rate = RATES.iter().position(|rate| *rate == field);
            let place = rate.and_then(|rate| axis.rates.get_mut(rate)).ok_or_else(|| {
                let near = nearest(field, &AXIS_KEYS).map(|near| format!("; did you mean {near}?"));
                format!("the fields are {}{}", AXIS_KEYS.join(", "), near.unwrap_or_default())
            })?;
            let [number] = numbers(value)?;
            *place = Some(number);
        }
    }
    Ok(())
}

fn numbers<const N: usize>(value: &str) -> Result<[f64; N], String> {
    let wrong = || format!("{N} numbers are expected, separated by commas");
    let all: Result<Vec<f64>, _> =
        value.split(',').map(|word| word.trim().parse::<f64>()).collect();
    all.ok().and_then(|all| all.try_into().ok()).ok_or_else(wrong)
}

/// Returns the machine, or what is missing, one fault a field.
pub(super) fn complete(draft: MachineDraft, faults: &mut Vec<Diagnostic>) -> MachineSpec {
    if draft.chain.is_none() {
        let names: Vec<&str> = draft.axes.iter().map(|axis| axis.name.as_str()).collect();
        faults.push(
            Diagnostic::whole(format!(
                "the file does not state the order of the axes {} from the workpiece to the tool",
                names.join(", ")
            ))
            .with_help("give chain, such as w,C,B,b,X,Y,Z,t (w workpiece, b bed, t tool)"),
        );
    }
    for kind in [AxisKind::Linear, AxisKind::Rotary] {
        missing_of(&draft.axes, kind, faults);
    }
    MachineSpec {
        name: draft.name,
        chain: draft.chain.unwrap_or_default(),
        tool_axis: draft.tool_axis,
        gauge: draft.gauge,
        axes: draft.axes.iter().map(axis_spec).collect(),
        cycle: ControlLimits { servo_period: draft.servo_period, ..ControlLimits::default() },
        singular: SingularPolicy::STANDARD,
        retract: RetractPolicy::standard(),
        dialect: draft.dialect,
        bodies: Vec::new(),
    }
}

fn missing_of(axes: &[AxisDraft], kind: AxisKind, faults: &mut Vec<Diagnostic>) {
    let (group, unit) = match kind {
        AxisKind::Linear => ("linear", "mm"),
        AxisKind::Rotary => ("rotary", "deg"),
    };
    let mut ask = |field: &str, unit: &str, lacks: &dyn Fn(&AxisDraft) -> bool| {
        let names: Vec<&str> = axes
            .iter()
            .filter(|axis| axis.kind == kind && lacks(axis))
            .map(|axis| axis.name.as_str())
            .collect();
        if let Some(first) = names.first() {
            let why =
                axes.iter().filter(|axis| lacks(axis)).find_map(|axis| axis.unknown_point.clone());
            let why = why.filter(|_| field == "point").map(|why| format!(": {why}"));
            let message = format!(
                "the file does not state {field} of {}{}",
                names.join(", "),
                why.unwrap_or_default()
            );
            let all = if names.len() > 1 {
                format!(", or {group}.{field} for all {group} axes")
            } else {
                String::new()
            };
            let help = format!("give axis.{first}.{field} ({unit}){all}");
            faults.push(Diagnostic::whole(message).with_help(help));
        }
    };
    ask("dir", "x,y,z", &|axis| axis.dir.is_none());
    ask("point", "x,y,z in mm", &|axis| kind == AxisKind::Rotary && axis.point.is_none());
    let ends = if kind == AxisKind::Linear {
        "low,high in mm".to_owned()
    } else {
        "low,high in deg, or endless".to_owned()
    };
    ask("limits", &ends, &|axis| axis.limits.is_none() && !axis.endless);
    for (index, rate) in RATES.into_iter().enumerate() {
        let unit = format!("{unit}/s{}", ["", "2", "3"].get(index).copied().unwrap_or_default());
        ask(rate, &unit, &|axis| axis.rates.get(index).copied().flatten().is_none());
    }
}

fn axis_spec(draft: &AxisDraft) -> AxisSpec {
    let dir = draft.dir.unwrap_or([0.0, 0.0, 1.0]);
    let (base, unit) = match draft.kind {
        AxisKind::Linear => (AxisSpec::linear(&draft.name, dir), 1.0),
        AxisKind::Rotary => (
            AxisSpec::rotary(&draft.name, dir, draft.point.unwrap_or_default()),
            1.0_f64.to_radians(),
        ),
    };
    let [vel, acc, jerk] = draft.rates.map(|rate| rate.unwrap_or(1.0) * unit);
    let limits =
        draft.limits.filter(|_| !draft.endless).map(|ends| Interval::from(ends).scaled(unit));
    AxisSpec {
        limits,
        cyclic: (draft.kind == AxisKind::Rotary && draft.endless).then_some(TAU),
        home: draft.home.map(|home| home * unit),
        vel,
        acc,
        jerk,
        sense: draft.sense,
        ..base
    }
}
