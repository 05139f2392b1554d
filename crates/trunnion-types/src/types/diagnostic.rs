//! Diagnostics of text files: the place, the defect, the remedy.

use super::error_list::ErrorList;
use std::fmt;

/// All defects that a reader found in a text file.
pub type Diagnostics = ErrorList<Diagnostic>;

/// One defect of a text file, with its place. Readers return all they find, as [`Diagnostics`].
///
/// # Example
///
/// ```
/// use trunnion_types::types::Diagnostic;
///
/// let text = "feed = 500\nspeed = fast\n";
/// let wrong = Diagnostic::at(text, 19, "`fast` is no number").with_help("give rpm");
/// assert_eq!(wrong.to_string(), "2:9: `fast` is no number\n  help: give rpm");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Line, counted from 1; 0 if the defect concerns the file as a whole.
    pub line: u32,
    /// Column in characters, counted from 1; 0 if the defect concerns the whole line.
    pub column: u32,
    /// Description of the defect, with values and units.
    pub message: String,
    /// Remedy; empty if the message suffices.
    pub help: String,
}

impl Diagnostic {
    /// Creates a diagnostic at a byte offset of `text`.
    pub fn at(text: &str, offset: usize, message: impl Into<String>) -> Self {
        // Bytes are cut instead of the text: slicing a string inside a character would panic.
        let before = String::from_utf8_lossy(&text.as_bytes()[..offset.min(text.len())]);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |last| last.chars().count()) + 1;
        let narrow = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let (line, column) = (narrow(line), narrow(column));
        Self { line, column, message: message.into(), help: String::new() }
    }

    /// Creates a diagnostic of the file as a whole.
    pub fn whole(message: impl Into<String>) -> Self {
        Self { line: 0, column: 0, message: message.into(), help: String::new() }
    }

    /// Sets the line, if the diagnostic has none yet.
    #[must_use]
    pub fn on_line(mut self, line: u64) -> Self {
        if self.line == 0 {
            self.line = u32::try_from(line).unwrap_or(u32::MAX);
        }
        self
    }

    /// Adds the remedy.
    #[must_use]
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }
}

impl fmt::Display for Diagnostic {
    /// Writes `line:column: message`, then the remedy on a line of its own.
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
        let diagnostic =
            Diagnostic::at(text, text.find('=').unwrap(), "why").with_help("leave it out");
        assert_eq!(diagnostic.to_string(), "2:5: why\n  help: leave it out");
        assert_eq!(Diagnostic::at(text, 999, "end").line, 3);
    }
}
