//! Checks of a machine description. They report all errors at once.

use super::checked::{Axis, Machine};
use super::error::{MachineError, MachineErrors};
use super::links;
use super::spec::{AxisKind, AxisSpec, MachineSpec};
use crate::math::angle::angle_between;
use crate::types::{AXES, Interval};
use nalgebra::{Matrix3, Point3, UnitVector3, Vector3};
use std::f64::consts::TAU;

/// Directions closer than this \[rad\], or linear axes this near one plane, make a machine that
/// cannot be built: the condition of its inverse would be above 10^4, and calibration errors of
/// real machines are below 10^-3 rad from 90° or 45°, never near 0.
const DEGENERATE: f64 = 1e-4;

/// Tolerance on the stated period of a cyclic axis against one turn \[rad\]: degrees written with ten
/// digits.
const PERIOD_ROUNDING: f64 = 1e-9;

impl Machine {
    /// Checks a machine.
    ///
    /// # Errors
    ///
    /// All errors of the specification, in its order.
    pub fn new(spec: MachineSpec) -> Result<Self, MachineErrors> {
        machine(spec)
    }
}

/// Runs all checks, and builds the machine if none fails.
fn machine(spec: MachineSpec) -> Result<Machine, MachineErrors> {
    let mut faults = Vec::new();
    let order = chain(&spec, &mut faults);
    letters(&spec, &mut faults);
    let tool_axis = direction("tool_axis", spec.tool_axis, &mut faults);
    finite("gauge", &spec.gauge, &mut faults);
    settings(&spec, &mut faults);
    links::bodies(&spec, &mut faults);
    let axes: Vec<Option<Axis>> = spec.axes.iter().map(|one| axis(one, &mut faults)).collect();
    let ordered: Option<Vec<Axis>> =
        order.and_then(|order| order.iter().map(|&at| axes.get(at).cloned().flatten()).collect());
    let ordered: Option<[Axis; AXES]> = ordered.and_then(|axes| axes.try_into().ok());
    // Geometry is checked on what could be built, so that one report has every error.
    if let (Some(axes), Some(tool_axis)) = (&ordered, &tool_axis) {
        geometry(axes, tool_axis, &mut faults);
    } else {
        // The angles between the axes can be checked without chain and tool.
        let axes: Vec<Axis> = axes.into_iter().flatten().collect();
        spread(&axes, &mut faults);
    }
    match (ordered, tool_axis) {
        (Some(axes), Some(tool_axis)) if faults.is_empty() => {
            let stage = stages(&spec.chain, &axes);
            let gauge = Point3::from(spec.gauge);
            let MachineSpec { name, chain, cycle, singular, retract, dialect, bodies, .. } = spec;
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
                bodies,
                stage,
            })
        }
        _ => Err(faults.into()),
    }
}

/// Returns the indices of the described axes in the order X, Y, Z, first rotary, second rotary.
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
            // A name that the chain has twice is reported by `chain_words`.
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
    // With other errors in the chain the counts would only repeat them.
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

/// Checks that the chain has `w` first, `t` last, one `b`, and every name once.
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
            wrong(format!("{word:?} is in it twice"));
        }
    }
}

/// Checks that no two axes share a name or a letter.
fn letters(spec: &MachineSpec, faults: &mut Vec<MachineError>) {
    let letter = |axis: &AxisSpec| axis.output.letter.clone().unwrap_or_else(|| axis.name.clone());
    for (at, second) in spec.axes.iter().enumerate() {
        if let Some(first) = spec.axes.iter().take(at).find(|first| letter(first) == letter(second))
        {
            // Blame the axis that states its letter: the other has it by name.
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

/// Checks one axis by itself.
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
    // Exactly 1 or -1: the sense is a factor of directions, which have to stay unit vectors.
    if spec.sense.abs().to_bits() != 1.0_f64.to_bits() {
        let must = "must be 1 (ISO 841) or -1 (reversed)";
        faults.push(MachineError::Number { key: key("sense"), value: spec.sense, must });
    }
    cyclic(spec, &key("cyclic"), faults);
    let limits = travel(spec, &key("limits"), faults);
    // Preset home: 0, or the end of travel next to it.
    let home = spec.home.unwrap_or_else(|| limits.clamp(0.0));
    // An empty travel is an error of its own; no home is inside it.
    if !limits.contains(home) && limits.low < limits.high {
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

/// Checks that only a rotary axis is cyclic, with a period of one turn.
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

/// Checks the travel of an axis; unlimited where it is missing or wrong, so that no further error follows
/// from it.
fn travel(spec: &AxisSpec, key: &str, faults: &mut Vec<MachineError>) -> Interval {
    match spec.limits {
        Some(limits) if limits.low < limits.high => {
            finite(key, &limits.ends(), faults);
            limits
        }
        Some(Interval { low, high }) => {
            faults.push(MachineError::EmptyTravel {
                axis: spec.name.clone(),
                kind: spec.kind,
                low,
                high,
            });
            Interval::UNBOUNDED
        }
        None if spec.cyclic.is_some() => Interval::UNBOUNDED,
        None => {
            let why = "only a cyclic axis has no ends of travel";
            faults.push(MachineError::Missing { key: key.to_owned(), why });
            Interval::UNBOUNDED
        }
    }
}

/// Checks the directions against each other.
fn geometry(axes: &[Axis; AXES], tool: &UnitVector3<f64>, faults: &mut Vec<MachineError>) {
    let [_, _, _, _, second] = axes;
    spread(axes, faults);
    let angle = line_angle(&second.dir, tool);
    if angle < DEGENERATE {
        faults.push(MachineError::SpindleParallel { axis: second.name.clone(), angle });
    }
}

/// Checks that three linear axes span the space, and that two rotary axes are not parallel.
///
/// More or fewer axes are not checked.
fn spread(axes: &[Axis], faults: &mut Vec<MachineError>) {
    let of_kind = |kind| axes.iter().filter(move |axis| axis.kind == kind).collect::<Vec<_>>();
    if let [x, y, z] = of_kind(AxisKind::Linear)[..] {
        // Volume of the unit directions: the sine of the angle between one axis and the plane of the others,
        // times that between those two.
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

/// Returns the angle between two lines \[rad\], in `[0, π/2]`.
fn line_angle(u: &UnitVector3<f64>, v: &UnitVector3<f64>) -> f64 {
    // Lines have no sense: an angle above 90 degrees is that of the opposite direction.
    let angle = angle_between(u, v);
    angle.min(std::f64::consts::PI - angle)
}

/// Counts the rotaries between the workpiece and each of X, Y, Z.
fn stages(chain: &[String], axes: &[Axis; AXES]) -> [usize; 3] {
    // A rotary turns a linear axis if it stands nearer to the workpiece in the chain.
    let place = |axis: &Axis| chain.iter().position(|word| *word == axis.name);
    let [x, y, z, first, second] = axes;
    [x, y, z]
        .map(|linear| [first, second].iter().filter(|rotary| place(rotary) < place(linear)).count())
}

/// Checks the limits of the control and the policies.
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

/// Returns a direction as a unit vector; `None` if it is zero or not finite, which is reported.
fn direction(key: &str, v: [f64; 3], faults: &mut Vec<MachineError>) -> Option<UnitVector3<f64>> {
    let before = faults.len();
    finite(key, &v, faults);
    // Only one error for one entry: a zero vector is reported if its numbers are finite.
    let unit = UnitVector3::try_new(Vector3::from(v), f64::MIN_POSITIVE);
    if unit.is_none() && faults.len() == before {
        faults.push(MachineError::ZeroDirection { key: key.to_owned() });
    }
    unit.filter(|_| faults.len() == before)
}

/// Reports the numbers that are not finite.
fn finite(key: &str, values: &[f64], faults: &mut Vec<MachineError>) {
    for &value in values.iter().filter(|value| !value.is_finite()) {
        faults.push(MachineError::Number {
            key: key.to_owned(),
            value,
            must: "must be a finite number",
        });
    }
}

/// Reports a number that is not finite and positive.
fn positive(key: &str, value: f64, faults: &mut Vec<MachineError>) {
    if !(value > 0.0 && value.is_finite()) {
        let must = "must be a finite number above zero";
        faults.push(MachineError::Number { key: key.to_owned(), value, must });
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{ac_trunnion, axis};
    use super::*;

    #[test]
    fn all_faults_are_reported_at_once() {
        let mut spec = ac_trunnion();
        spec.axes[0].dir = [0.0; 3];
        spec.axes[1].limits = Some(Interval::new(1.0, -1.0));
        spec.axes[2].vel = f64::NAN;
        spec.axes[3].point = None;
        spec.axes[4].sense = 0.5;
        spec.axes[4].limits = None;
        spec.chain = ["C", "A", "X", "X", "Y", "Q"].map(str::to_owned).to_vec();
        let keys: Vec<String> =
            Machine::new(spec).unwrap_err().iter().map(MachineError::key).collect();
        assert_eq!(
            keys,
            [
                "chain",
                "chain",
                "chain",
                "chain",
                "chain",
                "axis.Z",
                "axis.X.dir",
                "axis.Y.limits",
                "axis.Z.vel",
                "axis.C.point",
                "axis.A.sense",
                "axis.A.limits"
            ]
        );
    }

    #[test]
    fn degenerate_directions_are_named() {
        let mut spec = ac_trunnion();
        spec.axes[2].dir = [1.0, 1.0, 0.0];
        spec.axes[4].dir = [0.0, 1e-6, -1.0];
        let faults = Machine::new(spec).unwrap_err();
        assert!(matches!(faults[0], MachineError::CoplanarLinear { .. }));
        assert!(matches!(faults[1], MachineError::ParallelRotaries { .. }));
        assert!(matches!(faults[2], MachineError::SpindleParallel { .. }));
        assert_eq!(faults.len(), 3);
    }

    #[test]
    fn an_axis_needs_a_direction() {
        for axis in [1, 3, 4] {
            let mut spec = ac_trunnion();
            spec.axes[axis].dir = [0.0; 3];
            let key = format!("axis.{}.dir", spec.axes[axis].name);
            assert_eq!(Machine::new(spec).unwrap_err(), [MachineError::ZeroDirection { key }]);
        }
    }

    #[test]
    fn a_chain_needs_workpiece_and_tool() {
        let reported = |drop: &str| {
            let mut spec = ac_trunnion();
            spec.chain.retain(|word| word != drop);
            let faults = Machine::new(spec).unwrap_err();
            assert_eq!(faults.len(), 1, "{faults:?}");
            faults[0].to_string()
        };
        assert!(reported("w").ends_with("it must start with \"w\", the workpiece"));
        assert!(reported("t").ends_with("it must end with \"t\", the tool"));
        assert!(reported("b").contains("it needs \"b\", the bed"));
    }

    #[test]
    fn empty_travel_is_reported_in_its_unit() {
        let mut spec = ac_trunnion();
        spec.axes[0].limits = Some(Interval::new(1.0, -1.0));
        spec.axes[4].limits = Some(Interval::new(std::f64::consts::PI, 0.0));
        let faults = Machine::new(spec).unwrap_err();
        let reported: Vec<String> = faults.iter().map(ToString::to_string).collect();
        assert!(
            reported[0].contains("axis X is empty: from 1.0000 mm to -1.0000 mm"),
            "{reported:?}"
        );
        assert!(
            reported[1].contains("axis A is empty: from 180.0000 deg to 0.0000 deg"),
            "{reported:?}"
        );
    }

    #[test]
    fn two_axes_with_one_letter_are_refused() {
        let mut spec = ac_trunnion();
        spec.axes[4].output.letter = Some("C".to_owned());
        let faults = Machine::new(spec).unwrap_err();
        assert!(
            matches!(&faults[..], [MachineError::DoubleLetter { letter, .. }] if letter == "C")
        );
        let mut spec = ac_trunnion();
        spec.axes.push(axis("X", AxisKind::Linear, [1.0, 0.0, 0.0]));
        assert!(Machine::new(spec).is_err());
    }

    #[test]
    fn axes_stand_in_order_whatever_the_file_says() {
        let mut spec = ac_trunnion();
        spec.axes.reverse();
        let machine = Machine::new(spec).unwrap();
        assert_eq!(
            machine.axes.each_ref().map(|axis| axis.name.as_str()),
            ["X", "Y", "Z", "C", "A"]
        );
    }
}
