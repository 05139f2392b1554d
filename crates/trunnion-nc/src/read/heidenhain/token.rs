//! Words of a block, parted by blanks, and their values.

use super::super::arithmetic::{self, Written};
use super::super::control::COMPUTED;
use super::super::log::Remark;
use super::super::number;
use super::Heidenhain;

/// A word and its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Token<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
}

impl<'a> Token<'a> {
    /// The word without its first bytes.
    pub(super) fn after(&self, bytes: usize) -> Token<'a> {
        Token { text: self.text.get(bytes..).unwrap_or_default(), at: self.at + bytes }
    }
}

/// A value and the digits behind its point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Value {
    pub(super) value: f64,
    pub(super) decimals: u8,
}

/// The words of a block.
#[derive(Debug, Clone)]
pub(super) struct Tokens<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Tokens<'a> {
    pub(super) fn new(text: &'a str, at: usize) -> Self {
        Self { text, at }
    }

    /// The whole block.
    pub(super) fn text(&self) -> &'a str {
        self.text
    }

    /// The next word; quotes keep blanks.
    pub(super) fn next_token(&mut self) -> Option<Token<'a>> {
        let rest = self.text.get(self.at..)?;
        let at = self.at + rest.len() - rest.trim_start().len();
        let rest = self.text.get(at..)?;
        let mut quoted = false;
        let ends = |c: char| {
            quoted ^= c == '"';
            c.is_whitespace() && !quoted
        };
        let length = rest.find(ends).unwrap_or(rest.len());
        self.at = at + length;
        (length > 0).then(|| Token { text: rest.get(..length).unwrap_or_default(), at })
    }

    /// The next word, which has to be there.
    pub(super) fn expect(&mut self) -> Result<Token<'a>, Remark> {
        let at = self.text.len();
        self.next_token().ok_or_else(|| Remark::new(at, "a word is missing here", ""))
    }
}

impl Heidenhain {
    /// `+10`, `10,5`, `-Q3`.
    pub(super) fn value(&self, token: &Token<'_>) -> Result<Value, Remark> {
        if let Some(found) = number::signed(token.text, true)
            && found.length == token.text.len()
        {
            return Ok(Value { value: found.value, decimals: found.decimals });
        }
        let value = self.arithmetic(token.text, token.at)?;
        Ok(Value { value, decimals: COMPUTED })
    }

    /// `+Q1 * 2`, `Q1 DIV 2`.
    pub(super) fn arithmetic(&self, text: &str, at: usize) -> Result<f64, Remark> {
        let text = text.replace("DIV", "/");
        let written = Written { text: &text, from: 0, at, comma: true };
        arithmetic::value(&written, &self.variables)
    }
}
