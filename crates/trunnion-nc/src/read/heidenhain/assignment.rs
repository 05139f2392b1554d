//! Assignments to Q parameters: `Q1 = +5`, and the formulas `FN 0` to `FN 13`.

use super::reader::HeidenhainReader;
use super::token::{Token, Tokens, is_q};
use crate::math;
use crate::read::log::{ReadRemark, excerpt};
use crate::read::state::ReaderState;

impl HeidenhainReader {
    /// Runs `Q1 = +5`, from a byte offset on.
    pub(super) fn assign(
        &mut self,
        first: &Token<'_>,
        code: &str,
        at: usize,
    ) -> Result<(), ReadRemark> {
        // FN 0: stands before the assignment, which begins behind its colon.
        let from = at.max(first.at);
        let text = code.get(from..).unwrap_or_default();
        let Some((name, value)) = text.split_once('=') else {
            return Err(ReadRemark::new(from, "= is missing here", "write Q1 = 5"));
        };
        let name = name.trim().to_ascii_uppercase();
        if !is_q(&name) {
            let message = format!("{} is no parameter", excerpt(&name));
            return Err(ReadRemark::new(from, message, "write Q and its number"));
        }
        let value_at = code.len() - value.len();
        let value = self.arithmetic(value, value_at)?;
        self.variables.insert(name.into(), value);
        Ok(())
    }

    /// Runs `FN 0: Q1 = +5`, up to `FN 7`; `FN 9` to `FN 12` jump.
    pub(super) fn formula(
        &mut self,
        state: &mut ReaderState,
        tokens: &mut Tokens<'_>,
        code: &str,
    ) -> Result<(), ReadRemark> {
        let Some(kind) = tokens.next_token() else { return Ok(()) };
        let number = kind.text.trim_end_matches(':').parse::<u32>().unwrap_or(u32::MAX);
        if matches!(number, 15 | 16 | 38) {
            // They print, and move nothing.
            state.control.keep(state.log.line, code.trim_start());
            return Ok(());
        }
        if number > 13 {
            let message = format!("FN {} is not understood", excerpt(kind.text));
            let help = "FN 0 to FN 13 are; it needs data of the machine, or stops the program";
            return Err(ReadRemark::new(kind.at, message, help));
        }
        let after = code.get(kind.at..).unwrap_or_default().find(':').map_or(0, |at| at + 1);
        let text = code.get(kind.at + after..).unwrap_or_default();
        let from = kind.at + after + text.len() - text.trim_start().len();
        if matches!(number, 9..=12) {
            return self.condition(state, number, code, from);
        }
        if matches!(number, 8 | 13) {
            return self.two_sides(number, code, from);
        }
        let first = Token { text: "", at: from };
        self.assign(&first, code, from)
    }

    /// Runs `FN 8: Q1 = +3 LEN +4`, `FN 13: Q1 = +3 ANG +4`: hypotenuse and angle of a right triangle.
    fn two_sides(&mut self, number: u32, code: &str, from: usize) -> Result<(), ReadRemark> {
        let word = if number == 8 { "LEN" } else { "ANG" };
        let text = code.get(from..).unwrap_or_default().to_ascii_uppercase();
        let parts = text.split_once('=').and_then(|(name, sides)| {
            sides.split_once(word).map(|(first, second)| (name.trim().to_owned(), first, second))
        });
        let Some((name, first, second)) = parts.filter(|(name, ..)| is_q(name)) else {
            let message = format!("FN {number} without =, or {word}");
            let help = format!("write FN {number}: Q1 = +3 {word} +4");
            return Err(ReadRemark::new(from, message, help));
        };
        let [a, b] = [self.arithmetic(first, from)?, self.arithmetic(second, from)?];
        // The first is opposite to the angle, which counts from 0 to 360 degrees.
        let value = if number == 8 {
            math::hypot(a, b)
        } else {
            math::atan2(a, b).to_degrees().rem_euclid(360.0)
        };
        self.variables.insert(name.into(), value);
        Ok(())
    }
}
