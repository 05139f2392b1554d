//! Klartext: `L X+10 FMAX`, `LN .. TX TY TZ`, `CC`, `C`, `CYCL DEF`, `Q1 = 5`.

use super::contour::{ContourStep, HeldElement, OpenCorner};
use super::drilling_cycle::KlartextCycle;
use super::flow;
use super::flow::KlartextFlow;
use super::frame::ProgramFrame;
use super::iso::IsoModes;
use super::token::{Token, Tokens, is_q};
use super::units::value_begins;
use crate::read::control::{FeedMode, SLOTS};
use crate::read::dialect::is_heidenhain_iso;
use crate::read::log::{FileLine, ReadRemark, excerpt};
use crate::read::options::ReadOptions;
use crate::read::remedy::undecided_block;
use crate::read::state::ReaderState;
use crate::read::step::Step;
use std::collections::{HashMap, VecDeque};

/// Words of contour elements.
const CONTOUR: [&str; 8] = ["L", "LP", "C", "CR", "CT", "CP", "CTP", "APPR"];

/// Longest block joined by `~` \[bytes\].
const LONGEST: usize = 10_000;

/// Pace of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LastPace {
    /// `FMAX`.
    Rapid,
    Feed,
}

/// Reader of Klartext.
#[derive(Debug)]
pub(in crate::read) struct HeidenhainReader {
    /// `Q1` and so on.
    pub(super) variables: HashMap<Box<str>, f64>,
    /// `CC` \[mm\], by X Y Z.
    pub(super) pole: [Option<f64>; 3],
    /// Indices of the two of X Y Z that span the plane of circles; the tool axis is the third.
    pub(super) plane: [usize; 2],
    /// `M126`.
    pub(super) shortest: bool,
    /// `AXIS SPAT`: rotary words are angles in space.
    pub(super) spatial: bool,
    /// The cycle being defined.
    pub(super) cycle: u32,
    /// The drilling cycle that `M99` and `CYCL CALL` run.
    pub(super) drilling: Option<KlartextCycle>,
    /// The program has turned a rotary axis, or a plane may have.
    pub(super) turned: bool,
    /// Upper end of the travel of Z \[mm\].
    pub(super) retract_height: Option<f64>,
    /// F of the last `TOOL CALL`, for `FAUTO` \[units/min\].
    pub(super) tool_feed: Option<f64>,
    /// `M136`: F is one per revolution.
    pub(super) feed_mode: FeedMode,
    /// Pace of the last block that moved.
    pub(super) last_pace: Option<LastPace>,
    /// Cycles 8 and 10.
    pub(super) frame: ProgramFrame,
    /// The contour element that waits for the next block.
    pub(super) held: Option<HeldElement>,
    /// Direction in the plane in which the last contour element ended.
    pub(super) heading: Option<[f64; 2]>,
    /// The corner that the element being run opens: an approach.
    pub(super) opened: Option<OpenCorner>,
    /// Modes of a DIN/ISO program; none: Klartext.
    pub(super) iso: Option<IsoModes>,
    /// Names of tools by the numbers that they were given.
    pub(super) tool_names: HashMap<u32, Box<str>>,
    pub(super) flow: KlartextFlow,
    pub(super) lines: u32,
    /// A block that goes on, and its first line.
    pub(super) joined: String,
    pub(super) first: u32,
    pub(super) block_delete: Option<bool>,
}

impl HeidenhainReader {
    pub(in crate::read) fn new(options: &ReadOptions) -> Self {
        let name = |name: &str| name.trim().to_ascii_uppercase().into_boxed_str();
        let given = options.parameters.iter().map(|(key, value)| (name(key), *value));
        Self {
            variables: given.collect(),
            pole: [None; 3],
            plane: [0, 1],
            shortest: false,
            spatial: false,
            cycle: 0,
            drilling: None,
            turned: false,
            retract_height: options.retract_height,
            tool_feed: None,
            feed_mode: FeedMode::PerMinute,
            last_pace: None,
            frame: ProgramFrame::default(),
            held: None,
            heading: None,
            opened: None,
            iso: None,
            tool_names: HashMap::new(),
            flow: KlartextFlow::new(options.most_repeated),
            lines: 0,
            joined: String::new(),
            first: 0,
            block_delete: options.block_delete,
        }
    }

    /// Returns true if blocks are to be run before the next of the file.
    pub(in crate::read) fn is_busy(&self) -> bool {
        self.flow.tape.is_busy()
    }

    /// Runs one of them.
    pub(in crate::read) fn advance(&mut self, state: &mut ReaderState) {
        if let Some((number, text)) = state.replayed(&mut self.flow.tape) {
            self.run_line(state, FileLine { number, text: &text });
        }
    }

    /// Reports a missing end.
    pub(in crate::read) fn finish(&self, state: &mut ReaderState) {
        state.unended(self.flow.open(), "end it with END PGM or M30");
    }

    /// Reads a line of the file.
    pub(in crate::read) fn line(&mut self, state: &mut ReaderState, text: &str) {
        self.lines = self.lines.saturating_add(1);
        self.flow.tape.record(self.lines, text);
        self.run_line(state, FileLine { number: self.lines, text });
    }

    /// Runs a line, for the first time or again.
    pub(super) fn run_line(&mut self, state: &mut ReaderState, line: FileLine<'_>) {
        let FileLine { number, text } = line;
        state.log.line = number;
        // A tool called before the program begins is as good as one called in it.
        state.control.length |= self.lines == 1;
        // Behind a semicolon stands a comment.
        let (code, comment) = text.split_once(';').unwrap_or((text, ""));
        let code = code.trim_end();
        // A tilde continues the block on the next line, as long cycles are written; it also stands
        // behind the comment of a parameter.
        let goes_on = comment.trim_end().ends_with('~') && !code.trim().is_empty();
        if let Some(part) = code.strip_suffix('~').or(goes_on.then_some(code)) {
            self.begin_or_go_on(number, part);
            if self.joined.len() > LONGEST {
                let message = format!("a block of more than {LONGEST} bytes");
                state.log.fault(
                    text,
                    ReadRemark::new(0, message, "look at the ~ at the ends of its lines"),
                );
                self.joined.clear();
            }
            return;
        }
        if self.joined.is_empty() {
            return self.block(state, code);
        }
        self.begin_or_go_on(number, code);
        state.log.line = self.first;
        let block = std::mem::take(&mut self.joined);
        self.block(state, &block);
    }

    pub(super) fn begin_or_go_on(&mut self, number: u32, part: &str) {
        if self.joined.is_empty() {
            self.first = number;
        }
        self.joined.push_str(part);
        self.joined.push(' ');
    }

    pub(super) fn block(&mut self, state: &mut ReaderState, code: &str) {
        let done = match self.skips(code) {
            Ok(Some(_)) if self.lines == 1 && is_heidenhain_iso(code) => {
                state.control.inch = code.to_ascii_uppercase().contains("G70");
                self.iso = Some(IsoModes::new());
                Ok(())
            }
            Ok(Some(from)) if self.iso.is_some() => self.iso_block(state, code, from),
            Ok(Some(from)) => self.statement(state, code, from),
            Ok(None) => Ok(()),
            Err(remark) => Err(remark),
        };
        if let Err(remark) = done {
            state.log.fault(code, remark);
        }
    }

    /// Returns the start of a block after `/` and its number; `None`: it is skipped or empty.
    pub(super) fn skips(&self, code: &str) -> Result<Option<usize>, ReadRemark> {
        let mut from = code.len() - code.trim_start().len();
        let digits = |from: usize| {
            let rest = code.get(from..).unwrap_or_default();
            let count = rest.bytes().take_while(u8::is_ascii_digit).count();
            let behind = rest.get(count..).unwrap_or_default();
            from + count + behind.len() - behind.trim_start().len()
        };
        from = digits(from);
        if code.as_bytes().get(from) == Some(&b'/') {
            match self.block_delete {
                Some(true) => from = digits(from + 1),
                Some(false) => return Ok(None),
                None => return Err(undecided_block(from)),
            }
        }
        let rest = code.get(from..).unwrap_or_default();
        // `* -` begins a heading.
        Ok((!rest.is_empty() && !rest.starts_with('*')).then_some(from))
    }

    /// Runs a block of a DIN/ISO program.
    fn iso_block(
        &mut self,
        state: &mut ReaderState,
        code: &str,
        from: usize,
    ) -> Result<(), ReadRemark> {
        // What is kept to be run again, from a label or a call on, is the line as it stands.
        if code.contains(['L', 'l']) {
            self.flow.tape.keep(code);
        }
        let Some(mut modes) = self.iso else { return Ok(()) };
        let lines = modes.translate(code, from)?;
        // Blocks up to a label that is searched change nothing.
        if self.flow.seek.is_none() {
            self.iso = Some(modes);
        }
        for line in lines {
            // Columns count in the block, not in what it stands for.
            self.statement(state, &line, 0).map_err(|remark| ReadRemark { at: from, ..remark })?;
        }
        Ok(())
    }

    pub(super) fn statement(
        &mut self,
        state: &mut ReaderState,
        code: &str,
        from: usize,
    ) -> Result<(), ReadRemark> {
        let label = flow::label_of(code, from);
        if label.is_some() || starts(code, from, "CALL") || starts(code, from, "FN") {
            // Blocks may be run again from here on.
            self.flow.tape.keep(code);
        }
        if let Some(label) = label.filter(|label| *label != "0") {
            self.flow.note(label, state.log.line);
        }
        // Blocks up to the label that is searched are not run.
        if self.flow.passes(label) {
            return Ok(());
        }
        if let Some(label) = label {
            self.label(label);
            return Ok(());
        }
        let mut tokens = Tokens::new(code, from);
        let Some(first) = tokens.next_token() else { return Ok(()) };
        let word = first.text.to_ascii_uppercase();
        if matches!(word.as_str(), "RND" | "CHF") {
            return self.corner(state, &word, &first, tokens);
        }
        // Only a corner may follow an element that waits.
        if let Some(held) = self.held.take_if(|held| held.corner().is_none()) {
            held.release(&mut state.control);
        }
        let mut released = std::mem::take(&mut state.control.steps);
        let start = state.control.place;
        self.run(state, code, from)?;
        self.settle(state, start, &word)?;
        // What waited comes before what this block makes.
        released.append(&mut state.control.steps);
        state.control.steps = released;
        Ok(())
    }

    /// Lets the last contour element wait for the next block, or closes the corner that waits for it.
    fn settle(
        &mut self,
        state: &mut ReaderState,
        start: [Option<f64>; SLOTS],
        word: &str,
    ) -> Result<(), ReadRemark> {
        let mut steps = std::mem::take(&mut state.control.steps);
        let plane = self.plane_slots(state);
        let moves = steps.iter().filter(|step| matches!(step, Step::Move(_))).count();
        let is_contour = CONTOUR.contains(&word) && moves == 1;
        let at = steps.iter().position(|step| matches!(step, Step::Move(_)));
        if moves > 0 {
            self.heading = None;
        }
        let end = state.control.place;
        let element = match at.and_then(|at| steps.get(at)) {
            Some(Step::Move(step)) => Some(ContourStep { step: *step, start, end, plane }),
            _ => None,
        };
        let Some((element, at)) = element.filter(|_| is_contour).zip(at) else {
            return self.pass(state, steps);
        };
        self.heading = element.heading();
        let behind = steps.split_off(at + 1);
        _ = steps.pop_back();
        let mut waiting = None;
        match self.held.take() {
            Some(mut held) if held.corner().is_some() => {
                held.follow(steps)?;
                let rest = held.close(&mut state.control, &element)?;
                waiting = Some(HeldElement::new(&rest, self.opened.take()));
            }
            held => {
                if let Some(held) = held {
                    held.release(&mut state.control);
                }
                state.control.steps.extend(steps);
            }
        }
        let mut waiting = waiting.unwrap_or_else(|| HeldElement::new(&element, self.opened.take()));
        waiting.follow(behind)?;
        // Behind the end of the program no further block comes.
        if state.control.ended {
            waiting.release(&mut state.control);
        } else {
            self.held = Some(waiting);
        }
        Ok(())
    }

    /// Runs the element that waits, unless a corner waits with it.
    pub(in crate::read) fn release_element(&mut self, state: &mut ReaderState) {
        if let Some(held) = self.held.take_if(|held| held.corner().is_none()) {
            held.release(&mut state.control);
        }
    }

    /// Passes steps on that are no contour element.
    fn pass(&mut self, state: &mut ReaderState, steps: VecDeque<Step>) -> Result<(), ReadRemark> {
        let moves = steps.iter().any(|step| matches!(step, Step::Move(_)));
        let Some(held) = &mut self.held else {
            state.control.steps = steps;
            return Ok(());
        };
        if let (Some(corner), true) = (held.corner(), moves || state.control.ended) {
            let message = format!(
                "no contour element follows the corner or approach of line {}",
                corner.line
            );
            return Err(ReadRemark::new(0, message, "write L, C, CR, CT, LP or CP behind it"));
        }
        held.follow(steps)
    }

    fn run(&mut self, state: &mut ReaderState, code: &str, from: usize) -> Result<(), ReadRemark> {
        let mut tokens = Tokens::new(code, from);
        let Some(first) = tokens.next_token() else { return Ok(()) };
        let word = first.text.to_ascii_uppercase();
        match word.as_str() {
            "BEGIN" => Self::begin(state, &mut tokens),
            "END" => {
                state.control.ended = true;
                Ok(())
            }
            "BLK" | "TOOL" | "STOP" => self.technology(state, &first, code, &mut tokens),
            "L" | "LN" | "LP" | "C" | "CR" | "CT" | "CP" | "CTP" | "CC" => {
                self.path(state, &word, &first, tokens)
            }
            "APPR" | "DEP" => {
                let kind = tokens.expect()?.text.to_ascii_uppercase();
                self.path(state, &format!("{word} {kind}"), &first, tokens)
            }
            "TRANS" => self.trans(state, &first, code, &mut tokens),
            "FUNCTION" => self.function(state, &first, code, &mut tokens),
            "CYCL" | "CYCLE" => self.cycle(state, &first, code, &mut tokens),
            "PLANE" => self.plane(state, &first, Tokens::new(code, from)),
            "FN" => self.formula(state, &mut tokens, code),
            "CALL" => self.call(state, &first, code, &mut tokens),
            // Blanks beside the sign may be absent.
            _ if is_q(word.split('=').next().unwrap_or_default()) => self.assign(&first, code, 0),
            // `M3` and the like stand alone, too.
            _ if word.starts_with('M') || word.starts_with('S') => {
                self.path(state, "L", &first, Tokens::new(code, from))
            }
            _ => Err(not_understood(&first, code)),
        }
    }

    /// Runs `BEGIN PGM NAME MM`.
    pub(super) fn begin(
        state: &mut ReaderState,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let unit = std::iter::from_fn(|| tokens.next_token()).last();
        match unit {
            Some(unit) if unit.text.eq_ignore_ascii_case("INCH") => state.control.inch = true,
            Some(unit) if unit.text.eq_ignore_ascii_case("MM") => {}
            _ => return Err(ReadRemark::new(0, "BEGIN PGM without MM or INCH", "write the unit")),
        }
        Ok(())
    }

    pub(super) fn dwell(
        &self,
        state: &mut ReaderState,
        token: &Token<'_>,
    ) -> Result<(), ReadRemark> {
        // The time may be joined to its word.
        let digits = value_begins(token.text).unwrap_or(token.text.len());
        let seconds = self.value(&token.after(digits))?.value;
        let line = state.log.line;
        state.control.steps.push_back(Step::Dwell { line, seconds });
        Ok(())
    }

    /// Cancels the datum shift.
    pub(super) fn unshift(state: &mut ReaderState) {
        state.control.local = [0.0; SLOTS];
    }
}

/// Returns true if a block begins with a word.
pub(super) fn starts(code: &str, from: usize, word: &str) -> bool {
    code.get(from..from + word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word))
}

pub(super) fn not_understood(token: &Token<'_>, code: &str) -> ReadRemark {
    let rest = excerpt(code.get(token.at..).unwrap_or_default());
    let help = match token.text.to_ascii_uppercase().as_str() {
        "FL" | "FC" | "FLT" | "FCT" | "FPOL" | "FSELECT" => "write the contour as L, C and CR",
        _ => "is it the right dialect?",
    };
    ReadRemark::new(token.at, format!("{rest} is not understood as heidenhain"), help)
}
