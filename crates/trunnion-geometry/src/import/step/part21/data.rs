//! Records of a STEP file, as they are written.

use std::collections::HashMap;

/// One parameter of a record.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::import::step) enum StepValue {
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
    Typed(StepRecord),
    /// `(value, ...)`
    List(Vec<StepValue>),
}

/// `NAME(value, ...)`
#[derive(Debug, Clone, PartialEq)]
pub(in crate::import::step) struct StepRecord {
    /// Keyword in upper case.
    pub(in crate::import::step) name: String,
    /// Parameters in order.
    pub(in crate::import::step) values: Vec<StepValue>,
}

/// `#id = record;` or `#id = ( record record ... );`
#[derive(Debug, Clone, PartialEq)]
pub(in crate::import::step) struct StepInstance {
    /// The number after `#`.
    pub(in crate::import::step) id: u64,
    /// Line of the file, from 1.
    pub(in crate::import::step) line: usize,
    /// One record, or the parts of a complex entity.
    pub(in crate::import::step) records: Vec<StepRecord>,
}

/// The data sections of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::import::step) struct StepExchange {
    /// In file order.
    pub(in crate::import::step) instances: Vec<StepInstance>,
    index: HashMap<u64, usize>,
}

impl StepValue {
    /// Returns the number, written as a real, an integer or `TYPE(number)`.
    pub(in crate::import::step) fn number(&self) -> Option<f64> {
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

    /// Returns the whole number as a count or index.
    pub(in crate::import::step) fn count(&self) -> Option<usize> {
        match self {
            Self::Integer(x) => usize::try_from(*x).ok(),
            _ => None,
        }
    }

    /// Returns the referenced entity.
    pub(in crate::import::step) fn reference(&self) -> Option<u64> {
        match self {
            Self::Reference(id) => Some(*id),
            _ => None,
        }
    }

    /// Returns the truth value of `.T.` or `.F.`.
    pub(in crate::import::step) fn truth(&self) -> Option<bool> {
        match self {
            Self::Word(word) if word == "T" => Some(true),
            Self::Word(word) if word == "F" => Some(false),
            _ => None,
        }
    }

    /// Returns the elements of a list.
    pub(in crate::import::step) fn list(&self) -> Option<&[Self]> {
        match self {
            Self::List(values) => Some(values),
            _ => None,
        }
    }
}

impl StepInstance {
    /// Returns the part of that name.
    pub(in crate::import::step) fn part(&self, name: &str) -> Option<&StepRecord> {
        self.records.iter().find(|record| record.name == name)
    }

    /// Returns the name of a simple entity, or the names of a complex one joined by `+`.
    pub(in crate::import::step) fn kind(&self) -> String {
        let names: Vec<&str> = self.records.iter().map(|record| record.name.as_str()).collect();
        names.join("+")
    }
}

impl StepExchange {
    /// Returns the instance numbered `id`.
    pub(in crate::import::step) fn get(&self, id: u64) -> Option<&StepInstance> {
        self.index.get(&id).and_then(|&place| self.instances.get(place))
    }

    /// Returns the line of instance `id`; 0 if there is none.
    pub(in crate::import::step) fn line(&self, id: u64) -> usize {
        self.get(id).map_or(0, |instance| instance.line)
    }

    pub(super) fn push(&mut self, instance: StepInstance) -> Result<(), (usize, u64)> {
        if let Some(earlier) = self.get(instance.id) {
            return Err((earlier.line, instance.id));
        }
        self.index.insert(instance.id, self.instances.len());
        self.instances.push(instance);
        Ok(())
    }
}
