//! The HAL file: every joint is looped back, so that the machine is simulated.

use super::args::Planner;
use super::configuration::Configuration;
use std::fmt::Write;

/// Connections of the planner: it plans with the kinematics and the tool of the block.
const PLANNER: &str = "# The planner needs the same. Corners: rotaries within axis-tolerance, degrees; G64 without P, mm.
net kinematics-type => trunniontp.kinematics-type
net tool-length => trunniontp.tool-offset
setp trunniontp.axis-tolerance 0.1
setp trunniontp.path-tolerance 0.1

";

/// Writes the HAL file.
pub(super) fn hal(of: &Configuration) -> String {
    let mut text = format!(
        "# HAL of machine {}, written by trunnion. Every joint is simulated: it reports the position it is commanded.

loadrt [KINS]KINEMATICS
loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
addf motion-command-handler servo-thread
addf motion-controller servo-thread

# M428 and M429 write the analogue output that selects the kinematics; the tool length goes to the kinematics.
net kinematics-type motion.analog-out-03 => motion.switchkins-type
net tool-length motion.tooloffset.z => trunnionkins.tool-offset

{planner}# Emergency stop and tool changer answer at once.
net estop iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in
net tool-prepare iocontrol.0.tool-prepare => iocontrol.0.tool-prepared
net tool-change iocontrol.0.tool-change => iocontrol.0.tool-changed

# Drives: replace the loops by your hardware.
",
        of.name,
        planner = if of.planner == Planner::Trunnion { PLANNER } else { "" },
    );
    for index in 0..of.joints.len() {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "net joint-{index} joint.{index}.motor-pos-cmd => joint.{index}.motor-pos-fb"
        );
    }
    text
}
