//! Macro statements of Fanuc and Haas: `IF [..] GOTO 10`, `WHILE [..] DO 1`, `END 1`, `G65 P1000 A1.`.

use super::super::log::{Remark, excerpt};
use super::super::reader::State;
use super::super::tape::Tape;
use super::block::Block;
use super::codes::{Now, natural};
use super::expression::Scan;
use super::{Gcode, label};
use crate::read::Dialect;

/// Loops in loops: a control has three, and a jump may leave some behind.
const DEEPEST: usize = 100;

/// Letters of `G65` and the parameters they set.
const ARGUMENTS: [(char, usize); 21] = [
    ('A', 1),
    ('B', 2),
    ('C', 3),
    ('I', 4),
    ('J', 5),
    ('K', 6),
    ('D', 7),
    ('E', 8),
    ('F', 9),
    ('H', 11),
    ('M', 13),
    ('Q', 17),
    ('R', 18),
    ('S', 19),
    ('T', 20),
    ('U', 21),
    ('V', 22),
    ('W', 23),
    ('X', 24),
    ('Y', 25),
    ('Z', 26),
];

/// A statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Word {
    If,
    Goto,
    While,
    End,
}

const WORDS: [(&str, Word); 4] =
    [("IF", Word::If), ("GOTO", Word::Goto), ("WHILE", Word::While), ("END", Word::End)];

/// A `WHILE` that runs.
#[derive(Debug)]
struct Loop {
    number: u32,
    /// How many calls deep, and its line there.
    level: usize,
    line: usize,
}

/// What lines of the file are passed over for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Seek {
    /// `N10`.
    Number(u32),
    /// `END 1`.
    End(u32),
}

/// Jumps and loops of macro statements.
#[derive(Debug)]
pub(super) struct Macros {
    pub(super) tape: Tape,
    seek: Option<(Seek, u32)>,
    loops: Vec<Loop>,
}

impl Macros {
    pub(super) fn new(most: u64) -> Self {
        Self { tape: Tape::new(most), seek: None, loops: Vec::new() }
    }

    /// Whether a line of the file is passed over.
    pub(super) fn passes(&mut self, text: &str) -> bool {
        let Some((seek, _)) = self.seek else { return false };
        let end = end_of(text);
        if let Some(number) = end.filter(|number| seek != Seek::End(*number)) {
            // A jump out of a loop leaves it.
            self.loops.retain(|inner| inner.level > 0 || inner.number != number);
        }
        match seek {
            Seek::Number(number) if number_of(text) == Some(number) => {
                self.seek = None;
                false
            }
            Seek::End(number) => {
                if end == Some(number) {
                    self.seek = None;
                }
                true
            }
            Seek::Number(_) => true,
        }
    }

    /// Lines that ran `level` calls deep go on: loops of the deeper ones are over.
    pub(super) fn leave(&mut self, level: usize) {
        self.loops.retain(|inner| inner.level <= level);
    }

    /// What is still looked for when the file is over.
    pub(super) fn open(&self) -> Option<(u32, Remark)> {
        let (seek, line) = self.seek?;
        let remark = match seek {
            Seek::Number(number) => {
                let message = format!("N{number} is not in the file");
                Remark::new(0, message, "lines before the first # are not kept: jump to later ones")
            }
            Seek::End(number) => {
                Remark::new(0, format!("DO {number} has no END {number}"), "end the loop")
            }
        };
        Some((line, remark))
    }
}

/// Byte offset of a statement, which, and where it goes on.
fn statement(text: &str, from: usize) -> Option<(usize, Word, usize)> {
    let at = label::after_number(text, from);
    let rest = text.get(at..)?;
    let letters = rest.bytes().take_while(u8::is_ascii_alphabetic).count();
    let name = rest.get(..letters)?;
    let (_, word) = WORDS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    Some((at, *word, at + letters))
}

/// 10 of a line that begins `N10`.
fn number_of(text: &str) -> Option<u32> {
    let rest = text.trim_start().strip_prefix(['N', 'n'])?.trim_start();
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    rest.get(..digits)?.parse().ok()
}

/// 1 of `END 1`.
fn end_of(text: &str) -> Option<u32> {
    let (_, word, behind) = statement(text, 0)?;
    let rest = text.get(behind..)?.trim_start();
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    if word == Word::End { rest.get(..digits)?.parse().ok() } else { None }
}

impl Gcode {
    /// Does what a macro statement says, if a line is one; whether it was.
    pub(super) fn statement(
        &mut self,
        state: &mut State,
        (text, from): (&str, usize),
        line: usize,
    ) -> Result<bool, Remark> {
        if self.dialect == Dialect::LinuxCnc {
            return Ok(false);
        }
        let Some((at, word, behind)) = statement(text, from) else { return Ok(false) };
        let mut scan = Scan::new(text, behind);
        match word {
            Word::If => self.condition_of_macro(state, (text, at), behind)?,
            Word::Goto => {
                let number = scan.value(&self.env(state))?.number;
                nothing_more(&mut scan)?;
                self.go_to(state, at, number)?;
            }
            Word::While => self.while_do(state, (scan, at), line)?,
            Word::End => {
                let number = natural_at(scan.value(&self.env(state))?.number, at)?;
                nothing_more(&mut scan)?;
                self.end(number, at)?;
            }
        }
        Ok(true)
    }

    /// `IF [..] GOTO 10`, `IF [..] THEN #1 = 5`.
    fn condition_of_macro(
        &mut self,
        state: &mut State,
        (text, at): (&str, usize),
        behind: usize,
    ) -> Result<(), Remark> {
        let mut scan = Scan::new(text, behind);
        let holds = scan.bracket(&self.env(state))?.abs() > 0.0;
        scan.blanks();
        let word = scan.rest().bytes().take_while(u8::is_ascii_alphabetic).count();
        let name = scan.rest().get(..word).unwrap_or_default().to_ascii_uppercase();
        let word_at = scan.at;
        scan.at += word;
        match name.as_str() {
            "GOTO" => {
                let number = scan.value(&self.env(state))?.number;
                nothing_more(&mut scan)?;
                if holds { self.go_to(state, at, number) } else { Ok(()) }
            }
            "THEN" => {
                if holds {
                    self.plain(state, (text, scan.at));
                }
                Ok(())
            }
            _ => Err(Remark::new(word_at, "IF without GOTO or THEN", "write IF [#1 LT 5] GOTO 10")),
        }
    }

    /// `WHILE [..] DO 1`.
    fn while_do(
        &mut self,
        state: &State,
        (mut scan, at): (Scan<'_>, usize),
        line: usize,
    ) -> Result<(), Remark> {
        let holds = scan.bracket(&self.env(state))?.abs() > 0.0;
        scan.blanks();
        let does = scan.rest().get(..2).is_some_and(|word| word.eq_ignore_ascii_case("DO"));
        if !does {
            return Err(Remark::new(scan.at, "WHILE without DO", "write WHILE [#1 LT 5] DO 1"));
        }
        scan.at += 2;
        let number = natural_at(scan.value(&self.env(state))?.number, at)?;
        nothing_more(&mut scan)?;
        let level = self.flow.frames.len();
        self.macros.loops.retain(|inner| inner.level < level || inner.line < line);
        if !holds {
            return self.pass_to_end(state, number, at);
        }
        if self.macros.loops.len() >= DEEPEST {
            let message = format!("more than {DEEPEST} loops in each other");
            return Err(Remark::new(at, message, "does a jump lead into a loop again and again?"));
        }
        self.macros.loops.push(Loop { number, level, line });
        Ok(())
    }

    fn pass_to_end(&mut self, state: &State, number: u32, at: usize) -> Result<(), Remark> {
        let Some(frame) = self.flow.frames.last_mut() else {
            self.macros.seek = Some((Seek::End(number), state.log.line));
            return Ok(());
        };
        let mut behind = frame.lines.iter().enumerate().skip(frame.next);
        let Some((end, _)) = behind.find(|(_, (_, text))| end_of(text) == Some(number)) else {
            return Err(Remark::new(
                at,
                format!("DO {number} has no END {number}"),
                "end the loop",
            ));
        };
        self.left = self.left.saturating_sub(u64::try_from(end - frame.next).unwrap_or(u64::MAX));
        frame.next = end + 1;
        Ok(())
    }

    /// `END 1`.
    fn end(&mut self, number: u32, at: usize) -> Result<(), Remark> {
        let level = self.flow.frames.len();
        let inner = self.macros.loops.pop();
        let Some(inner) = inner.filter(|of| of.number == number && of.level == level) else {
            let message = format!("END {number}: nothing was begun that it could end");
            return Err(Remark::new(at, message, "loops must lie inside of each other"));
        };
        match self.flow.frames.last_mut() {
            Some(frame) => frame.next = inner.line,
            None => self.macros.tape.go_to(u32::try_from(inner.line).unwrap_or(u32::MAX)),
        }
        Ok(())
    }

    /// `GOTO 10`: a line of the same program.
    pub(super) fn go_to(&mut self, state: &State, at: usize, number: f64) -> Result<(), Remark> {
        let number = natural_at(number, at)?;
        let level = self.flow.frames.len();
        if let Some(frame) = self.flow.frames.last_mut() {
            let found = frame.lines.iter().position(|(_, text)| number_of(text) == Some(number));
            let Some(to) = found else {
                let message = format!("N{number} is not in this subprogram");
                return Err(Remark::new(at, message, "GOTO does not lead out of subprograms"));
            };
            self.left = self.left.saturating_sub(u64::try_from(to).unwrap_or(u64::MAX));
            frame.next = to;
            self.macros.loops.retain(|inner| inner.level < level || inner.line < to);
            return Ok(());
        }
        let line = state.log.line;
        let is = |text: &str| number_of(text) == Some(number);
        match self.macros.tape.back(line.saturating_add(1), is)? {
            Some(to) => {
                let first = usize::try_from(to).unwrap_or(usize::MAX);
                self.macros.loops.retain(|inner| inner.line < first);
                self.macros.tape.go_to(to);
            }
            None => self.macros.seek = Some((Seek::Number(number), line)),
        }
        Ok(())
    }
}

/// A call that every move makes: `G66`.
#[derive(Debug, Clone)]
pub(super) struct EachMove {
    program: Box<str>,
    arguments: Vec<f64>,
    /// How many calls deep it was given: moves of the macro itself make none.
    level: usize,
    at: usize,
}

impl Gcode {
    /// `G65 P1000 A1. B2.`, a subprogram with parameters of its own; `G66`, the same behind every move.
    pub(super) fn macro_call(
        &mut self,
        block: &mut Block,
        (text, now): (&str, &mut Now),
    ) -> Result<(), Remark> {
        let modal = block.codes.iter().any(|code| code.tenths == MODAL);
        let (program, arguments, at) = called(block, text)?;
        let program: Box<str> = program.to_string().into();
        if modal {
            let level = self.flow.frames.len();
            self.modal.each = Some(EachMove { program, arguments, level, at });
        } else {
            now.call = Some((program, 1, at));
            now.arguments = Some(arguments);
        }
        Ok(())
    }

    /// The call that `G66` makes behind a move.
    pub(super) fn call_behind_move(&self, now: &mut Now) {
        let level = self.flow.frames.len();
        if let Some(each) = self.modal.each.as_ref().filter(|each| each.level == level)
            && now.call.is_none()
        {
            now.call = Some((each.program.clone(), 1, each.at));
            now.arguments = Some(each.arguments.clone());
        }
    }
}

/// `G66`.
const MODAL: u32 = 660;

/// Program and arguments of a call, and its place.
fn called(block: &mut Block, text: &str) -> Result<(u32, Vec<f64>, usize), Remark> {
    let call = block.codes.first().copied().filter(|_| block.codes.len() == 1);
    let Some(call) = call else {
        let at = block.codes.first().map_or(0, |code| code.at);
        let message = "G65 or G66 beside other codes";
        return Err(Remark::new(at, message, "put it on a line of its own"));
    };
    let program = block.take('P').ok_or_else(|| {
        Remark::new(call.at, "a macro call without a program", "write P and its number")
    })?;
    let times = block.take('L').map(|word| natural(word, 'L')).transpose()?;
    if times.is_some_and(|times| times != 1) {
        let message =
            format!("{} with L", excerpt(text.get(call.at..call.end).unwrap_or_default()));
        return Err(Remark::new(call.at, message, "write the call as often as it is to run"));
    }
    let mut arguments = vec![0.0; 26];
    for (letter, number) in ARGUMENTS {
        if let (Some(word), Some(place)) = (block.take(letter), arguments.get_mut(number - 1)) {
            *place = word.value;
        }
    }
    _ = block.take('N');
    let program = natural(program, 'P')?;
    Ok((program, arguments, call.at))
}

/// Behind a statement stand comments at most.
fn nothing_more(scan: &mut Scan<'_>) -> Result<(), Remark> {
    scan.blanks();
    let rest = scan.rest();
    if rest.is_empty() || rest.starts_with(['(', ';']) {
        return Ok(());
    }
    Err(Remark::new(scan.at, "something behind a macro statement", "put it on a line of its own"))
}

/// A number of a line or loop.
fn natural_at(value: f64, at: usize) -> Result<u32, Remark> {
    // Numbers are reckoned with, too.
    let whole = value.round();
    if (value - whole).abs() > 1e-4 || !(0.0..=f64::from(u32::MAX)).contains(&whole) {
        return Err(Remark::new(at, format!("{value} must be a whole number from 0"), ""));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let whole = whole as u32;
    Ok(whole)
}
