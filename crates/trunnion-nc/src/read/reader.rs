//! A reader of any dialect, line by line.

use super::control::Control;
use super::gcode::Gcode;
use super::heidenhain::Heidenhain;
use super::log::{Log, Remark, excerpt};
use super::siemens::Siemens;
use super::tape::Tape;
use super::{Dialect, ReadOptions, Step};
use crate::types::{AxisVector, Diagnostic};
use std::sync::Arc;

/// Longest line \[bytes\]; a longer one is not of a program.
const LONGEST: usize = 100_000;

/// What all dialects share.
#[derive(Debug)]
pub(super) struct State {
    pub(super) control: Control,
    pub(super) log: Log,
}

impl State {
    /// The line to run again, if there is one; what is run too often ends the program.
    pub(super) fn replayed(&mut self, tape: &mut Tape) -> Option<(u32, Arc<str>)> {
        tape.play().unwrap_or_else(|remark| {
            self.log.fault("", remark);
            self.control.ended = true;
            None
        })
    }

    /// Tells what is missing at the end of the file: that of a loop or a condition, or that of the program, which is `end`.
    pub(super) fn unended(&mut self, open: Option<(u32, Remark)>, end: &str) {
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

/// The dialect's own part.
#[derive(Debug)]
enum Language {
    Gcode(Box<Gcode>),
    Siemens(Box<Siemens>),
    Heidenhain(Box<Heidenhain>),
    /// Not read here.
    None,
}

/// Takes lines, gives steps.
#[derive(Debug)]
pub(super) struct Reader {
    state: State,
    language: Language,
    lines: u32,
}

impl Reader {
    pub(super) fn new(options: &ReadOptions) -> Self {
        let control = Control::new(options);
        let mut log = Log::new(options.most_faults);
        let language = match options.dialect {
            Dialect::LinuxCnc | Dialect::Fanuc | Dialect::Haas => {
                Language::Gcode(Box::new(Gcode::new(options)))
            }
            Dialect::Siemens => Language::Siemens(Box::new(Siemens::new(options))),
            Dialect::Heidenhain => Language::Heidenhain(Box::new(Heidenhain::new(options))),
            Dialect::Apt => {
                log.whole("cutter locations are no program", "read them as a CL file");
                Language::None
            }
        };
        Self { state: State { control, log }, language, lines: 0 }
    }

    /// The next step, once lines made one; none after a fault.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<Step> {
        if !self.state.log.faults.is_empty() {
            self.state.control.steps.clear();
        }
        self.state.control.steps.pop_front()
    }

    /// No further line is wanted.
    #[inline]
    pub(super) fn is_over(&self) -> bool {
        self.state.control.ended || self.state.log.is_full()
    }

    /// There is something to run before the next line of the file.
    #[inline]
    pub(super) fn is_busy(&self) -> bool {
        match &self.language {
            Language::Gcode(gcode) => !self.is_over() && gcode.is_busy(),
            Language::Siemens(siemens) => !self.is_over() && siemens.is_busy(),
            Language::Heidenhain(klartext) => !self.is_over() && klartext.is_busy(),
            Language::None => false,
        }
    }

    /// Runs it.
    pub(super) fn advance(&mut self) {
        match &mut self.language {
            Language::Gcode(gcode) => gcode.advance(&mut self.state),
            Language::Siemens(siemens) => siemens.advance(&mut self.state),
            Language::Heidenhain(klartext) => klartext.advance(&mut self.state),
            Language::None => {}
        }
    }

    /// Reads a line of the file.
    #[inline]
    pub(super) fn line(&mut self, text: &str) {
        self.lines = self.lines.saturating_add(1);
        self.state.log.line = self.lines;
        let text = match (self.lines, text.strip_prefix('\u{feff}')) {
            (1, Some(rest)) => rest,
            _ => text,
        };
        if text.len() > LONGEST {
            let length = text.len();
            let message = format!("a line of {length} bytes begins {}", excerpt(text));
            self.state.log.fault(text, Remark::new(0, message, "is this a program?"));
            return;
        }
        match &mut self.language {
            Language::Gcode(gcode) => gcode.line(&mut self.state, text),
            Language::Siemens(siemens) => siemens.line(&mut self.state, text),
            Language::Heidenhain(klartext) => klartext.line(&mut self.state, text),
            Language::None => self.state.control.ended = true,
        }
    }

    /// Every fault, once the program is over.
    pub(super) fn finish(&mut self) -> Vec<Diagnostic> {
        if self.state.log.faults.is_empty() {
            match &mut self.language {
                Language::Gcode(gcode) => gcode.finish(&mut self.state),
                Language::Siemens(siemens) => siemens.finish(&mut self.state),
                Language::Heidenhain(klartext) => klartext.finish(&mut self.state),
                Language::None => {}
            }
        }
        self.state.log.faults.clone()
    }

    /// Faults so far.
    pub(super) fn faults(&self) -> &[Diagnostic] {
        &self.state.log.faults
    }

    pub(super) fn warnings(&self) -> &[Diagnostic] {
        &self.state.log.warnings
    }

    pub(super) fn tools(&self) -> &[u32] {
        &self.state.control.tools
    }

    pub(super) fn rounding(&self) -> AxisVector {
        self.state.control.rounding()
    }

    pub(super) fn feed_rounding(&self) -> f64 {
        self.state.control.feed_rounding()
    }
}
