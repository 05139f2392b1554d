//! Figures of a machine in the units of `LinuxCNC`: mm, degrees, seconds.

use super::args::Planner;
use crate::outcome::Failure;
use trunnion::machine::{Axis, AxisKind, FIRST_ROTARY, Kinematics, Machine, Setup};
use trunnion::nalgebra::Vector3;
use trunnion::nc::read::AxisWords;

/// Servo period of a machine that states none \[s\]: the usual one of the control.
const SERVO_PERIOD: f64 = 0.001;

/// Longest tool that the travel of the tool tip allows for \[mm\].
const LONGEST_TOOL: f64 = 500.0;

/// Steps to which the travel of the tool tip is rounded up \[mm\].
const TIP_STEP: f64 = 100.0;

/// Largest component of a direction that still counts as parallel to the machine frame.
const PARALLEL: f64 = 1e-12;

/// Machine as a configuration states it.
#[derive(Debug)]
pub(super) struct Configuration {
    /// Name of the machine, and stem of the files.
    pub(super) name: String,
    /// Joints in the order of their numbers.
    pub(super) joints: Vec<Joint>,
    /// Servo period \[s\].
    pub(super) period: f64,
    /// Bound on every coordinate of the tool tip with tool-centre-point control \[mm\].
    pub(super) tip_travel: f64,
    /// Length of tool 1 \[mm\].
    pub(super) tool_length: f64,
    /// All linear axes count along the machine frame.
    pub(super) parallel: bool,
    /// Planner of the motion.
    pub(super) planner: Planner,
}

/// One joint, in mm or degrees.
#[derive(Debug, Clone, serde::Serialize)]
pub(super) struct Joint {
    pub(super) letter: char,
    #[serde(rename = "rotary", serialize_with = "write_is_rotary")]
    pub(super) kind: AxisKind,
    /// Lower end of travel; `None` without end.
    pub(super) low: Option<f64>,
    pub(super) high: Option<f64>,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    pub(super) home: f64,
}

impl Configuration {
    pub(super) fn of(
        machine: &Machine,
        tool_length: f64,
        planner: Planner,
    ) -> Result<Self, Failure> {
        let letters = letters(machine)?;
        let mut joints: Vec<Joint> = letters
            .into_iter()
            .zip(&machine.axes)
            .map(|(letter, axis)| joint(letter, axis))
            .collect();
        // LinuxCNC's own five-axis machines have their rotaries in the order of letters.
        joints.sort_by_key(|joint| (joint.kind == AxisKind::Rotary, joint.letter));
        let tip_travel = tip_bound(machine);
        if !(tool_length.is_finite() && tool_length.abs() <= LONGEST_TOOL) {
            return Err(Failure::input(format!(
                "--tool-length {tool_length}: the length of a tool is at most {LONGEST_TOOL} mm\n  \
                 help: give the distance from the gauge line to the tip; a longer tool belongs into the tool table"
            )));
        }
        Ok(Self {
            name: stem(&machine.name),
            joints,
            period: machine.cycle.servo_period.unwrap_or(SERVO_PERIOD),
            tip_travel: (tip_travel / TIP_STEP).ceil() * TIP_STEP,
            tool_length,
            parallel: parallel(machine),
            planner,
        })
    }

    /// Joints of one kind.
    pub(super) fn of_kind(&self, kind: AxisKind) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(move |joint| joint.kind == kind)
    }

    /// Letters of the joints, with `between` between them.
    pub(super) fn coordinates(&self, between: &str) -> String {
        let letters: Vec<String> =
            self.joints.iter().map(|joint| joint.letter.to_string()).collect();
        letters.join(between)
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn write_is_rotary<S: serde::Serializer>(kind: &AxisKind, out: S) -> Result<S::Ok, S::Error> {
    out.serialize_bool(*kind == AxisKind::Rotary)
}

fn joint(letter: char, axis: &Axis) -> Joint {
    let scale = if axis.kind == AxisKind::Rotary { 1.0_f64.to_degrees() } else { 1.0 };
    let end = |value: f64| value.is_finite().then_some(value * scale);
    let [low, high] = axis.limits.ends();
    Joint {
        letter,
        kind: axis.kind,
        low: end(low),
        high: end(high),
        velocity: axis.vel * scale,
        acceleration: axis.acc * scale,
        home: axis.home * scale,
    }
}

/// Letters of the axes; the kinematics module finds the tip by X, Y, Z and the rotaries by A, B, C.
fn letters(machine: &Machine) -> Result<Vec<char>, Failure> {
    let words = AxisWords::of(machine).map_err(Failure::input)?;
    for (index, word) in words.0.iter().enumerate() {
        let wanted = ["X", "Y", "Z"].get(index).copied().unwrap_or("ABC");
        if !wanted.contains(word.letter) {
            let axis = machine.axes.get(index).map_or("", |axis| &axis.name);
            return Err(Failure::input(format!(
                "axis {axis} has the letter {}, and LinuxCNC needs one of {wanted} there\n  help: set output.letter \
                 of [axis.{axis}]",
                word.letter
            )));
        }
    }
    Ok(words.0.iter().map(|word| word.letter).collect())
}

/// Bounds every coordinate of the tip with the rotaries anywhere \[mm\]: the sum of all arms, whatever their directions.
fn tip_bound(machine: &Machine) -> f64 {
    let chain = *Kinematics::new(machine, &Setup::default()).chain();
    let [first, second] = chain.rotary;
    let farthest = |axis: &Axis| axis.limits.low.abs().max(axis.limits.high.abs());
    let [x, y, z, ..] = &machine.axes;
    let linear = Vector3::from([x, y, z].map(farthest)).norm();
    let arms = [first.point, second.point - first.point, chain.tip - second.point];
    let arms: f64 = arms.iter().map(Vector3::norm).sum();
    // The words count the length along Z, the machine along the tool.
    linear + arms + machine.gauge.coords.norm() + 2.0 * LONGEST_TOOL
}

fn parallel(machine: &Machine) -> bool {
    let units = [Vector3::x(), Vector3::y(), Vector3::z()];
    let linear = machine.axes.iter().take(FIRST_ROTARY);
    linear.zip(units).all(|(axis, unit)| (axis.dir.scale(axis.sense) - unit).amax() <= PARALLEL)
}

/// Turns a name into the stem of a file.
fn stem(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' };
    let stem: String = name.chars().map(safe).collect();
    if stem.is_empty() { "machine".to_owned() } else { stem }
}

/// Writes a number with at most six decimals.
pub(super) fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trunnion::files::machine::{BUILT_IN, parse};
    use trunnion::types::AxisVector;

    #[test]
    fn the_tip_stays_within_its_bound() {
        for (name, text) in BUILT_IN {
            let machine = parse(text).unwrap().machine;
            let bound = tip_bound(&machine);
            let setup = Setup { tool_length: LONGEST_TOOL, ..Setup::default() };
            let kinematics = Kinematics::new(&machine, &setup);
            let mut largest = 0.0_f64;
            for corner in 0..8 {
                for turn in 0..400 {
                    let end = |axis: usize| {
                        let [low, high] = machine.axes[axis].limits.ends();
                        if corner >> axis & 1 == 0 { low } else { high }
                    };
                    let [first, second] = [f64::from(turn % 20), f64::from(turn / 20)];
                    let q = AxisVector::from([end(0), end(1), end(2), 0.33 * first, 0.33 * second]);
                    let words = kinematics.forward(&q).tip.coords - machine.gauge.coords
                        + Vector3::z() * LONGEST_TOOL;
                    largest = largest.max(words.amax());
                }
            }
            assert!(largest <= bound && bound < 6.0 * largest, "{name}: {largest} {bound}");
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(
            [number(1500.0), number(-0.0), number(0.5), number(149.999_999_99)],
            ["1500", "0", "0.5", "150"]
        );
    }
}
