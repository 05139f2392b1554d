//! O-words: `o<name> sub`, `O100 while [..]`, `O1000`.

/// Contents of an O-word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OKeyword {
    Sub,
    EndSub,
    Call,
    Return,
    While,
    EndWhile,
    Do,
    If,
    ElseIf,
    Else,
    EndIf,
    Repeat,
    EndRepeat,
    Break,
    Continue,
    /// A program number: nothing behind the label.
    Nothing,
    /// Something else.
    Unknown,
}

const KEYWORDS: [(&str, OKeyword); 15] = [
    ("sub", OKeyword::Sub),
    ("endsub", OKeyword::EndSub),
    ("call", OKeyword::Call),
    ("return", OKeyword::Return),
    ("while", OKeyword::While),
    ("endwhile", OKeyword::EndWhile),
    ("do", OKeyword::Do),
    ("if", OKeyword::If),
    ("elseif", OKeyword::ElseIf),
    ("else", OKeyword::Else),
    ("endif", OKeyword::EndIf),
    ("repeat", OKeyword::Repeat),
    ("endrepeat", OKeyword::EndRepeat),
    ("break", OKeyword::Break),
    ("continue", OKeyword::Continue),
];

/// An O-word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OWord {
    /// Lower case; numbers without zeros before them. Empty: it is computed.
    pub(super) label: Box<str>,
    /// Byte offset of the expression that computes the label: `o#<name> call`, `O[#1 * 10] call`.
    pub(super) computed: Option<usize>,
    pub(super) keyword: OKeyword,
    /// Byte offset of the O.
    pub(super) at: usize,
    /// Byte offset behind the keyword.
    pub(super) rest: usize,
}

/// Returns the byte offset behind blanks and a line number.
#[inline]
pub(super) fn after_number(text: &str, from: usize) -> usize {
    let bytes = text.as_bytes();
    let pass = |mut at: usize, which: fn(&u8) -> bool| {
        while bytes.get(at).is_some_and(which) {
            at += 1;
        }
        at
    };
    let blank = |byte: &u8| matches!(byte, b' ' | b'\t' | b'\r');
    let start = pass(from, blank);
    // N without digits is no line number but the beginning of a word.
    if !matches!(bytes.get(start), Some(b'N' | b'n')) {
        return start;
    }
    let digits = pass(start + 1, blank);
    let end = pass(digits, u8::is_ascii_digit);
    if end == digits { start } else { pass(end, blank) }
}

/// Returns the O-word that a line begins with.
pub(super) fn o_word(text: &str, from: usize) -> Option<OWord> {
    let at = after_number(text, from);
    if !matches!(text.as_bytes().get(at), Some(b'o' | b'O' | b':')) {
        return None;
    }
    let rest = text.get(at + 1..)?;
    // Blanks may stand between the O, its label and its keyword.
    let skipped = rest.len() - rest.trim_start().len();
    let rest = rest.trim_start();
    let start = at + 1 + skipped;
    if let Some(length) = computed_length(rest) {
        let (keyword, rest) = keyword(text, start + length);
        return Some(OWord { label: "".into(), computed: Some(start), keyword, at, rest });
    }
    let (label, length): (Box<str>, usize) = if let Some(name) = rest.strip_prefix('<') {
        let end = name.find('>')?;
        (super::parameters::normal(name.get(..end)?), end + 2)
    } else {
        let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
        let number = rest.get(..digits)?;
        if digits == 0 {
            return None;
        }
        // O0001 and O1 are the same program.
        let bare = number.trim_start_matches('0');
        (if bare.is_empty() { "0" } else { bare }.into(), digits)
    };
    let (keyword, rest) = keyword(text, start + length);
    Some(OWord { label, computed: None, keyword, at, rest })
}

/// Returns the length of `#1`, `##1`, `#<name>` or `[expression]`, without evaluating it.
fn computed_length(text: &str) -> Option<usize> {
    let marks = text.bytes().take_while(|byte| *byte == b'#').count();
    let rest = text.get(marks..)?;
    let length = match rest.bytes().next()? {
        b'[' => closing_bracket(rest)?,
        b'<' if marks > 0 => rest.find('>')? + 1,
        _ if marks > 0 => rest.bytes().take_while(u8::is_ascii_digit).count(),
        _ => return None,
    };
    Some(marks + length)
}

/// Returns the length of a text up to the bracket that closes its first one.
fn closing_bracket(text: &str) -> Option<usize> {
    let mut depth = 0_u32;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'[' => depth += 1,
            b']' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return Some(at + 1);
        }
    }
    None
}

fn keyword(text: &str, from: usize) -> (OKeyword, usize) {
    let rest = text.get(from..).unwrap_or_default();
    let blanks = rest.len() - rest.trim_start().len();
    let rest = rest.trim_start();
    // A label alone is a program number, as Fanuc and Haas write it.
    if rest.is_empty() || rest.starts_with(['(', ';']) {
        return (OKeyword::Nothing, from + blanks);
    }
    // Blanks mean nothing inside of a keyword either: `end sub`.
    let is_of_word = |byte: &u8| byte.is_ascii_alphabetic() || matches!(byte, b' ' | b'\t');
    let length = rest.bytes().take_while(is_of_word).count();
    let words = rest.get(..length).unwrap_or_default().trim_end();
    let word: String = words.split_whitespace().collect();
    let found = KEYWORDS.iter().find(|(name, _)| name.eq_ignore_ascii_case(&word));
    (found.map_or(OKeyword::Unknown, |(_, keyword)| *keyword), from + blanks + words.len())
}

/// Returns 10 of a line that begins `N10`.
pub(super) fn line_number(text: &str) -> Option<u32> {
    let rest = text.trim_start().strip_prefix(['N', 'n'])?.trim_start();
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    rest.get(..digits)?.parse().ok()
}

/// Returns true if a line has `M99`.
pub(super) fn ends_subprogram(text: &str) -> bool {
    let mut code = String::new();
    let mut comment = false;
    for c in text.chars() {
        match c {
            '(' => comment = true,
            ')' => comment = false,
            ';' if !comment => break,
            c if !comment && !c.is_whitespace() => code.push(c.to_ascii_uppercase()),
            _ => {}
        }
    }
    // M990 and M99.1 are other codes.
    let behind = code.split("M99").nth(1);
    behind.is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit() || c == '.'))
}

/// Returns the key of a subprogram `O1000`.
pub(super) fn numbered_key(label: &str) -> Box<str> {
    // No O-word label has a blank, so the two kinds cannot collide.
    format!("M98 {label}").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn o_words_are_told_from_words() {
        let word = |text: &str| o_word(text, 0).map(|word| (word.label.to_string(), word.keyword));
        let is = |label: &str, keyword| Some((label.to_owned(), keyword));
        assert_eq!(word(" o<Helix ac>sub"), is("helixac", OKeyword::Sub));
        assert_eq!(word("N10 O0100 WHILE [#1 lt 2]"), is("100", OKeyword::While));
        assert_eq!(word("O0001 (DEMO)"), is("1", OKeyword::Nothing));
        assert_eq!(word("O1 G0 X1"), is("1", OKeyword::Unknown));
        assert_eq!(word(":0001"), is("1", OKeyword::Nothing));
        assert_eq!(word("o100 end sub (of the first)"), is("100", OKeyword::EndSub));
        assert_eq!(word("O[#2 * [1 + 9]] call [1]"), is("", OKeyword::Call));
        assert_eq!(word("o#<sub> call"), is("", OKeyword::Call));
        assert_eq!(word("o##1call"), is("", OKeyword::Call));
        assert_eq!(word("G0 X1"), None);
        assert_eq!(word("N5 G0 X1"), None);
        assert!(ends_subprogram("N5 M99 (back)") && ends_subprogram("g0 x1 m99"));
        assert!(!ends_subprogram("(M99)") && !ends_subprogram("M998"));
    }
}
