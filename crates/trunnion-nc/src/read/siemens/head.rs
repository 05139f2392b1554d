//! Heads of blocks: `N10`, `LABEL:`, and words that decide which block comes next.

/// Kind of a structure that encloses lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StructureKind {
    If,
    While,
    For,
    Loop,
    Repeat,
}

/// First words of lines that decide which comes next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FlowWord {
    Open(StructureKind),
    Close(StructureKind),
    Else,
    /// `IF .. GOTO`.
    If,
    Jump,
    /// `REPEAT LABEL P=3`.
    Section,
    /// `DEF REAL LENGTH = 5`.
    Define,
}

/// Beginning of a block.
pub(super) struct BlockHead<'a> {
    /// `N10`.
    number: &'a str,
    pub(super) label: &'a str,
    pub(super) word: Option<FlowWord>,
    /// Byte offset behind number and label.
    pub(super) at: usize,
}

impl<'a> BlockHead<'a> {
    #[inline]
    pub(super) fn of(code: &'a str, from: usize) -> Self {
        let (mut number, mut label, mut at) = ("", "", from);
        let rest = code.get(at..).unwrap_or_default();
        let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
        if rest.starts_with(['N', 'n']) && digits(rest.get(1..).unwrap_or_default()) > 0 {
            let length = 1 + digits(rest.get(1..).unwrap_or_default());
            number = rest.get(..length).unwrap_or_default();
            at += length;
            at += blanks(code, at);
        }
        let name = name_at(code, at);
        // Labels have two characters at least, and a colon behind.
        if name.len() > 1 && code.as_bytes().get(at + name.len()) == Some(&b':') {
            label = name;
            at += name.len() + 1;
            at += blanks(code, at);
        }
        let name = if label.is_empty() { name } else { name_at(code, at) };
        let word = if name.len() > 1 { word_of(code, at, name) } else { None };
        Self { number, label, word, at }
    }

    /// Returns true if a later line may lead back here.
    pub(super) fn may_return(&self) -> bool {
        !self.label.is_empty() || matches!(self.word, Some(FlowWord::Open(_)))
    }

    pub(super) fn is(&self, target: &str) -> bool {
        let [label, number] = [self.label, self.number];
        label.eq_ignore_ascii_case(target) || number.eq_ignore_ascii_case(target)
    }
}

/// Returns the number of blanks at a byte offset.
pub(super) fn blanks(code: &str, at: usize) -> usize {
    let rest = code.get(at..).unwrap_or_default();
    rest.len() - rest.trim_start().len()
}

pub(super) fn name_at(code: &str, at: usize) -> &str {
    let rest = code.get(at..).unwrap_or_default();
    let letter = rest.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    let length = rest.bytes().take_while(|b| b.is_ascii_alphanumeric() || *b == b'_').count();
    if letter { rest.get(..length).unwrap_or_default() } else { "" }
}

const WORDS: [(&str, FlowWord); 18] = [
    ("IF", FlowWord::Open(StructureKind::If)),
    ("ELSE", FlowWord::Else),
    ("ENDIF", FlowWord::Close(StructureKind::If)),
    ("WHILE", FlowWord::Open(StructureKind::While)),
    ("ENDWHILE", FlowWord::Close(StructureKind::While)),
    ("FOR", FlowWord::Open(StructureKind::For)),
    ("ENDFOR", FlowWord::Close(StructureKind::For)),
    ("LOOP", FlowWord::Open(StructureKind::Loop)),
    ("ENDLOOP", FlowWord::Close(StructureKind::Loop)),
    ("REPEAT", FlowWord::Open(StructureKind::Repeat)),
    ("REPEATB", FlowWord::Section),
    ("UNTIL", FlowWord::Close(StructureKind::Repeat)),
    ("GOTO", FlowWord::Jump),
    ("GOTOF", FlowWord::Jump),
    ("GOTOB", FlowWord::Jump),
    ("GOTOC", FlowWord::Jump),
    ("GOTOS", FlowWord::Jump),
    ("DEF", FlowWord::Define),
];

fn word_of(code: &str, at: usize, name: &str) -> Option<FlowWord> {
    let (_, word) = WORDS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    // `IF .. GOTOF` jumps by itself and has no ENDIF; REPEAT with a label repeats a section.
    let behind = || code.get(at + name.len()..).unwrap_or_default().trim();
    Some(match word {
        FlowWord::Open(StructureKind::If) if jump_in(code, at).is_some() => FlowWord::If,
        FlowWord::Open(StructureKind::Repeat) if !behind().is_empty() => FlowWord::Section,
        word => *word,
    })
}

/// Returns the byte offset of `GOTO..` in a line.
pub(super) fn jump_in(code: &str, from: usize) -> Option<usize> {
    let upper = code.get(from..)?.to_ascii_uppercase();
    upper.find("GOTO").map(|at| from + at)
}
