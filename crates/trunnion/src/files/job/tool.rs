//! The job's `[tool]`, and the tools of other programs that are checked.

use super::super::document::Document;
use super::data::{HolderFile, JobTool, ToolConstruction, ToolKind, ToolSide};
use super::raw::{RawConstruction, RawTool, RawToolKind};
use super::tool_side::{self as side, EndShape, kind_name};

/// Reads the tools that other programs call beside those `known` by their numbers.
pub(super) fn others(
    raw: Vec<RawTool>,
    mut known: Vec<u32>,
    doc: &mut Document<'_>,
) -> Option<Vec<JobTool>> {
    let mut all = Vec::new();
    for (at, raw) in raw.into_iter().enumerate() {
        let (path, number) = (format!("verify.tool.{at}"), raw.number);
        if known.contains(&number) {
            let message = format!("tool {number} is given twice");
            let help = "the job's own tool is in [tool]; give every other tool its own number";
            doc.fault(&format!("{path}.number"), message, help);
        }
        // Pushed even if it is a duplicate: a third one is reported as well.
        known.push(number);
        all.push(tool(raw, &path, doc));
    }
    all.into_iter().collect()
}

/// Reads the tool at `path`, if its entries agree.
pub(in super::super) fn tool(raw: RawTool, path: &str, doc: &mut Document<'_>) -> Option<JobTool> {
    let kind = match raw.kind {
        RawToolKind::Flat => ToolKind::Flat,
        RawToolKind::Ball => ToolKind::Ball,
        RawToolKind::Bull => ToolKind::Bull,
        RawToolKind::Taper => ToolKind::Taper,
        RawToolKind::Barrel => ToolKind::Barrel,
        RawToolKind::ConicalBarrel => ToolKind::ConicalBarrel,
        RawToolKind::Lens => ToolKind::Lens,
    };
    let shape = match kind {
        ToolKind::Flat | ToolKind::Ball | ToolKind::Bull => {
            side::none(&raw, kind, path, doc);
            radii(&raw, kind, path, doc).map(|[major, minor]| EndShape {
                major,
                minor,
                side: ToolSide::Straight,
            })
        }
        _ => side::shape(&raw, kind, path, doc),
    };
    let construction = construction(&raw, shape.as_ref(), path, doc);
    profile(&format!("{path}.shank"), &raw.shank, doc);
    profile(&format!("{path}.holder"), &raw.holder, doc);
    if let (Some(&[end, _]), Some(&[start, _])) = (raw.shank.last(), raw.holder.first())
        && start < end
    {
        let message = format!("the holder begins at {start} mm, below the shank's end at {end} mm");
        doc.fault(
            &format!("{path}.holder"),
            message,
            "heights count from the tip; the holder sits on the shank",
        );
    }
    let holder_file = holder_file(&raw, path, doc);
    // Everything that can be checked without kind and radii has been reported by now.
    let EndShape { major, minor, side } = shape?;
    // The corner lies below the gauge point; where a side ends is known when the profile is laid out.
    if minor >= raw.length && side == ToolSide::Straight {
        let message = format!("a corner of {minor} mm does not fit a length of {} mm", raw.length);
        doc.fault(
            &format!("{path}.length"),
            message,
            "length runs from the gauge point to the tip, in mm",
        );
    }
    Some(JobTool {
        number: raw.number,
        kind,
        major,
        minor,
        side,
        length: raw.length,
        construction: construction?,
        shank: raw.shank,
        holder: raw.holder,
        holder_file,
    })
}

fn holder_file(raw: &RawTool, path: &str, doc: &mut Document<'_>) -> Option<HolderFile> {
    let name = raw.holder_file.clone()?;
    let key = format!("{path}.holder_file");
    if !raw.holder.is_empty() {
        let message = "the holder is given twice: by holder and by holder_file";
        doc.fault(&key, message, "keep one of them");
    }
    Some(HolderFile { name, key })
}

/// Reads `[R, r]`, written as radii or as diameter and corner.
fn radii(raw: &RawTool, kind: ToolKind, path: &str, doc: &mut Document<'_>) -> Option<[f64; 2]> {
    let by_radii = raw.major_radius.is_some() || raw.minor_radius.is_some();
    let by_diameter = raw.diameter.is_some() || raw.corner_radius.is_some();
    if by_radii && by_diameter {
        // Even equal values are refused: the next edit would change one of them alone.
        let message = "the tool is given twice: by radii and by diameter";
        doc.fault(
            &format!("{path}.diameter"),
            message,
            "keep major_radius and minor_radius, or diameter",
        );
        return None;
    }
    let mut missing = |key: &str, example: &str| {
        let message = format!("a {} tool needs {key}", kind_name(kind));
        doc.fault(&format!("{path}.kind"), message, format!("add `{key} = ...`, in mm, {example}"));
        None
    };
    let (major, minor) = if by_diameter {
        let Some(diameter) = raw.diameter else { return missing("diameter", "2 (R + r)") };
        // D = 2 (R + r).
        let radius = 0.5 * diameter;
        let corner = match (kind, raw.corner_radius) {
            (_, Some(corner)) => corner,
            (ToolKind::Flat, None) => 0.0,
            (ToolKind::Ball, None) => radius,
            (_, None) => return missing("corner_radius", "or use minor_radius"),
        };
        (radius - corner, corner)
    } else {
        match (kind, raw.major_radius, raw.minor_radius) {
            (ToolKind::Flat, Some(major), minor) => (major, minor.unwrap_or(0.0)),
            (ToolKind::Ball, major, Some(minor)) => (major.unwrap_or(0.0), minor),
            (ToolKind::Flat, None, _) => {
                return missing("major_radius", "or diameter and corner_radius");
            }
            (ToolKind::Ball, _, None) => {
                return missing("minor_radius", "the radius of the corner arc");
            }
            (_, None, _) => return missing("major_radius", "or diameter and corner_radius"),
            (_, _, None) => return missing("minor_radius", "the radius of the corner arc"),
            (_, Some(major), Some(minor)) => (major, minor),
        }
    };
    // R = 0 is a ball, r = 0 a flat end: the kind must agree with the radii.
    let fits = match kind {
        ToolKind::Flat => major > 0.0 && minor <= 0.0,
        ToolKind::Ball => major.abs() <= 0.0 && minor > 0.0,
        _ => major > 0.0 && minor > 0.0,
    };
    if fits {
        return Some([major, minor]);
    }
    let message =
        format!("a {} tool cannot have R = {major} mm and r = {minor} mm", kind_name(kind));
    let help = "flat: r = 0; ball: R = 0, corner_radius half the diameter; bull: both above 0";
    doc.fault(&format!("{path}.kind"), message, help);
    None
}

fn construction(
    raw: &RawTool,
    shape: Option<&EndShape>,
    path: &str,
    doc: &mut Document<'_>,
) -> Option<ToolConstruction> {
    let inner = format!("{path}.inner_cutting_radius");
    match (raw.construction, raw.inner_cutting_radius) {
        (RawConstruction::Solid, None) => Some(ToolConstruction::Solid),
        (RawConstruction::Solid, Some(_)) => {
            let message = "a solid tool cuts to its centre: it has no inner_cutting_radius";
            doc.fault(&inner, message, "remove it, or write construction = \"insert\"");
            None
        }
        (RawConstruction::Insert, None) => {
            let message = "a tool with inserts needs inner_cutting_radius";
            let help = "add `inner_cutting_radius = ...`: nothing cuts inside it, in mm";
            doc.fault(&format!("{path}.construction"), message, help);
            None
        }
        (RawConstruction::Insert, Some(inner_cutting_radius)) => {
            // Inserts that begin at the outer radius cut nothing.
            if let Some(radius) = shape.map(EndShape::radius)
                && inner_cutting_radius >= radius
            {
                let message = format!(
                    "inner_cutting_radius {inner_cutting_radius} mm leaves no cutting edge on a cutter of radius {radius} mm"
                );
                doc.fault(&inner, message, "it must be below R + r");
            }
            Some(ToolConstruction::Insert { inner_cutting_radius })
        }
    }
}

fn profile(path: &str, pairs: &[[f64; 2]], doc: &mut Document<'_>) {
    let mut below = 0.0;
    for (at, &[height, radius]) in pairs.iter().enumerate() {
        // Equal heights are steps of the profile.
        if height < below || radius < 0.0 {
            let message =
                format!("the heights of `{path}` fall: [{height}, {radius}] after {below} mm");
            let help = "pairs are [height above the tip, radius] in mm, heights not falling";
            doc.fault(&format!("{path}.{at}"), message, help);
            return;
        }
        below = height;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{JobPlacement, parse};

    /// The last line of it, 52, stands in [verify].
    const EXAMPLE: &str = include_str!("../../../../../examples/bezier-patch/job.toml");

    /// The example with another cutter.
    fn with_tool(lines: &str) -> String {
        let plain = "kind = \"bull\"";
        let start = EXAMPLE.find(plain).unwrap();
        let end = EXAMPLE.find("minor_radius").unwrap();
        let rest = EXAMPLE[end..].find('\n').map_or("", |line| &EXAMPLE[end + line..]);
        let method = rest.replace("method = \"widest\"", "method = \"auto\"");
        format!("{}{lines}{method}", &EXAMPLE[..start])
    }

    #[test]
    fn cutters_with_a_side_have_the_keys_of_catalogues() {
        let end = |lines: &str| {
            let tool = parse(&with_tool(lines)).unwrap().tool;
            (tool.minor, tool.radius(), tool.tip_angle().to_degrees())
        };
        let (tip, radius, angle) =
            end("kind = \"taper\"\ntip_radius = 1\ntaper_angle = 5\ndiameter = 10");
        assert!((tip - 1.0).abs() < 1e-12 && (radius - 5.0).abs() < 1e-12);
        assert!((angle - 85.0).abs() < 1e-9);
        let (tip, radius, angle) =
            end("kind = \"lens\"\ntip_radius = 101\ncorner_radius = 1\ndiameter = 22");
        assert!((tip - 101.0).abs() < 1e-12 && (radius - 11.0).abs() < 1e-12);
        assert!((angle.to_radians().sin() - 0.1).abs() < 1e-12);
    }

    #[test]
    fn keys_of_other_kinds_and_missing_ones_are_named() {
        let found = |lines: &str| -> Vec<String> {
            parse(&with_tool(lines)).unwrap_err().iter().map(ToString::to_string).collect()
        };
        let taper = found("kind = \"taper\"\ntip_radius = 1\nbarrel_radius = 85");
        assert!(taper.iter().any(|one| one.contains("needs taper_angle")), "{taper:?}");
        assert!(taper.iter().any(|one| one.contains("needs diameter")), "{taper:?}");
        assert!(taper.iter().any(|one| one.contains("has no barrel_radius")), "{taper:?}");
        let bull = found("kind = \"bull\"\ndiameter = 32\ncorner_radius = 6\ntip_radius = 1");
        assert!(bull[0].contains("a bull tool has no tip_radius"), "{bull:?}");
        let lens = "kind = \"lens\"\ntip_radius = 101\ncorner_radius = 1\ndiameter = 22";
        let far = with_tool(lens).replace("[strategy]", "[strategy]\nlead_angle = 8");
        let far: Vec<String> = parse(&far).unwrap_err().iter().map(ToString::to_string).collect();
        assert!(far[0].contains("its tip arc ends at 5.74 deg"), "{far:?}");
    }

    #[test]
    fn a_barrel_is_inclined_sideways_as_far_as_its_arc_goes() {
        let tool = "kind = \"barrel\"\ntip_radius = 2\nbarrel_radius = 85\ndiameter = 12";
        let free = parse(&with_tool(tool)).unwrap();
        assert_eq!(free.strategy.method, JobPlacement::Widest);
        // sin = 79 / 83 where tip arc and large arc meet.
        let arc = free.tool.arc_inclinations();
        assert!((arc.low.sin() - 79.0 / 83.0).abs() < 1e-12 && arc.high.cos().abs() < 1e-12);
        let with = |keys: &str| {
            let text = with_tool(tool)
                .replace("method = \"auto\"", &format!("method = \"fixed-tilt\"\n{keys}"));
            parse(&text)
        };
        let tilted = with("tilt_angle = -78").unwrap().strategy.method;
        let JobPlacement::Fixed { lead, tilt } = tilted else { panic!("{tilted:?}") };
        assert!(lead.abs() <= 0.0 && (tilt.to_degrees() + 78.0).abs() < 1e-9);
        let message = |keys: &str| with(keys).unwrap_err().iter().next().unwrap().to_string();
        let found = message("");
        assert!(found.contains("needs tilt_angle"), "{found}");
        assert!(found.contains("from 72.14 to 90.00 deg"), "{found}");
        let found = message("tilt_angle = 60");
        assert!(found.contains("a barrel tool cannot tilt by 60 deg"), "{found}");
        let found = message("tilt_angle = 75\nlead_angle = 4");
        assert!(found.contains("a barrel tool cannot lead by 4 deg"), "{found}");
    }

    #[test]
    fn a_barrel_is_read_as_the_tool_of_another_program() {
        let tool = "[[verify.tool]]\nnumber = 2\nkind = \"conical-barrel\"\ntip_radius = 2\nbarrel_radius = 250\n\
                    taper_angle = 20\ndiameter = 12\nlength = 80\n";
        let job = parse(&format!("{EXAMPLE}{tool}")).unwrap();
        let radius = job.other_tools[0].radius();
        assert!((radius - 6.0).abs() < 1e-12);
    }

    #[test]
    fn other_tools_are_written_as_the_jobs_own() {
        let tool = |number: u32| {
            format!(
                "[[verify.tool]]\nnumber = {number}\nkind = \"ball\"\ndiameter = 6\nlength = 80\n"
            )
        };
        let job = parse(&format!("{EXAMPLE}{}{}", tool(2), tool(7))).unwrap();
        let read: Vec<_> =
            job.other_tools.iter().map(|of| (of.number, of.minor, of.length)).collect();
        assert_eq!(read, [(2, 3.0, 80.0), (7, 3.0, 80.0)]);
        assert_eq!(job.places.get("verify.tool.1.length").line, 62);
        let wrong = format!("{EXAMPLE}{}{}corner_radius = 2\n", tool(1), tool(1));
        let found = parse(&wrong).unwrap_err();
        let found: Vec<String> = found.iter().map(ToString::to_string).collect();
        let expected = [
            "54:10: tool 1 is given twice\n  help: the job's own tool is in [tool]",
            "59:10: tool 1 is given twice",
            "60:8: a ball tool cannot have R = 1 mm and r = 2 mm",
        ];
        assert_eq!(found.len(), expected.len(), "{found:#?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.starts_with(expected), "{found}\n{expected}");
        }
        let misspelt = parse(&format!("{EXAMPLE}[[verify.tool]]\nnumbr = 2\n")).unwrap_err();
        let misspelt: Vec<String> = misspelt.iter().map(ToString::to_string).collect();
        let expected =
            "54:1: unknown key `numbr` in [[verify.tool]]\n  help: did you mean `number`?";
        assert!(misspelt.iter().any(|fault| fault == expected), "{misspelt:#?}");
    }
}
