//! G-code as `LinuxCNC`, Fanuc and Haas write it.

use super::block::GcodeBlock;
use super::expression::ExpressionEnv;
use super::flow::{CallSite, FrameFile, FrameKind, GcodeFlow, LineCollection, SubCall, SubKind};
use super::label::OWord;
use super::macro_flow::MacroFlow;
use super::modal::{BlockActions, CycleState, ModalState};
use super::numbered_line::NumberedLine;
use super::parameters::{ParameterKey, Parameters};
use super::predefined::ModalView;
use super::spline_points::SplineState;
use super::words::left_over;
use super::{label, parameters};
use crate::read::control::{ControlState, DistanceMode, SLOTS};
use crate::read::dialect::Dialect;
use crate::read::log::{FileLine, LineTail, ReadRemark};
use crate::read::options::{CodeRemap, ReadOptions};
use crate::read::remedy::undecided_block;
use crate::read::state::ReaderState;
use std::sync::Arc;

/// Reader of G-code.
#[derive(Debug)]
pub(in crate::read) struct GcodeReader {
    pub(super) dialect: Dialect,
    pub(super) block_delete: Option<bool>,
    /// Repeated lines that may still be run.
    pub(super) left: u64,
    pub(super) most_repeated: u64,
    pub(super) modal: ModalState,
    /// Taken out while a line is run.
    pub(super) block: Option<Box<GcodeBlock>>,
    pub(super) parameters: Parameters,
    pub(super) flow: GcodeFlow,
    /// Codes that stand for subprograms.
    pub(super) remaps: Arc<[CodeRemap]>,
    pub(super) macros: MacroFlow,
    /// A line with words was run.
    pub(super) ran: bool,
    /// Lines of the file so far, and lone `%` among them.
    pub(super) lines: u32,
    pub(super) percents: u32,
}

impl GcodeReader {
    pub(in crate::read) fn new(options: &ReadOptions) -> Self {
        let mut first = [Some(0.0); SLOTS];
        // G28 leads to the reference given for reading; G30 is unknown until the program stores it.
        for (to, from) in first.iter_mut().zip(options.reference) {
            *to = Some(from);
        }
        // A control that is switched on has zeros there, unless it has kept others.
        let second = options.start.map_or([None; SLOTS], |_| [Some(0.0); SLOTS]);
        let modal = ModalState {
            motion: None,
            before_cycle: None,
            distance: DistanceMode::Absolute,
            arc_absolute: false,
            plane: 0,
            vector: false,
            diameter: false,
            compensation: None,
            leaves_contour: false,
            line_began: 0,
            spline_code: 0,
            spline: SplineState::default(),
            saved: Vec::new(),
            // LinuxCNC's interpreter starts with G99, the others with G98.
            to_r: options.dialect == Dialect::LinuxCnc,
            cycle: CycleState::default(),
            kept_shift: [0.0; SLOTS],
            stood: false,
            each: None,
            polar: None,
            mirror: [None; 3],
            references: [first, second],
        };
        Self {
            dialect: options.dialect,
            block_delete: options.block_delete,
            left: options.most_repeated,
            most_repeated: options.most_repeated,
            modal,
            block: Some(Box::new(GcodeBlock::new())),
            parameters: Parameters::new(options),
            flow: GcodeFlow::new(options),
            remaps: options.remaps.clone().into(),
            macros: MacroFlow::new(options.most_repeated),
            ran: false,
            lines: 0,
            percents: 0,
        }
    }

    pub(super) fn env<'a>(&'a self, state: &'a ReaderState) -> ExpressionEnv<'a> {
        ExpressionEnv {
            parameters: &self.parameters,
            view: self.view(&state.control, state.log.line),
            fanuc: self.dialect != Dialect::LinuxCnc,
        }
    }

    /// Returns the state that parameters of the control show.
    pub(super) fn view<'a>(&'a self, control: &'a ControlState, line: u32) -> ModalView<'a> {
        ModalView { modal: self.modal.codes(), control, line, dialect: self.dialect }
    }

    /// Returns true if lines are to be run before the next of the file.
    pub(in crate::read) fn is_busy(&self) -> bool {
        self.flow.is_busy() || self.macros.tape.is_busy()
    }

    /// Runs one of them.
    pub(in crate::read) fn advance(&mut self, state: &mut ReaderState) {
        self.advance_by_line(state);
        self.settle(state);
    }

    fn advance_by_line(&mut self, state: &mut ReaderState) {
        // The innermost call or loop runs first.
        let Some(frame) = self.flow.frames.last_mut() else { return self.advance_file(state) };
        let at = frame.next;
        frame.next += 1;
        // The lines are shared by all calls of a subprogram.
        let lines = std::sync::Arc::clone(&frame.lines);
        let frame_file =
            self.flow.frames.iter().find_map(|frame| frame.file.clone()).map(|outer| {
                // The outermost file was called from the program itself.
                let own = self.flow.frames.last().and_then(|frame| frame.file.clone());
                FrameFile { line: outer.line, ..own.unwrap_or(outer) }
            });
        let Some(NumberedLine { number, text }) = lines.get(at) else {
            return self.leave(state);
        };
        state.log.line = *number;
        // Lines of another file count as the line that calls it; messages name both.
        state.log.within = frame_file.map(|FrameFile { name, line }| {
            state.log.line = line;
            format!("{name}, line {number}").into()
        });
        if !self.may_repeat(state, text) {
            return;
        }
        match self.beginning(state, text) {
            Some((_, Some(word))) => {
                let done = self.o_word_in_frame(state, &word, at, text);
                note(state, text, done);
            }
            Some((from, None)) => self.statement_or_plain(state, LineTail { text, from }, at),
            None => {}
        }
    }

    /// Runs a line of the file again, or one that was read ahead of its turn.
    pub(super) fn advance_file(&mut self, state: &mut ReaderState) {
        state.log.within = None;
        // Lines that a loop runs again come before those that were read ahead.
        match self.macros.tape.play() {
            Ok(Some((number, text))) => self.run_of_file(state, FileLine { number, text: &text }),
            Ok(None) => {
                if let Some(line) = self.flow.next_ahead() {
                    self.of_file(state, line.as_line());
                }
            }
            Err(remark) => {
                state.log.fault("", remark);
                state.control.ended = true;
            }
        }
    }

    /// Ends the lines that run.
    pub(super) fn leave(&mut self, state: &mut ReaderState) {
        if self.flow.frames.pop().is_some_and(|frame| frame.is_scoped()) {
            self.parameters.leave();
        }
        self.call_returned(state);
        let level = self.flow.frames.len();
        self.macros.leave(level);
    }

    /// Counts a line that is run out of turn.
    pub(super) fn may_repeat(&mut self, state: &mut ReaderState, text: &str) -> bool {
        // Counts lines, not rounds: an empty loop ends as well.
        if let Some(left) = self.left.checked_sub(1) {
            self.left = left;
            return true;
        }
        if !state.control.ended {
            let message =
                format!("loops and subprograms run more than {} lines", self.most_repeated);
            let help = "does the loop end? if so, allow more when reading";
            state.log.fault(text, ReadRemark::new(0, message, help));
        }
        state.control.ended = true;
        false
    }

    /// Takes in a line of the file.
    pub(in crate::read) fn line(&mut self, state: &mut ReaderState, text: &str) {
        self.lines = self.lines.saturating_add(1);
        state.log.line = self.lines;
        state.log.within = None;
        let line = FileLine { number: self.lines, text };
        match self.flow.collect(line) {
            LineCollection::No => {}
            LineCollection::Yes => return,
            LineCollection::Called(called) => return self.called(called),
        }
        self.of_file(state, line);
        self.settle(state);
    }

    /// Runs a line of the file for the first time, and keeps it where a later line may lead back.
    pub(super) fn of_file(&mut self, state: &mut ReaderState, line: FileLine<'_>) {
        let FileLine { number, text } = line;
        // The tape needs every line in order, whether it is run or skipped.
        self.macros.tape.record(number, text);
        if self.dialect != Dialect::LinuxCnc && text.as_bytes().contains(&b'#') {
            // From here on a loop may count, and lead back to any line.
            self.macros.tape.keep(text);
        }
        self.run_of_file(state, line);
    }

    /// Runs a line of the file, for the first time or again.
    pub(super) fn run_of_file(&mut self, state: &mut ReaderState, line: FileLine<'_>) {
        let FileLine { number, text } = line;
        state.log.line = number;
        // A jump skips lines up to its target.
        if self.macros.passes(text) {
            return;
        }
        match self.beginning(state, text) {
            Some((_, Some(word))) => {
                let done = self.o_word_of_file(state, &word, line);
                note(state, text, done);
            }
            Some((from, None)) => {
                let line = usize::try_from(number).unwrap_or(usize::MAX);
                self.statement_or_plain(state, LineTail { text, from }, line);
            }
            None => {}
        }
    }

    /// Runs a line without O-word, which is number `line` of the file or of the subprogram that
    /// runs.
    pub(super) fn statement_or_plain(
        &mut self,
        state: &mut ReaderState,
        tail: LineTail<'_>,
        line: usize,
    ) {
        match self.statement(state, tail, line) {
            Ok(true) => {}
            Ok(false) => self.plain(state, tail),
            Err(remark) => state.log.fault(tail.text, remark),
        }
    }

    /// Returns the start of a line and its O-word; `None`: nothing to run.
    #[inline]
    pub(super) fn beginning(
        &mut self,
        state: &mut ReaderState,
        text: &str,
    ) -> Option<(usize, Option<OWord>)> {
        let bytes = text.as_bytes();
        let from = bytes.iter().position(|byte| !matches!(byte, b' ' | b'\t' | b'\r'))?;
        match bytes.get(from)? {
            b'%' if text.trim() == "%" => {
                self.percents += 1;
                // The second one ends a tape.
                state.control.ended |= self.percents > 1;
                None
            }
            // Block delete stands before everything else.
            b'/' => {
                let (run, from) = self.deleted(state, text, from);
                run.then(|| (from, label::o_word(text, from)))
            }
            b'O' | b'o' | b':' | b'N' | b'n' => Some((from, label::o_word(text, from))),
            _ => Some((from, None)),
        }
    }

    /// Decides on `/` or `/2` before a line: returns true if it is run, and the offset behind the
    /// mark.
    pub(super) fn deleted(
        &self,
        state: &mut ReaderState,
        text: &str,
        from: usize,
    ) -> (bool, usize) {
        // /2 to /9 are switches of their own; one answer holds for all.
        let digit = text.as_bytes().get(from + 1).is_some_and(u8::is_ascii_digit);
        if let Some(run) = self.block_delete {
            return (run, from + 1 + usize::from(digit));
        }
        state.log.fault(text, undecided_block(from));
        (false, from)
    }

    /// Runs a line of plain words.
    pub(super) fn plain(&mut self, state: &mut ReaderState, tail: LineTail<'_>) {
        let text = tail.text;
        let mut block = self.block.take().unwrap_or_else(|| Box::new(GcodeBlock::new()));
        let before = state.log.faults.len();
        {
            let ReaderState { control, log } = state;
            let fanuc = self.dialect != Dialect::LinuxCnc;
            let view = self.view(control, log.line);
            let env = ExpressionEnv { parameters: &self.parameters, view, fanuc };
            block.scan(tail, &env, |remark| log.fault(text, remark));
        }
        self.warn_of_unset(state, text);
        // A line that cannot be read in whole must not run in part.
        if state.log.faults.len() == before && !(block.is_empty() && block.assignments.is_empty()) {
            self.run(state, &mut block, text);
        }
        self.block = Some(block);
    }

    /// Warns of a program that consists of subprograms which nothing calls: it moves nothing.
    fn warn_of_uncalled(&self, state: &mut ReaderState) {
        if self.ran {
            return;
        }
        for (label, line) in self.flow.uncalled() {
            let message =
                format!("subprogram {label} is defined in line {} and never called", line.number);
            state.log.line = line.number;
            let help = "call it from a program, or append a call to the file";
            state.log.warn(&line.text, ReadRemark::new(0, message, help));
        }
    }

    /// Warns of a parameter that was read as zero because nothing had set it.
    fn warn_of_unset(&self, state: &mut ReaderState, text: &str) {
        if let Some(number) = self.parameters.take_unset() {
            let message = format!("#{number} is zero, as nothing has set it");
            let help =
                "LinuxCNC may keep another value in its parameter file: give it when reading";
            state.log.warn(text, ReadRemark::new(0, message, help));
        }
    }

    /// Runs the words of a line.
    pub(super) fn run(&mut self, state: &mut ReaderState, block: &mut GcodeBlock, text: &str) {
        self.ran = true;
        self.modal.line_began = state.control.steps.len();
        let mut now = BlockActions::default();
        let done = self.words(state, block, text, &mut now);
        let failed = done.is_err();
        note(state, text, done);
        // A word that no code took would have an effect that is not understood.
        for (letter, word) in block.left() {
            // Words are left over where the code that wants them could not be understood.
            if failed {
                continue;
            }
            let text_of = text.get(word.at..word.end).unwrap_or_default();
            let remark = left_over(letter, text_of, word.at, &state.control);
            state.log.fault(text, remark);
        }
        if let Some(word) = block.polar.radius.or(block.polar.angle).filter(|_| !failed) {
            let message = "polar coordinates without a motion";
            state.log.fault(text, ReadRemark::new(word.at, message, "write G0 or G1 before them"));
        }
        for (key, value) in block.assignments.drain(..) {
            // Setting #3000 stops a Fanuc control with an alarm.
            if key == parameters::ALARM && self.dialect != Dialect::LinuxCnc {
                let message = "the program raises an alarm here (#3000)";
                state.log.fault(text, ReadRemark::new(0, message, "look at what it found wrong"));
            }
            if let ParameterKey::Name(name) = &key
                && self.dialect == Dialect::LinuxCnc
                && (name.starts_with("_ini[") || name.starts_with("_hal["))
            {
                let message = format!("#<{name}> belongs to the control and cannot be set");
                state.log.fault(text, ReadRemark::new(0, message, "use another name"));
            }
            self.parameters.set(key, value);
        }
        self.after(state, &now, text);
    }

    /// Runs the actions after the motion of a block: stops, ends, calls.
    pub(super) fn after(&mut self, state: &mut ReaderState, now: &BlockActions, text: &str) {
        for &(at, end) in now.stops.iter().flatten() {
            state.control.keep(state.log.line, text.get(at..end).unwrap_or_default());
        }
        // Stops and ends take effect behind the motion of their line.
        state.control.ended |= now.ends;
        self.order_steps(state);
        if let Some((label, times, at)) = &now.call {
            let call = SubCall {
                kind: if now.calls_locally { SubKind::Local } else { SubKind::Numbered },
                label: label.clone(),
                arguments: now.arguments.clone(),
                names: Vec::new(),
                times: *times,
            };
            let line = FileLine { number: state.log.line, text };
            let done = self.run_sub(call, CallSite { line, at: *at });
            note(state, text, done);
        }
        match now.return_to {
            Some((line, at)) if now.returns => {
                // M99 P10 leaves the subprogram before the jump.
                if matches!(
                    self.flow.frames.last().map(|frame| frame.of),
                    Some(FrameKind::Numbered { .. })
                ) {
                    self.leave(state);
                }
                let done = self.go_to(state, at, line);
                note(state, text, done);
            }
            _ if now.returns => self.return_numbered(state),
            _ => {}
        }
    }

    /// Runs `M99`.
    pub(super) fn return_numbered(&mut self, state: &mut ReaderState) {
        match self.flow.frames.last_mut() {
            Some(frame) => match &mut frame.of {
                // M98 with L runs the subprogram again from the line behind its label.
                FrameKind::Numbered { again: 0, .. } => self.leave(state),
                FrameKind::Numbered { again, .. } => (*again, frame.next) = (*again - 1, 1),
                _ => state.control.ended = true,
            },
            // The main program would begin anew, and what it does is known by then.
            None => state.control.ended = true,
        }
    }

    /// Reports a missing end; a file of subprograms has no end of its own.
    pub(in crate::read) fn finish(&mut self, state: &mut ReaderState) {
        if let Some((line, open)) = self.flow.open().filter(|_| !state.control.ended) {
            state.log.line = line.number;
            state.log.fault(&line.text, open);
            return;
        }
        self.warn_of_uncalled(state);
        let open = self.macros.open();
        // A file of subprograms alone needs no end.
        if open.is_some() || self.ran || !self.flow.has_subs() {
            state.unended(open, "end it with M2 or M30");
        }
    }
}

/// Notes what went wrong.
pub(super) fn note(state: &mut ReaderState, text: &str, done: Result<(), ReadRemark>) {
    if let Err(remark) = done {
        state.log.fault(text, remark);
    }
}
