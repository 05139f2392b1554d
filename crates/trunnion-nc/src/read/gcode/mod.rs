//! G-code as `LinuxCNC`, Fanuc and Haas write it.

mod arc;
mod block;
mod codes;
mod cycle;
mod expression;
mod flow;
mod label;
mod m_codes;
mod macros;
mod motion;
mod offsets;
mod owords;
mod parameters;

pub(super) use block::tenths;
pub(super) use motion::axis_of;

use super::control::SLOTS;
use super::log::Remark;
use super::reader::State;
use super::{Dialect, ReadOptions};
use block::Block;
use codes::Now;
use cycle::Cycle;
use expression::Env;
use flow::{Call, Flow, Of, Taken};
use label::OWord;
use macros::{EachMove, Macros};
use parameters::Parameters;

/// What axis words do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Rapid,
    Feed,
    /// `G2` or `G3`.
    Arc {
        clockwise: bool,
    },
    /// `G81` and so on, in tenths.
    Cycle(u32),
}

/// What holds from line to line beside [`Control`](super::control::Control).
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "modal switches are what a control has")]
struct Modal {
    motion: Option<Motion>,
    incremental: bool,
    /// `G90.1`.
    arc_absolute: bool,
    /// 0: XY, 1: ZX, 2: YZ.
    plane: usize,
    /// `G43.5`.
    vector: bool,
    /// `G99`.
    to_r: bool,
    cycle: Cycle,
    /// `G66`.
    each: Option<EachMove>,
    /// `G28` and `G30` \[mm, rad\]; `None`: not known.
    references: [[Option<f64>; SLOTS]; 2],
}

/// Reader of G-code.
#[derive(Debug)]
pub(super) struct Gcode {
    dialect: Dialect,
    block_delete: Option<bool>,
    /// Repeated lines that may still be run.
    left: u64,
    most_repeated: u64,
    modal: Modal,
    /// Taken out while a line is run.
    block: Option<Box<Block>>,
    parameters: Parameters,
    flow: Flow,
    macros: Macros,
    /// A line said something.
    ran: bool,
    /// Lines of the file so far, and lone `%` among them.
    lines: u32,
    percents: u32,
}

impl Gcode {
    pub(super) fn new(options: &ReadOptions) -> Self {
        let mut first = [Some(0.0); SLOTS];
        for (to, from) in first.iter_mut().zip(options.reference) {
            *to = Some(from);
        }
        let modal = Modal {
            motion: None,
            incremental: false,
            arc_absolute: false,
            plane: 0,
            vector: false,
            to_r: false,
            cycle: Cycle::default(),
            each: None,
            references: [first, [None; SLOTS]],
        };
        Self {
            dialect: options.dialect,
            block_delete: options.block_delete,
            left: options.most_repeated,
            most_repeated: options.most_repeated,
            modal,
            block: Some(Box::new(Block::new())),
            parameters: Parameters::new(&options.parameters),
            flow: Flow::default(),
            macros: Macros::new(options.most_repeated),
            ran: false,
            lines: 0,
            percents: 0,
        }
    }

    fn env<'a>(&'a self, state: &'a State) -> Env<'a> {
        Env {
            parameters: &self.parameters,
            control: &state.control,
            line: state.log.line,
            fanuc: self.dialect != Dialect::LinuxCnc,
        }
    }

    /// There are lines to run before the file's next.
    pub(super) fn is_busy(&self) -> bool {
        self.flow.is_busy() || self.macros.tape.is_busy()
    }

    /// Runs one of them.
    pub(super) fn advance(&mut self, state: &mut State) {
        let Some(frame) = self.flow.frames.last_mut() else { return self.advance_file(state) };
        let at = frame.next;
        frame.next += 1;
        let lines = std::sync::Arc::clone(&frame.lines);
        let Some((number, text)) = lines.get(at) else {
            return self.leave();
        };
        state.log.line = *number;
        if !self.may_repeat(state, text) {
            return;
        }
        match self.beginning(state, text) {
            Some((_, Some(word))) => {
                let done = self.o_word_in_frame(state, &word, (at, text));
                note(state, text, done);
            }
            Some((from, None)) => self.statement_or_plain(state, (text, from), at),
            None => {}
        }
    }

    /// Runs a line of the file again, or one that was read ahead of its turn.
    fn advance_file(&mut self, state: &mut State) {
        match self.macros.tape.play() {
            Ok(Some((number, text))) => self.run_of_file(state, (number, &text)),
            Ok(None) => {
                if let Some((number, text)) = self.flow.next_ahead() {
                    self.of_file(state, (number, &text));
                }
            }
            Err(remark) => {
                state.log.fault("", remark);
                state.control.ended = true;
            }
        }
    }

    /// Ends the lines that run.
    fn leave(&mut self) {
        if self.flow.frames.pop().is_some_and(|frame| frame.is_scoped()) {
            self.parameters.leave();
        }
        let level = self.flow.frames.len();
        self.macros.leave(level);
    }

    /// Counts a line that is run out of turn.
    fn may_repeat(&mut self, state: &mut State, text: &str) -> bool {
        if let Some(left) = self.left.checked_sub(1) {
            self.left = left;
            return true;
        }
        if !state.control.ended {
            let message =
                format!("loops and subprograms run more than {} lines", self.most_repeated);
            let help = "does the loop end? if so, allow more when reading";
            state.log.fault(text, Remark::new(0, message, help));
        }
        state.control.ended = true;
        false
    }

    /// Takes in a line of the file.
    pub(super) fn line(&mut self, state: &mut State, text: &str) {
        self.lines = self.lines.saturating_add(1);
        state.log.line = self.lines;
        match self.flow.collect(self.lines, text) {
            Taken::No => {}
            Taken::Yes => return,
            Taken::Called(called) => return self.called(called),
        }
        self.of_file(state, (self.lines, text));
    }

    fn of_file(&mut self, state: &mut State, (number, text): (u32, &str)) {
        self.macros.tape.record(number, text);
        if self.dialect != Dialect::LinuxCnc && text.as_bytes().contains(&b'#') {
            // From here on a loop may count, and lead back to any line.
            self.macros.tape.keep(text);
        }
        self.run_of_file(state, (number, text));
    }

    fn run_of_file(&mut self, state: &mut State, (number, text): (u32, &str)) {
        state.log.line = number;
        if self.macros.passes(text) {
            return;
        }
        match self.beginning(state, text) {
            Some((_, Some(word))) => {
                let done = self.o_word_of_file(state, &word, (number, text));
                note(state, text, done);
            }
            Some((from, None)) => {
                let line = usize::try_from(number).unwrap_or(usize::MAX);
                self.statement_or_plain(state, (text, from), line);
            }
            None => {}
        }
    }

    /// A line without O-word, which is number `line` of the file or of the subprogram that runs.
    fn statement_or_plain(&mut self, state: &mut State, (text, from): (&str, usize), line: usize) {
        match self.statement(state, (text, from), line) {
            Ok(true) => {}
            Ok(false) => self.plain(state, (text, from)),
            Err(remark) => state.log.fault(text, remark),
        }
    }

    /// Where a line begins, and its O-word; `None`: nothing to run.
    #[inline]
    fn beginning(&mut self, state: &mut State, text: &str) -> Option<(usize, Option<OWord>)> {
        let bytes = text.as_bytes();
        let from = bytes.iter().position(|byte| !matches!(byte, b' ' | b'\t' | b'\r'))?;
        match bytes.get(from)? {
            b'%' if text.trim() == "%" => {
                self.percents += 1;
                // The second one ends a tape.
                state.control.ended |= self.percents > 1;
                None
            }
            b'/' => {
                let (run, from) = self.deleted(state, text, from);
                run.then(|| (from, label::o_word(text, from)))
            }
            b'O' | b'o' | b':' | b'N' | b'n' => Some((from, label::o_word(text, from))),
            _ => Some((from, None)),
        }
    }

    /// `/` or `/2` before a line: whether it is run, and where it goes on.
    fn deleted(&self, state: &mut State, text: &str, from: usize) -> (bool, usize) {
        let digit = text.as_bytes().get(from + 1).is_some_and(u8::is_ascii_digit);
        if let Some(run) = self.block_delete {
            return (run, from + 1 + usize::from(digit));
        }
        let message = "block delete: whether the control runs this block is not known";
        let help = "say whether such blocks are run: --block-delete true, or false";
        state.log.fault(text, Remark::new(from, message, help));
        (false, from)
    }

    /// Words.
    fn plain(&mut self, state: &mut State, (text, from): (&str, usize)) {
        let mut block = self.block.take().unwrap_or_else(|| Box::new(Block::new()));
        let before = state.log.faults.len();
        {
            let State { control, log } = state;
            let fanuc = self.dialect != Dialect::LinuxCnc;
            let env = Env { parameters: &self.parameters, control, line: log.line, fanuc };
            block.scan((text, from), &env, |remark| log.fault(text, remark));
        }
        if state.log.faults.len() == before && !(block.is_empty() && block.assignments.is_empty()) {
            self.run(state, &mut block, text);
        }
        self.block = Some(block);
    }

    /// Does what the words of a line say.
    fn run(&mut self, state: &mut State, block: &mut Block, text: &str) {
        self.ran = true;
        let mut now = Now::default();
        let done = self.words(state, block, (text, &mut now));
        let failed = done.is_err();
        note(state, text, done);
        for (letter, word) in block.left() {
            // Axes are left over where something else of the line could not be understood.
            if failed && state.control.known_slot(letter).is_some() {
                continue;
            }
            let text_of = text.get(word.at..word.end).unwrap_or_default();
            let remark = codes::left_over(letter, text_of, word.at, &state.control);
            state.log.fault(text, remark);
        }
        for (key, value) in block.assignments.drain(..) {
            if key == parameters::ALARM && self.dialect != Dialect::LinuxCnc {
                let message = "the program raises an alarm here (#3000)";
                state.log.fault(text, Remark::new(0, message, "look at what it found wrong"));
            }
            self.parameters.set(key, value);
        }
        self.after(state, &now, text);
    }

    /// What happens once a block has moved: stops, ends, calls.
    fn after(&mut self, state: &mut State, now: &Now, text: &str) {
        for &(at, end) in now.stops.iter().flatten() {
            state.control.keep(state.log.line, text.get(at..end).unwrap_or_default());
        }
        state.control.ended |= now.ends;
        if let Some((label, times, at)) = &now.call {
            let call = Call { arguments: now.arguments.clone(), times: *times };
            let done = self.run_sub((label, true), call, (state.log.line, text, *at));
            note(state, text, done);
        }
        match now.return_to {
            Some((line, at)) if now.returns => {
                if matches!(
                    self.flow.frames.last().map(|frame| frame.of),
                    Some(Of::Numbered { .. })
                ) {
                    self.leave();
                }
                let done = self.go_to(state, at, line);
                note(state, text, done);
            }
            _ if now.returns => self.return_numbered(state),
            _ => {}
        }
    }

    /// `M99`.
    fn return_numbered(&mut self, state: &mut State) {
        match self.flow.frames.last_mut() {
            Some(frame) => match &mut frame.of {
                Of::Numbered { again: 0, .. } => self.leave(),
                Of::Numbered { again, .. } => (*again, frame.next) = (*again - 1, 1),
                _ => state.control.ended = true,
            },
            // The main program would begin anew, and what it does is known by then.
            None => state.control.ended = true,
        }
    }

    /// What is missing at the end; a file of subprograms has no end of its own.
    pub(super) fn finish(&mut self, state: &mut State) {
        if let Some(((line, text), open)) = self.flow.open().filter(|_| !state.control.ended) {
            state.log.line = *line;
            state.log.fault(text, open);
            return;
        }
        let open = self.macros.open();
        // A file of subprograms alone needs no end.
        if open.is_some() || self.ran || !self.flow.has_subs() {
            state.unended(open, "end it with M2 or M30");
        }
    }
}

/// Notes what went wrong.
fn note(state: &mut State, text: &str, done: Result<(), Remark>) {
    if let Err(remark) = done {
        state.log.fault(text, remark);
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::read::control::Control;
    use crate::read::{AxisWord, AxisWords};

    pub(in crate::read) fn options(dialect: Dialect) -> ReadOptions {
        let word = |letter: char| AxisWord {
            letter,
            rotary: "ABC".contains(letter),
            decimals: 4,
            reversed: false,
        };
        ReadOptions::new(dialect, AxisWords(['X', 'Y', 'Z', 'A', 'C'].map(word)), 20)
    }

    /// Parameters with values, and a control.
    pub(super) fn env(given: &[(&str, f64)]) -> (Parameters, Control) {
        let given: Vec<_> =
            given.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        let options = options(Dialect::LinuxCnc);
        (Parameters::new(&given), Control::new(&options))
    }
}
