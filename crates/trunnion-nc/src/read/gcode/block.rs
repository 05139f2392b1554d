//! Words of one line.

use super::expression::{ExpressionEnv, ExpressionScan, ExpressionValue};
use super::parameters::ParameterKey;
use crate::read::control::letter_index;
use crate::read::log::{LineTail, ReadRemark};

/// Codes and assignments of one line; more are no program for a machine.
const MOST: usize = 64;

/// A G or M code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct CodeWord {
    /// Upper case.
    pub(super) letter: u8,
    /// Number in tenths: `43.4` is 434.
    pub(super) tenths: u32,
    /// Byte offsets.
    pub(super) at: usize,
    pub(super) end: usize,
}

/// A letter with its value.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockWord {
    pub(super) value: f64,
    pub(super) decimals: u8,
    pub(super) point: bool,
    pub(super) at: usize,
    pub(super) end: usize,
}

/// The words of a line.
#[derive(Debug)]
pub(super) struct GcodeBlock {
    words: [BlockWord; 26],
    present: u32,
    used: u32,
    pub(super) codes: Vec<CodeWord>,
    pub(super) assignments: Vec<(ParameterKey, f64)>,
    /// `@` and `^`: polar coordinates of `LinuxCNC`.
    pub(super) polar: PolarWords,
}

/// Distance and angle of an end in polar coordinates.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PolarWords {
    /// `@`
    pub(super) radius: Option<BlockWord>,
    /// `^` \[degrees\]
    pub(super) angle: Option<BlockWord>,
}

impl PolarWords {
    pub(super) fn is_empty(&self) -> bool {
        self.radius.is_none() && self.angle.is_none()
    }
}

const EMPTY: BlockWord = BlockWord { value: 0.0, decimals: 0, point: false, at: 0, end: 0 };

impl GcodeBlock {
    pub(super) fn new() -> Self {
        Self {
            words: [EMPTY; 26],
            present: 0,
            used: 0,
            codes: Vec::new(),
            assignments: Vec::new(),
            polar: PolarWords::default(),
        }
    }

    fn clear(&mut self) {
        (self.present, self.used) = (0, 0);
        self.codes.clear();
        self.assignments.clear();
        self.polar = PolarWords::default();
    }

    /// Returns the word of a letter, which thereby counts as understood.
    #[inline]
    pub(super) fn take(&mut self, letter: char) -> Option<BlockWord> {
        let word = self.look(letter)?;
        self.used |= bit(letter);
        Some(word)
    }

    /// Returns the word of a letter.
    #[inline]
    pub(super) fn look(&self, letter: char) -> Option<BlockWord> {
        let at = letter_index(letter)?;
        if self.present >> at & 1 == 0 {
            return None;
        }
        self.words.get(at).copied()
    }

    pub(super) fn has_any(&self, letters: &str) -> bool {
        letters.chars().any(|letter| self.present & bit(letter) != 0)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.present == 0 && self.codes.is_empty() && self.polar.is_empty()
    }

    /// Iterates over the words that no code took.
    pub(super) fn left(&self) -> impl Iterator<Item = (char, BlockWord)> + '_ {
        // Most lines have none: the words of the others are counted off, bit by bit.
        let mut left = self.present & !self.used;
        std::iter::from_fn(move || {
            let at = left.trailing_zeros();
            left &= left.wrapping_sub(1);
            let letter = u8::try_from(at).ok()?.checked_add(b'A').filter(u8::is_ascii_uppercase)?;
            self.words.get(usize::try_from(at).ok()?).map(|word| (char::from(letter), *word))
        })
    }

    pub(super) fn none_left(&self) -> bool {
        self.present & !self.used == 0 && self.polar.is_empty()
    }

    /// Reads the words of the tail of a line; the first fault, which ends it, is handed to `fault`.
    pub(super) fn scan(
        &mut self,
        line: LineTail<'_>,
        env: &ExpressionEnv<'_>,
        mut fault: impl FnMut(ReadRemark),
    ) {
        self.clear();
        let mut scan = ExpressionScan::new(line.text, line.from);
        loop {
            match self.next(&mut scan, env) {
                Ok(true) => {}
                Ok(false) => return,
                Err(remark) => {
                    fault(remark);
                    return;
                }
            }
        }
    }

    /// Reads the next word; returns false at the end of the line.
    fn next(
        &mut self,
        scan: &mut ExpressionScan<'_>,
        env: &ExpressionEnv<'_>,
    ) -> Result<bool, ReadRemark> {
        scan.blanks();
        let at = scan.at;
        let Some(byte) = scan.peek() else { return Ok(false) };
        match byte {
            // A comment in brackets stands anywhere; one behind a semicolon ends the line.
            b'(' if !env.fanuc && aborts(scan.rest()) => {
                let help = "look at what it found wrong, or give the values that it tests";
                return Err(ReadRemark::new(at, "the program aborts here", help));
            }
            b'(' => return comment(scan),
            b';' => return Ok(false),
            b'#' => return self.assignment(scan, env),
            b'@' | b'^' if !env.fanuc => return self.polar_word(byte, scan, env),
            // A word is a letter and a value; blanks between them mean nothing.
            _ if !byte.is_ascii_alphabetic() => return Err(stray(byte, scan)),
            _ => scan.at += 1,
        }
        let value = match scan.plain() {
            Some(value) => value,
            None => scan.value(env).map_err(|remark| letter_alone(scan, at, remark))?,
        };
        let letter = byte.to_ascii_uppercase();
        match letter {
            b'G' | b'M' => self.code(letter, value.number, at, scan)?,
            _ => self.word(letter, value, at, scan)?,
        }
        Ok(true)
    }

    fn code(
        &mut self,
        letter: u8,
        value: f64,
        at: usize,
        scan: &ExpressionScan<'_>,
    ) -> Result<(), ReadRemark> {
        let text = || scan.text.get(at..scan.at).unwrap_or_default();
        // Codes have one decimal at most (G43.4), so that tenths identify them as integers.
        let Some(tenths) = tenths(value) else {
            return Err(ReadRemark::new(at, format!("{} is no code", text()), ""));
        };
        if self.codes.len() >= MOST {
            let message = format!("more than {MOST} codes on a line");
            return Err(ReadRemark::new(at, message, "break it up"));
        }
        self.codes.push(CodeWord { letter, tenths, at, end: scan.at });
        Ok(())
    }

    #[inline]
    fn word(
        &mut self,
        letter: u8,
        value: ExpressionValue,
        at: usize,
        scan: &ExpressionScan<'_>,
    ) -> Result<(), ReadRemark> {
        let letter = char::from(letter);
        // All letters but G and M occur once on a line (RS274/NGC).
        if self.present & bit(letter) != 0 {
            let message = format!("second {letter} word on this line");
            return Err(ReadRemark::new(at, message, "keep one of them"));
        }
        self.present |= bit(letter);
        if let Some(word) = letter_index(letter).and_then(|index| self.words.get_mut(index)) {
            let ExpressionValue { number: value, decimals, point } = value;
            *word = BlockWord { value, decimals, point, at, end: scan.at };
        }
        Ok(())
    }

    /// Reads `@10` or `^45`.
    fn polar_word(
        &mut self,
        mark: u8,
        scan: &mut ExpressionScan<'_>,
        env: &ExpressionEnv<'_>,
    ) -> Result<bool, ReadRemark> {
        let at = scan.at;
        scan.at += 1;
        let ExpressionValue { number: value, decimals, point } = scan.value(env)?;
        let place = if mark == b'@' { &mut self.polar.radius } else { &mut self.polar.angle };
        if place.is_some() {
            let message = format!("second {} on this line", char::from(mark));
            return Err(ReadRemark::new(at, message, "keep one of them"));
        }
        *place = Some(BlockWord { value, decimals, point, at, end: scan.at });
        Ok(true)
    }

    /// Reads `#1 = 5`.
    fn assignment(
        &mut self,
        scan: &mut ExpressionScan<'_>,
        env: &ExpressionEnv<'_>,
    ) -> Result<bool, ReadRemark> {
        let key = scan.key(env)?;
        scan.blanks();
        if scan.peek() != Some(b'=') {
            let help = "a parameter that begins a word is set: #1 = 5";
            return Err(ReadRemark::new(scan.at, "= is missing here", help));
        }
        scan.at += 1;
        // Fanuc has expressions without brackets behind the equals sign; LinuxCNC has a value.
        let value = if env.fanuc { scan.sum(env)? } else { scan.value(env)?.number };
        if self.assignments.len() >= MOST {
            let message = format!("more than {MOST} parameters set on a line");
            return Err(ReadRemark::new(scan.at, message, "break it up"));
        }
        // Assignments take effect at the end of the line: expressions on it see the old values.
        self.assignments.push((key, value));
        Ok(true)
    }
}

#[inline]
fn bit(letter: char) -> u32 {
    1_u32.checked_shl((letter as u32).wrapping_sub('A' as u32)).unwrap_or(0)
}

/// Returns true for `(abort, text)`, with which a program of `LinuxCNC` stops itself.
fn aborts(comment: &str) -> bool {
    let words = comment.trim_start_matches('(').trim_start();
    words.get(..6).is_some_and(|word| word.eq_ignore_ascii_case("abort,"))
}

/// Passes a comment.
fn comment(scan: &mut ExpressionScan<'_>) -> Result<bool, ReadRemark> {
    let Some(end) = scan.rest().find(')') else {
        return Err(ReadRemark::new(scan.at, "comment without a closing )", "close it"));
    };
    scan.at += end + 1;
    Ok(true)
}

/// Returns a code number in tenths.
pub(in super::super) fn tenths(value: f64) -> Option<u32> {
    // 43.4 becomes 434.
    let tenths = (value * 10.0).round();
    // Codes come from expressions, too: as exact as a parameter's number.
    let whole = (tenths - value * 10.0).abs() < 1e-4 && (0.0..1e5).contains(&tenths);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
    whole.then_some(tenths as u32)
}

/// Names what stands where a word should begin.
fn stray(byte: u8, scan: &ExpressionScan<'_>) -> ReadRemark {
    let (message, help) = match byte {
        b'[' => ("an expression without a letter", "write the letter of its word before it"),
        b'%' => ("% must stand alone on its line", ""),
        b'/' => ("a slash inside a line", "block delete stands at its beginning"),
        b',' => (
            "a rounding or chamfer of the next corner (,R ,C)",
            "write it as an arc or a line of its own",
        ),
        b'0'..=b'9' | b'.' | b'+' | b'-' => ("number without a letter", ""),
        _ => ("not a G-code word", "is it the right dialect?"),
    };
    ReadRemark::new(scan.at, message, help)
}

/// Returns the fault of a letter without a value; words of macro languages are named.
fn letter_alone(scan: &ExpressionScan<'_>, at: usize, remark: ReadRemark) -> ReadRemark {
    let rest = scan.text.get(at..).unwrap_or_default();
    let end = rest.bytes().take_while(u8::is_ascii_alphabetic).count();
    let word = rest.get(..end).unwrap_or_default().to_ascii_uppercase();
    if ["IF", "GOTO", "WHILE", "DO", "END", "THEN", "POPEN", "DPRNT"].contains(&word.as_str()) {
        let message = format!("{word}: not a macro statement that is understood");
        let help = "IF .. GOTO, IF .. THEN, WHILE .. DO, END and GOTO are, at Fanuc and Haas, on a line of their own";
        return ReadRemark::new(at, message, help);
    }
    // Two letters in a row are a word of another dialect, not an unknown function.
    let next = rest.as_bytes().get(1);
    let word = next.is_some_and(u8::is_ascii_alphabetic) && remark.message.contains("no function");
    if remark.message.contains("a value is missing") || word {
        return ReadRemark::new(at, "letter without a number", "is it the right dialect?");
    }
    remark
}
