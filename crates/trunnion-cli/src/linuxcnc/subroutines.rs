//! The remapped codes that switch the kinematics, and the tool table.

use super::configuration::{Configuration, number};

/// Code of tool-centre-point control, the number of its kinematics, and what it does.
pub(super) const SWITCHES: [(&str, u8, &str); 2] = [
    ("m428", 1, "Tool-centre-point control on: X Y Z are the tool tip in the table frame"),
    ("m429", 0, "Tool-centre-point control off: X Y Z are the axes of the machine"),
];

/// Writes the subroutine of a code. `M66` makes the interpreter wait and read the position again.
pub(super) fn switch(code: &str, kind: u8, meaning: &str) -> String {
    format!("({meaning})\no<{code}> sub\nM68 E3 Q{kind}\nM66 E0 L0\no<{code}> endsub\nM2\n")
}

/// Writes the tool table.
pub(super) fn tools(of: &Configuration) -> String {
    format!("T1 P1 Z{} D10 ;from the spindle nose to the tip\n", number(of.tool_length))
}
