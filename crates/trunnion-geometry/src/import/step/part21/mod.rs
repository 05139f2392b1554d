//! The text layer of a STEP file (ISO 10303-21, "Part 21"): bytes to numbered records.
//!
//! Reads in one pass, in linear time, without deep recursion and without ever
//! trusting a reference: what a record means, and whether what it refers to exists, is decided one
//! layer up. Records keep the order and the place they have in the file.

mod scan;

use super::super::ImportError;
use scan::Scanner;
use std::collections::HashMap;

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
