//! Codes that the configuration of the control maps to subprograms: `REMAP`.

use super::block::{CodeWord, GcodeBlock};
use super::flow::{CallFrame, CallSite, FrameKind, SubCall, SubKind};
use super::numbered_line::NumberedLine;
use super::reader::GcodeReader;
use crate::read::log::{FileLine, ReadRemark};
use crate::read::options::CodeRemap;
use crate::read::state::ReaderState;

/// A remapped code on a line.
pub(super) struct RemappedCode<'a> {
    pub(super) text: &'a str,
    pub(super) code: CodeWord,
    /// Place of its remap among those of the reader.
    pub(super) remap: usize,
}

impl GcodeReader {
    /// Returns the place of the remap of a code.
    pub(super) fn remap_of(&self, code: CodeWord) -> Option<usize> {
        self.remaps.iter().position(|remap| names(remap, code))
    }

    /// Calls the subprogram of a remapped code.
    pub(super) fn remapped(
        &mut self,
        state: &ReaderState,
        block: &mut GcodeBlock,
        line: &RemappedCode<'_>,
    ) -> Result<(), ReadRemark> {
        let RemappedCode { text, code, remap } = *line;
        let remaps = std::sync::Arc::clone(&self.remaps);
        let Some(remap) = remaps.get(remap) else { return Ok(()) };
        let what = text.get(code.at..code.end).unwrap_or_default();
        let Some(name) = &remap.subprogram else {
            let message = format!("{what} is remapped to Python, which is not run");
            let help = "declare it passive if it moves nothing";
            return Err(ReadRemark::new(code.at, message, help));
        };
        // The end of the program is the only code that is certain to come behind it.
        let ends = |other: &CodeWord| other.letter == b'M' && matches!(other.tenths, 20 | 300);
        let others = block.codes.iter().filter(|other| other.at != code.at);
        if let Some(other) = others.clone().find(|other| !ends(other)) {
            let message = format!("{what}, which is remapped, beside another code");
            return Err(ReadRemark::new(other.at, message, "put it on a line of its own"));
        }
        let ended = others.count() > 0;
        let (arguments, names) = arguments(remap, block, code.at)?;
        let number = state.log.line;
        if ended {
            // Lines that run when the subprogram has returned.
            self.flow.frames.push(CallFrame {
                lines: [NumberedLine { number, text: "M2".into() }].into(),
                next: 0,
                loops: Vec::new(),
                of: FrameKind::File,
                file: None,
            });
        }
        let label = super::parameters::normal(name);
        let (kind, arguments) = (SubKind::Named, Some(arguments));
        let call = SubCall { kind, label, arguments, names, times: 1 };
        self.run_sub(call, CallSite { line: FileLine { number, text }, at: code.at })
    }
}

/// Returns true if a remap is that of a code.
fn names(remap: &CodeRemap, code: CodeWord) -> bool {
    let mut letters = remap.code.chars();
    if letters.next() != Some(char::from(code.letter)) {
        return false;
    }
    let tenths = letters.as_str().parse::<f64>().map_or(-1.0, |number| (10.0 * number).round());
    (tenths - f64::from(code.tenths)).abs() < 0.5
}

/// Arguments by position, and by name.
type Arguments = (Vec<f64>, Vec<super::flow::NamedArgument>);

/// Takes the words of a remapped code from its line.
fn arguments(
    remap: &CodeRemap,
    block: &mut GcodeBlock,
    at: usize,
) -> Result<Arguments, ReadRemark> {
    let by_position = remap.words.contains('@');
    let (mut values, mut names) = (Vec::new(), Vec::new());
    for letter in remap.words.chars().filter(char::is_ascii_alphabetic) {
        match block.take(letter.to_ascii_uppercase()) {
            Some(word) if by_position => values.push(word.value),
            Some(word) => {
                names.push((letter.to_ascii_lowercase().to_string().into(), word.value));
            }
            None if letter.is_ascii_uppercase() => {
                let message = format!("{} without {letter}, which its remap needs", remap.code);
                return Err(ReadRemark::new(at, message, "write the word"));
            }
            None => {}
        }
    }
    Ok((values, names))
}
