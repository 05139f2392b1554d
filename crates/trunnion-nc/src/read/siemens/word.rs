//! Words of a block: `X10`, `A3=0.5`, `CYCLE832(0.01)`, `TRAORI`.

use crate::read::log::ReadRemark;
use crate::read::number::{self, DecimalMark};

/// Text behind a name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WordTail<'a> {
    /// Nothing.
    Nothing,
    /// A number, at once: `X10`.
    Number(&'a str),
    /// `=` and a text.
    Assigned(&'a str),
    /// `( .. )`.
    Arguments,
}

/// A G or M code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SiemensCode {
    /// `G` or `M`.
    pub(super) letter: u8,
    /// Number in tenths: `G54` is 540.
    pub(super) tenths: u32,
}

/// The name of a word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum WordName<'a> {
    /// `G54`, `M3`.
    Code(SiemensCode),
    Text(&'a str),
}

/// A word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SiemensWord<'a> {
    pub(super) name: WordName<'a>,
    pub(super) behind: WordTail<'a>,
    /// Byte offsets.
    pub(super) at: usize,
    pub(super) end: usize,
    /// Byte offset of the value.
    pub(super) value_at: usize,
    pub(super) line: &'a str,
}

impl<'a> SiemensWord<'a> {
    pub(super) fn text_name(&self) -> &'a str {
        match self.name {
            WordName::Text(name) => name,
            WordName::Code(_) => "",
        }
    }

    pub(super) fn is_assignment(&self) -> bool {
        matches!(self.behind, WordTail::Assigned(_))
    }

    pub(super) fn has_value(&self) -> bool {
        !matches!(self.behind, WordTail::Nothing)
    }

    /// Returns the text between quotes.
    pub(super) fn quoted(&self) -> Option<&'a str> {
        match self.behind {
            WordTail::Assigned(text) => text.trim().strip_prefix('"')?.strip_suffix('"'),
            _ => None,
        }
    }

    /// Returns the number behind a prefix of the name: 12 of `R12`.
    pub(super) fn number_of(&self, prefix: &str) -> Option<u32> {
        let name = self.text_name().to_ascii_uppercase();
        name.strip_prefix(prefix)?.parse().ok()
    }
}

/// The words of a block, one by one.
pub(super) struct SiemensWords<'a> {
    line: &'a str,
    at: usize,
}

/// Returns the block without its comment, which begins with `;` outside of quotes.
pub(super) fn without_comment(line: &str) -> &str {
    let mut quoted = false;
    for (at, byte) in line.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b';' if !quoted => return line.get(..at).unwrap_or(line),
            _ => {}
        }
    }
    line
}

impl<'a> SiemensWords<'a> {
    pub(super) fn new(line: &'a str, at: usize) -> Self {
        Self { line, at }
    }

    fn peek(&self) -> Option<u8> {
        self.line.as_bytes().get(self.at).copied()
    }

    fn blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
    }

    fn rest(&self) -> &'a str {
        self.line.get(self.at..).unwrap_or_default()
    }

    /// Returns the next word, if there is one.
    pub(super) fn next_item(&mut self) -> Result<Option<SiemensWord<'a>>, ReadRemark> {
        self.blanks();
        let at = self.at;
        let Some(byte) = self.peek() else { return Ok(None) };
        if !(byte.is_ascii_alphabetic() || byte == b'_') {
            return Err(ReadRemark::new(at, "not a word", "is it the right dialect?"));
        }
        let rest = self.rest();
        let letters = rest.bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
        let name = rest.get(..letters).unwrap_or_default();
        let behind = rest.get(letters..).unwrap_or_default().trim_start();
        // FGREF[A]=10: the index stands before the sign.
        let index = behind.starts_with('[').then(|| behind.find(']')).flatten();
        if let Some(close) = index
            && behind.get(close + 1..).is_some_and(|rest| rest.trim_start().starts_with('='))
        {
            let from = rest.len() - behind.len();
            return self.named(at, name, from + close + 1).map(Some);
        }
        // `==` compares: the name before it is no assignment.
        if behind.starts_with('=') && !behind.starts_with("==") || behind.starts_with('(') {
            return self.named(at, name, name.len()).map(Some);
        }
        self.address(at, name).map(Some)
    }

    /// Reads `NAME = value`, `NAME(..)`.
    fn named(
        &mut self,
        at: usize,
        name: &'a str,
        length: usize,
    ) -> Result<SiemensWord<'a>, ReadRemark> {
        self.at += length;
        self.blanks();
        let assigned = self.peek() == Some(b'=');
        self.at += usize::from(assigned);
        self.blanks();
        let value_at = self.at;
        let length = extent(self.rest()).ok_or_else(|| {
            ReadRemark::new(value_at, "a bracket or quote that is not closed", "close it")
        })?;
        if assigned && length == 0 {
            return Err(ReadRemark::new(value_at, "a value is missing here", "write it behind ="));
        }
        self.at += length;
        let text = self.line.get(value_at..self.at).unwrap_or_default();
        let behind = if assigned { WordTail::Assigned(text) } else { WordTail::Arguments };
        let (name, end, line) = (WordName::Text(name), self.at, self.line);
        Ok(SiemensWord { name, behind, at, end, value_at, line })
    }

    /// Reads `X10`, `G54`, `M30`, or a bare name.
    fn address(&mut self, at: usize, name: &'a str) -> Result<SiemensWord<'a>, ReadRemark> {
        let line = self.line;
        let letter = name.as_bytes().first().map_or(0, u8::to_ascii_uppercase);
        let second = name.as_bytes().get(1);
        // A second letter: a keyword. A digit or sign: an address with its number.
        let bare = second.is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_');
        if bare {
            self.at += name.len();
            let (name, end) = (WordName::Text(name), self.at);
            return Ok(SiemensWord {
                name,
                behind: WordTail::Nothing,
                at,
                end,
                value_at: end,
                line,
            });
        }
        self.at += 1;
        self.blanks();
        let value_at = self.at;
        let Some(found) = number::signed(self.rest().as_bytes(), DecimalMark::Point) else {
            let message = "letter without a number";
            return Err(ReadRemark::new(at, message, "write its value, or = and an expression"));
        };
        self.at += found.length;
        let (end, text) = (self.at, self.line.get(value_at..self.at).unwrap_or_default());
        // The value of other addresses keeps its digits for the rounding of words.
        if matches!(letter, b'G' | b'M') {
            let tenths = super::super::gcode::tenths(found.value)
                .ok_or_else(|| ReadRemark::new(at, "no code", "codes are whole numbers"))?;
            let name = WordName::Code(SiemensCode { letter, tenths });
            return Ok(SiemensWord {
                name,
                behind: WordTail::Number(text),
                at,
                end,
                value_at,
                line,
            });
        }
        let name = WordName::Text(name.get(..1).unwrap_or_default());
        Ok(SiemensWord { name, behind: WordTail::Number(text), at, end, value_at, line })
    }
}

/// Returns the length of a value or argument list: up to a blank outside of brackets, quotes and
/// operators.
fn extent(text: &str) -> Option<usize> {
    let (mut depth, mut quoted, mut operand) = (0_u32, false, true);
    let mut end = 0;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'"' => (quoted, operand) = (!quoted, false),
            _ if quoted => {}
            b'(' => depth = depth.checked_add(1)?,
            b')' if depth == 0 => return Some(end),
            b')' => {
                depth -= 1;
                operand = false;
            }
            b' ' | b'\t' | b'\r' if depth == 0 => continue,
            b'+' | b'-' | b'*' | b'/' if depth == 0 => operand = true,
            _ if depth == 0 => {
                // What stands behind a blank or bracket, and no operator awaits, is the next word.
                let closed = text.as_bytes().get(..at).is_some_and(|before| before.ends_with(b")"));
                if (end < at || closed) && !operand {
                    return Some(end);
                }
                operand = false;
            }
            _ => {}
        }
        end = at + 1;
    }
    (depth == 0 && !quoted).then_some(end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_end_where_they_end() {
        let mut items = SiemensWords::new(
            "T=\"A B\" N10 G1 X=R1 + 2*(3 - 1) Y-5.5A3=0.5 CYCLE832(0.1, 2) TRAORI C=ACP(33)F5",
            0,
        );
        let mut found = Vec::new();
        while let Some(item) = items.next_item().unwrap() {
            found.push(item.line.get(item.at..item.end).unwrap());
        }
        let expected = [
            "T=\"A B\"",
            "N10",
            "G1",
            "X=R1 + 2*(3 - 1)",
            "Y-5.5",
            "A3=0.5",
            "CYCLE832(0.1, 2)",
            "TRAORI",
            "C=ACP(33)",
            "F5",
        ];
        assert_eq!(found, expected);
        assert!(SiemensWords::new("MSG(\"a", 0).next_item().is_err());
        assert_eq!(without_comment("MSG(\"a;b\") ; c"), "MSG(\"a;b\") ");
    }
}
