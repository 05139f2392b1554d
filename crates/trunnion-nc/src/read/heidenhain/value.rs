//! Values of words.

use super::reader::HeidenhainReader;
use super::token::Token;
use crate::read::arithmetic;
use crate::read::arithmetic::FormulaText;
use crate::read::control::COMPUTED;
use crate::read::log::ReadRemark;
use crate::read::number::{self, DecimalMark};

/// A value and the digits behind its point.
#[derive(Debug, Clone, Copy)]
pub(super) struct KlartextValue {
    pub(super) value: f64,
    pub(super) decimals: u8,
}

/// Returns the byte at which the value behind a name begins: `V.ZEIT0.5`, `DEPTH -20`, `DWELL Q5`.
pub(super) fn value_begins(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    (0..bytes.len()).find(|at| {
        let behind = bytes.get(at + 1).copied().unwrap_or(0).to_ascii_uppercase();
        let starts_name = at
            .checked_sub(1)
            .is_none_or(|before| bytes.get(before).is_some_and(|byte| !byte.is_ascii_alphabetic()));
        match bytes.get(*at) {
            Some(b'0'..=b'9' | b'+' | b'-') => true,
            // A point may be that of an abbreviation.
            Some(b'.') => behind.is_ascii_digit(),
            Some(b'Q' | b'q') => {
                behind.is_ascii_digit() || starts_name && matches!(behind, b'L' | b'R')
            }
            _ => false,
        }
    })
}

impl HeidenhainReader {
    /// Reads `+10`, `10,5`, `-Q3`.
    pub(super) fn value(&self, token: &Token<'_>) -> Result<KlartextValue, ReadRemark> {
        if let Some(found) = number::signed(token.text, DecimalMark::PointOrComma)
            && found.length == token.text.len()
        {
            return Ok(KlartextValue { value: found.value, decimals: found.decimals });
        }
        // The value may stand apart from its sign and letter.
        if token.text.contains(char::is_whitespace) {
            let joined = token.text.replace(char::is_whitespace, "");
            return self.value(&Token { text: &joined, at: token.at });
        }
        let value = self.arithmetic(token.text, token.at)?;
        Ok(KlartextValue { value, decimals: COMPUTED })
    }

    /// Evaluates `+Q1 * 2`, `Q1 DIV 2`.
    pub(super) fn arithmetic(&self, text: &str, at: usize) -> Result<f64, ReadRemark> {
        // FN 4 writes its division as DIV.
        let text = text.replace("DIV", "/");
        let written = FormulaText { text: &text, from: 0, at, mark: DecimalMark::PointOrComma };
        arithmetic::value(&written, &self.variables)
    }
}
