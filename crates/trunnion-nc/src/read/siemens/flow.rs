//! Lines that jumps and loops skip.

use super::head::{BlockHead, FlowWord, StructureKind};
use crate::read::log::{LineRemark, ReadRemark};
use crate::read::tape::Tape;

/// A loop that runs.
#[derive(Debug)]
pub(super) struct SiemensLoop {
    pub(super) kind: StructureKind,
    /// Its first line.
    pub(super) line: u32,
    /// Last value of the variable of a `FOR`.
    pub(super) last: f64,
}

/// Target up to which lines are skipped.
#[derive(Debug)]
pub(super) enum SiemensSeek {
    /// A label or block number, upper case.
    Label(Box<str>),
    /// The end of what a line began, or its `ELSE`.
    End { kind: StructureKind, or_else: bool },
}

/// Everything about the order of lines.
#[derive(Debug)]
pub(super) struct SiemensFlow {
    pub(super) tape: Tape,
    pub(super) seek: Option<SiemensSeek>,
    /// Structures opened and not yet closed among the skipped lines.
    pub(super) depth: u32,
    /// Line that began to skip.
    pub(super) asked: u32,
    pub(super) loops: Vec<SiemensLoop>,
    /// Lines with `REPEAT LABEL`, and how often they still jump.
    pub(super) sections: Vec<(u32, u32)>,
    /// Labels at whose blocks repeated sections end, and the lines of their `REPEAT`.
    pub(super) returns: Vec<(Box<str>, u32)>,
}

impl SiemensFlow {
    pub(super) fn new(most: u64) -> Self {
        Self {
            tape: Tape::new(most),
            seek: None,
            depth: 0,
            asked: 0,
            loops: Vec::new(),
            sections: Vec::new(),
            returns: Vec::new(),
        }
    }

    pub(super) fn seek(&mut self, what: SiemensSeek, line: u32) {
        (self.seek, self.depth, self.asked) = (Some(what), 0, line);
    }

    /// Returns true if a line is skipped.
    pub(super) fn passes(&mut self, head: &BlockHead<'_>) -> bool {
        let Some(seek) = &self.seek else { return false };
        match (seek, head.word) {
            (SiemensSeek::Label(label), _) if head.is(label) => {
                self.seek = None;
                return false;
            }
            // On the way to a label structures are counted: an END without its beginning closes a
            // loop that the jump has left.
            (SiemensSeek::Label(_), Some(FlowWord::Open(_))) => self.depth += 1,
            (SiemensSeek::Label(_), Some(FlowWord::Close(kind))) => {
                // A jump out of a loop leaves it.
                match self.depth.checked_sub(1) {
                    Some(depth) => self.depth = depth,
                    None if kind != StructureKind::If => _ = self.loops.pop(),
                    None => {}
                }
            }
            // Structures of the same kind inside have ends of their own.
            (SiemensSeek::End { kind, .. }, Some(FlowWord::Open(other))) if *kind == other => {
                self.depth += 1;
            }
            (SiemensSeek::End { kind, .. }, Some(FlowWord::Close(other))) if *kind == other => {
                match self.depth.checked_sub(1) {
                    Some(depth) => self.depth = depth,
                    None => self.seek = None,
                }
            }
            (SiemensSeek::End { or_else: true, .. }, Some(FlowWord::Else)) if self.depth == 0 => {
                self.seek = None;
            }
            _ => {}
        }
        true
    }

    /// Goes back to the `REPEAT` of a section that ends with a block.
    pub(super) fn end_section(&mut self, label: &str) {
        let last = self.returns.last();
        if let Some((_, line)) = last.filter(|(end, _)| end.eq_ignore_ascii_case(label)) {
            let line = *line;
            self.tape.go_to(line);
        }
    }

    /// Returns the target that is still missing at the end of the file.
    pub(super) fn open(&self) -> Option<LineRemark> {
        let remark = match self.seek.as_ref()? {
            SiemensSeek::Label(label) => {
                let message = format!("{label} does not stand behind this jump");
                ReadRemark::new(0, message, "GOTOB jumps back; labels of other files are not known")
            }
            SiemensSeek::End { kind, .. } => {
                let word = format!("{kind:?}").to_uppercase();
                ReadRemark::new(
                    0,
                    format!("{word} has no end"),
                    "end it: ENDIF, ENDWHILE, ENDFOR, ENDLOOP",
                )
            }
        };
        Some(LineRemark { line: self.asked, remark })
    }
}
