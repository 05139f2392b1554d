//! G-code: lines to steps.

use super::lexer::{Lexer, Word};
use super::modal::{LineFault, Modal};
use super::{Program, ReadOptions, Step};
use crate::types::AxisVector;
use crate::types::Fault;

/// Reads a five-axis G-code program.
///
/// Understood: `G0 G1 G4 G17-G19 G20 G21 G40 G43 G43.4 G49 G53 G54-G59.3 G61 G61.1 G64 G80 G90 G91
/// G90.1 G91.1 G93 G94 G234`, `M0-M9 M30 M48 M49`, `M428`/`M429` (TCP on/off), `F H N P Q S T`,
/// comments, a lone `%` and a lone `O` number. Reading ends at `M2` or `M30`: a control stops there.
///
/// # Errors
///
/// Every fault found, up to `options.most_faults`: what is not a word or not understood (arcs,
/// cycles, expressions and the rest among them), codes of one modal group twice on a line, axis
/// words without a motion code, a feed move without a feed, no end of program.
pub fn gcode(text: &str, options: &ReadOptions) -> Result<Program, Vec<Fault>> {
    let mut reader = Reader::new(options);
    for (index, line) in text.lines().enumerate() {
        reader.line(u32::try_from(index + 1).unwrap_or(u32::MAX), line);
        if reader.modal.ended || reader.faults.len() >= options.most_faults {
            break;
        }
    }
    if reader.faults.is_empty() && !reader.modal.ended {
        let fault = Fault::whole("the program has no end: a line is missing, or the file was cut");
        reader.faults.push(fault.with_help("end it with M2 or M30"));
    }
    if reader.faults.is_empty() { Ok(reader.program()) } else { Err(reader.faults) }
}

/// State while reading.
struct Reader<'a> {
    options: &'a ReadOptions,
    modal: Modal,
    steps: Vec<Step>,
    faults: Vec<Fault>,
}

impl<'a> Reader<'a> {
    fn new(options: &'a ReadOptions) -> Self {
        Self { options, modal: Modal::new(), steps: Vec::new(), faults: Vec::new() }
    }

    /// Reads one line.
    fn line(&mut self, number: u32, line: &str) {
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

    /// What was read.
    fn program(self) -> Program {
        let mut rounding = AxisVector::zeros();
        let units = self.modal.finest_units;
        for ((half, unit), word) in rounding.iter_mut().zip(units).zip(&self.options.axes.0) {
            *half = 0.5 * if word.rotary { unit.to_radians() } else { unit };
        }
        Program {
            steps: self.steps,
            rounding,
            feed_rounding: 0.5 * self.modal.finest_feed,
            tools: self.modal.tools,
        }
    }
}
