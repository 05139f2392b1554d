//! The job's `[tool]`.

use super::super::document::Document;
use super::data::{Construction, Tool, ToolKind};
use super::raw::{RawConstruction, RawTool, RawToolKind};

/// The tool, if its entries go together.
pub(super) fn tool(raw: RawTool, doc: &mut Document<'_>) -> Option<Tool> {
    let kind = match raw.kind {
        RawToolKind::Flat => Some(ToolKind::Flat),
        RawToolKind::Ball => Some(ToolKind::Ball),
        RawToolKind::Bull => Some(ToolKind::Bull),
        RawToolKind::Taper | RawToolKind::Barrel => {
            let message = "tapered and barrel tools cannot be placed yet";
            doc.fault("tool.kind", message, "use \"bull\" with the radii of the cutting end");
            None
        }
    };
    let radii = kind.and_then(|kind| radii(&raw, kind, doc));
    let construction = construction(&raw, radii, doc);
    profile("tool.shank", &raw.shank, doc);
    profile("tool.holder", &raw.holder, doc);
    if let (Some(&[end, _]), Some(&[start, _])) = (raw.shank.last(), raw.holder.first())
        && start < end
    {
        let message = format!("the holder begins at {start} mm, below the shank's end at {end} mm");
        doc.fault(
            "tool.holder",
            message,
            "heights count from the tip; the holder sits on the shank",
        );
    }
    let (kind, [major, minor]) = (kind?, radii?);
    if minor >= raw.length {
        let message = format!("a corner of {minor} mm does not fit a length of {} mm", raw.length);
        doc.fault("tool.length", message, "length runs from the gauge point to the tip, in mm");
    }
    Some(Tool {
        number: raw.number,
        kind,
        major,
        minor,
        length: raw.length,
        construction: construction?,
        shank: raw.shank,
        holder: raw.holder,
    })
}

/// `[R, r]` from either way to write them.
fn radii(raw: &RawTool, kind: ToolKind, doc: &mut Document<'_>) -> Option<[f64; 2]> {
    let by_radii = raw.major_radius.is_some() || raw.minor_radius.is_some();
    let by_diameter = raw.diameter.is_some() || raw.corner_radius.is_some();
    if by_radii && by_diameter {
        let message = "the tool is given twice: by radii and by diameter";
        doc.fault("tool.diameter", message, "keep major_radius and minor_radius, or diameter");
        return None;
    }
    let mut missing = |key: &str, example: &str| {
        let message = format!("a {} tool needs {key}", kind_name(kind));
        doc.fault("tool.kind", message, format!("add `{key} = ...`, in mm, {example}"));
        None
    };
    let (major, minor) = if by_diameter {
        let Some(diameter) = raw.diameter else { return missing("diameter", "2 (R + r)") };
        let radius = 0.5 * diameter;
        let corner = match (kind, raw.corner_radius) {
            (_, Some(corner)) => corner,
            (ToolKind::Flat, None) => 0.0,
            (ToolKind::Ball, None) => radius,
            (ToolKind::Bull, None) => return missing("corner_radius", "or use minor_radius"),
        };
        (radius - corner, corner)
    } else {
        match (kind, raw.major_radius, raw.minor_radius) {
            (ToolKind::Flat | ToolKind::Bull, None, _) => {
                return missing("major_radius", "or diameter and corner_radius");
            }
            (ToolKind::Ball | ToolKind::Bull, _, None) => {
                return missing("minor_radius", "the radius of the corner arc");
            }
            (_, major, minor) => (major.unwrap_or(0.0), minor.unwrap_or(0.0)),
        }
    };
    let fits = match kind {
        ToolKind::Flat => major > 0.0 && minor <= 0.0,
        ToolKind::Ball => major.abs() <= 0.0 && minor > 0.0,
        ToolKind::Bull => major > 0.0 && minor > 0.0,
    };
    if fits {
        return Some([major, minor]);
    }
    let message =
        format!("a {} tool cannot have R = {major} mm and r = {minor} mm", kind_name(kind));
    let help = "flat: r = 0; ball: R = 0, corner_radius half the diameter; bull: both above 0";
    doc.fault("tool.kind", message, help);
    None
}

fn kind_name(kind: ToolKind) -> &'static str {
    match kind {
        ToolKind::Flat => "flat",
        ToolKind::Ball => "ball",
        ToolKind::Bull => "bull",
    }
}

fn construction(
    raw: &RawTool,
    radii: Option<[f64; 2]>,
    doc: &mut Document<'_>,
) -> Option<Construction> {
    let path = "tool.inner_cutting_radius";
    match (raw.construction, raw.inner_cutting_radius) {
        (RawConstruction::Solid, None) => Some(Construction::Solid),
        (RawConstruction::Solid, Some(_)) => {
            let message = "a solid tool cuts to its centre: it has no inner_cutting_radius";
            doc.fault(path, message, "remove it, or write construction = \"insert\"");
            None
        }
        (RawConstruction::Insert, None) => {
            let message = "a tool with inserts needs inner_cutting_radius";
            let help = "add `inner_cutting_radius = ...`: nothing cuts inside it, in mm";
            doc.fault("tool.construction", message, help);
            None
        }
        (RawConstruction::Insert, Some(inner_cutting_radius)) => {
            if let Some([major, minor]) = radii
                && inner_cutting_radius >= major + minor
            {
                let radius = major + minor;
                let message = format!(
                    "inner_cutting_radius {inner_cutting_radius} mm leaves nothing of a cutter of radius {radius} mm"
                );
                doc.fault(path, message, "it must be below R + r");
            }
            Some(Construction::Insert { inner_cutting_radius })
        }
    }
}

fn profile(path: &str, pairs: &[[f64; 2]], doc: &mut Document<'_>) {
    let mut below = 0.0;
    for (at, &[height, radius]) in pairs.iter().enumerate() {
        if height < below || radius < 0.0 {
            let message = format!("`{path}` does not go up: [{height}, {radius}] after {below} mm");
            let help = "pairs are [height above the tip, radius] in mm, heights not falling";
            doc.fault(&format!("{path}.{at}"), message, help);
            return;
        }
        below = height;
    }
}
