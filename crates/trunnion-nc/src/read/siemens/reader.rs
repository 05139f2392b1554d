//! Sinumerik programs: `X10`, `A3=0.5`, `C=ACP(33)`, `CYCLE832(..)`, `R1=5`.

use super::cycle::SiemensCycle;
use super::flow::SiemensFlow;
use super::head::BlockHead;
use super::line::{CenterWord, FrameEffect, PolarPole, SiemensBlock, SiemensMotion};
use super::rotary::unwound;
use super::value::ValueMode;
use super::word::{SiemensWord, WordName};
use super::{value, word};
use crate::read::control::{DistanceMode, FeedUnit, LARGEST};
use crate::read::log::{FileLine, ReadRemark, column};
use crate::read::options::ReadOptions;
use crate::read::remedy::undecided_block;
use crate::read::state::ReaderState;
use crate::read::step::LengthEntry;
use std::collections::HashMap;

/// Reader of Sinumerik programs.
#[derive(Debug)]
pub(in crate::read) struct SiemensReader {
    pub(super) motion: Option<SiemensMotion>,
    pub(super) distance: DistanceMode,
    /// Unit of F words to come.
    pub(super) feed_unit: FeedUnit,
    /// 0: XY, 1: ZX, 2: YZ.
    pub(super) plane: usize,
    /// R parameters and variables, upper case.
    pub(super) variables: HashMap<Box<str>, f64>,
    pub(super) flow: SiemensFlow,
    pub(super) polar: PolarPole,
    /// Drilled behind every block that moves: `MCALL`.
    pub(super) modal_cycle: Option<SiemensCycle>,
    pub(super) lines: u32,
    pub(super) block_delete: Option<bool>,
}

impl SiemensReader {
    pub(in crate::read) fn new(options: &ReadOptions) -> Self {
        let name = |name: &str| name.trim().to_ascii_uppercase().into_boxed_str();
        let given = options.parameters.iter().map(|(key, value)| (name(key), *value));
        Self {
            motion: None,
            distance: DistanceMode::Absolute,
            feed_unit: FeedUnit::Millimetre,
            plane: 0,
            variables: given.collect(),
            flow: SiemensFlow::new(options.most_repeated),
            polar: PolarPole::default(),
            modal_cycle: None,
            lines: 0,
            block_delete: options.block_delete,
        }
    }

    /// Returns true if lines are to be run before the next of the file.
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
        state.unended(self.flow.open(), "end it with M30, M17 or RET");
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
        let code = word::without_comment(text);
        state.control.length |= self.lines == 1;
        let start = code.len() - code.trim_start().len();
        // `%_N_NAME_MPF`, `$PATH=..`, `PROC NAME`: names of the file.
        if code.trim().is_empty() || is_name(code.trim_start()) {
            return;
        }
        if code.trim_start().starts_with('$') {
            let message = "system variables are not known, and what they set is the control's";
            let help = "write tool data and offsets at the control; post plain coordinates";
            return state.log.fault(text, ReadRemark::new(start, message, help));
        }
        let mut from = start;
        if code.as_bytes().get(from) == Some(&b'/') {
            match self.block_delete {
                Some(true) => from += 1,
                Some(false) => return,
                None => return state.log.fault(text, undecided_block(from)),
            }
        }
        // The beginning of a block decides whether it runs, and what may lead back to it.
        let head = BlockHead::of(code, from);
        if head.may_return() {
            self.flow.tape.keep(text);
        }
        if self.flow.passes(&head) {
            return;
        }
        let done = match head.word {
            Some(word) => self.decide(state, code, &head, word),
            None => self.block(state, code, head.at),
        };
        match done {
            Err(remark) => state.log.fault(text, remark),
            Ok(()) if !head.label.is_empty() => self.flow.end_section(head.label),
            Ok(()) => {}
        }
    }

    pub(super) fn block(
        &mut self,
        state: &mut ReaderState,
        code: &str,
        from: usize,
    ) -> Result<(), ReadRemark> {
        let mut items = word::SiemensWords::new(code, from);
        let mut line = SiemensBlock::new();
        while let Some(item) = items.next_item()? {
            match item.name {
                WordName::Code(number) => self.code(state, &mut line, &item, number, code)?,
                WordName::Text(_) => self.word(state, &mut line, &item, code)?,
            }
        }
        if line.target.at == usize::MAX {
            line.target.at = from;
        }
        line.target.column = column(code, line.target.at);
        self.run(state, line, code)
    }

    /// Applies a word that carries a value, or a call.
    pub(super) fn word(
        &mut self,
        state: &mut ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        code: &str,
    ) -> Result<(), ReadRemark> {
        let name = item.text_name().to_ascii_uppercase();
        // Two letters at least: a single letter with a number is an address.
        let named = name.bytes().take(2).all(|byte| byte.is_ascii_alphabetic() || byte == b'_');
        let known = name.len() > 1 && named && self.variables.contains_key(name.as_str());
        if (known || item.number_of("R").is_some()) && item.is_assignment() {
            let (value, _) = self.value(item)?;
            self.variables.insert(name.into(), value.number);
            // From here on a loop may count, and lead back to any block number.
            self.flow.tape.keep(code);
            return Ok(());
        }
        // A3 B3 C3 are the components of the tool axis under TRAORI.
        if let Some(at) = ["A3", "B3", "C3"].iter().position(|known| *known == name) {
            if let Some(place) = line.vector.get_mut(at) {
                *place = Some(self.value(item)?.0.number);
            }
            line.target.at = line.target.at.min(item.at);
            return Ok(());
        }
        match name.as_str() {
            "I" | "J" | "K" => self.center(state, line, item, &name),
            "CR" => {
                line.radius = Some(state.control.scale() * self.value(item)?.0.number);
                Ok(())
            }
            "AP" | "RP" => self.polar_word(state, line, item, &name),
            "RPL" if line.frame.is_some() => {
                let angle = self.value(item)?.0.number;
                if let Some(frame) = line.frame.as_mut() {
                    frame.in_plane = Some(angle);
                }
                Ok(())
            }
            "TURN" => {
                line.turns = value::natural(self.value(item)?.0.number, item.at)?;
                Ok(())
            }
            "F" => {
                let value = self.value(item)?.0;
                state.control.note_feed(value.decimals);
                line.feed = Some(value.number);
                Ok(())
            }
            // S1= and M1= are of the first spindle.
            "M1" if item.is_assignment() => {
                let number = value::natural(self.value(item)?.0.number, item.at)?;
                Self::spindle_code(state, line, item, number, code);
                Ok(())
            }
            "S" | "S1" => {
                line.speed = Some(self.value(item)?.0.number);
                Ok(())
            }
            "T" => self.tool(state, line, item, code),
            "D" => {
                // D0 cancels the offsets of the tool; any other D selects one of its edges.
                let edge = value::natural(self.value(item)?.0.number, item.at)?;
                state.control.choose_length(state.log.line, LengthEntry::Edge(edge));
                if edge > 0 {
                    state.control.enable_length();
                } else {
                    state.control.disable_length();
                }
                Ok(())
            }
            "N" | "H" => Ok(()),
            "L" | "P" => Self::keyword(state, line, item, &name, code),
            _ => self.axis_or_keyword(state, line, item, &name, code),
        }
    }

    pub(super) fn center(
        &self,
        state: &ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        name: &str,
    ) -> Result<(), ReadRemark> {
        let (value, mode) = self.value(item)?;
        let at = usize::from(name.as_bytes().first().map_or(0, |byte| byte - b'I'));
        if let Some(place) = line.center.get_mut(at) {
            let absolute = mode == ValueMode::Absolute;
            *place = Some(CenterWord {
                value: state.control.scale() * value.number,
                mode: if absolute { DistanceMode::Absolute } else { DistanceMode::Incremental },
            });
        }
        Ok(())
    }

    /// Reads `T="NAME"` or `T5`: a name is kept, and counts as the number in it.
    pub(super) fn tool(
        &self,
        state: &mut ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        code: &str,
    ) -> Result<(), ReadRemark> {
        let number = if let Some(name) = item.quoted() {
            let text = code.get(item.at..item.end).unwrap_or_default();
            state.control.keep(state.log.line, text);
            let digits = name.chars().filter(char::is_ascii_digit).take(9).collect::<String>();
            digits.parse().unwrap_or(0)
        } else {
            value::natural(self.value(item)?.0.number, item.at)?
        };
        line.tool = Some(number);
        Ok(())
    }

    /// Reads `X10`, `X=IC(2)`, `C=ACP(33)`, or a word without motion.
    pub(super) fn axis_or_keyword(
        &mut self,
        state: &mut ReaderState,
        line: &mut SiemensBlock,
        item: &SiemensWord<'_>,
        name: &str,
        code: &str,
    ) -> Result<(), ReadRemark> {
        let slot = match name.as_bytes() {
            [letter] => state.control.slot(*letter),
            _ => None,
        };
        let Some(slot) = slot else {
            if matches!(name.as_bytes(), [b'A'..=b'Z']) && item.has_value() {
                let text = code.get(item.at..item.end).unwrap_or_default();
                return Err(state.control.no_axis(item.at, text));
            }
            if name == "CYCLE800" {
                return self.swivel(state, item);
            }
            if matches!(name, "HOLES1" | "HOLES2") {
                return self.pattern(state, item, name, code);
            }
            if let Some(cycle) = self.drilling_cycle(state, item, name)? {
                line.cycle = Some(cycle);
                return Ok(());
            }
            if let Some(smoothing) = self.smoothing(item, name)? {
                state.control.smooth(state.log.line, smoothing);
            }
            return Self::keyword(state, line, item, name, code);
        };
        let (value, mode) = self.value(item)?;
        // Behind ROT, MIRROR and SCALE the words of axes are angles and factors.
        if let Some(frame) = line.frame.as_mut().filter(|frame| frame.kind != FrameEffect::Shift) {
            let axis = state.control.xyz.iter().position(|axis| *axis == slot);
            let Some(place) = axis.and_then(|axis| frame.values.get_mut(axis)) else {
                let message = format!("{name} in a frame that turns, mirrors or scales");
                return Err(ReadRemark::new(item.at, message, "X, Y and Z are"));
            };
            *place = Some(value.number);
            return Ok(());
        }
        if line.target.get(slot).is_some() {
            let message = format!("second {name} word on this line");
            return Err(ReadRemark::new(item.at, message, "keep one of them"));
        }
        if value.number.abs() > LARGEST {
            let message = format!("{name} is beyond {LARGEST} mm or degrees");
            return Err(ReadRemark::new(item.at, message, "is a point missing?"));
        }
        let meant = state.control.meant(slot, value.number, value.decimals);
        // AC and IC go before G90 and G91; DC, ACP and ACN are coordinates.
        let distance = match mode {
            ValueMode::Plain => self.distance,
            ValueMode::Incremental => DistanceMode::Incremental,
            _ => DistanceMode::Absolute,
        };
        let meant = unwound(state, slot, meant, mode, item)?;
        line.target.set(slot, meant, distance);
        line.target.at = line.target.at.min(item.at);
        Ok(())
    }
}

/// Returns true for a line that names the file.
fn is_name(code: &str) -> bool {
    let begins =
        |word: &str| code.get(..word.len()).is_some_and(|head| head.eq_ignore_ascii_case(word));
    // PROC with parameters has values that only its caller knows.
    code.starts_with('%') || begins("$PATH") || begins("PROC ") && !code.contains('(')
}
