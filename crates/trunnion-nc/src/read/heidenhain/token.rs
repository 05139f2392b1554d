//! Words of a block, parted by blanks, and their values.

use crate::read::log::ReadRemark;

/// A word and its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Token<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
}

impl<'a> Token<'a> {
    /// Returns the word without its first bytes.
    pub(super) fn after(&self, bytes: usize) -> Token<'a> {
        Token { text: self.text.get(bytes..).unwrap_or_default(), at: self.at + bytes }
    }
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

    /// Returns the whole block.
    pub(super) fn text(&self) -> &'a str {
        self.text
    }

    /// Returns the next word; quotes keep blanks.
    pub(super) fn next_token(&mut self) -> Option<Token<'a>> {
        let rest = self.text.get(self.at..)?;
        let at = self.at + rest.len() - rest.trim_start().len();
        let rest = self.text.get(at..)?;
        // Names of labels and tools may have blanks between quotes.
        let mut quoted = false;
        let ends = |c: char| {
            quoted ^= c == '"';
            c.is_whitespace() && !quoted
        };
        let length = rest.find(ends).unwrap_or(rest.len());
        self.at = at + length;
        (length > 0).then(|| Token { text: rest.get(..length).unwrap_or_default(), at })
    }

    /// Returns the next word, which has to be there.
    pub(super) fn expect(&mut self) -> Result<Token<'a>, ReadRemark> {
        let at = self.text.len();
        self.next_token().ok_or_else(|| ReadRemark::new(at, "a word is missing here", ""))
    }
}
