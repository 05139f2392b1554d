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

    /// Returns the next word together with its value, which may stand apart: `Z 25.000`, `X + 5`.
    pub(super) fn next_word(&mut self) -> Option<Token<'a>> {
        let word = self.next_token()?;
        let mut end = word.at + word.text.len();
        // A sign may stand apart from both sides.
        while wants_value(self.text.get(word.at..end)?) {
            let mut ahead = self.clone();
            let Some(next) = ahead.next_token() else { break };
            let begins = next.text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
            let parameter = next.text.starts_with(['Q', 'q']) && next.text.len() > 1;
            if !(begins || parameter) {
                break;
            }
            end = next.at + next.text.len();
            *self = ahead;
        }
        Some(Token { text: self.text.get(word.at..end)?, at: word.at })
    }

    /// Returns the value of a word behind its first bytes, or the next word where nothing is behind them: `F800`, `F 800`.
    pub(super) fn value_of(
        &mut self,
        word: &Token<'a>,
        bytes: usize,
    ) -> Result<Token<'a>, ReadRemark> {
        if word.text.len() == bytes { self.expect() } else { Ok(word.after(bytes)) }
    }

    /// Returns the next word, which has to be there.
    pub(super) fn expect(&mut self) -> Result<Token<'a>, ReadRemark> {
        let at = self.text.len();
        self.next_token().ok_or_else(|| ReadRemark::new(at, "a word is missing here", ""))
    }
}

/// Returns true for `Q1`, `QL2`, `QR3`.
pub(super) fn is_q(word: &str) -> bool {
    let digits = word.trim_start_matches("QL").trim_start_matches("QR").trim_start_matches('Q');
    word.starts_with('Q') && !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())
}

/// Returns true for a letter, or one of the pairs of letters, whose value is still to come.
fn wants_value(text: &str) -> bool {
    const PAIRS: [&str; 14] =
        ["PR", "PA", "IPR", "IPA", "TX", "TY", "TZ", "NX", "NY", "NZ", "SPA", "SPB", "SPC", "MB"];
    let name = text.trim_end_matches(|c: char| "+-".contains(c) || c.is_whitespace());
    let name = name.to_ascii_uppercase();
    let letter = name.strip_prefix('I').filter(|rest| !rest.is_empty()).unwrap_or(&name);
    let single = letter.len() == 1 && letter.bytes().all(|byte| byte.is_ascii_uppercase());
    single || PAIRS.contains(&name.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<&str> {
        let mut tokens = Tokens::new(text, 0);
        std::iter::from_fn(|| tokens.next_word()).map(|token| token.text).collect()
    }

    #[test]
    fn values_may_stand_apart() {
        assert_eq!(words("Z 25.000 R0 F MAX"), ["Z 25.000", "R0", "F", "MAX"]);
        assert_eq!(words("X + 5  IY- 3 F Q1 M 3"), ["X + 5", "IY- 3", "F Q1", "M 3"]);
        assert_eq!(words("X+1 DR+ M99"), ["X+1", "DR+", "M99"]);
    }
}
