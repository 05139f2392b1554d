//! Order of blocks: `LBL`, `CALL LBL`, `FN 9` to `FN 12`.

use super::flow::same;
use super::flow::{LabelCall, upper};
use super::reader::HeidenhainReader;
use super::token::{Token, Tokens};
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;

/// Deepest nesting of calls, that of the control.
const DEEPEST: usize = 19;

impl HeidenhainReader {
    /// Runs `LBL 5`, `LBL 0`.
    pub(super) fn label(&mut self, label: &str) {
        if label != "0" {
            return;
        }
        // Outside of a subprogram it ends nothing: a section that is repeated may contain it.
        if self.flow.calls.iter().all(|call| call.left.is_some()) {
            return;
        }
        // Sections that were begun in it are over with the subprogram.
        while let Some(call) = self.flow.calls.pop() {
            if call.left.is_none() {
                return self.flow.tape.go_to(call.line.saturating_add(1));
            }
        }
    }

    /// Runs `CALL LBL 5`, `CALL LBL 5 REP 3`.
    pub(super) fn call(
        &mut self,
        state: &ReaderState,
        first: &Token<'_>,
        code: &str,
        tokens: &mut Tokens<'_>,
    ) -> Result<(), ReadRemark> {
        let label = tokens.next_token().filter(|token| same(token.text, "LBL"));
        let Some(label) = label.and_then(|_| tokens.next_token()) else {
            let help = "CALL LBL is; put the lines of other programs here, behind LBL";
            let message =
                format!("{} is not understood", excerpt(code.get(first.at..).unwrap_or_default()));
            return Err(ReadRemark::new(first.at, message, help));
        };
        let line = state.log.line;
        // Without REP the label is a subprogram, which returns at LBL 0.
        let Some(word) = tokens.next_token() else {
            let subs = self.flow.calls.iter().filter(|call| call.left.is_none()).count();
            if subs >= DEEPEST {
                let message = format!("more than {DEEPEST} calls in each other");
                return Err(ReadRemark::new(first.at, message, "does the subprogram call itself?"));
            }
            self.flow.calls.push(LabelCall { line, left: None });
            return self.jump(line, label);
        };
        let count = if word.text.len() > 3 { Some(word.after(3)) } else { tokens.next_token() };
        let (true, Some(count)) = (word.text.get(..3).is_some_and(|rep| same(rep, "REP")), count)
        else {
            return Err(ReadRemark::new(word.at, "only REP stands behind a label", "write REP 3"));
        };
        let is_this = |call: &LabelCall| call.line == line && call.left.is_some();
        // The line is reached again after each repetition: it then counts down what is left.
        let begun = self.flow.calls.iter().rposition(is_this).map(|at| {
            // Sections that were left by a jump are over.
            self.flow.calls.truncate(at + 1);
            self.flow.calls.pop().and_then(|call| call.left).unwrap_or(0)
        });
        let left = if let Some(left) = begun { left } else { self.count(&count)? };
        let Some(left) = left.checked_sub(1) else { return Ok(()) };
        self.flow.calls.push(LabelCall { line, left: Some(left) });
        self.jump(line, label)
    }

    /// Returns the repetitions of a section.
    fn count(&self, word: &Token<'_>) -> Result<u32, ReadRemark> {
        // Older controls write what is left behind a slash.
        let text = word.text.split('/').next().unwrap_or_default();
        let count = self.value(&Token { text, at: word.at })?.value.round();
        if !(0.0..=65_534.0).contains(&count) {
            return Err(ReadRemark::new(word.at, "REP counts from 0 to 65534", ""));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let count = count as u32;
        Ok(count)
    }

    /// Runs `IF +Q1 EQU +Q2 GOTO LBL 5` behind `FN 9:`; `number` selects the comparison.
    pub(super) fn condition(
        &mut self,
        state: &ReaderState,
        number: u32,
        code: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        let mut tokens = Tokens::new(code, at);
        let word = match number {
            9 => "EQU",
            10 => "NE",
            11 => "GT",
            _ => "LT",
        };
        let wrong = |at: usize| {
            let message = format!("FN {number} without IF, {word} and GOTO LBL");
            ReadRemark::new(at, message, format!("write FN {number}: IF +Q1 {word} +5 GOTO LBL 1"))
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
        // EQU and NE compare up to rounding; GT and LT exclude values that are equal in this sense.
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
    fn jump(&mut self, line: u32, label: Token<'_>) -> Result<(), ReadRemark> {
        if label.text == "0" {
            return Err(ReadRemark::new(
                label.at,
                "LBL 0 only ends subprograms",
                "jump to another label",
            ));
        }
        // A label that was read leads back; any other is searched in the blocks to come.
        match self.flow.known.get(&upper(label.text)) {
            Some(to) => self.flow.tape.go_to(*to),
            None => self.flow.seek = Some((label.text.into(), line)),
        }
        Ok(())
    }
}

/// Two values closer than this share of the larger, or of 1, are equal: sums of numbers such as 0.1 differ by less.
const EQUAL: f64 = 1e-10;
