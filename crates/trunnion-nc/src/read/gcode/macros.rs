//! Macro statements of Fanuc and Haas: `IF [..] GOTO 10`, `WHILE [..] DO 1`, `END 1`, `G65 P1000 A1.`.

use super::block::GcodeBlock;
use super::expression::ExpressionScan;
use super::label::line_number;
use super::macro_flow::{MacroLoop, MacroSeek, MacroWord, end_of};
use super::macro_flow::{output, statement};
use super::modal::{BlockActions, ModalCall};
use super::reader::GcodeReader;
use super::words::natural;
use crate::read::dialect::Dialect;
use crate::read::log::{LineTail, ReadRemark, excerpt};
use crate::read::state::ReaderState;
/// Deepest nesting of loops: a control has three, and a jump may leave some behind.
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

impl GcodeReader {
    /// Executes a macro statement; returns false if the line is none. `LinuxCNC` has none: it uses O words.
    pub(super) fn statement(
        &mut self,
        state: &mut ReaderState,
        tail: LineTail<'_>,
        line: usize,
    ) -> Result<bool, ReadRemark> {
        // LinuxCNC has O-words for all of these.
        if self.dialect == Dialect::LinuxCnc {
            return Ok(false);
        }
        let text = tail.text;
        if let Some(at) = output(text, tail.from) {
            state.control.keep(state.log.line, text.get(at..).unwrap_or_default());
            return Ok(true);
        }
        let Some((at, word, behind)) = statement(text, tail.from) else { return Ok(false) };
        let mut scan = ExpressionScan::new(text, behind);
        match word {
            MacroWord::If => self.condition_of_macro(state, text, at, behind)?,
            MacroWord::Goto => {
                let number = scan.value(&self.env(state))?.number;
                nothing_more(&mut scan)?;
                self.go_to(state, at, number)?;
            }
            MacroWord::While => self.while_do(state, scan, at, line)?,
            MacroWord::End => {
                let number = natural_at(scan.value(&self.env(state))?.number, at)?;
                nothing_more(&mut scan)?;
                self.end(number, at)?;
            }
        }
        Ok(true)
    }

    /// Runs `IF [..] GOTO 10`, `IF [..] THEN #1 = 5`.
    fn condition_of_macro(
        &mut self,
        state: &mut ReaderState,
        text: &str,
        at: usize,
        behind: usize,
    ) -> Result<(), ReadRemark> {
        let mut scan = ExpressionScan::new(text, behind);
        // The condition is evaluated once; any value but zero holds.
        let holds = scan.bracket(&self.env(state))?.abs() > 0.0;
        scan.blanks();
        let word = scan.rest().bytes().take_while(u8::is_ascii_alphabetic).count();
        let name = scan.rest().get(..word).unwrap_or_default().to_ascii_uppercase();
        let word_at = scan.at;
        scan.at += word;
        match name.as_str() {
            "GOTO" | "GO" => {
                let number = scan.value(&self.env(state))?.number;
                nothing_more(&mut scan)?;
                if holds { self.go_to(state, at, number) } else { Ok(()) }
            }
            // The statement behind THEN is an assignment or any other block.
            "THEN" | "TH" => {
                if holds {
                    self.plain(state, LineTail { text, from: scan.at });
                }
                Ok(())
            }
            _ => Err(ReadRemark::new(
                word_at,
                "IF without GOTO or THEN",
                "write IF [#1 LT 5] GOTO 10",
            )),
        }
    }

    /// Runs `WHILE [..] DO 1`.
    fn while_do(
        &mut self,
        state: &ReaderState,
        mut scan: ExpressionScan<'_>,
        at: usize,
        line: usize,
    ) -> Result<(), ReadRemark> {
        let holds = scan.bracket(&self.env(state))?.abs() > 0.0;
        scan.blanks();
        let does = scan.rest().get(..2).is_some_and(|word| word.eq_ignore_ascii_case("DO"));
        if !does {
            return Err(ReadRemark::new(scan.at, "WHILE without DO", "write WHILE [#1 LT 5] DO 1"));
        }
        scan.at += 2;
        let number = natural_at(scan.value(&self.env(state))?.number, at)?;
        nothing_more(&mut scan)?;
        let level = self.flow.frames.len();
        // A loop of the same call that begins here or further down was left by a jump.
        self.macros.loops.retain(|inner| inner.level < level || inner.line < line);
        // The condition is asked again whenever END leads back here.
        if !holds {
            return self.pass_to_end(state, number, at);
        }
        if self.macros.loops.len() >= DEEPEST {
            let message = format!("more than {DEEPEST} loops in each other");
            return Err(ReadRemark::new(
                at,
                message,
                "does a jump lead into a loop again and again?",
            ));
        }
        self.macros.loops.push(MacroLoop { number, level, line });
        Ok(())
    }

    fn pass_to_end(
        &mut self,
        state: &ReaderState,
        number: u32,
        at: usize,
    ) -> Result<(), ReadRemark> {
        // The main program is read as a stream: its END is searched in the lines to come.
        let Some(frame) = self.flow.frames.last_mut() else {
            self.macros.seek = Some((MacroSeek::End(number), state.log.line));
            return Ok(());
        };
        let mut behind = frame.lines.iter().enumerate().skip(frame.next);
        let Some((end, _)) = behind.find(|(_, line)| end_of(&line.text) == Some(number)) else {
            return Err(ReadRemark::new(
                at,
                format!("DO {number} has no END {number}"),
                "end the loop",
            ));
        };
        // Skipped lines count as well, so that no loop runs for ever.
        self.left = self.left.saturating_sub(u64::try_from(end - frame.next).unwrap_or(u64::MAX));
        frame.next = end + 1;
        Ok(())
    }

    /// Runs `END 1`.
    fn end(&mut self, number: u32, at: usize) -> Result<(), ReadRemark> {
        let level = self.flow.frames.len();
        // Loops are nested: the END is that of the innermost one.
        let inner = self.macros.loops.pop();
        let Some(inner) = inner.filter(|of| of.number == number && of.level == level) else {
            let message = format!("END {number}: nothing was begun that it could end");
            return Err(ReadRemark::new(at, message, "loops must lie inside of each other"));
        };
        match self.flow.frames.last_mut() {
            Some(frame) => frame.next = inner.line,
            None => self.macros.tape.go_to(u32::try_from(inner.line).unwrap_or(u32::MAX)),
        }
        Ok(())
    }

    /// Runs `GOTO 10`, a jump to a line of the same program.
    pub(super) fn go_to(
        &mut self,
        state: &ReaderState,
        at: usize,
        number: f64,
    ) -> Result<(), ReadRemark> {
        let number = natural_at(number, at)?;
        let level = self.flow.frames.len();
        if let Some(frame) = self.flow.frames.last_mut() {
            // In a subprogram all lines are known, so that a jump may lead either way.
            let found = frame.lines.iter().position(|line| line_number(&line.text) == Some(number));
            let Some(to) = found else {
                let message = format!("N{number} is not in this subprogram");
                return Err(ReadRemark::new(at, message, "GOTO does not lead out of subprograms"));
            };
            self.left = self.left.saturating_sub(u64::try_from(to).unwrap_or(u64::MAX));
            frame.next = to;
            self.macros.loops.retain(|inner| inner.level < level || inner.line < to);
            return Ok(());
        }
        let line = state.log.line;
        let is = |text: &str| line_number(text) == Some(number);
        // Lines before the jump and its own first, then those to come.
        match self.macros.tape.back(line.saturating_add(1), is)? {
            Some(to) => {
                let first = usize::try_from(to).unwrap_or(usize::MAX);
                self.macros.loops.retain(|inner| inner.line < first);
                self.macros.tape.go_to(to);
            }
            None => self.macros.seek = Some((MacroSeek::Number(number), line)),
        }
        Ok(())
    }
}

impl GcodeReader {
    /// Runs `G65 P1000 A1. B2.`, a subprogram with parameters of its own; `G66` calls it behind
    /// every move.
    pub(super) fn macro_call(
        &mut self,
        block: &mut GcodeBlock,
        text: &str,
        now: &mut BlockActions,
    ) -> Result<(), ReadRemark> {
        // G65 calls once; G66 behind every move until G67.
        let modal = block.codes.iter().any(|code| code.tenths == MODAL);
        let (program, arguments, at) = called(block, text)?;
        let program: Box<str> = program.to_string().into();
        if modal {
            let level = self.flow.frames.len();
            self.modal.each = Some(ModalCall { program, arguments, level, at });
        } else {
            now.call = Some((program, 1, at));
            now.arguments = Some(arguments);
        }
        Ok(())
    }

    /// Makes the call of `G66` behind a move.
    pub(super) fn call_behind_move(&self, now: &mut BlockActions) {
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

/// Returns program and arguments of a call, and its byte offset.
fn called(block: &mut GcodeBlock, text: &str) -> Result<(u32, Vec<f64>, usize), ReadRemark> {
    let call = block.codes.first().copied().filter(|_| block.codes.len() == 1);
    let Some(call) = call else {
        let at = block.codes.first().map_or(0, |code| code.at);
        let message = "G65 or G66 beside other codes";
        return Err(ReadRemark::new(at, message, "put it on a line of its own"));
    };
    let program = block.take('P').ok_or_else(|| {
        ReadRemark::new(call.at, "a macro call without a program", "write P and its number")
    })?;
    let times = block.take('L').map(|word| natural(word, 'L')).transpose()?;
    // Repetitions would need the arguments anew for each.
    if times.is_some_and(|times| times != 1) {
        let message =
            format!("{} with L", excerpt(text.get(call.at..call.end).unwrap_or_default()));
        return Err(ReadRemark::new(call.at, message, "write the call as often as it is to run"));
    }
    // Arguments of the first kind: each letter has its own parameter; those not given are taken as
    // 0.
    let mut arguments = vec![0.0; 26];
    for (letter, number) in ARGUMENTS {
        if let (Some(word), Some(place)) = (block.take(letter), arguments.get_mut(number - 1)) {
            *place = word.value;
        }
    }
    // The line number is no argument.
    _ = block.take('N');
    let program = natural(program, 'P')?;
    Ok((program, arguments, call.at))
}

/// Checks that nothing but a comment stands behind a statement.
fn nothing_more(scan: &mut ExpressionScan<'_>) -> Result<(), ReadRemark> {
    scan.blanks();
    let rest = scan.rest();
    if rest.is_empty() || rest.starts_with(['(', ';']) {
        return Ok(());
    }
    Err(ReadRemark::new(
        scan.at,
        "something behind a macro statement",
        "put it on a line of its own",
    ))
}

/// Returns the number of a line or loop.
fn natural_at(value: f64, at: usize) -> Result<u32, ReadRemark> {
    // Numbers are reckoned with, too.
    let whole = value.round();
    if (value - whole).abs() > 1e-4 || !(0.0..=f64::from(u32::MAX)).contains(&whole) {
        return Err(ReadRemark::new(at, format!("{value} must be a whole number from 0"), ""));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    let whole = whole as u32;
    Ok(whole)
}
