//! G-code: lines to steps.

use super::lexer::{Lexer, Word};
use super::modal::{LineFault, Modal};
use super::{Dialect, ReadOptions, Step};
use crate::types::AxisVector;
use crate::types::Fault;
use std::collections::VecDeque;

/// State while reading.
#[derive(Debug)]
pub(super) struct Reader {
    options: ReadOptions,
    modal: Modal,
    lines: u32,
    steps: VecDeque<Step>,
    faults: Vec<Fault>,
    warnings: Vec<Fault>,
}

impl Reader {
    pub(super) fn new(options: ReadOptions) -> Self {
        let mut reader = Self {
            options,
            modal: Modal::new(),
            lines: 0,
            steps: VecDeque::new(),
            faults: Vec::new(),
            warnings: Vec::new(),
        };
        let dialect = reader.options.dialect;
        if matches!(dialect, Dialect::Siemens | Dialect::Heidenhain | Dialect::Apt) {
            let message = format!("{dialect} programs are not read as G-code");
            reader.faults.push(Fault::whole(message));
        }
        reader
    }

    /// The next step, once lines made one; none after a fault.
    pub(super) fn pop(&mut self) -> Option<Step> {
        if self.faults.is_empty() { self.steps.pop_front() } else { None }
    }

    /// No further line is wanted.
    pub(super) fn is_over(&self) -> bool {
        self.modal.ended || self.faults.len() >= self.options.most_faults
    }

    /// Every fault, once the program is over.
    pub(super) fn finish(&mut self) -> Vec<Fault> {
        if self.faults.is_empty() && !self.modal.ended {
            let fault =
                Fault::whole("the program has no end: a line is missing, or the file was cut");
            self.faults.push(fault.with_help("end it with M2 or M30"));
        }
        self.faults.clone()
    }

    pub(super) fn warnings(&self) -> &[Fault] {
        &self.warnings
    }

    pub(super) fn tools(&self) -> &[u32] {
        &self.modal.tools
    }

    pub(super) fn feed_rounding(&self) -> f64 {
        0.5 * self.modal.finest_feed
    }

    /// Reads one line.
    pub(super) fn line(&mut self, line: &str) {
        self.lines = self.lines.saturating_add(1);
        let number = self.lines;
        if line.trim() == "%" {
            return;
        }
        let before = self.faults.len();
        let mut words: Vec<Word<'_>> = Vec::with_capacity(8);
        let mut lexer = Lexer::new(line);
        while let Some(next) = lexer.next_word() {
            match next {
                Ok(word) => words.push(word),
                Err(error) => {
                    let message = error.message.to_owned();
                    self.fault(number, line, LineFault { at: error.at, message, help: "" });
                }
            }
        }
        let step = self.modal.line(&words, &self.options.axes, number);
        match step {
            Ok(step) if self.faults.len() == before => self.steps.extend(step),
            Ok(_) => {}
            Err(faults) => {
                for fault in faults {
                    self.fault(number, line, fault);
                }
            }
        }
    }

    /// Notes a fault at a byte offset of a line.
    fn fault(&mut self, number: u32, line: &str, fault: LineFault) {
        let column = line.char_indices().take_while(|&(offset, _)| offset < fault.at).count() + 1;
        let column = u32::try_from(column).unwrap_or(u32::MAX);
        let (message, help) = (fault.message, fault.help.to_owned());
        self.faults.push(Fault { line: number, column, message, help });
    }

    /// Half of the last digit of each axis word \[mm, rad\].
    pub(super) fn rounding(&self) -> AxisVector {
        let mut rounding = AxisVector::zeros();
        let units = self.modal.finest_units;
        for ((half, unit), word) in rounding.iter_mut().zip(units).zip(&self.options.axes.0) {
            *half = 0.5 * if word.rotary { unit.to_radians() } else { unit };
        }
        rounding
    }
}
