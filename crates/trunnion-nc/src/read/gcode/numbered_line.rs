//! A line of a program that is kept.

use crate::read::log::FileLine;

/// A line of the file that is kept.
#[derive(Debug, Clone)]
pub(super) struct NumberedLine {
    /// Number of the line, counted from 1.
    pub(super) number: u32,
    pub(super) text: Box<str>,
}

impl NumberedLine {
    pub(super) fn new(line: FileLine<'_>) -> Self {
        Self { number: line.number, text: line.text.into() }
    }

    pub(super) fn as_line(&self) -> FileLine<'_> {
        FileLine { number: self.number, text: &self.text }
    }
}
