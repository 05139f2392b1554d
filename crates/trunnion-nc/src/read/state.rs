//! State that the readers of all dialects share.

use super::control::ControlState;
use super::log::{LineRemark, ReadLog};
use super::tape::Tape;
use std::sync::Arc;

/// State that all dialects share.
#[derive(Debug)]
pub(super) struct ReaderState {
    pub(super) control: ControlState,
    pub(super) log: ReadLog,
}

impl ReaderState {
    /// Returns the line to run again, if there is one; one that runs too often ends the program.
    pub(super) fn replayed(&mut self, tape: &mut Tape) -> Option<(u32, Arc<str>)> {
        tape.play().unwrap_or_else(|remark| {
            // A loop without end would run for ever: reading stops with the fault.
            self.log.fault("", remark);
            self.control.ended = true;
            None
        })
    }

    /// Reports a loop or condition that is still open at the end of the file, or a program without
    /// its end; `end` is the remedy for the latter.
    pub(super) fn unended(&mut self, open: Option<LineRemark>, end: &str) {
        // A program that reached its end may leave loops open behind it.
        if self.control.ended {
            return;
        }
        // An open loop explains a missing end, so it alone is reported.
        if let Some(LineRemark { line, remark }) = open {
            self.log.line = line;
            self.log.fault("", remark);
        } else {
            let message = "the program has no end: a line is missing, or the file was cut";
            self.log.whole(message, end);
        }
    }
}
