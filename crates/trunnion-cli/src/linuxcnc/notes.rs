//! The text that says what to change for a real machine.

use super::args::Planner;
use super::configuration::Configuration;

/// Remarks on each planner for the operator.
const STOCK: &str = "  LinuxCNC's own planner looks one block ahead while a rotary moves, and limits the words of a program. With
  tool-centre-point control X, Y and Z are the tip there, so the joints can exceed their limits: program feeds that
  they can follow, as `trunnion run` and `trunnion post` write them.";
const TRUNNION: &str = "  trunniontp keeps velocity, acceleration and jerk of every joint as the machine file states them; a joint's limits
  in the INI file are for jogging and homing. Keep both equal: it does not load where those of the INI file are
  narrower.
  It looks far ahead: write jobs for it with link_blocks = \"short\" in [output].
  It rounds corners within P of G64 at the tip; without P within trunniontp.path-tolerance. It does not plan motion
  in step with the spindle (G33, G33.1, G76, G95) and rotaries that lock: LinuxCNC says so.";

/// Pins of the planner.
const PINS: &str = "
HAL pins of trunniontp
  axis-tolerance     largest deviation of the rotaries at corners, degrees
  path-tolerance     largest deviation of the tip at corners for G64 without P, mm
  queue              blocks that are not run
  time-ahead         time until rest of what the servo thread has, s
  cycle-ns           time of the planner in the last servo cycle; cycle-ns-max the longest
  plan-worked        time that the planning thread has worked, s; plan-longest its longest turn
  binding-limit      what limits the speed: 0 nothing, 1 feed, 2 rapid; 10, 20, 30 and the axis of the machine file
                     for its velocity, acceleration, jerk
  plan-late          plans that came too late: the tool stopped, and went on
  fault              reason of the last refusal, as trunnionkins.refusal; 8: a letter without an axis
";

/// Writes the notes.
pub(super) fn notes(of: &Configuration) -> String {
    let Configuration { name, .. } = of;
    let mut text = format!(
        "Configuration of machine {name} for LinuxCNC

Start it:      linuxcnc {name}.ini
It needs:      LinuxCNC 2.9, and the {modules} (folder linuxcnc of trunnion:
               make && sudo make install)

Files
  {name}.ini      limits, from the machine file
  {name}.hal      joints, kinematics, tool length; all drives are simulated
  {name}.toml     the machine file, which trunnionkins reads at the start
  {name}.tbl      tool table: enter the lengths of your tools, from the spindle nose to the tip
  subroutines/    M428 switches tool-centre-point control on, M429 off

Programs
  X Y Z of G54 are entered in machine coordinates with all rotaries at zero, as the head of a program states them.
  Switch tool-centre-point control off (M429) before G43, G49 and tool changes with the tool tilted: the control
  refuses the next move otherwise, because the linear axes would have to jump.

For real drives
  1. {name}.hal: replace the loops at its end by your drives, and the answers of emergency stop and tool changer
     by your wiring.
  2. {name}.ini, every [JOINT_..]: homing (HOME_SEARCH_VEL, HOME_LATCH_VEL, HOME_OFFSET, HOME_SEQUENCE), FERROR and
     MIN_FERROR. HOME is the position of the machine file.
  3. {name}.ini: DISPLAY, the screen of your choice.
  4. Jog every rotary by itself, and compare its sign with concepts/frames.md of the book of trunnion. An axis that
     turns the other way gets sense = -1 in {name}.toml.
  5. Cut air first.

Watch
{planner}
  With tool-centre-point control the drives are switched off where a joint would leave its travel inside a block.
  `trunnion check` finds such blocks before.

HAL pins of trunnionkins
  tool-offset        length of the tool in the spindle, mm
  refusal            reason of the last refusal: 1 travel, 3 linear axes in one plane, 4 no number, 5 tool length
                     changed with the tool tilted
  refusal-joint      joint that was outside its travel, or -1
  refusal-excess     distance outside, mm or degrees
  refusals           number of refusals
  inverse-ns         time of the last inverse; inverse-ns-max the longest
",
        planner = match of.planner {
            Planner::Stock => STOCK,
            Planner::Trunnion => TRUNNION,
        },
        modules = match of.planner {
            Planner::Stock => "kinematics module trunnionkins",
            Planner::Trunnion => "modules trunnionkins and trunniontp",
        },
    );
    if of.planner == Planner::Trunnion {
        text.push_str(PINS);
    }
    if !of.parallel {
        text.push_str(
            "
The linear axes of this machine do not count along the machine frame. With tool-centre-point control X Y Z of G54
are the workpiece origin less the gauge point, both in the machine frame, and not the positions of the axes.
",
        );
    }
    text
}
