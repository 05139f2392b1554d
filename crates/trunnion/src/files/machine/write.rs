//! From a machine to the text of its file, in mm, deg and s.

use super::layout::LAYOUT;
use crate::machine::{
    AxisFormat, AxisInterpolation, AxisKind, AxisSpec, BodyShape, ControlLimits, FeedMode,
    MachineBody, MachineSpec, PreferredSign, ProgramFormat, RetractFrame, RetractPolicy,
    SingularPolicy, TurnFormat,
};
use crate::math;
use std::fmt::Write;

/// Writes the file of a machine; each note becomes a comment line on top.
///
/// Reading the text gives the machine back, angles to a rounding.
///
/// # Example
///
/// ```
/// use trunnion::files::machine::{built_in, parse, write};
///
/// let text = built_in("bc-trunnion").map_err(|nearest| format!("did you mean {nearest:?}?"))?;
/// let spec = parse(text).map_err(|faults| faults.to_string())?.spec;
/// let again = parse(&write(&spec, &["a copy".to_owned()])).map_err(|faults| faults.to_string())?.spec;
/// assert_eq!((again.chain, again.gauge), (spec.chain, spec.gauge));
/// # Ok::<(), String>(())
/// ```
pub fn write(spec: &MachineSpec, notes: &[String]) -> String {
    let mut text = String::new();
    for line in notes.iter().flat_map(|note| note.lines()) {
        text.push_str(format!("# {line}").trim_end());
        text.push('\n');
    }
    let chain = spec.chain.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(", ");
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "schema = {}\nname = {}\nunits = {{ length = \"mm\", angle = \"deg\", time = \"s\" }}\n\
         chain = [{chain}]\ntool_axis = {}\ngauge = {}\n",
        quoted(LAYOUT),
        quoted(&spec.name),
        vector(spec.tool_axis),
        vector(spec.gauge),
    );
    for axis in &spec.axes {
        write_axis(&mut text, axis);
    }
    write_cycle(&mut text, &spec.cycle);
    write_singular(&mut text, &spec.singular);
    write_retract(&mut text, &spec.retract, spec);
    write_dialect(&mut text, &spec.dialect);
    for body in &spec.bodies {
        write_body(&mut text, body);
    }
    text
}

/// Writes a body; triangles that were read from a file are left to that file, whose name they do not have.
fn write_body(text: &mut String, body: &MachineBody) {
    let mut entries = vec![("name", quoted(&body.name)), ("link", quoted(&body.link))];
    let mut kind = |kind: &str| entries.push(("kind", quoted(kind)));
    match &body.shape {
        BodyShape::Box { min, max } => {
            kind("box");
            entries.extend([("min", vector((*min).into())), ("max", vector((*max).into()))]);
        }
        BodyShape::Cylinder { base, axis, radius, height } => {
            kind("cylinder");
            entries.extend([
                ("base", vector((*base).into())),
                ("axis", vector(*axis)),
                ("radius", number(*radius)),
                ("height", number(*height)),
            ]);
        }
        BodyShape::File { file, place, chord } => {
            let is_step =
                file.to_lowercase().ends_with(".step") || file.to_lowercase().ends_with(".stp");
            kind(if is_step { "step" } else { "stl" });
            let angles = math::xyz_of_rotation(&place.rotation.to_rotation_matrix());
            let angles: [f64; 3] = angles.into();
            entries.push(("file", quoted(file)));
            if is_step {
                entries.push(("chord", number(*chord)));
            }
            entries.push(("origin", vector(place.translation.vector.into())));
            entries.push(("rotation", vector(angles.map(f64::to_degrees))));
        }
        BodyShape::Mesh { .. } => return,
    }
    if !body.touches.is_empty() {
        let names: Vec<String> = body.touches.iter().map(|name| quoted(name)).collect();
        entries.push(("touches", format!("[{}]", names.join(", "))));
    }
    let lines: String = entries.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
    let _ = write!(text, "\n[[body]]\n{lines}");
}

fn write_axis(text: &mut String, axis: &AxisSpec) {
    let (kind, factor) = match axis.kind {
        AxisKind::Linear => ("linear", 1.0),
        AxisKind::Rotary => ("rotary", 1.0_f64.to_degrees()),
    };
    let figure = |value: f64| number(value * factor);
    let _ = writeln!(text, "\n[axis.{}]", key(&axis.name));
    let mut line = |key: &str, value: String| {
        let _ = writeln!(text, "{key} = {value}");
    };
    line("kind", quoted(kind));
    line("dir", vector(axis.dir));
    if let Some(point) = axis.point {
        line("point", vector(point));
    }
    if let Some([low, high]) = axis.limits.map(|limits| limits.ends().map(figure)) {
        line("limits", format!("[{low}, {high}]"));
    }
    let rates = [("vel", axis.vel), ("acc", axis.acc), ("jerk", axis.jerk)];
    let optional = [("cyclic", axis.cyclic), ("rapid", axis.rapid), ("home", axis.home)];
    for (key, value) in
        optional.into_iter().filter_map(|(key, value)| Some((key, value?))).chain(rates)
    {
        line(key, figure(value));
    }
    if axis.sense < 0.0 {
        line("sense", number(axis.sense));
    }
    if let Some(prefer) = axis.prefer {
        let sign = if prefer == PreferredSign::Positive { "positive" } else { "negative" };
        line("prefer", quoted(sign));
    }
    if axis.output != AxisFormat::STANDARD {
        line("output", output(&axis.output));
    }
}

fn output(format: &AxisFormat) -> String {
    let letter = format.letter.as_ref().map(|letter| format!("letter = {}, ", quoted(letter)));
    let modulo = match format.modulo {
        TurnFormat::Unwound => "unwound",
        TurnFormat::Positive => "positive",
        TurnFormat::Signed => "signed",
    };
    let letter = letter.unwrap_or_default();
    format!("{{ {letter}decimals = {}, modulo = {} }}", format.decimals, quoted(modulo))
}

fn write_cycle(text: &mut String, cycle: &ControlLimits) {
    let degrees = cycle.orientation_tolerance.map(f64::to_degrees);
    let entries = [
        ("servo_period", cycle.servo_period),
        ("tip_speed_max", cycle.tip_speed_max),
        ("tip_acc_max", cycle.tip_acc_max),
        ("tip_jerk_max", cycle.tip_jerk_max),
        ("contour_tolerance", cycle.contour_tolerance),
        ("orientation_tolerance", degrees),
    ];
    let given = entries.into_iter().filter_map(|(key, value)| Some((key, value?)));
    let lines: String = given.map(|(key, value)| format!("{key} = {}\n", number(value))).collect();
    if !lines.is_empty() {
        let _ = write!(text, "\n[cycle]\n{lines}");
    }
}

fn write_singular(text: &mut String, policy: &SingularPolicy) {
    let _ = write!(
        text,
        "\n[singular]\ncone = {}\nmin_rotary = {}\ntolerance = {}\n",
        number(policy.cone.to_degrees()),
        number(policy.min_rotary.to_degrees()),
        number(policy.tolerance)
    );
}

fn write_retract(text: &mut String, policy: &RetractPolicy, spec: &MachineSpec) {
    // The standard needs no table, and may name an axis that another machine does not have.
    if *policy == RetractPolicy::standard() && spec.chain.contains(&policy.axis) {
        return;
    }
    let frame = if policy.frame == RetractFrame::Machine { "machine" } else { "tool" };
    let _ = write!(
        text,
        "\n[retract]\nframe = {}\naxis = {}\nto = {}\nfirst = {}\n",
        quoted(frame),
        quoted(&policy.axis),
        number(policy.to),
        policy.first
    );
}

fn write_dialect(text: &mut String, format: &ProgramFormat) {
    let interpolation = match format.interpolation {
        AxisInterpolation::RotaryLinear => "rotary-linear",
        AxisInterpolation::GreatCircle => "great-circle",
        AxisInterpolation::Axes => "axes",
    };
    let feed = if format.feed == FeedMode::Tip { "tip" } else { "inverse-time" };
    let _ = write!(
        text,
        "\n[dialect]\nname = {}\ninterpolation = {}\nfeed = {}\n",
        quoted(&format.name),
        quoted(interpolation),
        quoted(feed)
    );
    for (name, value) in &format.strings {
        let _ = writeln!(text, "{} = {}", key(name), quoted(value));
    }
}

/// Writes a bare key, or a quoted one if it has other characters.
fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    if !name.is_empty() && name.chars().all(bare) { name.to_owned() } else { quoted(name) }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn vector(parts: [f64; 3]) -> String {
    format!("[{}]", parts.map(number).join(", "))
}

/// Writes a number without the digits that the conversion of units made up.
fn number(value: f64) -> String {
    // A conversion costs a few roundings of 1e-16: a number of 13 digits that is as near was meant.
    let short: f64 = format!("{value:.12e}").parse().unwrap_or(value);
    let value = if (short - value).abs() <= 1e-15 * value.abs() { short } else { value } + 0.0;
    if value.abs() < 1e16 { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::super::{BUILT_IN, parse};
    use super::*;
    use crate::machine::Machine;

    #[test]
    fn every_built_in_machine_is_read_back() {
        for (name, text) in BUILT_IN {
            let spec = parse(text).unwrap().spec;
            let written = write(&spec, &["a note".to_owned(), "in two\nlines".to_owned()]);
            let again =
                parse(&written).unwrap_or_else(|faults| panic!("{name}: {faults}\n{written}"));
            let [one, other] = [spec, again.spec].map(|spec| Machine::new(spec).unwrap());
            assert_eq!((&one.chain, &one.dialect), (&other.chain, &other.dialect), "{name}");
            for (a, b) in one.axes.iter().zip(&other.axes) {
                assert_eq!((&a.name, a.point, &a.output), (&b.name, b.point, &b.output));
                assert!((a.vel - b.vel).abs() <= 1e-14 * a.vel && (a.home - b.home).abs() < 1e-14);
                let cyclic = a.limits.width().is_infinite() && b.limits.width().is_infinite();
                assert!(cyclic || (a.limits.low - b.limits.low).abs() < 1e-12);
            }
            assert!(!written.contains("00000000"), "{written}");
        }
    }
}
