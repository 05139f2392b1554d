//! Values of a foreign file by key, and the record of their use.

use super::source_value::SourceValue;
use super::value_origin::ValueOrigin;
use crate::types::Diagnostic;

/// All values of a file, in order.
#[derive(Debug, Default)]
pub(super) struct SourceValues {
    list: Vec<SourceValue>,
    pub(super) faults: Vec<Diagnostic>,
    pub(super) origins: Vec<ValueOrigin>,
}

/// Returns `true` for the same text, or for one number in two forms, such as 360 and 360.0.
fn is_same(a: &str, b: &str) -> bool {
    let number = |text: &str| text.parse::<f64>().ok();
    a == b || matches!((number(a), number(b)), (Some(a), Some(b)) if a.total_cmp(&b).is_eq())
}

impl SourceValues {
    /// Adds a value; a second, different one for its key is a fault.
    pub(super) fn add(&mut self, key: &str, value: &str, line: u64) {
        let value = value.trim().trim_matches('"');
        match self.find(key) {
            Some(first) if !is_same(&first.value, value) => {
                let message =
                    format!("{key} is {value} here and {} in line {}", first.value, first.line);
                self.faults.push(
                    Diagnostic::whole(message)
                        .with_help("leave only the one that holds")
                        .on_line(line),
                );
            }
            Some(_) => {}
            None => {
                self.list.push(SourceValue { key: key.to_owned(), value: value.to_owned(), line });
            }
        }
    }

    /// Returns a value; keys match in either case.
    pub(super) fn find(&self, key: &str) -> Option<&SourceValue> {
        self.list.iter().find(|one| one.key.eq_ignore_ascii_case(key))
    }

    /// Returns all values whose key begins so.
    pub(super) fn beginning(&self, key: &str) -> Vec<SourceValue> {
        self.list.iter().filter(|one| one.key.starts_with(key)).cloned().collect()
    }

    /// Returns a text, and records what it became.
    pub(super) fn text(&mut self, key: &str, target: &str) -> Option<String> {
        let found = self.find(key)?.clone();
        self.origins.push(ValueOrigin::new(&found, target));
        Some(found.value)
    }

    /// Returns a number, and records what it became.
    pub(super) fn number(&mut self, key: &str, target: &str) -> Option<f64> {
        let found = self.find(key)?.clone();
        let value = found.value.parse::<f64>().ok().filter(|value| value.is_finite());
        if value.is_some() {
            self.origins.push(ValueOrigin::new(&found, target));
        } else {
            let SourceValue { key, value, line } = found;
            let message = format!("{key} = {value:?} is not a number");
            let fault = Diagnostic::whole(message).with_help("write a decimal number");
            self.faults.push(fault.on_line(line));
        }
        value
    }

    /// Returns a number without which there is no machine.
    pub(super) fn needed(&mut self, key: &str, target: &str) -> Option<f64> {
        if self.find(key).is_none() {
            self.missing(key, target);
        }
        self.number(key, target)
    }

    /// Returns three numbers without which there is no machine.
    pub(super) fn vector(&mut self, keys: &[String; 3], target: &str) -> Option<[f64; 3]> {
        let parts = keys.each_ref().map(|key| self.needed(key, target));
        match parts {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        }
    }

    /// Reports a value that is not in the file.
    pub(super) fn missing(&mut self, key: &str, target: &str) {
        let message = format!("{key} is not in the file; {target} is made of it");
        self.faults.push(
            Diagnostic::whole(message).with_help(format!("add the line of {key} to the file")),
        );
    }

    /// Reports a fault at the line of a key.
    pub(super) fn fault(&mut self, key: &str, message: String, help: &str) {
        let line = self.find(key).map_or(0, |found| found.line);
        self.faults.push(Diagnostic::whole(message).with_help(help).on_line(line));
    }
}
