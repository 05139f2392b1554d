//! Order of lines: subprograms, loops, conditions.

use super::label;
use super::label::{OKeyword, OWord};
use crate::read::log::ReadRemark;
use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

/// A line of the file and its number.
pub(super) type NumberedLine = (u32, Box<str>);

/// Calls in calls, loops in loops.
const DEEPEST: usize = 100;

/// A loop that runs.
#[derive(Debug)]
pub(super) struct OpenLoop {
    pub(super) label: Box<str>,
    pub(super) kind: LoopKind,
    /// Line it begins at.
    pub(super) start: usize,
}

/// Kind of loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum LoopKind {
    While,
    Do,
    /// Rounds still to run.
    Repeat(f64),
}

/// Lines that are run out of turn.
#[derive(Debug)]
pub(super) struct CallFrame {
    pub(super) lines: Arc<[NumberedLine]>,
    pub(super) next: usize,
    pub(super) loops: Vec<OpenLoop>,
    pub(super) of: FrameKind,
}

/// Kind of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrameKind {
    /// A loop or condition of the file.
    File,
    /// `o<name> sub`.
    Sub,
    /// `O1000 .. M99`, to be run so often again; with parameters of its own (`G65`).
    Numbered { again: u32, scoped: bool },
}

/// Lines being collected.
#[derive(Debug)]
struct LineCapture {
    label: Box<str>,
    keyword: OKeyword,
    lines: Vec<NumberedLine>,
}

/// A subprogram that is called before the file has shown it.
#[derive(Debug)]
struct AwaitedSub {
    label: Box<str>,
    numbered: bool,
    call: SubCall,
    /// Line of the call, and where in it the call stands.
    line: NumberedLine,
    at: usize,
    /// Where it begins in the lines ahead.
    start: Option<usize>,
}

/// A call.
#[derive(Debug, Clone)]
pub(super) struct SubCall {
    /// Parameters of its own begin with these; `None`: it has those of its caller.
    pub(super) arguments: Option<Vec<f64>>,
    pub(super) times: u32,
}

/// Everything about the order of lines.
#[derive(Debug, Default)]
pub(super) struct GcodeFlow {
    subs: HashMap<Box<str>, Arc<[NumberedLine]>>,
    pub(super) frames: Vec<CallFrame>,
    capture: Option<LineCapture>,
    /// Lines read ahead of their turn.
    ahead: VecDeque<NumberedLine>,
    wanted: Option<AwaitedSub>,
}

/// Result of collecting a line of the file.
pub(super) enum LineCollection {
    No,
    Yes,
    /// And a call could be made.
    Called(CallOutcome),
}

/// Outcome of a call.
pub(super) enum CallOutcome {
    /// It runs now, with these arguments if it has its own parameters.
    Runs(Option<Vec<f64>>),
    /// The file has to be read on to find it.
    Later,
}

impl GcodeFlow {
    /// There are lines to run before the file's next.
    pub(super) fn is_busy(&self) -> bool {
        self.wanted.is_none() && !(self.frames.is_empty() && self.ahead.is_empty())
    }

    /// The next line that was read ahead.
    pub(super) fn next_ahead(&mut self) -> Option<NumberedLine> {
        self.ahead.pop_front()
    }

    /// Takes a line of the file if it is being collected or searched; what it set off.
    pub(super) fn collect(&mut self, line: u32, text: &str) -> LineCollection {
        if self.wanted.is_some() {
            self.ahead.push_back((line, text.into()));
            return match self.look(self.ahead.len() - 1) {
                Some(called) => LineCollection::Called(called),
                None => LineCollection::Yes,
            };
        }
        let Some(capture) = self.capture.as_mut() else { return LineCollection::No };
        capture.lines.push((line, text.into()));
        let ends = label::o_word(text, 0).is_some_and(|word| {
            word.label == capture.label && word.keyword == closer(capture.keyword)
        });
        if ends && let Some(LineCapture { label, keyword, lines }) = self.capture.take() {
            if keyword == OKeyword::Sub {
                self.subs.insert(label, lines.into());
            } else {
                let lines = lines.into();
                self.frames.push(CallFrame {
                    lines,
                    next: 0,
                    loops: Vec::new(),
                    of: FrameKind::File,
                });
            }
        }
        LineCollection::Yes
    }

    /// Begins to collect lines.
    pub(super) fn begin(&mut self, word: &OWord, line: u32, text: &str) {
        let (label, keyword) = (word.label.clone(), word.keyword);
        self.capture = Some(LineCapture { label, keyword, lines: vec![(line, text.into())] });
    }

    /// Calls a subprogram.
    pub(super) fn call(
        &mut self,
        (label, numbered): (&str, bool),
        call: SubCall,
        (line, text, at): (u32, &str, usize),
    ) -> Result<CallOutcome, ReadRemark> {
        if self.frames.len() >= DEEPEST {
            let message = format!("more than {DEEPEST} calls in each other");
            return Err(ReadRemark::new(at, message, "does the subprogram call itself?"));
        }
        // Both kinds of subprograms may have one label.
        let key = if numbered { format!("M98 {label}") } else { label.to_owned() };
        if let Some(lines) = self.subs.get(key.as_str()) {
            return Ok(self.enter(Arc::clone(lines), numbered, call));
        }
        let line = (line, text.into());
        self.wanted =
            Some(AwaitedSub { label: label.into(), numbered, call, line, at, start: None });
        for at in 0..self.ahead.len() {
            if let Some(called) = self.look(at) {
                return Ok(called);
            }
        }
        Ok(CallOutcome::Later)
    }

    fn enter(&mut self, lines: Arc<[NumberedLine]>, numbered: bool, call: SubCall) -> CallOutcome {
        let of = if numbered {
            let scoped = call.arguments.is_some();
            FrameKind::Numbered { again: call.times.saturating_sub(1), scoped }
        } else {
            FrameKind::Sub
        };
        self.frames.push(CallFrame { lines, next: 1, loops: Vec::new(), of });
        CallOutcome::Runs(call.arguments)
    }

    /// Looks whether a line ahead begins or ends the subprogram that is wanted.
    fn look(&mut self, at: usize) -> Option<CallOutcome> {
        let wanted = self.wanted.as_mut()?;
        let (_, text) = self.ahead.get(at)?;
        let word = label::o_word(text, 0);
        let of_label = word.filter(|word| word.label == wanted.label).map(|word| word.keyword);
        let Some(start) = wanted.start else {
            let begins = if wanted.numbered { OKeyword::Nothing } else { OKeyword::Sub };
            if of_label == Some(begins) {
                wanted.start = Some(at);
            }
            return None;
        };
        let ends = if wanted.numbered {
            label::ends_subprogram(text)
        } else {
            of_label == Some(OKeyword::EndSub)
        };
        if !ends {
            return None;
        }
        let lines: Arc<[NumberedLine]> = self.ahead.range(start..=at).cloned().collect();
        let AwaitedSub { label, numbered, call, .. } = self.wanted.take()?;
        let key = if numbered { format!("M98 {label}").into() } else { label };
        self.subs.insert(key, Arc::clone(&lines));
        Some(self.enter(lines, numbered, call))
    }

    /// What is still open when the file is over, and the line that opened it.
    pub(super) fn open(&self) -> Option<(&NumberedLine, ReadRemark)> {
        if let Some(AwaitedSub { label, line, at, .. }) = &self.wanted {
            let message = format!("subprogram {label} is not in the file");
            return Some((line, ReadRemark::new(*at, message, "append its lines to the program")));
        }
        let capture = self.capture.as_ref()?;
        let message = format!("what o<{}> begins here has no end", capture.label);
        let remark = ReadRemark::new(0, message, "end it: endsub, endwhile, endif, endrepeat");
        Some((capture.lines.first()?, remark))
    }

    /// Only subprograms were read.
    pub(super) fn has_subs(&self) -> bool {
        !self.subs.is_empty()
    }
}

impl CallFrame {
    /// Its parameters are its own.
    pub(super) fn is_scoped(&self) -> bool {
        matches!(self.of, FrameKind::Sub | FrameKind::Numbered { scoped: true, .. })
    }

    /// The line of a label and one of some keywords, from a line on.
    pub(super) fn find(&self, label: &str, keywords: &[OKeyword], from: usize) -> Option<usize> {
        let is = |line: &NumberedLine| {
            label::o_word(&line.1, 0)
                .is_some_and(|word| *word.label == *label && keywords.contains(&word.keyword))
        };
        self.lines.iter().skip(from).position(is).map(|at| at + from)
    }

    /// The innermost loop is the one of this label and of a kind.
    pub(super) fn in_loop(&self, label: &str, is: fn(LoopKind) -> bool) -> bool {
        self.loops.last().is_some_and(|last| *last.label == *label && is(last.kind))
    }

    /// Leaves all loops from the one of a label on; that loop.
    pub(super) fn leave(&mut self, label: &str) -> Option<OpenLoop> {
        let at = self.loops.iter().rposition(|inner| *inner.label == *label)?;
        self.loops.truncate(at + 1);
        self.loops.pop()
    }
}

/// What ends what a keyword begins.
pub(super) fn closer(keyword: OKeyword) -> OKeyword {
    match keyword {
        OKeyword::Sub => OKeyword::EndSub,
        OKeyword::Do => OKeyword::While,
        OKeyword::If => OKeyword::EndIf,
        OKeyword::Repeat => OKeyword::EndRepeat,
        _ => OKeyword::EndWhile,
    }
}
