//! The grammar of Part 21: records out of bytes, with line and column for what breaks it.

use super::data::{StepExchange, StepInstance, StepRecord, StepValue};
use crate::import::error::ImportError;

/// Deepest nesting of lists that is read. The deepest of the schema is 3 (rows of a control net
/// inside a record); more is a damaged or hostile file, and would only serve to exhaust the stack.
const MAX_DEPTH: usize = 32;

/// A position in the bytes, and the line it is on.
pub(super) struct Part21Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    line_start: usize,
}

type Read<T> = Result<T, ImportError>;

impl<'a> Part21Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, line: 1, line_start: 0 }
    }

    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn advance(&mut self) {
        if self.peek() == Some(b'\n') {
            self.line += 1;
            self.line_start = self.at + 1;
        }
        self.at += 1;
    }

    fn starts_with(&self, text: &str) -> bool {
        self.bytes.get(self.at..).is_some_and(|rest| rest.starts_with(text.as_bytes()))
    }

    fn fault<T>(&self, message: impl Into<String>) -> Read<T> {
        if self.at >= self.bytes.len() {
            return Err(ImportError::Truncated { line: self.line });
        }
        let column = self.at - self.line_start + 1;
        Err(ImportError::Syntax { line: self.line, column, message: message.into() })
    }

    /// Returns the word that stands here, for a message.
    fn found(&self) -> String {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let word: String = rest
            .iter()
            .take(16)
            .take_while(|byte| byte.is_ascii_graphic())
            .map(|&byte| char::from(byte))
            .collect();
        if word.is_empty() { "an unprintable byte".to_owned() } else { format!("`{word}`") }
    }

    /// Passes white space and comments.
    fn skip(&mut self) -> Read<()> {
        loop {
            match self.peek() {
                Some(byte) if byte.is_ascii_whitespace() => self.advance(),
                Some(b'/') if self.starts_with("/*") => self.comment()?,
                _ => return Ok(()),
            }
        }
    }

    fn comment(&mut self) -> Read<()> {
        while !self.starts_with("*/") {
            if self.peek().is_none() {
                return self.fault("");
            }
            self.advance();
        }
        self.at += 2;
        Ok(())
    }

    fn expect(&mut self, byte: u8, place: &str) -> Read<()> {
        self.skip()?;
        if self.peek() != Some(byte) {
            let wanted = char::from(byte);
            let found = self.found();
            return self.fault(format!("expected `{wanted}` {place}, found {found}"));
        }
        self.advance();
        Ok(())
    }

    /// Passes everything up to the first data section.
    pub(super) fn header(&mut self) -> Read<()> {
        self.skip()?;
        if !self.starts_with("ISO-10303-21;") {
            let found = self.found();
            return self.fault(format!("expected `ISO-10303-21;`, found {found}"));
        }
        loop {
            self.skip()?;
            match self.peek() {
                None => return self.fault(""),
                Some(b'\'') => {
                    self.text()?;
                }
                // Texts are skipped as a whole above: a `DATA` in one does not end the header.
                Some(b'D') if self.starts_with("DATA") => return Ok(()),
                Some(byte) if byte.is_ascii_alphanumeric() => {
                    self.keyword();
                }
                Some(_) => self.advance(),
            }
        }
    }

    /// Reads one `DATA ... ENDSEC;`; returns `false` at `END-ISO-10303-21;` (a signature may follow
    /// it).
    pub(super) fn data_section(&mut self, exchange: &mut StepExchange) -> Read<bool> {
        self.skip()?;
        if self.starts_with("END-ISO-10303-21;") {
            return Ok(false);
        }
        if self.keyword() != "DATA" {
            let found = self.found();
            return self.fault(format!("expected `DATA` or `END-ISO-10303-21;`, found {found}"));
        }
        self.skip()?;
        if self.peek() == Some(b'(') {
            // Since edition 2 a section may carry its name and schemas, which are not needed.
            self.values(0)?;
        }
        self.expect(b';', "after DATA")?;
        loop {
            self.skip()?;
            if self.starts_with("ENDSEC") {
                self.keyword();
                self.expect(b';', "after ENDSEC")?;
                return Ok(true);
            }
            let instance = self.instance()?;
            if let Err((earlier, id)) = exchange.push(instance) {
                return self.fault(format!("#{id} was defined on line {earlier} already"));
            }
        }
    }

    fn instance(&mut self) -> Read<StepInstance> {
        let line = self.line;
        if self.peek() != Some(b'#') {
            let found = self.found();
            return self.fault(format!("expected `#number =` or `ENDSEC;`, found {found}"));
        }
        let id = self.identifier()?;
        self.expect(b'=', "after the number of an entity")?;
        self.skip()?;
        let mut records = Vec::new();
        if self.peek() == Some(b'(') {
            self.advance();
            self.skip()?;
            // A complex entity: records one after another, without commas.
            while self.peek() != Some(b')') {
                records.push(self.record(0)?);
                self.skip()?;
            }
            self.advance();
        } else {
            records.push(self.record(0)?);
        }
        self.expect(b';', "at the end of an entity")?;
        Ok(StepInstance { id, line, records })
    }

    fn record(&mut self, depth: usize) -> Read<StepRecord> {
        // User-defined keywords begin with an exclamation mark.
        if self.peek() == Some(b'!') {
            self.advance();
        }
        let name = self.keyword();
        if name.is_empty() {
            let found = self.found();
            return self.fault(format!("expected a keyword, found {found}"));
        }
        self.skip()?;
        if self.peek() != Some(b'(') {
            return self.fault(format!("`{name}` is not a value, and no `(` follows it"));
        }
        Ok(StepRecord { name, values: self.values(depth)? })
    }

    /// Reads `( value, ... )`.
    fn values(&mut self, depth: usize) -> Read<Vec<StepValue>> {
        if depth > MAX_DEPTH {
            return self.fault(format!("lists are nested more than {MAX_DEPTH} deep"));
        }
        self.expect(b'(', "before values")?;
        let mut values = Vec::new();
        self.skip()?;
        if self.peek() == Some(b')') {
            self.advance();
            return Ok(values);
        }
        loop {
            self.skip()?;
            values.push(self.value(depth)?);
            self.skip()?;
            match self.peek() {
                Some(b',') => self.advance(),
                Some(b')') => {
                    self.advance();
                    return Ok(values);
                }
                _ => {
                    let found = self.found();
                    return self.fault(format!("expected `,` or `)`, found {found}"));
                }
            }
        }
    }

    fn value(&mut self, depth: usize) -> Read<StepValue> {
        match self.peek() {
            Some(b'$' | b'*') => {
                self.advance();
                Ok(StepValue::Absent)
            }
            Some(b'\'') => self.text().map(StepValue::Text),
            Some(b'"') => self.binary(),
            Some(b'.') => self.word(),
            Some(b'#') => self.identifier().map(StepValue::Reference),
            Some(b'(') => self.values(depth + 1).map(StepValue::List),
            Some(b'+' | b'-' | b'0'..=b'9') => self.number(),
            _ => self.record(depth + 1).map(StepValue::Typed),
        }
    }

    fn keyword(&mut self) -> String {
        let start = self.at;
        while self.peek().is_some_and(|byte| byte.is_ascii_alphanumeric() || byte == b'_') {
            self.at += 1;
        }
        let word = self.bytes.get(start..self.at).unwrap_or_default();
        word.iter().map(|byte| char::from(byte.to_ascii_uppercase())).collect()
    }

    fn identifier(&mut self) -> Read<u64> {
        self.advance();
        let start = self.at;
        let digits = self.digits();
        if let Some(id) = digits.parse().ok().filter(|_| !digits.is_empty()) {
            return Ok(id);
        }
        self.at = start;
        self.fault("`#` must be followed by a number below 2^64")
    }

    fn digits(&mut self) -> &'a str {
        let start = self.at;
        while self.peek().is_some_and(|byte| byte.is_ascii_digit()) {
            self.at += 1;
        }
        let digits = self.bytes.get(start..self.at).unwrap_or_default();
        std::str::from_utf8(digits).unwrap_or_default()
    }

    fn number(&mut self) -> Read<StepValue> {
        let start = self.at;
        let numeric = |byte: u8| matches!(byte, b'+' | b'-' | b'.' | b'E' | b'e' | b'0'..=b'9');
        while self.peek().is_some_and(numeric) {
            self.at += 1;
        }
        let text = self.bytes.get(start..self.at).unwrap_or_default();
        let text = std::str::from_utf8(text).unwrap_or_default();
        // An integer too large for 64 bits falls through to a real number.
        if let Ok(integer) = text.parse() {
            return Ok(StepValue::Integer(integer));
        }
        match text.parse::<f64>() {
            Ok(real) if real.is_finite() => Ok(StepValue::Real(real)),
            _ => {
                let text = text.to_owned();
                self.at = start;
                self.fault(format!("`{text}` is not a finite number"))
            }
        }
    }

    /// Reads `'text'`, a quote inside doubled. Bytes above 127 are taken as Latin-1: such texts are
    /// only ever labels.
    fn text(&mut self) -> Read<String> {
        self.advance();
        let mut text = String::new();
        loop {
            match self.peek() {
                None => return self.fault(""),
                Some(b'\'') if self.starts_with("''") => {
                    text.push('\'');
                    self.at += 2;
                }
                Some(b'\'') => {
                    self.advance();
                    return Ok(text);
                }
                Some(byte) => {
                    text.push(char::from(byte));
                    self.advance();
                }
            }
        }
    }

    fn binary(&mut self) -> Read<StepValue> {
        self.advance();
        while self.peek() != Some(b'"') {
            if self.peek().is_none() {
                return self.fault("");
            }
            self.advance();
        }
        self.advance();
        Ok(StepValue::Absent)
    }

    fn word(&mut self) -> Read<StepValue> {
        // `.5` is not a number of this format, but a common slip: the message names it.
        self.advance();
        let word = self.keyword();
        if word.is_empty() || self.peek() != Some(b'.') {
            return self.fault("a `.WORD.` must end with a dot, a number starts with a digit");
        }
        self.advance();
        Ok(StepValue::Word(word))
    }
}
