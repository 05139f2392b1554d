//! Faults and warnings with their places.

use crate::types::Diagnostic;

/// Something about a line: byte offset, what, what to do.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ReadRemark {
    pub(super) at: usize,
    pub(super) message: String,
    pub(super) help: String,
}

impl ReadRemark {
    pub(super) fn new(at: usize, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { at, message: message.into(), help: help.into() }
    }

    /// Replaces the message.
    pub(super) fn with(self, message: String) -> Self {
        Self { message, ..self }
    }
}

/// A remark about another line than the one being read.
#[derive(Debug)]
pub(super) struct LineRemark {
    /// Line, counted from 1.
    pub(super) line: u32,
    pub(super) remark: ReadRemark,
}

/// A line of a program.
#[derive(Debug, Clone, Copy)]
pub(super) struct FileLine<'a> {
    /// Number of the line, counted from 1.
    pub(super) number: u32,
    pub(super) text: &'a str,
}

/// A line and the byte offset from which it is to be read.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineTail<'a> {
    /// The whole line, so that columns in messages count from its start.
    pub(super) text: &'a str,
    pub(super) from: usize,
}

/// Warnings that are kept; a file with more has one kind of trouble many times.
const MOST_WARNINGS: usize = 100;

/// Most characters of a line in a message.
const EXCERPT: usize = 40;

/// Defects and warnings so far, and the line being read.
#[derive(Debug)]
pub(super) struct ReadLog {
    pub(super) line: u32,
    pub(super) faults: Vec<Diagnostic>,
    pub(super) warnings: Vec<Diagnostic>,
    /// File and line of a subprogram in another file, while one runs.
    pub(super) within: Option<Box<str>>,
    most: usize,
}

impl ReadLog {
    pub(super) fn new(most: usize) -> Self {
        // At least one fault is kept: with none, a faulty file would pass as a good one.
        Self { line: 0, faults: Vec::new(), warnings: Vec::new(), within: None, most: most.max(1) }
    }

    /// Returns true if no further fault is wanted.
    pub(super) fn is_full(&self) -> bool {
        self.faults.len() >= self.most
    }

    pub(super) fn fault(&mut self, text: &str, remark: ReadRemark) {
        if !self.is_full() {
            self.faults.push(self.placed(text, remark));
        }
    }

    /// Adds a warning; a repeated message is reported once.
    pub(super) fn warn(&mut self, text: &str, remark: ReadRemark) {
        // Post-processors repeat an unusual word in every block.
        let known = self.warnings.iter().any(|warning| warning.message == remark.message);
        if !known && self.warnings.len() < MOST_WARNINGS {
            self.warnings.push(self.placed(text, remark));
        }
    }

    fn placed(&self, text: &str, remark: ReadRemark) -> Diagnostic {
        let ReadRemark { at, message, help } = remark;
        let (line, column) = (self.line, column(text, at));
        match &self.within {
            None => Diagnostic { line, column, message, help },
            Some(within) => {
                let message = format!("in {within}, column {column}: {message}");
                Diagnostic { line, column: 0, message, help }
            }
        }
    }

    /// Adds a fault of the file as a whole.
    pub(super) fn whole(&mut self, message: &str, help: &str) {
        if !self.is_full() {
            self.faults.push(Diagnostic::whole(message).with_help(help));
        }
    }
}

/// Returns the column of a byte offset in characters, counted from 1.
pub(super) fn column(text: &str, at: usize) -> u32 {
    let before = text.as_bytes().get(..at.min(text.len())).unwrap_or_default();
    // Continuation bytes begin no character.
    let characters = before.iter().filter(|byte| **byte & 0xC0 != 0x80).count();
    u32::try_from(characters + 1).unwrap_or(u32::MAX)
}

/// Returns the beginning of a text, for a message.
pub(super) fn excerpt(text: &str) -> String {
    let text = text.trim();
    let mut short: String = text.chars().take(EXCERPT).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}
