//! State that the readers of all dialects share.

use super::control::ControlState;
use super::log::{ReadLog, ReadRemark};
use super::tape::Tape;
use std::sync::Arc;

/// State that all dialects share.
#[derive(Debug)]
pub(super) struct ReaderState {
    pub(super) control: ControlState,
    pub(super) log: ReadLog,
}

impl ReaderState {
    /// The line to run again, if there is one; what is run too often ends the program.
    pub(super) fn replayed(&mut self, tape: &mut Tape) -> Option<(u32, Arc<str>)> {
        tape.play().unwrap_or_else(|remark| {
            self.log.fault("", remark);
            self.control.ended = true;
            None
        })
    }

    /// Tells what is missing at the end of the file: that of a loop or a condition, or that of the program, which is `end`.
    pub(super) fn unended(&mut self, open: Option<(u32, ReadRemark)>, end: &str) {
        if self.control.ended {
            return;
        }
        if let Some((line, remark)) = open {
            self.log.line = line;
            self.log.fault("", remark);
        } else {
            let message = "the program has no end: a line is missing, or the file was cut";
            self.log.whole(message, end);
        }
    }
}
