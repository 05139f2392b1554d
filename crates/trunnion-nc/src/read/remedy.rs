//! Remedies that the options of a reader decide.

use super::log::ReadRemark;
use crate::types::Diagnostic;

/// Help of the fault of a block whose execution the options leave open.
const BLOCK_DELETE: &str = "state whether the control runs such blocks (ReadOptions::block_delete)";

/// Help of the fault of a tool whose row of the tool table is needed.
const TOOLS: &str = "give the tool table of the control (ReadOptions::tools)";

/// Help of the fault of a code whose effect the program does not tell.
pub(super) const PASSIVE: &str = "it may move the machine: leave it out, or declare that it moves nothing (ReadOptions::passive)";

/// Remedy of a fault that lies in [`ReadOptions`](super::ReadOptions), not in the program.
///
/// A shell that sets those options can replace the help of such a fault by the words of its own
/// user interface.
///
/// # Example
///
/// ```
/// use trunnion_nc::read::{AxisWord, AxisWords, Dialect, ReadOptions, ReadRemedy, read};
///
/// let word = |letter: char| {
///     AxisWord { letter, rotary: "AC".contains(letter), decimals: 3, reversed: false }
/// };
/// let axes = AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word));
/// let faults = read("/G0 X1\nM2\n", &ReadOptions::new(Dialect::Fanuc, axes, 10)).unwrap_err();
/// let remedy = faults.iter().find_map(ReadRemedy::of);
/// assert_eq!(remedy, Some(ReadRemedy::DecideBlockDelete));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReadRemedy {
    /// Set [`ReadOptions::block_delete`](super::ReadOptions::block_delete).
    DecideBlockDelete,
    /// Set [`ReadOptions::tools`](super::ReadOptions::tools).
    GiveTools,
    /// Name the code in [`ReadOptions::passive`](super::ReadOptions::passive), if it moves nothing.
    DeclarePassive,
}

impl ReadRemedy {
    /// Returns the remedy of a diagnostic, if it lies in the options of the reader.
    pub fn of(diagnostic: &Diagnostic) -> Option<Self> {
        match diagnostic.help.as_str() {
            BLOCK_DELETE => Some(Self::DecideBlockDelete),
            TOOLS => Some(Self::GiveTools),
            PASSIVE => Some(Self::DeclarePassive),
            _ => None,
        }
    }
}

/// Returns the fault of a block that begins with `/` where the options leave open its execution.
pub(super) fn undecided_block(at: usize) -> ReadRemark {
    let message = "block delete: whether the control runs this block is not known";
    ReadRemark::new(at, message, BLOCK_DELETE)
}

/// Returns the fault of a tool whose offsets or radius are needed but not known.
pub(super) fn unknown_tool(at: usize, message: String) -> ReadRemark {
    ReadRemark::new(at, message, TOOLS)
}
