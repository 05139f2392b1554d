//! Which block comes next: `LBL`, `CALL LBL`, `FN 9` to `FN 12`.

use super::super::log::{Remark, excerpt};
use super::super::reader::State;
use super::super::tape::Tape;
use super::Heidenhain;
use super::token::{Token, Tokens};
use std::collections::HashMap;

/// Calls in calls, as deep as the control has them.
const DEEPEST: usize = 19;

/// A label that is called.
#[derive(Debug)]
struct Call {
    /// The line that called.
    line: u32,
    /// How often a section is still to be repeated; `None`: a subprogram, that ends at `LBL 0`.
    left: Option<u32>,
}

/// Everything about the order of blocks.
#[derive(Debug)]
pub(super) struct Flow {
    pub(super) tape: Tape,
    /// Label that is looked for, and the line that asked for it.
    seek: Option<(Box<str>, u32)>,
    calls: Vec<Call>,
    /// Lines of the labels so far.
    known: HashMap<Box<str>, u32>,
}

impl Flow {
    pub(super) fn new(most: u64) -> Self {
        Self { tape: Tape::new(most), seek: None, calls: Vec::new(), known: HashMap::new() }
    }

    /// Notes where a label stands.
    pub(super) fn note(&mut self, label: &str, line: u32) {
        self.known.entry(upper(label)).or_insert(line);
    }

    /// Whether a block is passed over on the way to a label.
    pub(super) fn passes(&mut self, label: Option<&str>) -> bool {
        let Some((wanted, _)) = &self.seek else { return false };
        if label.is_some_and(|label| same(label, wanted)) {
            self.seek = None;
        }
        true
    }

    /// What is still looked for when the file is over.
    pub(super) fn open(&self) -> Option<(u32, Remark)> {
        let (label, line) = self.seek.as_ref()?;
        let message = format!("LBL {label} is not in the file");
        Some((*line, Remark::new(0, message, "labels of other files are not known: put them here")))
    }
}

fn upper(label: &str) -> Box<str> {
    label.to_ascii_uppercase().into()
}

/// Labels are numbers or quoted names.
fn same(one: &str, other: &str) -> bool {
    one.eq_ignore_ascii_case(other)
}

/// The label that a block sets.
pub(super) fn label_of(code: &str, from: usize) -> Option<&str> {
    let head = code.get(from..from + 3)?;
    if !head.eq_ignore_ascii_case("LBL") {
        return None;
    }
    let mut tokens = Tokens::new(code, from + 3);
    tokens.next_token().map(|token| token.text)
}

impl Heidenhain {
    /// `LBL 5`, `LBL 0`.
    pub(super) fn label(&mut self, label: &str) {
        if label != "0" {
            return;
        }
        // Sections that were begun in it are over with the subprogram.
        while let Some(call) = self.flow.calls.pop() {
            if call.left.is_none() {
                return self.flow.tape.go_to(call.line.saturating_add(1));
            }
        }
    }

    /// `CALL LBL 5`, `CALL LBL 5 REP 3`.
    pub(super) fn call(
        &mut self,
        state: &State,
        (first, code): (&Token<'_>, &str),
        tokens: &mut Tokens<'_>,
    ) -> Result<(), Remark> {
        let label = tokens.next_token().filter(|token| same(token.text, "LBL"));
        let Some(label) = label.and_then(|_| tokens.next_token()) else {
            let help = "CALL LBL is; put the lines of other programs here";
            let message =
                format!("{} is not understood", excerpt(code.get(first.at..).unwrap_or_default()));
            return Err(Remark::new(first.at, message, help));
        };
        let line = state.log.line;
        let Some(word) = tokens.next_token() else {
            let subs = self.flow.calls.iter().filter(|call| call.left.is_none()).count();
            if subs >= DEEPEST {
                let message = format!("more than {DEEPEST} calls in each other");
                return Err(Remark::new(first.at, message, "does the subprogram call itself?"));
            }
            self.flow.calls.push(Call { line, left: None });
            return self.jump(line, label);
        };
        let count = if word.text.len() > 3 { Some(word.after(3)) } else { tokens.next_token() };
        let (true, Some(count)) = (word.text.get(..3).is_some_and(|rep| same(rep, "REP")), count)
        else {
            return Err(Remark::new(word.at, "only REP stands behind a label", "write REP 3"));
        };
        let is_this = |call: &Call| call.line == line && call.left.is_some();
        let begun = self.flow.calls.iter().rposition(is_this).map(|at| {
            // Sections that were left by a jump are over.
            self.flow.calls.truncate(at + 1);
            self.flow.calls.pop().and_then(|call| call.left).unwrap_or(0)
        });
        let left = if let Some(left) = begun { left } else { self.count(&count)? };
        let Some(left) = left.checked_sub(1) else { return Ok(()) };
        self.flow.calls.push(Call { line, left: Some(left) });
        self.jump(line, label)
    }

    /// How often a section is repeated.
    fn count(&self, word: &Token<'_>) -> Result<u32, Remark> {
        let count = self.value(word)?.value.round();
        if !(0.0..=65_534.0).contains(&count) {
            return Err(Remark::new(word.at, "REP counts from 0 to 65534", ""));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let count = count as u32;
        Ok(count)
    }

    /// `IF +Q1 EQU +Q2 GOTO LBL 5` behind `FN 9:`; `number` says which comparison.
    pub(super) fn condition(
        &mut self,
        state: &State,
        (number, code, at): (u32, &str, usize),
    ) -> Result<(), Remark> {
        let mut tokens = Tokens::new(code, at);
        let word = match number {
            9 => "EQU",
            10 => "NE",
            11 => "GT",
            _ => "LT",
        };
        let wrong = |at: usize| {
            let message = format!("FN {number} without IF, {word} and GOTO LBL");
            Remark::new(at, message, format!("write FN {number}: IF +Q1 {word} +5 GOTO LBL 1"))
        };
        let begins = tokens.next_token().is_some_and(|token| same(token.text, "IF"));
        let [a, sign, b, goto, lbl, label] = std::array::from_fn(|_| tokens.next_token());
        let (true, Some(a), Some(sign), Some(b), Some(label)) = (begins, a, sign, b, label) else {
            return Err(wrong(at));
        };
        let is = |token: Option<Token<'_>>, word: &str| token.is_some_and(|of| same(of.text, word));
        if !(same(sign.text, word) && is(goto, "GOTO") && is(lbl, "LBL")) {
            return Err(wrong(sign.at));
        }
        let [a, b] = [self.value(&a)?.value, self.value(&b)?.value];
        let equal = (a - b).abs() <= EQUAL * a.abs().max(b.abs()).max(1.0);
        let holds = match number {
            9 => equal,
            10 => !equal,
            11 => a > b && !equal,
            _ => a < b && !equal,
        };
        if holds { self.jump(state.log.line, label) } else { Ok(()) }
    }

    /// Goes on at a label, wherever it stands.
    fn jump(&mut self, line: u32, label: Token<'_>) -> Result<(), Remark> {
        if label.text == "0" {
            return Err(Remark::new(
                label.at,
                "LBL 0 only ends subprograms",
                "jump to another label",
            ));
        }
        match self.flow.known.get(&upper(label.text)) {
            Some(to) => self.flow.tape.go_to(*to),
            None => self.flow.seek = Some((label.text.into(), line)),
        }
        Ok(())
    }
}

/// Two values closer than this share of the larger, or of 1, are equal: sums of numbers such as 0.1 differ by less.
const EQUAL: f64 = 1e-10;
