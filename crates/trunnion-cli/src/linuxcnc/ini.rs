//! The INI file.

use super::args::Planner;
use super::configuration::{Configuration, Joint, number};
use std::fmt::Write;
use trunnion::machine::AxisKind;

/// Following error that stops the machine, as the time that the joint may lag behind at full speed \[s\].
const LAG: f64 = 0.01;

/// Writes the INI file.
pub(super) fn ini(of: &Configuration) -> String {
    let mut text = head(of);
    text.push_str(&speeds(of));
    for (number, joint) in of.joints.iter().enumerate() {
        text.push_str(&axis(of, joint));
        text.push_str(&joint_section(number, joint));
    }
    text
}

fn head(of: &Configuration) -> String {
    let Configuration { name, joints, period, .. } = of;
    format!(
        "# LinuxCNC configuration of machine {name}, written by trunnion. It runs as a simulator: linuxcnc {name}.ini
# {name}.txt says what to change for real drives.

[EMC]
VERSION = 1.1
MACHINE = {name}
DEBUG = 0

[DISPLAY]
# Waits for the Enter key and ends. A screen: axis, gmoccapy, qtdragon.
DISPLAY = dummy
GEOMETRY = {geometry}
MAX_LINEAR_VELOCITY = {fastest}
MAX_FEED_OVERRIDE = 1.5
PROGRAM_PREFIX = .

[RS274NGC]
PARAMETER_FILE = {name}.var
SUBROUTINE_PATH = subroutines
RS274NGC_STARTUP_CODE = G17 G21 G40 G49 G54 G90 G94
# M428 switches tool-centre-point control on, M429 off.
REMAP = M428 modalgroup=10 ngc=m428
REMAP = M429 modalgroup=10 ngc=m429

[KINS]
KINEMATICS = trunnionkins machine={name}.toml coordinates={letters}
JOINTS = {count}

[EMCMOT]
EMCMOT = motmod
COMM_TIMEOUT = 4.0
SERVO_PERIOD = {nanoseconds:.0}

[TASK]
TASK = milltask
CYCLE_TIME = 0.001

[HAL]
HALFILE = {name}.hal

[EMCIO]
EMCIO = io
CYCLE_TIME = 0.1
TOOL_TABLE = {name}.tbl
",
        geometry = of.coordinates(""),
        letters = of.coordinates(""),
        fastest = number(together(of, AxisKind::Linear, |joint| joint.velocity)),
        count = joints.len(),
        nanoseconds = period * 1e9,
    )
}

/// Largest rate of all joints of a kind together: along the diagonal of their box.
fn together(of: &Configuration, kind: AxisKind, rate: impl Fn(&Joint) -> f64) -> f64 {
    of.of_kind(kind).map(|joint| rate(joint).powi(2)).sum::<f64>().sqrt()
}

/// Writes the speeds of the path, which leave the decision to the axes.
fn speeds(of: &Configuration) -> String {
    let mut text = format!(
        "
[TRAJ]
COORDINATES = {}
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
",
        of.coordinates(" ")
    );
    if of.planner == Planner::Trunnion {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "# Keeps the limits of every joint, as the machine file has them.\nTPMOD = trunniontp machine={}.toml",
            of.name
        );
    }
    for (name, kind) in [("LINEAR", AxisKind::Linear), ("ANGULAR", AxisKind::Rotary)] {
        let velocity = number(together(of, kind, |joint| joint.velocity));
        let acceleration = number(together(of, kind, |joint| joint.acceleration));
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "DEFAULT_{name}_VELOCITY = {velocity}
MAX_{name}_VELOCITY = {velocity}
DEFAULT_{name}_ACCELERATION = {acceleration}
MAX_{name}_ACCELERATION = {acceleration}
"
        );
    }
    text
}

/// Writes the limits of a letter. With tool-centre-point control X, Y and Z are the tip, which goes where the joints lead
/// it: their travel is that of the tip, and the joints have their own.
fn axis(of: &Configuration, joint: &Joint) -> String {
    let mut text = format!("\n[AXIS_{}]\n", joint.letter);
    if joint.kind == AxisKind::Rotary {
        travel(&mut text, [joint.low, joint.high]);
    } else {
        text.push_str(
            "# Travel of the tool tip. The travel of the machine is that of the joint below.\n",
        );
        travel(&mut text, [Some(-of.tip_travel), Some(of.tip_travel)]);
    }
    rates(&mut text, joint);
    text
}

fn joint_section(index: usize, joint: &Joint) -> String {
    let kind = if joint.kind == AxisKind::Rotary { "ANGULAR" } else { "LINEAR" };
    let mut text = format!("\n[JOINT_{index}]\nTYPE = {kind}\n");
    travel(&mut text, [joint.low, joint.high]);
    rates(&mut text, joint);
    let (lag, home) = (number(joint.velocity * LAG), number(joint.home));
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "FERROR = {lag}
MIN_FERROR = {lag}
# Homed where it stands: without switches the joint is at its home position when the control starts.
HOME = {home}
HOME_OFFSET = {home}
HOME_SEARCH_VEL = 0
HOME_LATCH_VEL = 0
HOME_SEQUENCE = 0
"
    );
    text
}

/// Writes the ends of travel; an axis that turns without end has none.
fn travel(text: &mut String, ends: [Option<f64>; 2]) {
    for (key, end) in ["MIN_LIMIT", "MAX_LIMIT"].iter().zip(ends) {
        if let Some(end) = end {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{key} = {}", number(end));
        }
    }
}

fn rates(text: &mut String, joint: &Joint) {
    let [velocity, acceleration] = [joint.velocity, joint.acceleration].map(number);
    // Writing to a string cannot fail.
    let _ = write!(text, "MAX_VELOCITY = {velocity}\nMAX_ACCELERATION = {acceleration}\n");
}
