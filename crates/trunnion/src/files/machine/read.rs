//! From the layout to a checked machine: units, and errors of the whole machine at their lines.

use super::super::document::Document;
use super::super::places::KeyPositions;
use super::super::schema;
use super::super::walk::nearest;
use super::body::{BodyScale, bodies};
use super::layout::LAYOUT;
use super::raw::{
    RawAngle, RawAxis, RawCycle, RawDialect, RawFeed, RawFrame, RawInterpolation, RawKind,
    RawLength, RawModulo, RawOutput, RawPrefer, RawRetract, RawSingular, RawTime, RawUnits,
};
use crate::machine::{
    AxisFormat, AxisInterpolation, AxisKind, AxisSpec, ControlLimits, FeedMode, Machine,
    MachineError, MachineSpec, PreferredSign, ProgramFormat, RetractFrame, RetractPolicy,
    SingularPolicy, TurnFormat,
};
use crate::types::{Diagnostic, Diagnostics, Interval};
use std::f64::consts::TAU;

/// Machine file that was read and checked.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MachineFile {
    /// Checked machine.
    pub machine: Machine,
    /// Content of the file in mm, rad, s.
    pub spec: MachineSpec,
    /// Positions of the keys in the file.
    pub places: KeyPositions,
}

/// Reads a machine file and checks the machine as a whole.
///
/// # Errors
///
/// Every fault that was found, in order of lines.
///
/// # Example
///
/// ```
/// use trunnion::files::machine::{built_in, parse};
///
/// let text = built_in("bc-trunnion").map_err(|nearest| format!("did you mean {nearest:?}?"))?;
/// let machine = parse(text).map_err(|faults| faults.to_string())?.machine;
/// assert_eq!(machine.axes.map(|axis| axis.name), ["X", "Y", "Z", "C", "B"]);
/// # Ok::<(), String>(())
/// ```
pub fn parse(text: &str) -> Result<MachineFile, Diagnostics> {
    let mut doc = Document::open(text, LAYOUT, &schema::machine_value())?;
    let found = sections(&mut doc);
    let spec = found.as_ref().map(|found| found.spec.clone());
    let machine = found.and_then(|found| match Machine::new(found.spec.clone()) {
        Ok(machine) => Some(machine),
        Err(errors) => {
            blame(&errors, &found, &mut doc);
            None
        }
    });
    let places = doc.finish()?;
    match (machine, spec) {
        (Some(machine), Some(spec)) => Ok(MachineFile { machine, spec, places }),
        _ => Err(Diagnostic::whole("the machine file cannot be read").into()),
    }
}

/// Readable part of a file. In a faulty file, neutral values replace the rest, so that everything else
/// is checked too.
struct Found {
    spec: MachineSpec,
    /// Axes that are described but could not be read.
    unread: Vec<String>,
    has_chain: bool,
}

/// Reports errors of the whole machine at the keys that cause them.
fn blame(errors: &[MachineError], found: &Found, doc: &mut Document<'_>) {
    for error in errors {
        // An error that follows from a fault that is reported already would confuse.
        let reported = match error {
            MachineError::MissingAxis { name } => found.unread.contains(name),
            MachineError::UnusedAxis { .. } => !found.has_chain,
            // A missing key may be the one that a misspelt key was meant to be.
            MachineError::Missing { key, .. } => {
                key.rsplit_once('.').is_some_and(|(table, _)| doc.is_misspelt(table))
            }
            _ => false,
        };
        let key = error.key();
        if !reported && !doc.is_faulty(&key) {
            doc.fault(&key, error.to_string(), error.remedy());
        }
    }
}

/// Tool axis for files that state none: parallel to no axis that anyone builds, so that no error
/// about parallel axes follows from it.
const NO_TOOL_AXIS: [f64; 3] = [0.123, 0.456, 0.789];

fn sections(doc: &mut Document<'_>) -> Option<Found> {
    let units = doc.or_default::<RawUnits>("units").map(Scale::new);
    // Where the units cannot be read, the rest is still checked, in mm, deg and s.
    let scale = units.unwrap_or(Scale::new(RawUnits::default()));
    let name = doc.section::<String>("name");
    let chain = doc.section::<Vec<String>>("chain");
    let tool_axis = doc.section::<[f64; 3]>("tool_axis");
    let gauge = doc.section::<[f64; 3]>("gauge");
    let axes = doc.tables::<RawAxis>("axis").map(|(axes, unread)| {
        for (name, axis) in &axes {
            in_file_units(name, axis, units, doc);
        }
        let axes: Vec<AxisSpec> =
            axes.into_iter().map(|(name, axis)| scale.axis(name, axis)).collect();
        (axes, unread)
    });
    let cycle = doc.or_default::<RawCycle>("cycle").map(|raw| scale.cycle(&raw));
    let singular = doc.or_default::<RawSingular>("singular").map(|raw| scale.singular(&raw));
    let raw_retract = doc.or_default::<RawRetract>("retract");
    // Kept in the units of the file for the message; the policy below is in mm.
    let to = raw_retract.as_ref().and_then(|raw| raw.to);
    let retract = raw_retract.map(|raw| scale.retract(raw));
    let raw_dialect = doc.or_default::<RawDialect>("dialect").unwrap_or_default();
    let dialect = dialect(raw_dialect, doc);
    if let (Some(RetractPolicy { frame: RetractFrame::Machine, axis, .. }), Some(chain)) =
        (&retract, &chain)
        && !chain.contains(axis)
    {
        let message = format!("the retracting axis {axis} is not in the chain");
        doc.fault("retract.axis", message, "name a linear axis of the chain");
    }
    let bodies = bodies(BodyScale { length: scale.length, angle: scale.angle }, doc);
    // Without axes there is no machine to judge: everything else has been reported above.
    let (axes, unread) = axes?;
    if let Some(retract) = &retract {
        retracting(retract, to, &axes, doc);
    }
    let has_chain = chain.is_some();
    let spec = MachineSpec {
        name: name.unwrap_or_default(),
        chain: chain.unwrap_or_default(),
        tool_axis: tool_axis.unwrap_or(NO_TOOL_AXIS),
        gauge: gauge.unwrap_or_default().map(|value| value * scale.length),
        axes,
        cycle: cycle.unwrap_or_default(),
        singular: singular.unwrap_or(SingularPolicy::STANDARD),
        retract: retract.unwrap_or_else(RetractPolicy::standard),
        dialect,
        bodies: bodies?,
    };
    // With unreadable units every number may be wrong by a factor: the whole is not judged.
    units.map(|_| Found { spec, unread, has_chain })
}

/// Checks the retracting axis and its position, in the units of the file.
fn retracting(retract: &RetractPolicy, to: Option<f64>, axes: &[AxisSpec], doc: &mut Document<'_>) {
    let of_machine = retract.frame == RetractFrame::Machine;
    let found = axes.iter().find(|axis| of_machine && axis.name == retract.axis);
    let Some(axis) = found else { return };
    if axis.kind == AxisKind::Rotary {
        let message = format!("the retracting axis {} is a rotary axis", axis.name);
        doc.fault("retract.axis", message, "name a linear axis of the chain");
    } else if let (Some(to), Some([low, high])) = (to, axis.limits.map(Interval::ends))
        && !(low..=high).contains(&retract.to)
        // An empty travel has its own fault.
        && low < high
    {
        let message = format!("the retract goes to {to}, outside the travel of {}", axis.name);
        doc.fault("retract.to", message, "give a position inside its limits");
    }
}

/// Checks travel and period in the units of the file: in radians users would not recognise their
/// numbers.
fn in_file_units(name: &str, axis: &RawAxis, units: Option<Scale>, doc: &mut Document<'_>) {
    let key = |field: &str| format!("axis.{name}.{field}");
    if let (Some(period), RawKind::Rotary, Some(scale)) = (axis.cyclic, axis.kind, units) {
        let turns = period * scale.angle / TAU;
        // Far from one turn; the fine comparison is the machine's.
        if (turns - 1.0).abs() > 1e-3 {
            let message = format!("axis {name} has the period {period}, which is {turns} turns");
            let help = format!("the period of a rotary axis is one turn: {}", TAU / scale.angle);
            doc.fault(&key("cyclic"), message, help);
        }
    }
    let Some([low, high]) = axis.limits else { return };
    if low >= high {
        let message = format!("travel of axis {name} is empty: [{low}, {high}]");
        doc.fault(&key("limits"), message, "the lower end comes first");
    } else if let Some(home) = axis.home
        && !(low..=high).contains(&home)
    {
        let message = format!("home {home} of axis {name} is outside its travel [{low}, {high}]");
        doc.fault(&key("home"), message, "put it inside, or leave it out");
    }
}

/// Factors from the units of the file to mm, rad, s.
#[derive(Debug, Clone, Copy)]
struct Scale {
    length: f64,
    angle: f64,
    time: f64,
}

impl Scale {
    fn new(units: RawUnits) -> Self {
        Self {
            length: match units.length {
                RawLength::Mm => 1.0,
                RawLength::Inch => 25.4,
            },
            angle: match units.angle {
                RawAngle::Deg => 1.0_f64.to_radians(),
                RawAngle::Rad => 1.0,
            },
            time: match units.time {
                RawTime::S => 1.0,
                RawTime::Min => 60.0,
            },
        }
    }

    fn axis(self, name: String, raw: RawAxis) -> AxisSpec {
        let (kind, unit) = match raw.kind {
            RawKind::Linear => (AxisKind::Linear, self.length),
            RawKind::Rotary => (AxisKind::Rotary, self.angle),
        };
        // A rate of order n is in units per timeⁿ.
        let per_time = |order: i32| unit / self.time.powi(order);
        AxisSpec {
            name,
            kind,
            dir: raw.dir,
            point: raw.point.map(|point| point.map(|value| value * self.length)),
            limits: raw.limits.map(|limits| Interval::from(limits).scaled(unit)),
            cyclic: raw.cyclic.map(|value| value * unit),
            vel: raw.vel * per_time(1),
            rapid: raw.rapid.map(|value| value * per_time(1)),
            acc: raw.acc * per_time(2),
            jerk: raw.jerk * per_time(3),
            sense: raw.sense,
            home: raw.home.map(|value| value * unit),
            prefer: raw.prefer.map(|prefer| match prefer {
                RawPrefer::Positive => PreferredSign::Positive,
                RawPrefer::Negative => PreferredSign::Negative,
            }),
            output: output(raw.output),
        }
    }

    fn cycle(self, raw: &RawCycle) -> ControlLimits {
        let speed = |value: Option<f64>, order: i32| {
            value.map(|value| value * self.length / self.time.powi(order))
        };
        ControlLimits {
            servo_period: raw.servo_period.map(|value| value * self.time),
            tip_speed_max: speed(raw.tip_speed_max, 1),
            tip_acc_max: speed(raw.tip_acc_max, 2),
            tip_jerk_max: speed(raw.tip_jerk_max, 3),
            contour_tolerance: speed(raw.contour_tolerance, 0),
            orientation_tolerance: raw.orientation_tolerance.map(|value| value * self.angle),
        }
    }

    fn singular(self, raw: &RawSingular) -> SingularPolicy {
        let SingularPolicy { cone, min_rotary, tolerance } = SingularPolicy::STANDARD;
        SingularPolicy {
            cone: raw.cone.map_or(cone, |value| value * self.angle),
            min_rotary: raw.min_rotary.map_or(min_rotary, |value| value * self.angle),
            tolerance: raw.tolerance.map_or(tolerance, |value| value * self.length),
        }
    }

    fn retract(self, raw: RawRetract) -> RetractPolicy {
        let standard = RetractPolicy::standard();
        RetractPolicy {
            frame: match raw.frame {
                None => standard.frame,
                Some(RawFrame::Machine) => RetractFrame::Machine,
                Some(RawFrame::Tool) => RetractFrame::Tool,
            },
            axis: raw.axis.unwrap_or(standard.axis),
            to: raw.to.map_or(standard.to, |value| value * self.length),
            first: raw.first.unwrap_or(standard.first),
        }
    }
}

fn output(raw: RawOutput) -> AxisFormat {
    AxisFormat {
        letter: raw.letter,
        decimals: raw.decimals.unwrap_or(AxisFormat::STANDARD.decimals),
        modulo: match raw.modulo {
            RawModulo::Unwound => TurnFormat::Unwound,
            RawModulo::Positive => TurnFormat::Positive,
            RawModulo::Signed => TurnFormat::Signed,
        },
    }
}

fn dialect(raw: RawDialect, doc: &mut Document<'_>) -> ProgramFormat {
    // Any key is a text for templates, but one that is nearly a known key is a misspelling of it.
    for key in raw.strings.keys() {
        if let Some(nearest) = nearest(key, &["name", "interpolation", "feed", "tcp_on", "tcp_off"])
            && nearest != key
        {
            let message = format!("unknown key `{key}` in [dialect]");
            doc.fault(&format!("dialect.{key}"), message, format!("did you mean `{nearest}`?"));
        }
    }
    ProgramFormat {
        name: raw.name,
        interpolation: match raw.interpolation {
            RawInterpolation::RotaryLinear => AxisInterpolation::RotaryLinear,
            RawInterpolation::GreatCircle => AxisInterpolation::GreatCircle,
            RawInterpolation::Axes => AxisInterpolation::Axes,
        },
        feed: match raw.feed {
            RawFeed::Tip => FeedMode::Tip,
            RawFeed::InverseTime => FeedMode::InverseTime,
        },
        strings: raw.strings,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MACHINE: &str = r#"schema = "trunnion-machine/1"
name = "small"
chain = ["w", "C", "A", "b", "X", "Y", "Z", "t"]
tool_axis = [0, 0, 1]
gauge = [0, 0, 0]
[axis]
X = { kind = "linear", dir = [1, 0, 0], limits = [-4, 4], vel = 100, acc = 200, jerk = 300 }
Y = { kind = "linear", dir = [0, 1, 0], limits = [-4, 4], vel = 100, acc = 200, jerk = 300 }
Z = { kind = "linear", dir = [0, 0, 1], limits = [-4, 4], vel = 100, acc = 200, jerk = 300 }
A = { kind = "rotary", dir = [1, 0, 0], point = [0, 0, 1], limits = [-90, 90], vel = 180, acc = 3, jerk = 4 }
C = { kind = "rotary", dir = [0, 0, 1], point = [0, 0, 0], cyclic = 360, vel = 180, acc = 3, jerk = 4 }
"#;

    fn faults(text: &str) -> Vec<String> {
        let faults = parse(text).err().unwrap_or_else(|| panic!("no fault in\n{text}"));
        faults.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn degrees_become_radians() {
        let file = parse(MACHINE).unwrap();
        let names: Vec<&str> = file.machine.axes.iter().map(|axis| axis.name.as_str()).collect();
        assert_eq!(names, ["X", "Y", "Z", "C", "A"]);
        let [.., a] = &file.machine.axes;
        assert!((a.vel - std::f64::consts::PI).abs() < 1e-15);
        assert!((a.limits.high - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!(file.places.get("axis.A.vel").line, 10);
    }

    #[test]
    fn inches_and_minutes_scale_every_length_and_rate() {
        let text = MACHINE.replace(
            "gauge = [0, 0, 0]",
            "gauge = [0, 0, 1]\nunits = { length = \"inch\", angle = \"rad\", time = \"min\" }",
        );
        let text = text.replace("[-90, 90]", "[-1, 1]").replace("360", "6.283185307179586");
        let machine = parse(&text).unwrap().machine;
        let [x, .., a] = &machine.axes;
        assert!((machine.gauge.z - 25.4).abs() < 1e-12);
        assert!((x.jerk - 300.0 * 25.4 / 216_000.0).abs() < 1e-12);
        assert!((a.vel - 3.0).abs() < 1e-12);
    }

    #[test]
    fn faults_of_the_whole_machine_have_lines_too() {
        for (line, by, expected) in [
            ("\"A\", \"b\"", "\"b\"", "10:1: axis A is described but is not in the chain"),
            (
                "dir = [1, 0, 0], point",
                "dir = [0, 0, 1], point",
                "10:30: rotary axes C and A are parallel",
            ),
            (
                "limits = [-90, 90]",
                "limits = [90, -90]",
                "10:69: travel of axis A is empty: [90, -90]",
            ),
            (
                "jerk = 300 }\nY",
                "jerk = 300, rapd = 3 }\nY",
                "7:93: unknown key `rapd` in [axis.X]",
            ),
            ("[axis]", "[retract]\naxis = \"W\"\n[axis]", "7:8: the retracting axis W"),
        ] {
            assert!(MACHINE.contains(line), "{line}");
            let found = faults(&MACHINE.replacen(line, by, 1));
            assert!(found.iter().any(|fault| fault.starts_with(expected)), "{by}: {found:#?}");
        }
    }

    #[test]
    fn a_key_that_is_nearly_right_is_no_editable_text() {
        let text = format!("{MACHINE}[dialect]\nmacro = \"M3\"\ninterpolaton = \"axes\"\n");
        let found = faults(&text);
        assert!(found.len() == 1 && found[0].starts_with("14:16: unknown key"), "{found:#?}");
        let text = text.replace("interpolaton", "interpolation");
        assert_eq!(parse(&text).unwrap().machine.dialect.strings["macro"], "M3");
    }
}
