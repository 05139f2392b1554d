//! Blocks that calls and jumps skip.

use super::token::Tokens;
use crate::read::log::{LineRemark, ReadRemark};
use crate::read::tape::Tape;
use std::collections::HashMap;

/// A label that is called.
#[derive(Debug)]
pub(super) struct LabelCall {
    /// The line that called.
    pub(super) line: u32,
    /// Repetitions of a section that are left; `None`: a subprogram, which ends at `LBL 0`.
    pub(super) left: Option<u32>,
}

/// Everything about the order of blocks.
#[derive(Debug)]
pub(super) struct KlartextFlow {
    pub(super) tape: Tape,
    /// Label that is looked for, and the line that asked for it.
    pub(super) seek: Option<(Box<str>, u32)>,
    pub(super) calls: Vec<LabelCall>,
    /// Lines of the labels so far.
    pub(super) known: HashMap<Box<str>, u32>,
}

impl KlartextFlow {
    pub(super) fn new(most: u64) -> Self {
        Self { tape: Tape::new(most), seek: None, calls: Vec::new(), known: HashMap::new() }
    }

    /// Records the line of a label.
    pub(super) fn note(&mut self, label: &str, line: u32) {
        // A block that runs again sets the same label at the same line.
        self.known.entry(upper(label)).or_insert(line);
    }

    /// Returns true if a block is skipped on the way to a label.
    pub(super) fn passes(&mut self, label: Option<&str>) -> bool {
        let Some((wanted, _)) = &self.seek else { return false };
        if label.is_some_and(|label| same(label, wanted)) {
            self.seek = None;
        }
        true
    }

    /// Returns the target that is still missing at the end of the file.
    pub(super) fn open(&self) -> Option<LineRemark> {
        let (label, line) = self.seek.as_ref()?;
        let message = format!("LBL {label} is not in the file");
        let help = "labels of other files are not known: put them here";
        Some(LineRemark { line: *line, remark: ReadRemark::new(0, message, help) })
    }
}

pub(super) fn upper(label: &str) -> Box<str> {
    label.to_ascii_uppercase().into()
}

/// Compares labels, which are numbers or quoted names, in any case.
pub(super) fn same(one: &str, other: &str) -> bool {
    one.eq_ignore_ascii_case(other)
}

/// Returns the label that a block sets.
pub(super) fn label_of(code: &str, from: usize) -> Option<&str> {
    let head = code.get(from..from + 3)?;
    if !head.eq_ignore_ascii_case("LBL") {
        return None;
    }
    let mut tokens = Tokens::new(code, from + 3);
    tokens.next_token().map(|token| token.text)
}
