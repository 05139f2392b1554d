//! The text layer of a STEP file (ISO 10303-21, "Part 21"): bytes to numbered records.
//!
//! Reads in one pass, in linear time, without recursion beyond [`MAX_DEPTH`] and without ever
//! trusting a reference: what a record means, and whether what it refers to exists, is decided one
//! layer up. Records keep the order and the place they have in the file.

use super::super::ImportError;
use std::collections::HashMap;

/// Deepest nesting of lists that is read. The deepest of the schema is 3 (rows of a control net
/// inside a record); more is a damaged or hostile file, and would only serve to exhaust the stack.
const MAX_DEPTH: usize = 32;

/// One parameter of a record.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// `$`, `*`, or a binary: nothing this reader uses.
    Absent,
    /// A whole number.
    Integer(i64),
    /// A real number, always finite.
    Real(f64),
    /// `'text'`.
    Text(String),
    /// `.WORD.`
    Word(String),
    /// `#123`
    Reference(u64),
    /// `KEYWORD(value, ...)`
    Typed(Record),
    /// `(value, ...)`
    List(Vec<Value>),
}

/// `NAME(value, ...)`
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Record {
    /// Keyword in upper case.
    pub(super) name: String,
    /// Parameters in order.
    pub(super) values: Vec<Value>,
}

/// `#id = record;` or `#id = ( record record ... );`
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Instance {
    /// The number after `#`.
    pub(super) id: u64,
    /// Line of the file, from 1.
    pub(super) line: usize,
    /// One record, or the parts of a complex entity.
    pub(super) records: Vec<Record>,
}

/// The data sections of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Exchange {
    /// In file order.
    pub(super) instances: Vec<Instance>,
    index: HashMap<u64, usize>,
}

impl Value {
    /// The number, whether written as a real, an integer or `TYPE(number)`.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Real(x) => Some(*x),
            // Exact: lengths and knots written as integers are far below 2^53.
            Self::Integer(x) => Some(*x as f64),
            Self::Typed(record) => match record.values.as_slice() {
                [Self::Real(x)] => Some(*x),
                [Self::Integer(x)] => Some(*x as f64),
                _ => None,
            },
            _ => None,
        }
    }

    /// The whole number as a count or index.
    pub(super) fn count(&self) -> Option<usize> {
        match self {
            Self::Integer(x) => usize::try_from(*x).ok(),
            _ => None,
        }
    }

    /// The referenced entity.
    pub(super) fn reference(&self) -> Option<u64> {
        match self {
            Self::Reference(id) => Some(*id),
            _ => None,
        }
    }

    /// `.T.` or `.F.`
    pub(super) fn truth(&self) -> Option<bool> {
        match self {
            Self::Word(word) if word == "T" => Some(true),
            Self::Word(word) if word == "F" => Some(false),
            _ => None,
        }
    }

    /// The elements of a list.
    pub(super) fn list(&self) -> Option<&[Self]> {
        match self {
            Self::List(values) => Some(values),
            _ => None,
        }
    }
}

impl Instance {
    /// The part of that name.
    pub(super) fn part(&self, name: &str) -> Option<&Record> {
        self.records.iter().find(|record| record.name == name)
    }

    /// The name of a simple entity, the names of a complex one joined by `+`.
    pub(super) fn kind(&self) -> String {
        let names: Vec<&str> = self.records.iter().map(|record| record.name.as_str()).collect();
        names.join("+")
    }
}

impl Exchange {
    /// Reads a whole file.
    ///
    /// # Errors
    ///
    /// [`ImportError::Syntax`] at the first place that breaks the grammar,
    /// [`ImportError::Truncated`] where the file stops before `END-ISO-10303-21;`.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, ImportError> {
        let mut scanner = Scanner::new(bytes);
        scanner.header()?;
        let mut exchange = Self::default();
        while scanner.data_section(&mut exchange)? {}
        Ok(exchange)
    }

    /// The instance numbered `id`.
    pub(super) fn get(&self, id: u64) -> Option<&Instance> {
        self.index.get(&id).and_then(|&place| self.instances.get(place))
    }

    /// Line of instance `id`; 0 if there is none.
    pub(super) fn line(&self, id: u64) -> usize {
        self.get(id).map_or(0, |instance| instance.line)
    }

    fn push(&mut self, instance: Instance) -> Result<(), (usize, u64)> {
        if let Some(earlier) = self.get(instance.id) {
            return Err((earlier.line, instance.id));
        }
        self.index.insert(instance.id, self.instances.len());
        self.instances.push(instance);
        Ok(())
    }
}

/// A place in the bytes, and the line it is on.
struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    line_start: usize,
}

type Read<T> = Result<T, ImportError>;

impl<'a> Scanner<'a> {
    fn new(bytes: &'a [u8]) -> Self {
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

    /// What stands here, for a message.
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
    fn header(&mut self) -> Read<()> {
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
                Some(b'D') if self.starts_with("DATA") => return Ok(()),
                Some(byte) if byte.is_ascii_alphanumeric() => {
                    self.keyword();
                }
                Some(_) => self.advance(),
            }
        }
    }

    /// One `DATA ... ENDSEC;`; `false` at `END-ISO-10303-21;` (a signature may follow it).
    fn data_section(&mut self, exchange: &mut Exchange) -> Read<bool> {
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

    fn instance(&mut self) -> Read<Instance> {
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
            while self.peek() != Some(b')') {
                records.push(self.record(0)?);
                self.skip()?;
            }
            self.advance();
        } else {
            records.push(self.record(0)?);
        }
        self.expect(b';', "at the end of an entity")?;
        Ok(Instance { id, line, records })
    }

    fn record(&mut self, depth: usize) -> Read<Record> {
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
        Ok(Record { name, values: self.values(depth)? })
    }

    /// `( value, ... )`
    fn values(&mut self, depth: usize) -> Read<Vec<Value>> {
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

    fn value(&mut self, depth: usize) -> Read<Value> {
        match self.peek() {
            Some(b'$' | b'*') => {
                self.advance();
                Ok(Value::Absent)
            }
            Some(b'\'') => self.text().map(Value::Text),
            Some(b'"') => self.binary(),
            Some(b'.') => self.word(),
            Some(b'#') => self.identifier().map(Value::Reference),
            Some(b'(') => self.values(depth + 1).map(Value::List),
            Some(b'+' | b'-' | b'0'..=b'9') => self.number(),
            _ => self.record(depth + 1).map(Value::Typed),
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

    fn number(&mut self) -> Read<Value> {
        let start = self.at;
        let numeric = |byte: u8| matches!(byte, b'+' | b'-' | b'.' | b'E' | b'e' | b'0'..=b'9');
        while self.peek().is_some_and(numeric) {
            self.at += 1;
        }
        let text = self.bytes.get(start..self.at).unwrap_or_default();
        let text = std::str::from_utf8(text).unwrap_or_default();
        if let Ok(integer) = text.parse() {
            return Ok(Value::Integer(integer));
        }
        match text.parse::<f64>() {
            Ok(real) if real.is_finite() => Ok(Value::Real(real)),
            _ => {
                let text = text.to_owned();
                self.at = start;
                self.fault(format!("`{text}` is not a finite number"))
            }
        }
    }

    /// `'text'`, a quote inside doubled. Bytes above 127 are taken as Latin-1: such texts are only
    /// ever labels.
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

    fn binary(&mut self) -> Read<Value> {
        self.advance();
        while self.peek() != Some(b'"') {
            if self.peek().is_none() {
                return self.fault("");
            }
            self.advance();
        }
        self.advance();
        Ok(Value::Absent)
    }

    fn word(&mut self) -> Read<Value> {
        // `.5` is not a number of this format, but a common slip; say so.
        self.advance();
        let word = self.keyword();
        if word.is_empty() || self.peek() != Some(b'.') {
            return self.fault("a `.WORD.` must end with a dot, a number starts with a digit");
        }
        self.advance();
        Ok(Value::Word(word))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(text: &str) -> Result<Exchange, ImportError> {
        let file = format!("ISO-10303-21;\nHEADER;\nFILE_NAME('DATA;');\nENDSEC;\nDATA;\n{text}\n");
        Exchange::parse(format!("{file}ENDSEC;\nEND-ISO-10303-21;\n").as_bytes())
    }

    #[test]
    fn records_keep_order_line_and_values() {
        let text = "#7 = A('it''s',(1,-2.5E1,.T.),$,*,LENGTH(3.));\n/* no */ #2=(B()C(#7));";
        let exchange = data(text).unwrap();
        let first = &exchange.instances[0];
        assert_eq!((first.id, first.line), (7, 6));
        let values = &first.part("A").unwrap().values;
        assert_eq!(values[0], Value::Text("it's".to_owned()));
        let list = values[1].list().unwrap();
        assert_eq!((list[0].count(), list[1].number()), (Some(1), Some(-25.0)));
        assert_eq!(list[2].truth(), Some(true));
        assert_eq!(values[4].number(), Some(3.0));
        assert_eq!(exchange.get(2).unwrap().kind(), "B+C");
        assert_eq!(exchange.line(2), 7);
        assert_eq!(exchange.get(2).unwrap().part("C").unwrap().values[0].reference(), Some(7));
    }

    #[test]
    fn faults_name_their_place() {
        let at = |text| match data(text) {
            Err(ImportError::Syntax { line, column, .. }) => (line, column),
            other => panic!("{other:?}"),
        };
        assert_eq!(at("#1 = A(1,NAN);"), (6, 13));
        assert_eq!(at("#1 = A(1E999);"), (6, 8));
        assert_eq!(at("#1 = A(1);\n#1 = A(1);"), (7, 11));
        assert_eq!(at("#1 = A(1\n#2 = B();"), (7, 1));
        let deep = format!("#1 = A{}1{};", "(".repeat(100), ")".repeat(100));
        assert_eq!(at(&deep).0, 6);
    }

    #[test]
    fn a_file_cut_short_says_so() {
        let whole = "ISO-10303-21;HEADER;ENDSEC;DATA;#1=A('x',(1.,2.));ENDSEC;END-ISO-10303-21;";
        assert!(Exchange::parse(whole.as_bytes()).is_ok());
        for end in 13..whole.len() {
            assert!(Exchange::parse(&whole.as_bytes()[..end]).is_err(), "{}", &whole[..end]);
        }
    }
}
