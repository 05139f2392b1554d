//! A reader of any dialect, line by line.

use super::control::ControlState;
use super::dialect::Dialect;
use super::log::{ReadLog, ReadRemark, excerpt};
use super::options::ReadOptions;
use super::passive::{ActiveLine, PassiveCodes};
use super::state::ReaderState;
use super::step::Step;
use crate::read::gcode::GcodeReader;
use crate::read::heidenhain::HeidenhainReader;
use crate::read::siemens::SiemensReader;
use crate::types::{AxisVector, Diagnostic};

/// Longest line \[bytes\]; a longer one is not of a program.
const LONGEST: usize = 100_000;

/// The dialect's own part.
#[derive(Debug)]
enum LanguageReader {
    Gcode(Box<GcodeReader>),
    Siemens(Box<SiemensReader>),
    Heidenhain(Box<HeidenhainReader>),
    /// Not read here.
    None,
}

/// Takes lines, gives steps.
#[derive(Debug)]
pub(super) struct ProgramReader {
    state: ReaderState,
    language: LanguageReader,
    passive: PassiveCodes,
    lines: u32,
}

impl ProgramReader {
    pub(super) fn new(options: &ReadOptions) -> Self {
        let control = ControlState::new(options);
        let mut log = ReadLog::new(options.most_faults);
        let language = match options.dialect {
            Dialect::LinuxCnc | Dialect::Fanuc | Dialect::Haas => {
                LanguageReader::Gcode(Box::new(GcodeReader::new(options)))
            }
            Dialect::Siemens => LanguageReader::Siemens(Box::new(SiemensReader::new(options))),
            Dialect::Heidenhain => {
                LanguageReader::Heidenhain(Box::new(HeidenhainReader::new(options)))
            }
            Dialect::Apt => {
                log.whole("cutter locations are no program", "read them as a CL file");
                LanguageReader::None
            }
        };
        let passive = PassiveCodes::new(&options.passive);
        Self { state: ReaderState { control, log }, language, passive, lines: 0 }
    }

    /// Returns the next step that was made; none after a fault.
    #[inline]
    pub(super) fn pop(&mut self) -> Option<Step> {
        // After a fault the positions are not to be trusted: the rest is read for its faults only.
        if !self.state.log.faults.is_empty() {
            self.state.control.steps.clear();
        }
        self.state.control.steps.pop_front()
    }

    /// Returns true if no further line is wanted.
    #[inline]
    pub(super) fn is_over(&self) -> bool {
        self.state.control.ended || self.state.log.is_full()
    }

    /// Returns true if something is to be run before the next line of the file.
    #[inline]
    pub(super) fn is_busy(&self) -> bool {
        match &self.language {
            LanguageReader::Gcode(gcode) => !self.is_over() && gcode.is_busy(),
            LanguageReader::Siemens(siemens) => !self.is_over() && siemens.is_busy(),
            LanguageReader::Heidenhain(klartext) => !self.is_over() && klartext.is_busy(),
            LanguageReader::None => false,
        }
    }

    /// Runs it.
    pub(super) fn advance(&mut self) {
        match &mut self.language {
            LanguageReader::Gcode(gcode) => gcode.advance(&mut self.state),
            LanguageReader::Siemens(siemens) => siemens.advance(&mut self.state),
            LanguageReader::Heidenhain(klartext) => klartext.advance(&mut self.state),
            LanguageReader::None => {}
        }
    }

    /// Reads a line of the file.
    #[inline]
    pub(super) fn line(&mut self, text: &str) {
        self.lines = self.lines.saturating_add(1);
        self.state.log.line = self.lines;
        // Some editors put a byte order mark before the first line.
        let text = match (self.lines, text.strip_prefix('\u{feff}')) {
            (1, Some(rest)) => rest,
            _ => text,
        };
        // A binary file has such lines; the message must not repeat them.
        if text.len() > LONGEST {
            let length = text.len();
            let message = format!("a line of {length} bytes begins {}", excerpt(text));
            self.state.log.fault(text, ReadRemark::new(0, message, "is this a program?"));
            return;
        }
        let ActiveLine { text, kept } = self.passive.take(text);
        for words in &kept {
            self.state.control.keep(self.lines, words);
        }
        let text = &*text;
        match &mut self.language {
            LanguageReader::Gcode(gcode) => gcode.line(&mut self.state, text),
            LanguageReader::Siemens(siemens) => siemens.line(&mut self.state, text),
            LanguageReader::Heidenhain(klartext) => klartext.line(&mut self.state, text),
            LanguageReader::None => self.state.control.ended = true,
        }
    }

    /// Runs the move that waits for a corner in the next line.
    pub(super) fn release_element(&mut self) {
        if let LanguageReader::Heidenhain(klartext) = &mut self.language {
            klartext.release_element(&mut self.state);
        }
    }

    /// Ends the program and returns every fault.
    pub(super) fn finish(&mut self) -> Vec<Diagnostic> {
        // A missing end is often the consequence of a fault that is reported already.
        if self.state.log.faults.is_empty() {
            match &mut self.language {
                LanguageReader::Gcode(gcode) => gcode.finish(&mut self.state),
                LanguageReader::Siemens(siemens) => siemens.finish(&mut self.state),
                LanguageReader::Heidenhain(klartext) => klartext.finish(&mut self.state),
                LanguageReader::None => {}
            }
        }
        self.state.log.faults.clone()
    }

    /// Returns the faults so far.
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
