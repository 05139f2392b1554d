//! Effects of O-words.

use super::expression::{ExpressionEnv, ExpressionScan};
use super::flow::{
    CallFrame, CallOutcome, CallSite, FrameKind, LoopKind, OpenLoop, SubCall, SubKind, closer,
};
use super::label::{OKeyword, OWord};
use super::parameters::{LOCALS, ParameterKey, ParameterScope};
use super::reader::GcodeReader;
use crate::read::log::{FileLine, ReadRemark};
use crate::read::state::ReaderState;
impl GcodeReader {
    /// Runs an O-word on a line of the file.
    pub(super) fn o_word_of_file(
        &mut self,
        state: &ReaderState,
        word: &OWord,
        line: FileLine<'_>,
    ) -> Result<(), ReadRemark> {
        let text = line.text;
        match word.keyword {
            _ if is_misplaced(word) => Err(misplaced(word, text)),
            OKeyword::Nothing => Ok(()),
            // Lines are collected up to the end of the structure, then it runs as a frame of its
            // own.
            OKeyword::Sub | OKeyword::While | OKeyword::Do | OKeyword::If | OKeyword::Repeat => {
                self.flow.begin(word, line);
                Ok(())
            }
            OKeyword::Call => self.call(state, word, text),
            OKeyword::Unknown => Err(unknown(word, text)),
            _ => Err(stray(word, text)),
        }
    }

    /// Runs an O-word in a loop or subprogram.
    pub(super) fn o_word_in_frame(
        &mut self,
        state: &mut ReaderState,
        word: &OWord,
        at: usize,
        text: &str,
    ) -> Result<(), ReadRemark> {
        let opens = matches!(
            word.keyword,
            OKeyword::While | OKeyword::Do | OKeyword::Repeat | OKeyword::If
        );
        match word.keyword {
            _ if is_misplaced(word) => Err(misplaced(word, text)),
            OKeyword::Nothing => Ok(()),
            OKeyword::Unknown => Err(unknown(word, text)),
            OKeyword::Call => self.call(state, word, text),
            OKeyword::Return | OKeyword::EndSub => self.leave_sub(state, word, text),
            OKeyword::Sub => Err(ReadRemark::new(
                word.at,
                "a subprogram inside of another",
                "end the outer one before",
            )),
            _ if opens => self.open(state, word, at, text),
            // A branch that ran ends here: go on behind the condition.
            OKeyword::ElseIf | OKeyword::Else => self.jump(word, &[OKeyword::EndIf], at, 1),
            OKeyword::EndIf => Ok(()),
            OKeyword::EndWhile | OKeyword::EndRepeat => self.again(word),
            _ => self.break_or_continue(word, at),
        }
    }

    fn frame(&mut self, word: &OWord) -> Result<&mut CallFrame, ReadRemark> {
        let message = "an o-word outside of all lines";
        self.flow.frames.last_mut().ok_or_else(|| ReadRemark::new(word.at, message, ""))
    }

    /// Goes on `beyond` lines behind the line of a keyword.
    fn jump(
        &mut self,
        word: &OWord,
        to: &[OKeyword],
        from: usize,
        beyond: usize,
    ) -> Result<(), ReadRemark> {
        let frame = self.frame(word)?;
        let Some(at) = frame.find(&word.label, to, from + 1) else {
            let message = format!("o<{}> has no end", word.label);
            return Err(ReadRemark::new(
                word.at,
                message,
                "end it: endsub, endwhile, endif, endrepeat",
            ));
        };
        frame.next = at + beyond;
        // Looking for it is work, too, that a loop could ask for without end.
        let passed = u64::try_from(at.saturating_sub(from)).unwrap_or(u64::MAX);
        self.left = self.left.saturating_sub(passed);
        Ok(())
    }

    /// Runs `while`, `do`, `repeat`, `if`.
    fn open(
        &mut self,
        state: &ReaderState,
        word: &OWord,
        at: usize,
        text: &str,
    ) -> Result<(), ReadRemark> {
        let label = &word.label;
        match word.keyword {
            OKeyword::If => return self.condition(state, word, at, text),
            OKeyword::While => {
                let holds = self.value_behind(state, word, text)?.abs() > 0.0;
                let frame = self.frame(word)?;
                // The same keyword ends a `do` loop and begins a `while` loop.
                let closes = frame.in_loop(label, |kind| kind == LoopKind::Do);
                let begun = frame.in_loop(label, |kind| kind == LoopKind::While);
                if closes {
                    if holds {
                        frame.next = frame.loops.last().map_or(at, |inner| inner.start) + 1;
                    } else {
                        frame.loops.pop();
                    }
                    return Ok(());
                }
                if !holds {
                    if begun {
                        frame.loops.pop();
                    }
                    return self.jump(word, &[OKeyword::EndWhile], at, 1);
                }
                // The line is run before every round: the loop is entered with the first.
                if !begun {
                    self.enter_loop(word, at, LoopKind::While)?;
                }
            }
            OKeyword::Repeat => {
                let rounds = self.value_behind(state, word, text)?.round();
                // Zero or fewer rounds skip the loop.
                if rounds < 1.0 {
                    return self.jump(word, &[OKeyword::EndRepeat], at, 1);
                }
                self.enter_loop(word, at, LoopKind::Repeat(rounds))?;
            }
            _ => self.enter_loop(word, at, LoopKind::Do)?,
        }
        Ok(())
    }

    fn enter_loop(&mut self, word: &OWord, start: usize, kind: LoopKind) -> Result<(), ReadRemark> {
        let label = word.label.clone();
        // A loop that was left by a jump is no longer running.
        let frame = self.frame(word)?;
        frame.leave(&label);
        frame.loops.push(OpenLoop { label, kind, start });
        Ok(())
    }

    /// Runs `if`: goes on behind the first of its branches that holds.
    fn condition(
        &mut self,
        state: &ReaderState,
        word: &OWord,
        at: usize,
        text: &str,
    ) -> Result<(), ReadRemark> {
        if self.value_behind(state, word, text)?.abs() > 0.0 {
            return Ok(());
        }
        // Branches are tried in order; `else` always holds.
        let mut from = at;
        loop {
            self.jump(word, &[OKeyword::ElseIf, OKeyword::Else, OKeyword::EndIf], from, 0)?;
            let frame = self.frame(word)?;
            let at = frame.next;
            frame.next = at + 1;
            let Some(line) = frame.lines.get(at).cloned() else { return Ok(()) };
            let Some(branch) = super::label::o_word(&line.text, 0) else { return Ok(()) };
            if branch.keyword != OKeyword::ElseIf
                || self.value_at(state, line.as_line(), branch.rest)?.abs() > 0.0
            {
                return Ok(());
            }
            from = at;
        }
    }

    /// Runs `endwhile`, `endrepeat`.
    fn again(&mut self, word: &OWord) -> Result<(), ReadRemark> {
        let (label, repeat) = (&word.label, word.keyword == OKeyword::EndRepeat);
        let frame = self.frame(word)?;
        let inner = frame.loops.last_mut().filter(|inner| inner.label == *label);
        let begin = match inner {
            Some(OpenLoop { kind: LoopKind::While, start, .. }) if !repeat => *start,
            Some(OpenLoop { kind: LoopKind::Repeat(left), start, .. }) if repeat => {
                // The round that ends here is done.
                *left -= 1.0;
                if *left < 1.0 {
                    frame.loops.pop();
                    return Ok(());
                }
                *start + 1
            }
            _ => {
                let message = format!("the end of o<{label}> without its beginning");
                return Err(ReadRemark::new(
                    word.at,
                    message,
                    "loops must lie inside of each other",
                ));
            }
        };
        frame.next = begin;
        Ok(())
    }

    fn break_or_continue(&mut self, word: &OWord, at: usize) -> Result<(), ReadRemark> {
        let frame = self.frame(word)?;
        let Some(inner) = frame.leave(&word.label) else {
            let message = format!("o<{}> is no loop that runs here", word.label);
            return Err(ReadRemark::new(word.at, message, "break and continue name their loop"));
        };
        // `do` ends with `while`, the other loops with a keyword of their own.
        let end = match inner.kind {
            LoopKind::While => OKeyword::EndWhile,
            LoopKind::Do => closer(OKeyword::Do),
            LoopKind::Repeat(_) => OKeyword::EndRepeat,
        };
        if word.keyword == OKeyword::Break {
            return self.jump(word, &[end], at, 1);
        }
        let (start, kind) = (inner.start, inner.kind);
        // `continue` goes on with the loop: at its condition, which for `do` and `repeat` stands at
        // the end.
        frame.loops.push(inner);
        if kind == LoopKind::While {
            frame.next = start;
            return Ok(());
        }
        self.jump(word, &[end], at, 0)
    }

    /// Runs `call [1] [2]`.
    fn call(&mut self, state: &ReaderState, word: &OWord, text: &str) -> Result<(), ReadRemark> {
        let mut scan = ExpressionScan::new(text, word.rest);
        let env = self.env(state);
        let mut arguments = Vec::new();
        loop {
            // A comment may stand between two arguments.
            scan.blanks_and_comments();
            if scan.peek() != Some(b'[') {
                break;
            }
            // Arguments become #1 to #30.
            if arguments.len() >= LOCALS {
                let message = format!("more than {LOCALS} arguments");
                return Err(ReadRemark::new(scan.at, message, ""));
            }
            arguments.push(scan.bracket(&env)?);
        }
        nothing_more(&mut scan)?;
        let label = match word.computed {
            Some(at) => computed_label(ExpressionScan::new(text, at), &env)?,
            None => word.label.clone(),
        };
        let (kind, arguments, names) = (SubKind::Named, Some(arguments), Vec::new());
        let call = SubCall { kind, label, arguments, names, times: 1 };
        let line = FileLine { number: state.log.line, text };
        self.run_sub(call, CallSite { line, at: word.at })
    }

    /// Calls a subprogram, now or once it is found.
    pub(super) fn run_sub(&mut self, call: SubCall, site: CallSite<'_>) -> Result<(), ReadRemark> {
        let called = self.flow.call(call, site)?;
        self.called(called);
        Ok(())
    }

    /// Gives a call its parameters.
    pub(super) fn called(&mut self, called: CallOutcome) {
        if let CallOutcome::Runs(Some(arguments), names) = called {
            self.parameters.enter(ParameterScope::of_call(&arguments));
            for (name, value) in names {
                self.parameters.set(ParameterKey::Name(name), value);
            }
        }
    }

    /// Runs `endsub`, `return`, with a value or without.
    fn leave_sub(
        &mut self,
        state: &mut ReaderState,
        word: &OWord,
        text: &str,
    ) -> Result<(), ReadRemark> {
        let mut scan = ExpressionScan::new(text, word.rest);
        scan.blanks();
        let value = match scan.peek() {
            Some(b'[') => Some(scan.bracket(&self.env(state))?),
            _ => None,
        };
        nothing_more(&mut scan)?;
        // `return` inside a loop of the file belongs to no subprogram.
        if self.frame(word)?.of != FrameKind::Sub {
            return Err(stray(word, text));
        }
        self.flow.frames.pop();
        // The caller has its own #1 to #30 and local names again.
        self.parameters.leave();
        let returned = f64::from(u8::from(value.is_some()));
        self.parameters.set(ParameterKey::Name("_value_returned".into()), returned);
        self.parameters.set(ParameterKey::Name("_value".into()), value.unwrap_or(0.0));
        self.call_returned(state);
        Ok(())
    }

    /// Evaluates the brackets behind an O-word.
    fn value_behind(
        &self,
        state: &ReaderState,
        word: &OWord,
        text: &str,
    ) -> Result<f64, ReadRemark> {
        self.value_at(state, FileLine { number: state.log.line, text }, word.rest)
    }

    fn value_at(
        &self,
        state: &ReaderState,
        line: FileLine<'_>,
        at: usize,
    ) -> Result<f64, ReadRemark> {
        let mut scan = ExpressionScan::new(line.text, at);
        let mut env = self.env(state);
        env.view.line = line.number;
        let value = scan.bracket(&env)?;
        nothing_more(&mut scan)?;
        Ok(value)
    }
}

/// Returns the label that an expression stands for.
fn computed_label(
    mut scan: ExpressionScan<'_>,
    env: &ExpressionEnv<'_>,
) -> Result<Box<str>, ReadRemark> {
    let at = scan.at;
    let value = scan.value(env)?.number;
    let whole = value.round();
    // As exact as the number of a parameter.
    if (value - whole).abs() < 1e-4 && (0.0..1e9).contains(&whole) {
        return Ok(format!("{whole}").into());
    }
    Err(ReadRemark::new(at, format!("{value} is no number of a subprogram"), "name a whole number"))
}

/// Checks that nothing but comments stand behind an O-word.
fn nothing_more(scan: &mut ExpressionScan<'_>) -> Result<(), ReadRemark> {
    scan.blanks_and_comments();
    if scan.rest().is_empty() {
        return Ok(());
    }
    Err(ReadRemark::new(scan.at, "something behind an o-word", "put it on a line of its own"))
}

/// Returns true for a computed label on anything but a call.
fn is_misplaced(word: &OWord) -> bool {
    word.computed.is_some() && word.keyword != OKeyword::Call
}

fn misplaced(word: &OWord, text: &str) -> ReadRemark {
    let what = super::super::log::excerpt(text.get(word.at..).unwrap_or_default());
    let message = format!("{what}: a computed label on something other than a call");
    ReadRemark::new(word.at, message, "write the number or name itself")
}

fn unknown(word: &OWord, text: &str) -> ReadRemark {
    let what = super::super::log::excerpt(text.get(word.at..).unwrap_or_default());
    let help = "a program number stands alone; o-words are sub, call, while, do, if, repeat ...";
    ReadRemark::new(word.at, format!("{what} is not understood"), help)
}

fn stray(word: &OWord, text: &str) -> ReadRemark {
    let what = super::super::log::excerpt(text.get(word.at..).unwrap_or_default());
    ReadRemark::new(word.at, format!("{what}: nothing was begun that it could end"), "")
}
