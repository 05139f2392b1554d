//! Machine of `FreeCAD` (`.fcm`): JSON with axes, their joints, roles and parents.

use super::draft::{AxisDraft, MachineDraft};
use super::source_value::SourceValue;
use super::source_values::SourceValues;
use super::value_origin::ValueOrigin;
use crate::machine::{AxisKind, ProgramFormat};
use crate::types::Diagnostic;
use serde_json::Value;

/// An axis as the file has it.
struct FcmAxis {
    draft: AxisDraft,
    role: String,
    parent: Option<String>,
    sequence: f64,
}

pub(super) fn read(text: &str, values: &mut SourceValues) -> Option<MachineDraft> {
    let file: Value = match serde_json::from_str(text) {
        Ok(file) => file,
        Err(error) => {
            let line = error.line() as u64;
            values
                .faults
                .push(Diagnostic::whole(format!("the file is no JSON: {error}")).on_line(line));
            return None;
        }
    };
    let machine = &file["machine"];
    let unit = match machine["units"].as_str() {
        Some("metric") => 1.0,
        Some("imperial") => 25.4,
        other => {
            let message = format!("machine.units = {:?} is no unit", other.unwrap_or_default());
            values
                .faults
                .push(Diagnostic::whole(message).with_help("write \"metric\" or \"imperial\""));
            return None;
        }
    };
    let name = machine["name"].as_str().unwrap_or("freecad");
    let mut draft = MachineDraft::new(name, ProgramFormat::linuxcnc());
    draft.axes.clear();
    let Some(entries) = machine["axes"].as_object() else {
        values.faults.push(
            Diagnostic::whole("machine.axes is missing")
                .with_help("save the machine with its axes"),
        );
        return None;
    };
    let mut axes = Vec::new();
    for (name, entry) in entries {
        axes.extend(axis(name, entry, unit, values));
    }
    draft.chain = chain(&axes);
    if draft.chain.is_none() {
        draft.notes.push(
            "Roles, parents and sequences leave the order of the axes open: the chain was given."
                .into(),
        );
    }
    draft.notes.push(
        "The format does not state whether a table axis counts by ISO 841, nor the gauge point, which is taken at the \
         origin: compare the motions that `machine show` lists with the machine, or measure (`machine calibrate`)."
            .into(),
    );
    draft.axes = axes.into_iter().map(|axis| axis.draft).collect();
    Some(draft)
}

fn axis(name: &str, entry: &Value, unit: f64, values: &mut SourceValues) -> Option<FcmAxis> {
    let kind = match entry["type"].as_str() {
        Some("linear") => AxisKind::Linear,
        Some("rotary" | "angular") => AxisKind::Rotary,
        other => {
            let message = format!("axis {name} has the type {:?}", other.unwrap_or_default());
            values
                .faults
                .push(Diagnostic::whole(message).with_help("write \"linear\" or \"angular\""));
            return None;
        }
    };
    let scale = if kind == AxisKind::Linear { unit } else { 1.0 };
    let mut draft = AxisDraft::new(name, kind);
    draft.dir = vector(&entry["joint"]["axis"]);
    if kind == AxisKind::Rotary {
        draft.point = vector(&entry["joint"]["origin"]).map(|point| point.map(|part| part * unit));
    }
    let number = |value: &Value| value.as_f64();
    let ends = [number(&entry["limits"]["min"]), number(&entry["limits"]["max"])];
    if let [Some(low), Some(high)] = ends {
        draft.limits = Some([low * scale, high * scale]);
    }
    // Velocities are per minute.
    draft.rates =
        [number(&entry["max_velocity"]).map(|velocity| velocity * scale / 60.0), None, None];
    for (key, target) in [
        ("type", "kind"),
        ("joint", "dir, point"),
        ("limits", "limits"),
        ("max_velocity", "vel"),
        ("role", "chain"),
    ] {
        if !entry[key].is_null() {
            let from = SourceValue {
                key: format!("axes.{name}.{key}"),
                value: entry[key].to_string(),
                line: 0,
            };
            values.origins.push(ValueOrigin::new(&from, &format!("axis.{name}.{target}")));
        }
    }
    Some(FcmAxis {
        draft,
        role: entry["role"].as_str().unwrap_or_default().to_owned(),
        parent: entry["parent"].as_str().map(str::to_owned),
        sequence: number(&entry["sequence"]).unwrap_or_default(),
    })
}

fn vector(value: &Value) -> Option<[f64; 3]> {
    let parts: Vec<f64> = value.as_array()?.iter().filter_map(Value::as_f64).collect();
    parts.try_into().ok()
}

/// Returns the chain if roles and parents decide it: an axis stands farther from the bed than its parent.
fn chain(axes: &[FcmAxis]) -> Option<Vec<String>> {
    let side = |of: &str| -> Option<Vec<String>> {
        let mut found: Vec<&FcmAxis> =
            axes.iter().filter(|axis| axis.role.starts_with(of)).collect();
        let depth = |axis: &FcmAxis| {
            let mut depth = 0;
            let mut parent = axis.parent.as_deref();
            // A circle of parents ends as well.
            while let Some(name) = parent.filter(|_| depth <= axes.len()) {
                depth += 1;
                parent = axes
                    .iter()
                    .find(|one| one.draft.name == name)
                    .and_then(|one| one.parent.as_deref());
            }
            depth
        };
        found.sort_by(|a, b| depth(a).cmp(&depth(b)).then(a.sequence.total_cmp(&b.sequence)));
        // Two rotaries at one place have no order.
        let rotaries: Vec<&&FcmAxis> =
            found.iter().filter(|axis| axis.draft.kind == AxisKind::Rotary).collect();
        let open = rotaries.windows(2).any(|pair| match pair {
            [a, b] => depth(a) == depth(b) && a.sequence.total_cmp(&b.sequence).is_eq(),
            _ => false,
        });
        // A rotary without parent beside linear axes of its side: whether they carry it is open.
        let loose = |axis: &&FcmAxis| axis.parent.is_none();
        let linear = found.iter().any(|axis| axis.draft.kind == AxisKind::Linear);
        if open || (linear && rotaries.iter().any(|axis| loose(axis))) {
            return None;
        }
        Some(found.iter().map(|axis| axis.draft.name.clone()).collect())
    };
    let (mut table, head) = (side("table")?, side("head")?);
    if table.len() + head.len() != axes.len() {
        return None;
    }
    table.reverse();
    let ends = |word: &str| std::iter::once(word.to_owned());
    Some(ends("w").chain(table).chain(ends("b")).chain(head).chain(ends("t")).collect())
}
