//! What is wrong with a text file, and where.

use std::fmt;

/// One fault of a text file. Readers return all they find, not only the first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Line, counted from 1; 0 if the fault concerns the file as a whole.
    pub line: u32,
    /// Column in characters, counted from 1; 0 if the fault concerns the whole line.
    pub column: u32,
    /// What is wrong, with values and units.
    pub message: String,
    /// What to do about it; empty if the message says it all.
    pub help: String,
}

impl Fault {
    /// A fault at a byte offset of `text`.
    pub fn at(text: &str, offset: usize, message: impl Into<String>) -> Self {
        let before = String::from_utf8_lossy(&text.as_bytes()[..offset.min(text.len())]);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |last| last.chars().count()) + 1;
        let narrow = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let (line, column) = (narrow(line), narrow(column));
        Self { line, column, message: message.into(), help: String::new() }
    }

    /// A fault of the file as a whole.
    pub fn whole(message: impl Into<String>) -> Self {
        Self { line: 0, column: 0, message: message.into(), help: String::new() }
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }
}

impl fmt::Display for Fault {
    /// `line:column: message`, then the remedy on a line of its own.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, self.column) {
            (0, _) => write!(f, " {}", self.message)?,
            (line, 0) => write!(f, "{line}: {}", self.message)?,
            (line, column) => write!(f, "{line}:{column}: {}", self.message)?,
        }
        if !self.help.is_empty() {
            write!(f, "\n  help: {}", self.help)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_become_lines_and_columns_of_characters() {
        let text = "eins\nzwö =drei\n";
        let fault = Fault::at(text, text.find('=').unwrap(), "why").with_help("leave it out");
        assert_eq!(fault.to_string(), "2:5: why\n  help: leave it out");
        assert_eq!(Fault::at(text, 999, "end").line, 3);
    }
}
