//! Codes that the options declare passive: they are kept, and the dialect's reader does not see them.

use super::log::excerpt;
use std::borrow::Cow;

/// Codes in upper case.
#[derive(Debug, Clone, Default)]
pub(super) struct PassiveCodes(Vec<Box<str>>);

/// A line without its passive codes.
#[derive(Debug)]
pub(super) struct ActiveLine<'a> {
    /// Blanks stand for what was kept, so that columns stay.
    pub(super) text: Cow<'a, str>,
    /// Words that were kept, in their order.
    pub(super) kept: Vec<Box<str>>,
}

impl PassiveCodes {
    pub(super) fn new(codes: &[String]) -> Self {
        let code = |code: &String| code.trim().to_ascii_uppercase().into_boxed_str();
        Self(codes.iter().map(code).filter(|code| !code.is_empty()).collect())
    }

    /// Takes the passive codes out of a line.
    pub(super) fn take<'a>(&self, line: &'a str) -> ActiveLine<'a> {
        let mut active = ActiveLine { text: Cow::Borrowed(line), kept: Vec::new() };
        if self.0.is_empty() || !line.is_ascii() {
            return active;
        }
        for code in &self.0 {
            while let Some(at) = find(&active.text, code) {
                let whole = is_block_number(active.text.get(..at).unwrap_or_default());
                let end =
                    if whole { comment(&active.text, at + code.len()) } else { at + code.len() };
                let words = active.text.get(at..end).unwrap_or_default().trim_end();
                active.kept.push(excerpt(words).into());
                active.text.to_mut().replace_range(at..end, &" ".repeat(end - at));
            }
        }
        active
    }
}

/// Returns the place of a code outside of comments, apart from other words.
fn find(line: &str, code: &str) -> Option<usize> {
    let upper = line.to_ascii_uppercase();
    let end = comment(&upper, 0);
    let begins = |at: usize| {
        let before = upper.get(..at).unwrap_or_default();
        !before.ends_with(|c: char| c.is_ascii_alphabetic() || "_.#[<\"".contains(c))
    };
    let ends = |at: usize| {
        let behind = upper.get(at + code.len()..).unwrap_or_default();
        !behind.starts_with(|c: char| c.is_ascii_alphanumeric() || "_.=".contains(c))
    };
    let mut places = upper.match_indices(code).map(|(at, _)| at).take_while(|at| *at < end);
    places.find(|&at| begins(at) && ends(at))
}

/// Returns the place at which a comment begins: `;`, or a parenthesis that follows a blank or begins the line.
fn comment(line: &str, from: usize) -> usize {
    let is_comment = |&(at, found): &(usize, &str)| {
        let before = line.get(..at).unwrap_or_default();
        at >= from && (found == ";" || before.is_empty() || before.ends_with(' '))
    };
    line.match_indices([';', '(']).find(is_comment).map_or(line.len(), |(at, _)| at)
}

/// Returns true for nothing but a block number, `N10` or `10`, and blanks.
fn is_block_number(text: &str) -> bool {
    let text = text.trim();
    text.strip_prefix(['N', 'n']).unwrap_or(text).chars().all(|c| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(code: &str, line: &str) -> (String, Vec<String>) {
        let active = PassiveCodes::new(&[code.to_owned()]).take(line);
        (active.text.into_owned(), active.kept.into_iter().map(String::from).collect())
    }

    #[test]
    fn codes_are_taken_out_and_columns_stay() {
        let cases = [
            ("M400", "N10 M400 P1 Q2", "N10           ", "M400 P1 Q2"),
            ("m400", "G1 X10 M400 F100", "G1 X10      F100", "M400"),
            ("M400", "G1X10M400", "G1X10    ", "M400"),
            ("CYCLE999", "CYCLE999(1,2) ; probe", "              ; probe", "CYCLE999(1,2)"),
            ("CYCL DEF 239", "7 CYCL DEF 239 LOAD", "7                  ", "CYCL DEF 239 LOAD"),
        ];
        for (code, line, rest, kept) in cases {
            assert_eq!(taken(code, line), (rest.to_owned(), vec![kept.to_owned()]), "{line}");
        }
        // Another number, a comment, a parameter, an assignment.
        let others = ["M4001", "G1 X1 (M400)", "X1 ; M400", "XM400", "#<M400>", "M400=5", "M40"];
        for line in others {
            assert_eq!(taken("M400", line), (line.to_owned(), vec![]), "{line}");
        }
    }
}
