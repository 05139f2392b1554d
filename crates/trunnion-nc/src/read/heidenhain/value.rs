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

impl HeidenhainReader {
    /// Reads `+10`, `10,5`, `-Q3`.
    pub(super) fn value(&self, token: &Token<'_>) -> Result<KlartextValue, ReadRemark> {
        if let Some(found) = number::signed(token.text.as_bytes(), DecimalMark::PointOrComma)
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
