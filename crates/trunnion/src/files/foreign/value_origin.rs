//! Record of which value became which.

use super::source_value::SourceValue;

/// Use of one value of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct ValueOrigin {
    /// Line, counted from 1; 0 if the caller gave the value.
    pub line: u64,
    /// Its key in the file.
    pub key: String,
    /// The value as written.
    pub value: String,
    /// Entries of the machine file that it became.
    pub target: String,
}

impl ValueOrigin {
    pub(super) fn new(from: &SourceValue, target: &str) -> Self {
        let SourceValue { key, value, line } = from.clone();
        Self { line, key, value, target: target.to_owned() }
    }
}
