//! Words of one line of G-code.

/// A letter and its number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Word<'a> {
    /// Upper-case letter.
    pub(super) letter: char,
    /// Its number.
    pub(super) value: f64,
    /// Digits after the point.
    pub(super) decimals: u8,
    /// The word as written.
    pub(super) text: &'a str,
    /// Byte offset in the line.
    pub(super) at: usize,
}

/// Something that is no word: where it stands, what it is, what to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotAWord {
    /// Byte offset in the line.
    pub(super) at: usize,
    /// What it is.
    pub(super) message: &'static str,
}

/// Splits a line into words; comments `( )` and `;` are left out.
pub(super) struct Lexer<'a> {
    line: &'a str,
    at: usize,
}

impl<'a> Lexer<'a> {
    /// Words of `line`.
    pub(super) fn new(line: &'a str) -> Self {
        Self { line, at: 0 }
    }

    /// The byte that comes next.
    fn peek(&self) -> Option<u8> {
        self.line.as_bytes().get(self.at).copied()
    }

    /// Passes blanks and comments; the offset of a comment that does not end is an error.
    fn skip(&mut self) -> Result<(), NotAWord> {
        while let Some(byte) = self.peek() {
            match byte {
                b' ' | b'\t' | b'\r' => self.at += 1,
                b';' => self.at = self.line.len(),
                b'(' => {
                    let rest = self.line.get(self.at..).unwrap_or_default();
                    let Some(end) = rest.find(')') else {
                        let at = self.at;
                        self.at = self.line.len();
                        return Err(NotAWord { at, message: "comment without a closing )" });
                    };
                    self.at += end + 1;
                }
                _ => break,
            }
        }
        Ok(())
    }

    /// The number at the present place: its value and the digits after its point.
    fn number(&mut self) -> Option<(f64, u8)> {
        let start = self.at;
        if matches!(self.peek(), Some(b'+' | b'-')) {
            self.at += 1;
        }
        let whole = self.digits();
        let mut fraction = 0;
        if self.peek() == Some(b'.') {
            self.at += 1;
            fraction = self.digits();
        }
        let text = self.line.get(start..self.at)?;
        if whole + fraction == 0 {
            return None;
        }
        Some((text.parse().ok()?, u8::try_from(fraction).unwrap_or(u8::MAX)))
    }

    /// Passes digits and counts them.
    fn digits(&mut self) -> usize {
        let start = self.at;
        while self.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            self.at += 1;
        }
        self.at - start
    }

    /// Names what stands where a word should begin, and passes it.
    fn stray(&mut self) -> NotAWord {
        let at = self.at;
        let message = match self.peek() {
            Some(b'#' | b'[') => "parameters and expressions are not understood",
            Some(b'%') => "% must stand alone on its line",
            Some(b'/') => "block delete: whether the control runs this block is not known",
            Some(b'0'..=b'9' | b'.' | b'+' | b'-') => "number without a letter",
            _ => "not a G-code word",
        };
        self.at = self.line.len();
        NotAWord { at, message }
    }

    /// The next word; after an error the rest of the line is given up.
    pub(super) fn next_word(&mut self) -> Option<Result<Word<'a>, NotAWord>> {
        if let Err(error) = self.skip() {
            return Some(Err(error));
        }
        let at = self.at;
        let letter = self.peek()?;
        if !letter.is_ascii_alphabetic() {
            return Some(Err(self.stray()));
        }
        self.at += 1;
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        let Some((value, decimals)) = self.number() else {
            let message = match self.peek() {
                Some(b'#' | b'[' | b'=') => "parameters and expressions are not understood",
                _ => "letter without a number",
            };
            self.at = self.line.len();
            return Some(Err(NotAWord { at, message }));
        };
        let letter = char::from(letter.to_ascii_uppercase());
        let text = self.line.get(at..self.at).unwrap_or_default();
        Some(Ok(Word { letter, value, decimals, text, at }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<Result<(char, f64, u8), NotAWord>> {
        let mut lexer = Lexer::new(line);
        std::iter::from_fn(|| lexer.next_word())
            .map(|word| word.map(|w| (w.letter, w.value, w.decimals)))
            .collect()
    }

    #[test]
    fn words_need_no_blanks_and_comments_are_passed() {
        let expected = vec![Ok(('G', 1.0, 0)), Ok(('X', -0.5, 1)), Ok(('Y', 3.0, 0))];
        assert_eq!(words("g1X-.5 (Z9) y 3. ; F1"), expected);
    }

    #[test]
    fn strays_are_named_with_their_place() {
        let stray = |line: &str| words(line).into_iter().find_map(Result::err).map(|e| e.at);
        assert_eq!(stray("X1 #2=3"), Some(3));
        assert_eq!(stray("X"), Some(0));
        assert_eq!(stray("G1 (open"), Some(3));
        assert_eq!(stray("G1 Xé"), Some(3));
    }
}
