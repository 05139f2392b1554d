//! Everything that can be wrong with a machine, at once.

use super::spec::{AxisKind, AxisSpec, MachineSpec};
use super::{Axis, Machine};
use crate::math::angle::angle_between;
use crate::types::{AXES, ErrorList};
use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Directions closer than this \[rad\], or linear axes this near one plane, make a machine that
/// cannot be built: the condition of its inverse would be above 10^4, and calibration errors of
/// real machines are below 10^-3 rad from 90° or 45°, never near 0.
const DEGENERATE: f64 = 1e-4;

/// How far the stated period of a cyclic axis may be from one turn \[rad\]: degrees written with
/// ten digits.
const PERIOD_ROUNDING: f64 = 1e-9;

/// All errors of a machine description.
pub type MachineErrors = ErrorList<MachineError>;

/// What is wrong with a machine. [`MachineError::key`] says where in its file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineError {
    /// A word of the chain is missing, doubled, or in the wrong place.
    #[error("chain {chain:?}: {what}")]
    Chain {
        /// The chain as written.
        chain: Vec<String>,
        /// What is wrong with it, and what would be right.
        what: String,
    },
    /// The chain names an axis that is not described.
    #[error("the chain names axis {name}, but there is no [axis.{name}]")]
    MissingAxis {
        /// Name of the axis.
        name: String,
    },
    /// An axis is described but stands nowhere in the chain.
    #[error("axis {name} is described but does not stand in the chain")]
    UnusedAxis {
        /// Name of the axis.
        name: String,
    },
    /// Two axes have one name or one output letter.
    #[error("two axes are written with the letter {letter}: {first} and {second}")]
    DoubleLetter {
        /// The letter.
        letter: String,
        /// One axis.
        first: String,
        /// The other.
        second: String,
    },
    /// The chain does not have three linear and two rotary axes.
    #[error("the chain has {linear} linear and {rotary} rotary axes; it needs 3 and 2")]
    AxisCount {
        /// Linear axes in the chain.
        linear: usize,
        /// Rotary axes in the chain.
        rotary: usize,
    },
    /// A number is NaN, infinite, not positive where it must be, or otherwise senseless.
    #[error("{key} = {value}: {must}")]
    Number {
        /// Where it stands, such as `axis.B.vel`.
        key: String,
        /// The number (mm, rad, s).
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// A direction has no length.
    #[error("{key} is the zero vector; it needs a direction")]
    ZeroDirection {
        /// Where it stands.
        key: String,
    },
    /// A needed entry is left out.
    #[error("{key} is missing: {why}")]
    Missing {
        /// What is missing.
        key: String,
        /// Why it is needed.
        why: &'static str,
    },
    /// Travel with its ends in the wrong order, or of no length.
    #[error(
        "travel of axis {axis} is empty: from {} to {}; the lower end comes first",
        kind.told(*low), kind.told(*high)
    )]
    EmptyTravel {
        /// Name of the axis.
        axis: String,
        /// Linear or rotary.
        kind: AxisKind,
        /// First number \[mm or rad\].
        low: f64,
        /// Second number \[mm or rad\].
        high: f64,
    },
    /// The two rotary axes are parallel.
    #[error(
        "rotary axes {first} and {second} are parallel (angle {angle:.2e} rad): they cannot turn the tool two ways"
    )]
    ParallelRotaries {
        /// Workpiece-side axis.
        first: String,
        /// Tool-side axis.
        second: String,
        /// Angle between their lines \[rad\].
        angle: f64,
    },
    /// The tool-side rotary axis is parallel to the tool.
    #[error(
        "rotary axis {axis} is parallel to the tool axis (angle {angle:.2e} rad): turning it leaves the tool direction where it is"
    )]
    SpindleParallel {
        /// Name of the axis.
        axis: String,
        /// Angle between the lines \[rad\].
        angle: f64,
    },
    /// The three linear axes lie in one plane.
    #[error("linear axes {axes:?} lie in one plane (volume {volume:.2e} of the unit cube)")]
    CoplanarLinear {
        /// Their names.
        axes: [String; 3],
        /// Determinant of the three unit directions.
        volume: f64,
    },
}

impl MachineError {
    /// Returns what to change in the specification so that it can be used.
    pub fn remedy(&self) -> String {
        match self {
            Self::Chain { .. } | Self::AxisCount { .. } => {
                "for example chain = [\"w\", \"C\", \"B\", \"b\", \"X\", \"Y\", \"Z\", \"t\"]".into()
            }
            Self::MissingAxis { name } => format!("add [axis.{name}], or correct the name"),
            Self::UnusedAxis { name } => format!("put \"{name}\" into the chain, or remove it"),
            Self::DoubleLetter { .. } => "give one of them output.letter".into(),
            Self::ZeroDirection { .. } => "for example [0, 0, 1]".into(),
            Self::Missing { .. } => "add it".into(),
            Self::ParallelRotaries { .. } | Self::SpindleParallel { .. } => {
                "give the direction the axis has when all axes are at zero".into()
            }
            Self::CoplanarLinear { .. } => {
                "three linear axes point three ways: give the directions they have when all axes are at zero".into()
            }
            Self::EmptyTravel { .. } => "write [low, high]".into(),
            Self::Number { key, .. } if key.rsplit('.').next() == Some("sense") => {
                "leave it out if the control counts by ISO 841".into()
            }
            Self::Number { .. } => "correct the number".into(),
        }
    }

    /// Where in a machine file the fault stands: `chain`, `axis.B.limits`, `tool_axis`, ...
    pub fn key(&self) -> String {
        match self {
            Self::Chain { .. } | Self::AxisCount { .. } | Self::MissingAxis { .. } => {
                "chain".into()
            }
            Self::UnusedAxis { name } => format!("axis.{name}"),
            Self::DoubleLetter { second, .. } => format!("axis.{second}.output.letter"),
            Self::Number { key, .. } | Self::ZeroDirection { key } | Self::Missing { key, .. } => {
                key.clone()
            }
            Self::EmptyTravel { axis, .. } => format!("axis.{axis}.limits"),
            Self::ParallelRotaries { second, .. } => format!("axis.{second}.dir"),
            Self::SpindleParallel { axis, .. } => format!("axis.{axis}.dir"),
            Self::CoplanarLinear { axes, .. } => format!("axis.{}.dir", axes[2]),
        }
    }
}

/// [`Machine::new`].
pub(super) fn machine(spec: MachineSpec) -> Result<Machine, MachineErrors> {
    let mut faults = Vec::new();
    let order = chain(&spec, &mut faults);
    letters(&spec, &mut faults);
    let tool_axis = direction("tool_axis", spec.tool_axis, &mut faults);
    finite("gauge", &spec.gauge, &mut faults);
    settings(&spec, &mut faults);
    let axes: Vec<Option<Axis>> = spec.axes.iter().map(|one| axis(one, &mut faults)).collect();
    let ordered: Option<Vec<Axis>> =
        order.and_then(|order| order.iter().map(|&at| axes.get(at).cloned().flatten()).collect());
    let ordered: Option<[Axis; AXES]> = ordered.and_then(|axes| axes.try_into().ok());
    if let (Some(axes), Some(tool_axis)) = (&ordered, &tool_axis) {
        geometry(axes, tool_axis, &mut faults);
    } else {
        // What the axes are to each other can be judged without chain and tool.
        let axes: Vec<Axis> = axes.into_iter().flatten().collect();
        spread(&axes, &mut faults);
    }
    match (ordered, tool_axis) {
        (Some(axes), Some(tool_axis)) if faults.is_empty() => {
            let stage = stages(&spec.chain, &axes);
            let gauge = Point3::from(spec.gauge);
            let MachineSpec { name, chain, cycle, singular, retract, dialect, .. } = spec;
            Ok(Machine {
                name,
                axes,
                chain,
                tool_axis,
                gauge,
                cycle,
                singular,
                retract,
                dialect,
                stage,
            })
        }
        _ => Err(faults.into()),
    }
}

/// Indices of the described axes in the order X, Y, Z, first rotary, second rotary.
fn chain(spec: &MachineSpec, faults: &mut Vec<MachineError>) -> Option<[usize; AXES]> {
    let before = faults.len();
    chain_words(&spec.chain, faults);
    let names: Vec<&str> = spec
        .chain
        .iter()
        .map(String::as_str)
        .filter(|name| !matches!(*name, "w" | "b" | "t"))
        .collect();
    let mut found = Vec::new();
    for (at, name) in names.iter().enumerate() {
        match spec.axes.iter().position(|axis| axis.name == *name) {
            Some(index) if !names.iter().take(at).any(|other| other == name) => found.push(index),
            Some(_) => {}
            None => faults.push(MachineError::MissingAxis { name: (*name).to_owned() }),
        }
    }
    for axis in spec.axes.iter().filter(|axis| !names.contains(&axis.name.as_str())) {
        faults.push(MachineError::UnusedAxis { name: axis.name.clone() });
    }
    let of_kind = |kind| {
        let is = |&&index: &&usize| spec.axes.get(index).is_some_and(|axis| axis.kind == kind);
        found.iter().filter(is).copied().collect::<Vec<usize>>()
    };
    let [mut linear, rotary] = [of_kind(AxisKind::Linear), of_kind(AxisKind::Rotary)];
    if (linear.len(), rotary.len()) != (3, 2) && faults.len() == before {
        let [linear, rotary] = [linear.len(), rotary.len()];
        faults.push(MachineError::AxisCount { linear, rotary });
    }
    // X, Y, Z in this order; a quill or other name after them.
    linear.sort_by_key(|&index| {
        let name = spec.axes.get(index).map_or("", |axis| axis.name.as_str());
        (!matches!(name, "X" | "Y" | "Z"), name)
    });
    linear.extend(rotary);
    linear.try_into().ok().filter(|_| faults.len() == before)
}

/// `w` first, `t` last, one `b`, every name once.
fn chain_words(chain: &[String], faults: &mut Vec<MachineError>) {
    let mut wrong = |what: String| faults.push(MachineError::Chain { chain: chain.to_vec(), what });
    if chain.first().is_none_or(|word| word != "w") {
        wrong("it must start with \"w\", the workpiece".into());
    }
    if chain.last().is_none_or(|word| word != "t") {
        wrong("it must end with \"t\", the tool".into());
    }
    if !chain.iter().any(|word| word == "b") {
        wrong("it needs \"b\", the bed, somewhere between \"w\" and \"t\"".into());
    }
    for (at, word) in chain.iter().enumerate() {
        if chain.iter().take(at).any(|other| other == word) {
            wrong(format!("{word:?} stands in it twice"));
        }
    }
}

/// No two axes with one name or one letter.
fn letters(spec: &MachineSpec, faults: &mut Vec<MachineError>) {
    let letter = |axis: &AxisSpec| axis.output.letter.clone().unwrap_or_else(|| axis.name.clone());
    for (at, second) in spec.axes.iter().enumerate() {
        if let Some(first) = spec.axes.iter().take(at).find(|first| letter(first) == letter(second))
        {
            // Blamed is the one that states its letter: the other has it by name.
            let [first, second] =
                if second.output.letter.is_none() { [second, first] } else { [first, second] };
            faults.push(MachineError::DoubleLetter {
                letter: letter(second),
                first: first.name.clone(),
                second: second.name.clone(),
            });
        }
    }
}

/// One axis by itself.
fn axis(spec: &AxisSpec, faults: &mut Vec<MachineError>) -> Option<Axis> {
    let key = |field: &str| format!("axis.{}.{field}", spec.name);
    let dir = direction(&key("dir"), spec.dir, faults);
    let rotary = spec.kind == AxisKind::Rotary;
    match spec.point {
        Some(point) => finite(&key("point"), &point, faults),
        None if rotary => faults.push(MachineError::Missing {
            key: key("point"),
            why: "a rotary axis turns about a line",
        }),
        None => {}
    }
    let rapid = spec.rapid.unwrap_or(spec.vel);
    for (field, value) in [
        ("vel", Some(spec.vel)),
        ("rapid", spec.rapid),
        ("acc", Some(spec.acc)),
        ("jerk", Some(spec.jerk)),
    ] {
        if let Some(value) = value {
            positive(&key(field), value, faults);
        }
    }
    if spec.sense.abs().to_bits() != 1.0_f64.to_bits() {
        let must = "must be 1 (ISO 841) or -1 (reversed)";
        faults.push(MachineError::Number { key: key("sense"), value: spec.sense, must });
    }
    cyclic(spec, &key("cyclic"), faults);
    let limits = travel(spec, &key("limits"), faults);
    let home = spec.home.unwrap_or_else(|| 0.0_f64.max(limits[0]).min(limits[1]));
    if !(limits[0] <= home && home <= limits[1]) && limits[0] < limits[1] {
        let must = "must be inside the travel";
        faults.push(MachineError::Number { key: key("home"), value: home, must });
    }
    Some(Axis {
        name: spec.name.clone(),
        kind: spec.kind,
        dir: dir?,
        point: Point3::from(spec.point.filter(|_| rotary).unwrap_or_default()),
        limits,
        cyclic: spec.cyclic.is_some(),
        vel: spec.vel,
        rapid,
        acc: spec.acc,
        jerk: spec.jerk,
        sense: spec.sense,
        home,
        prefer: spec.prefer,
        output: spec.output.clone(),
    })
}

fn cyclic(spec: &AxisSpec, key: &str, faults: &mut Vec<MachineError>) {
    let Some(value) = spec.cyclic else { return };
    let must = if spec.kind == AxisKind::Linear {
        "a linear axis cannot be cyclic"
    } else if (value - TAU).abs() <= PERIOD_ROUNDING {
        return;
    } else {
        "the period of a rotary axis is one turn, 360 deg"
    };
    faults.push(MachineError::Number { key: key.to_owned(), value, must });
}

fn travel(spec: &AxisSpec, key: &str, faults: &mut Vec<MachineError>) -> [f64; 2] {
    const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    match spec.limits {
        Some([low, high]) if low < high => {
            finite(key, &[low, high], faults);
            [low, high]
        }
        Some([low, high]) => {
            faults.push(MachineError::EmptyTravel {
                axis: spec.name.clone(),
                kind: spec.kind,
                low,
                high,
            });
            FREE
        }
        None if spec.cyclic.is_some() => FREE,
        None => {
            let why = "only a cyclic axis has no ends of travel";
            faults.push(MachineError::Missing { key: key.to_owned(), why });
            FREE
        }
    }
}

/// Directions against each other.
fn geometry(axes: &[Axis; AXES], tool: &UnitVector3<f64>, faults: &mut Vec<MachineError>) {
    let [_, _, _, _, second] = axes;
    spread(axes, faults);
    let angle = line_angle(&second.dir, tool);
    if angle < DEGENERATE {
        faults.push(MachineError::SpindleParallel { axis: second.name.clone(), angle });
    }
}

/// Whether three linear axes span the space, and two rotary axes are not parallel; more or fewer are
/// not judged.
fn spread(axes: &[Axis], faults: &mut Vec<MachineError>) {
    let of_kind = |kind| axes.iter().filter(move |axis| axis.kind == kind).collect::<Vec<_>>();
    if let [x, y, z] = of_kind(AxisKind::Linear)[..] {
        let volume = Matrix3::from_columns(&[*x.dir, *y.dir, *z.dir]).determinant();
        if volume.abs() < DEGENERATE {
            let axes = [x, y, z].map(|axis| axis.name.clone());
            faults.push(MachineError::CoplanarLinear { axes, volume });
        }
    }
    if let [first, second] = of_kind(AxisKind::Rotary)[..] {
        let angle = line_angle(&first.dir, &second.dir);
        if angle < DEGENERATE {
            let [first, second] = [first, second].map(|axis| axis.name.clone());
            faults.push(MachineError::ParallelRotaries { first, second, angle });
        }
    }
}

/// Angle between two lines \[rad\], in `[0, π/2]`.
fn line_angle(u: &UnitVector3<f64>, v: &UnitVector3<f64>) -> f64 {
    let angle = angle_between(u, v);
    angle.min(std::f64::consts::PI - angle)
}

/// How many rotaries stand between the workpiece and each of X, Y, Z.
fn stages(chain: &[String], axes: &[Axis; AXES]) -> [usize; 3] {
    let place = |axis: &Axis| chain.iter().position(|word| *word == axis.name);
    let [x, y, z, first, second] = axes;
    [x, y, z]
        .map(|linear| [first, second].iter().filter(|rotary| place(rotary) < place(linear)).count())
}

fn settings(spec: &MachineSpec, faults: &mut Vec<MachineError>) {
    let cycle = &spec.cycle;
    for (key, value) in [
        ("cycle.servo_period", cycle.servo_period),
        ("cycle.tip_speed_max", cycle.tip_speed_max),
        ("cycle.tip_acc_max", cycle.tip_acc_max),
        ("cycle.tip_jerk_max", cycle.tip_jerk_max),
        ("cycle.contour_tolerance", cycle.contour_tolerance),
        ("cycle.orientation_tolerance", cycle.orientation_tolerance),
        ("singular.cone", Some(spec.singular.cone)),
        ("singular.min_rotary", Some(spec.singular.min_rotary)),
        ("singular.tolerance", Some(spec.singular.tolerance)),
    ] {
        if let Some(value) = value {
            positive(key, value, faults);
        }
    }
    finite("retract.to", &[spec.retract.to], faults);
}

fn direction(key: &str, v: [f64; 3], faults: &mut Vec<MachineError>) -> Option<UnitVector3<f64>> {
    let before = faults.len();
    finite(key, &v, faults);
    let unit = UnitVector3::try_new(Vector3::from(v), f64::MIN_POSITIVE);
    if unit.is_none() && faults.len() == before {
        faults.push(MachineError::ZeroDirection { key: key.to_owned() });
    }
    unit.filter(|_| faults.len() == before)
}

fn finite(key: &str, values: &[f64], faults: &mut Vec<MachineError>) {
    for &value in values.iter().filter(|value| !value.is_finite()) {
        faults.push(MachineError::Number {
            key: key.to_owned(),
            value,
            must: "must be a finite number",
        });
    }
}

fn positive(key: &str, value: f64, faults: &mut Vec<MachineError>) {
    if !(value > 0.0 && value.is_finite()) {
        let must = "must be a finite number above zero";
        faults.push(MachineError::Number { key: key.to_owned(), value, must });
    }
}
