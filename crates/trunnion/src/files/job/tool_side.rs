//! Keys of `[tool]` for cutters whose tip arc goes on into a cone or a second arc.

use super::super::document::Document;
use super::data::{ToolKind, ToolSide};
use super::raw::RawTool;

/// Shape of the cutting end, as `[tool]` gives it.
#[derive(Debug, Clone, Copy)]
pub(super) struct EndShape {
    pub(super) major: f64,
    pub(super) minor: f64,
    pub(super) side: ToolSide,
}

impl EndShape {
    /// Returns the outer radius \[mm\].
    pub(super) fn radius(&self) -> f64 {
        match self.side {
            ToolSide::Straight => self.major + self.minor,
            ToolSide::Cone { diameter, .. } | ToolSide::Arc { diameter, .. } => 0.5 * diameter,
        }
    }
}

pub(super) fn kind_name(kind: ToolKind) -> &'static str {
    match kind {
        ToolKind::Flat => "flat",
        ToolKind::Ball => "ball",
        ToolKind::Bull => "bull",
        ToolKind::Taper => "taper",
        ToolKind::Barrel => "barrel",
        ToolKind::ConicalBarrel => "conical-barrel",
        ToolKind::Lens => "lens",
    }
}

/// Key of a length or an angle of `[tool]`, with its value and its meaning.
struct SideKey {
    name: &'static str,
    value: Option<f64>,
    meaning: &'static str,
}

/// Returns all keys that belong to some kinds only.
fn keys(raw: &RawTool) -> [SideKey; 4] {
    let key = |name, value, meaning| SideKey { name, value, meaning };
    [
        key("tip_radius", raw.tip_radius, "in mm, the radius of the arc at the tip"),
        key(
            "barrel_radius",
            raw.barrel_radius,
            "in mm, the radius of the large arc beside the tip",
        ),
        key("taper_angle", raw.taper_angle, "in degrees, between the side and the tool axis"),
        key("corner_radius", raw.corner_radius, "in mm, the radius of the small arc at the flank"),
    ]
}

/// Returns the keys that a kind needs beside `diameter`.
fn needed(kind: ToolKind) -> &'static [&'static str] {
    match kind {
        ToolKind::Flat | ToolKind::Ball | ToolKind::Bull => &[],
        ToolKind::Taper => &["tip_radius", "taper_angle"],
        ToolKind::Barrel => &["tip_radius", "barrel_radius"],
        ToolKind::ConicalBarrel => &["tip_radius", "barrel_radius", "taper_angle"],
        ToolKind::Lens => &["tip_radius", "corner_radius"],
    }
}

/// Refuses the keys of a side on a tool with a straight flank.
pub(super) fn none(raw: &RawTool, kind: ToolKind, path: &str, doc: &mut Document<'_>) {
    // The corner radius is one of theirs as well.
    for key in keys(raw).iter().filter(|key| key.name != "corner_radius" && key.value.is_some()) {
        refuse(key, kind, path, doc);
    }
}

fn refuse(key: &SideKey, kind: ToolKind, path: &str, doc: &mut Document<'_>) {
    let message = format!("a {} tool has no {}", kind_name(kind), key.name);
    let kinds = [ToolKind::Taper, ToolKind::Barrel, ToolKind::ConicalBarrel, ToolKind::Lens];
    let with: Vec<String> = kinds
        .into_iter()
        .filter(|kind| needed(*kind).contains(&key.name))
        .map(|kind| format!("\"{}\"", kind_name(kind)))
        .collect();
    let help = format!("remove it, or write kind = {}", with.join(" or "));
    doc.fault(&format!("{path}.{}", key.name), message, help);
}

/// Reads the cutting end of a tapered, barrel or lens cutter, if its keys are complete.
pub(super) fn shape(
    raw: &RawTool,
    kind: ToolKind,
    path: &str,
    doc: &mut Document<'_>,
) -> Option<EndShape> {
    let mut complete = true;
    for (name, value) in [("major_radius", raw.major_radius), ("minor_radius", raw.minor_radius)] {
        if value.is_some() {
            let message = format!("a {} tool has no {name}", kind_name(kind));
            doc.fault(&format!("{path}.{name}"), message, "write tip_radius and diameter instead");
            complete = false;
        }
    }
    let diameter = SideKey {
        name: "diameter",
        value: raw.diameter,
        meaning: "in mm, where the side ends and the straight flank begins",
    };
    for key in keys(raw).iter().chain([&diameter]) {
        let is_needed = key.name == "diameter" || needed(kind).contains(&key.name);
        if is_needed && key.value.is_none() {
            let message = format!("a {} tool needs {}", kind_name(kind), key.name);
            let help = format!("add `{} = ...`, {}", key.name, key.meaning);
            doc.fault(&format!("{path}.kind"), message, help);
            complete = false;
        } else if !is_needed && key.value.is_some() {
            refuse(key, kind, path, doc);
            complete = false;
        }
    }
    let (minor, diameter) = (raw.tip_radius?, raw.diameter?);
    let taper_angle = raw.taper_angle.unwrap_or(0.0).to_radians();
    let side = match kind {
        ToolKind::Taper => ToolSide::Cone { taper_angle, diameter },
        ToolKind::Lens => ToolSide::Arc { radius: raw.corner_radius?, taper_angle, diameter },
        _ => ToolSide::Arc { radius: raw.barrel_radius?, taper_angle, diameter },
    };
    complete.then_some(EndShape { major: 0.0, minor, side })
}
