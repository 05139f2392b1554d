//! Options and controls that unit tests of the readers share.

use super::control::ControlState;
use super::dialect::Dialect;
use super::options::ReadOptions;
use crate::words::{AxisWord, AxisWords};
/// Returns options for an XYZAC machine.
pub(super) fn options(dialect: Dialect) -> ReadOptions {
    let word = |letter: char| AxisWord {
        letter,
        rotary: "ABC".contains(letter),
        decimals: 4,
        reversed: false,
    };
    ReadOptions::new(dialect, AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word)), 20)
}

/// Returns a control after its usual start.
pub(super) fn control() -> ControlState {
    ControlState::new(&options(Dialect::LinuxCnc))
}
