//! Subprograms in files of their own.

use super::label::{self, OKeyword, numbered_key};
use super::numbered_line::NumberedLine;
use crate::read::options::{ReadOptions, SubprogramFile};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Lines of a subprogram, from the one with its label to its end.
#[derive(Debug, Clone)]
pub(super) struct SubLines {
    pub(super) lines: Arc<[NumberedLine]>,
    /// Name of its file, if it is not that of the program.
    pub(super) file: Option<Arc<str>>,
}

/// Returns the names of the subprograms that lines of a `LinuxCNC` program call: `o<name> call`, `M98 P100`.
///
/// A name that is computed is not among them.
///
/// # Example
///
/// ```
/// use trunnion_nc::read::subprogram_calls;
///
/// let names = subprogram_calls("G0 X1\no<Hole> call [1]\no5 call\nM98 P0100 L2\n".lines());
/// assert!(names.into_iter().eq(["100", "5", "hole"]));
/// ```
pub fn subprogram_calls<I>(lines: I) -> BTreeSet<String>
where
    I: IntoIterator<Item: AsRef<str>>,
{
    let mut names = BTreeSet::new();
    for line in lines {
        let line = line.as_ref();
        if let Some(word) = label::o_word(line, 0) {
            if word.keyword == OKeyword::Call && word.computed.is_none() {
                names.insert(word.label.into());
            }
        } else if let Some(number) = called_number(line) {
            names.insert(number);
        }
    }
    names
}

/// Returns the number of `M98 P100`.
fn called_number(line: &str) -> Option<String> {
    // Most lines call nothing, and every line of the program passes here.
    if !line.bytes().any(|byte| matches!(byte, b'M' | b'm')) {
        return None;
    }
    let code = line.split(['(', ';']).next()?;
    let bare: String = code.chars().filter(|c| !c.is_whitespace()).collect();
    let upper = bare.to_ascii_uppercase();
    let (_, behind) = upper.split_once("M98")?;
    let (_, number) = behind.split_once('P')?;
    let digits: String = number.chars().take_while(char::is_ascii_digit).collect();
    let number = digits.trim_start_matches('0');
    (!number.is_empty()).then(|| number.to_owned())
}

/// Files of subprograms by the labels under which they are called.
#[derive(Debug, Default)]
pub(super) struct SubFiles {
    files: HashMap<Box<str>, SubprogramFile>,
}

impl SubFiles {
    pub(super) fn new(options: &ReadOptions) -> Self {
        let of = |file: &SubprogramFile| (super::parameters::normal(&file.name), file.clone());
        Self { files: options.subprograms.iter().map(of).collect() }
    }

    /// Returns the subprograms in the file of a label, by keys of their kinds; each file is read once.
    pub(super) fn open(&mut self, label: &str) -> Vec<(Box<str>, SubLines)> {
        let Some(SubprogramFile { name, text }) = self.files.remove(label) else {
            return Vec::new();
        };
        let file: Arc<str> = name.into();
        let mut found = Vec::new();
        let mut open: Option<(Box<str>, OKeyword, Vec<NumberedLine>)> = None;
        for (number, text) in (1_u32..).zip(text.lines()) {
            let word = label::o_word(text, 0);
            if open.is_none()
                && let Some(word) = &word
                && matches!(word.keyword, OKeyword::Sub | OKeyword::Nothing)
            {
                open = Some((word.label.clone(), word.keyword, Vec::new()));
            }
            let Some((label, keyword, lines)) = &mut open else { continue };
            lines.push(NumberedLine { number, text: text.into() });
            let ends = match keyword {
                OKeyword::Sub => word
                    .is_some_and(|word| word.keyword == OKeyword::EndSub && word.label == *label),
                _ => label::ends_subprogram(text),
            };
            if ends && let Some((label, keyword, lines)) = open.take() {
                let key = if keyword == OKeyword::Sub { label } else { numbered_key(&label) };
                found.push((key, SubLines { lines: lines.into(), file: Some(Arc::clone(&file)) }));
            }
        }
        found
    }
}
