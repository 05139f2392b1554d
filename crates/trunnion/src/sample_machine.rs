//! A machine for unit tests.

use crate::files::machine::parse;
use crate::machine::MachineSpec;

/// Table C on A, both through the machine origin, with round limits.
const AC_TRUNNION: &str = r#"
schema = "trunnion-machine/1"
name = "sample"
units = { length = "mm", angle = "rad", time = "s" }
chain = ["w", "C", "A", "b", "X", "Y", "Z", "t"]
axis.X = { kind = "linear", dir = [1, 0, 0], limits = [-500, 500], vel = 2, acc = 10, jerk = 100 }
axis.Y = { kind = "linear", dir = [0, 1, 0], limits = [-500, 500], vel = 2, acc = 10, jerk = 100 }
axis.Z = { kind = "linear", dir = [0, 0, 1], limits = [-500, 500], vel = 2, acc = 10, jerk = 100 }
dialect = { name = "linuxcnc", interpolation = "rotary-linear", feed = "inverse-time" }

[axis.C]
kind = "rotary"
dir = [0, 0, 1]
point = [0, 0, 0]
cyclic = 6.283185307179586
vel = 2
acc = 10
jerk = 100

[axis.A]
kind = "rotary"
dir = [1, 0, 0]
point = [0, 0, 0]
limits = [-3, 3]
vel = 2
acc = 10
jerk = 100
"#;

/// Specification of the sample machine.
pub(crate) fn ac_trunnion() -> MachineSpec {
    parse(AC_TRUNNION).unwrap().spec
}
