//! Loops and jumps of macro statements: the lines that they skip.

use super::label;
use crate::read::log::{LineRemark, ReadRemark};
use crate::read::tape::Tape;
/// A statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MacroWord {
    If,
    Goto,
    While,
    End,
}

/// Statements; Fanuc takes their first two letters as well.
pub(super) const WORDS: [(&str, MacroWord); 7] = [
    ("IF", MacroWord::If),
    ("GOTO", MacroWord::Goto),
    ("WHILE", MacroWord::While),
    ("END", MacroWord::End),
    ("GO", MacroWord::Goto),
    ("WH", MacroWord::While),
    ("EN", MacroWord::End),
];

/// A `WHILE` that runs.
#[derive(Debug)]
pub(super) struct MacroLoop {
    pub(super) number: u32,
    /// Depth of calls, and its line there.
    pub(super) level: usize,
    pub(super) line: usize,
}

/// Target up to which lines of the file are skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MacroSeek {
    /// `N10`.
    Number(u32),
    /// `END 1`.
    End(u32),
}

/// Jumps and loops of macro statements.
#[derive(Debug)]
pub(super) struct MacroFlow {
    pub(super) tape: Tape,
    pub(super) seek: Option<(MacroSeek, u32)>,
    pub(super) loops: Vec<MacroLoop>,
}

impl MacroFlow {
    pub(super) fn new(most: u64) -> Self {
        Self { tape: Tape::new(most), seek: None, loops: Vec::new() }
    }

    /// Returns true if a line of the file is skipped.
    pub(super) fn passes(&mut self, text: &str) -> bool {
        let Some((seek, _)) = self.seek else { return false };
        // Lines that are skipped are not run, but their END closes loops of the main program.
        let end = end_of(text);
        if let Some(number) = end.filter(|number| seek != MacroSeek::End(*number)) {
            // A jump out of a loop leaves it.
            self.loops.retain(|inner| inner.level > 0 || inner.number != number);
        }
        match seek {
            // The line with the number is run, the one with END is not.
            MacroSeek::Number(number) if label::line_number(text) == Some(number) => {
                self.seek = None;
                false
            }
            MacroSeek::End(number) => {
                if end == Some(number) {
                    self.seek = None;
                }
                true
            }
            MacroSeek::Number(_) => true,
        }
    }

    /// Ends the loops of calls deeper than `level`.
    pub(super) fn leave(&mut self, level: usize) {
        // Loops of a subprogram end with it.
        self.loops.retain(|inner| inner.level <= level);
    }

    /// Returns the target that is still missing at the end of the file.
    pub(super) fn open(&self) -> Option<LineRemark> {
        let (seek, line) = self.seek?;
        let remark = match seek {
            MacroSeek::Number(number) => {
                let message = format!("N{number} is not in the file");
                ReadRemark::new(
                    0,
                    message,
                    "lines before the first # are not kept: jump to later ones",
                )
            }
            MacroSeek::End(number) => {
                ReadRemark::new(0, format!("DO {number} has no END {number}"), "end the loop")
            }
        };
        Some(LineRemark { line, remark })
    }
}

/// Finds an output to another device, which moves nothing: `DPRNT[..]`; its byte offset.
pub(super) fn output(text: &str, from: usize) -> Option<usize> {
    let at = label::after_number(text, from);
    let rest = text.get(at..)?;
    let begins = |word: &str| rest.get(..5).is_some_and(|head| head.eq_ignore_ascii_case(word));
    ["DPRNT", "BPRNT", "POPEN", "PCLOS"].into_iter().any(begins).then_some(at)
}

/// Finds a statement: its byte offset, its keyword, and the offset behind it.
pub(super) fn statement(text: &str, from: usize) -> Option<(usize, MacroWord, usize)> {
    // Statements stand behind the line number.
    let at = label::after_number(text, from);
    let rest = text.get(at..)?;
    let letters = rest.bytes().take_while(u8::is_ascii_alphabetic).count();
    let name = rest.get(..letters)?;
    let (_, word) = WORDS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    Some((at, *word, at + letters))
}

/// Returns 1 of `END 1`.
pub(super) fn end_of(text: &str) -> Option<u32> {
    let (_, word, behind) = statement(text, 0)?;
    let rest = text.get(behind..)?.trim_start();
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    if word == MacroWord::End { rest.get(..digits)?.parse().ok() } else { None }
}
