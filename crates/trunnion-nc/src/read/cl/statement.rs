//! Statements of an APT/CL file: lines joined, words with their places.

use crate::types::Diagnostic;
use std::borrow::Cow;

/// Longest statement \[bytes\]: longer ones are no statements, and would fill the memory.
const LONGEST: usize = 1 << 16;

/// Largest coordinate, feed or number of any kind: beyond it is a slip.
pub(super) const LARGEST: f64 = 1e6;

/// Start of a line in the text of its statement.
#[derive(Debug, Clone, Copy)]
struct LineStart {
    at: usize,
    line: u32,
}

/// The text of one statement.
#[derive(Debug, Clone, Copy)]
pub(super) struct Statement<'a> {
    pub(super) text: &'a str,
    starts: &'a [LineStart],
}

/// A word and where it stands in its statement.
#[derive(Debug, Clone, Copy)]
pub(super) struct ClWord<'a> {
    pub(super) text: &'a str,
    pub(super) at: usize,
}

/// Lines on the way to a statement.
#[derive(Debug, Default)]
pub(super) struct JoinedLines {
    text: String,
    starts: Vec<LineStart>,
}

/// Major words whose line is text to its end, whatever it contains.
const TEXT: [&str; 8] =
    ["PARTNO", "PPRINT", "INSERT", "REMARK", "DISPLY", "TITLES", "LETTER", "TPRINT"];

/// Kind of a line.
pub(super) enum ClLine<'a> {
    /// A whole statement, or the end of one.
    Whole(&'a str),
    /// Goes on in the next line.
    Open(&'a str),
    /// Nothing, or a comment.
    Comment,
}

/// Position of a line in its statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LinePosition {
    First,
    /// The line before ended with `$`.
    Continuation,
}

/// Classifies a line. `$` joins the next line, and nothing behind it counts; `$$` begins a comment.
/// `$$->` begins a directive, which is joined as a statement is.
pub(super) fn classify(line: &str, position: LinePosition) -> ClLine<'_> {
    let first = position == LinePosition::First;
    let start = line.trim_start();
    if first && (start.is_empty() || start.starts_with("$$") && !start.starts_with("$$->")) {
        return ClLine::Comment;
    }
    // A text may contain anything; joining it could swallow a location.
    if first && text_word(start) {
        return ClLine::Whole(line);
    }
    let skipped = if first && start.starts_with("$$->") { line.len() - start.len() + 4 } else { 0 };
    match line.get(skipped..).unwrap_or_default().find('$') {
        None => ClLine::Whole(line),
        Some(found) => {
            let (words, mark) = line.split_at(skipped + found);
            if mark.starts_with("$$") { ClLine::Whole(words) } else { ClLine::Open(words) }
        }
    }
}

pub(super) fn text_word(start: &str) -> bool {
    let head = start.get(..6).unwrap_or_default();
    TEXT.iter().any(|word| head.eq_ignore_ascii_case(word))
}

impl JoinedLines {
    /// Returns true while a statement waits for its next line.
    pub(super) fn is_open(&self) -> bool {
        !self.starts.is_empty()
    }

    /// Returns the position of the next line.
    pub(super) fn next_line(&self) -> LinePosition {
        if self.is_open() { LinePosition::Continuation } else { LinePosition::First }
    }

    /// Adds a line; returns false if the statement is too long.
    pub(super) fn add(&mut self, line: u32, text: &str) -> bool {
        // Offsets of the lines lead faults back to their places.
        self.starts.push(LineStart { at: self.text.len(), line });
        self.text.push_str(text);
        self.text.push(' ');
        self.text.len() <= LONGEST
    }

    pub(super) fn clear(&mut self) {
        self.text.clear();
        self.starts.clear();
    }

    pub(super) fn statement(&self) -> Statement<'_> {
        Statement { text: &self.text, starts: &self.starts }
    }
}

/// Runs `with` on a statement of one line.
pub(super) fn single<T>(line: u32, text: &str, with: impl FnOnce(&Statement<'_>) -> T) -> T {
    with(&Statement { text, starts: &[LineStart { at: 0, line }] })
}

impl<'a> Statement<'a> {
    /// Returns the line in which it begins.
    pub(super) fn line(&self) -> u32 {
        self.starts.first().map_or(0, |start| start.line)
    }

    /// Returns the major word in capitals, and the text behind it and its `/`.
    pub(super) fn split(&self) -> (Cow<'a, str>, ClWord<'a>) {
        let head = self.text.len() - self.text.trim_start().len();
        let word = self.text.get(head..).unwrap_or_default();
        let major = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let named = word.starts_with(|c: char| c.is_ascii_alphabetic());
        let end = if named { word.find(|c| !major(c)).unwrap_or(word.len()) } else { 0 };
        let (name, rest) = word.split_at(end);
        let blank = rest.len() - rest.trim_start().len();
        let at = head + end + blank;
        let rest = rest.trim_start();
        let (rest, at) = rest.strip_prefix('/').map_or((rest, at), |rest| (rest, at + 1));
        let name = if name.bytes().any(|byte| byte.is_ascii_lowercase()) {
            Cow::Owned(name.to_ascii_uppercase())
        } else {
            Cow::Borrowed(name)
        };
        (name, ClWord { text: rest, at })
    }

    /// Returns a fault at a word of the statement.
    pub(super) fn fault(&self, at: usize, message: String, help: &str) -> Diagnostic {
        // The last line that begins at or before the offset has the word.
        let found = self.starts.iter().rev().find(|start| start.at <= at);
        let (from, line) = found.map_or((0, 0), |start| (start.at, start.line));
        let before = self.text.get(from..at).unwrap_or_default();
        let column = u32::try_from(before.chars().count() + 1).unwrap_or(u32::MAX);
        Diagnostic { line, column, message, help: help.to_owned() }
    }
}

impl<'a> ClWord<'a> {
    /// Iterates over the words between commas, without blanks around them.
    pub(super) fn items(self) -> impl Iterator<Item = ClWord<'a>> {
        let mut at = self.at;
        self.text.split(',').map(move |item| {
            let blank = item.len() - item.trim_start().len();
            let word = ClWord { text: item.trim(), at: at + blank };
            at += item.len() + 1;
            word
        })
    }

    /// Iterates over the words between commas, slashes and parentheses, without empty ones.
    pub(super) fn parts(self) -> impl Iterator<Item = ClWord<'a>> {
        let mut at = self.at;
        let pieces = self.text.split([',', '/', '(', ')']).map(move |item| {
            let blank = item.len() - item.trim_start().len();
            let word = ClWord { text: item.trim(), at: at + blank };
            at += item.len() + 1;
            word
        });
        pieces.filter(|word| !word.text.is_empty())
    }

    pub(super) fn is(&self, name: &str) -> bool {
        self.text.eq_ignore_ascii_case(name)
    }

    /// Returns the number if it can be a coordinate.
    pub(super) fn number(&self) -> Option<f64> {
        // "nan" and "inf" would pass as numbers; a word that does not begin as one is none.
        let first = self.text.bytes().next()?;
        if first.is_ascii_alphabetic() {
            return None;
        }
        self.text.parse::<f64>().ok().filter(|value| value.abs() <= LARGEST)
    }
}

/// Most numbers that a `GOTO` or a directive has.
pub(super) const MOST: usize = 12;

/// Up to [`MOST`] numbers between commas.
pub(super) struct Numbers {
    values: [f64; MOST],
    count: usize,
}

impl Numbers {
    /// Reads the numbers of a list, or returns the word that is none.
    pub(super) fn of(list: ClWord<'_>) -> Result<Self, ClWord<'_>> {
        let mut numbers = Self { values: [0.0; MOST], count: 0 };
        for item in list.items() {
            match (numbers.values.get_mut(numbers.count), item.number()) {
                (Some(slot), Some(value)) => *slot = value,
                _ => return Err(item),
            }
            numbers.count += 1;
        }
        Ok(numbers)
    }

    pub(super) fn as_slice(&self) -> &[f64] {
        self.values.get(..self.count).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(text: &str) -> (String, String, usize) {
        single(1, text, |statement| {
            let (major, rest) = statement.split();
            (major.into_owned(), rest.text.to_owned(), rest.at)
        })
    }

    #[test]
    fn a_slash_may_be_absent_and_blanks_stand_anywhere() {
        assert_eq!(split(" goto / 1, 2"), ("GOTO".into(), " 1, 2".into(), 7));
        assert_eq!(split("RAPID"), ("RAPID".into(), String::new(), 5));
        assert_eq!(split("PARTNO DEMO"), ("PARTNO".into(), "DEMO".into(), 7));
        assert_eq!(split("TLON,GOFWD/ (").0, "TLON");
        assert_eq!(split("END-OF-PATH").0, "END-OF-PATH");
    }

    #[test]
    fn lines_are_joined_and_comments_are_not() {
        let open = |line| matches!(classify(line, LinePosition::First), ClLine::Open(_));
        assert!(open("GOTO/1,$ 80") && open("$$-> CSYS / 1, $") && !open("$$ why $"));
        assert!(!open("PPRINT/costs 5 $") && !open("GOTO/1,2,3 $$ here"));
        assert!(matches!(
            classify("GOTO/1 $$ here", LinePosition::First),
            ClLine::Whole("GOTO/1 ")
        ));
        assert!(matches!(classify("  ", LinePosition::First), ClLine::Comment));
    }

    #[test]
    fn faults_are_placed_in_the_line_of_the_word() {
        let mut joined = JoinedLines::default();
        assert!(joined.add(3, "GOTO/1,2,") && joined.add(4, "  é,x"));
        let statement = joined.statement();
        let (_, rest) = statement.split();
        let word = rest.items().find(|word| word.text == "x").unwrap();
        let fault = statement.fault(word.at, "why".to_owned(), "");
        assert_eq!((fault.line, fault.column), (4, 5));
    }

    #[test]
    fn numbers_are_written_in_many_ways() {
        let numbers = Numbers::of(ClWord { text: " .5,16., -1E2,+3", at: 0 }).ok().unwrap();
        assert_eq!(numbers.as_slice(), [0.5, 16.0, -100.0, 3.0]);
        for text in ["nan", "1e9", "", "1 2", "inf", "."] {
            assert!(Numbers::of(ClWord { text, at: 0 }).is_err(), "{text}");
        }
    }
}
