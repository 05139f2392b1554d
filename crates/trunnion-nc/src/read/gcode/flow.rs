//! Order of lines: subprograms, loops, conditions.

use super::label;
use super::label::{OKeyword, OWord};
use super::numbered_line::NumberedLine;
use super::sub_files::{SubFiles, SubLines};
use crate::read::log::{FileLine, ReadRemark};
use crate::read::options::ReadOptions;
use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;

/// Deepest nesting of calls and loops.
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

/// Lines of a loop, condition or subprogram that is running.
#[derive(Debug)]
pub(super) struct CallFrame {
    pub(super) lines: Arc<[NumberedLine]>,
    pub(super) next: usize,
    pub(super) loops: Vec<OpenLoop>,
    pub(super) of: FrameKind,
    /// Another file that the lines are of.
    pub(super) file: Option<FrameFile>,
}

/// File of a subprogram that is not in the program.
#[derive(Debug, Clone)]
pub(super) struct FrameFile {
    pub(super) name: Arc<str>,
    /// Line of the program that called it.
    pub(super) line: u32,
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
    call: SubCall,
    /// Line of the call.
    line: NumberedLine,
    /// Byte offset of the call in its line.
    at: usize,
    /// Index of its first line among the lines ahead, once it was found.
    start: Option<usize>,
}

/// Kind of a subprogram. One of each kind may have the same label.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SubKind {
    /// `o<name> sub`, called by `o<name> call`.
    Named,
    /// `O1000 .. M99`, called by `M98 P1000` or `G65 P1000`.
    Numbered,
    /// `N100 .. M99` of the same program, called by `M97 P100` of Haas.
    Local,
}

/// Place of a call.
#[derive(Debug, Clone, Copy)]
pub(super) struct CallSite<'a> {
    pub(super) line: FileLine<'a>,
    /// Byte offset of the call in its line.
    pub(super) at: usize,
}

/// A call.
#[derive(Debug, Clone)]
pub(super) struct SubCall {
    pub(super) kind: SubKind,
    pub(super) label: Box<str>,
    /// Parameters of its own begin with these; `None`: it has those of its caller.
    pub(super) arguments: Option<Vec<f64>>,
    /// Local names that begin with a value.
    pub(super) names: Vec<NamedArgument>,
    pub(super) times: u32,
}

/// A local name and its value.
pub(super) type NamedArgument = (Box<str>, f64);

impl SubCall {
    /// Returns the key under which the lines of the subprogram are kept.
    fn key(&self) -> Box<str> {
        match self.kind {
            SubKind::Named => self.label.clone(),
            SubKind::Numbered => label::numbered_key(&self.label),
            SubKind::Local => format!("M97 {}", self.label).into(),
        }
    }
}

/// Everything about the order of lines.
#[derive(Debug, Default)]
pub(super) struct GcodeFlow {
    subs: HashMap<Box<str>, SubLines>,
    files: SubFiles,
    /// Labels of subprograms that were called.
    called: HashSet<Box<str>>,
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
    /// It runs now, with these arguments and names if it has its own parameters.
    Runs(Option<Vec<f64>>, Vec<NamedArgument>),
    /// The file has to be read on to find it.
    Later,
}

impl GcodeFlow {
    pub(super) fn new(options: &ReadOptions) -> Self {
        Self { files: SubFiles::new(options), ..Self::default() }
    }

    /// Returns true if lines are to be run before the next of the file.
    pub(super) fn is_busy(&self) -> bool {
        self.wanted.is_none() && !(self.frames.is_empty() && self.ahead.is_empty())
    }

    /// Returns the next line that was read ahead.
    pub(super) fn next_ahead(&mut self) -> Option<NumberedLine> {
        self.ahead.pop_front()
    }

    /// Takes a line of the file if it is being collected or searched.
    pub(super) fn collect(&mut self, line: FileLine<'_>) -> LineCollection {
        // A subprogram that stands behind its call: lines are kept until its end was read.
        if self.wanted.is_some() {
            self.ahead.push_back(NumberedLine::new(line));
            return match self.look(self.ahead.len() - 1) {
                Some(called) => LineCollection::Called(called),
                None => LineCollection::Yes,
            };
        }
        let Some(capture) = self.capture.as_mut() else { return LineCollection::No };
        capture.lines.push(NumberedLine::new(line));
        // Structures inside have labels of their own, so label and keyword identify the end.
        let ends = label::o_word(line.text, 0).is_some_and(|word| {
            word.label == capture.label && word.keyword == closer(capture.keyword)
        });
        // A subprogram waits for its calls; a loop or condition runs as soon as it is complete.
        if ends && let Some(LineCapture { label, keyword, lines }) = self.capture.take() {
            if keyword == OKeyword::Sub {
                self.subs.insert(label, SubLines { lines: lines.into(), file: None });
            } else {
                let lines = lines.into();
                self.frames.push(CallFrame {
                    lines,
                    next: 0,
                    loops: Vec::new(),
                    of: FrameKind::File,
                    file: None,
                });
            }
        }
        LineCollection::Yes
    }

    /// Begins to collect lines.
    pub(super) fn begin(&mut self, word: &OWord, line: FileLine<'_>) {
        let (label, keyword) = (word.label.clone(), word.keyword);
        self.capture = Some(LineCapture { label, keyword, lines: vec![NumberedLine::new(line)] });
    }

    /// Calls a subprogram.
    pub(super) fn call(
        &mut self,
        call: SubCall,
        site: CallSite<'_>,
    ) -> Result<CallOutcome, ReadRemark> {
        let CallSite { line, at } = site;
        // Recursion is allowed; one without end would fill the memory.
        if self.frames.len() >= DEEPEST {
            let message = format!("more than {DEEPEST} calls in each other");
            return Err(ReadRemark::new(at, message, "does the subprogram call itself?"));
        }
        self.called.insert(call.label.clone());
        if !self.subs.contains_key(&call.key()) {
            // A file of its own goes before a subprogram further down in the program.
            for (key, lines) in self.files.open(&call.label) {
                self.subs.entry(key).or_insert(lines);
            }
        }
        if let Some(lines) = self.subs.get(&call.key()).cloned() {
            return Ok(self.enter(lines, call, line.number));
        }
        self.wanted = Some(AwaitedSub { call, line: NumberedLine::new(line), at, start: None });
        // The subprogram may stand among the lines that were read ahead for an earlier call.
        for at in 0..self.ahead.len() {
            if let Some(called) = self.look(at) {
                return Ok(called);
            }
        }
        Ok(CallOutcome::Later)
    }

    fn enter(&mut self, sub: SubLines, call: SubCall, line: u32) -> CallOutcome {
        let SubLines { lines, file } = sub;
        let of = match call.kind {
            SubKind::Named => FrameKind::Sub,
            SubKind::Numbered | SubKind::Local => FrameKind::Numbered {
                again: call.times.saturating_sub(1),
                scoped: call.arguments.is_some(),
            },
        };
        // Line 0 is the one with the label.
        let file = file.map(|name| FrameFile { name, line });
        self.frames.push(CallFrame { lines, next: 1, loops: Vec::new(), of, file });
        CallOutcome::Runs(call.arguments, call.names)
    }

    /// Checks a line ahead for the beginning or end of the subprogram that is wanted.
    fn look(&mut self, at: usize) -> Option<CallOutcome> {
        let wanted = self.wanted.as_mut()?;
        let text = &self.ahead.get(at)?.text;
        let word = label::o_word(text, 0);
        let of_label = word.filter(|word| word.label == wanted.call.label).map(|word| word.keyword);
        // First the line that begins it is searched, then the one that ends it.
        let Some(start) = wanted.start else {
            let begins = match wanted.call.kind {
                SubKind::Numbered => of_label == Some(OKeyword::Nothing),
                SubKind::Named => of_label == Some(OKeyword::Sub),
                SubKind::Local => label::line_number(text) == wanted.call.label.parse().ok(),
            };
            if begins {
                wanted.start = Some(at);
            }
            return None;
        };
        let ends = match wanted.call.kind {
            SubKind::Numbered | SubKind::Local => label::ends_subprogram(text),
            SubKind::Named => of_label == Some(OKeyword::EndSub),
        };
        if !ends {
            return None;
        }
        let mut lines: Vec<NumberedLine> = self.ahead.range(start..=at).cloned().collect();
        // The line with the number of a local subprogram runs as well: one without words goes before it.
        if wanted.call.kind == SubKind::Local {
            let number = lines.first().map_or(0, |line| line.number);
            lines.insert(0, NumberedLine { number, text: "".into() });
        }
        let lines: Arc<[NumberedLine]> = lines.into();
        let AwaitedSub { call, line, .. } = self.wanted.take()?;
        let sub = SubLines { lines, file: None };
        self.subs.insert(call.key(), sub.clone());
        Some(self.enter(sub, call, line.number))
    }

    /// Returns the structure that is still open at the end of the file, with the line that opened it.
    pub(super) fn open(&self) -> Option<(&NumberedLine, ReadRemark)> {
        if let Some(AwaitedSub { call, line, at, .. }) = &self.wanted {
            let message = format!("subprogram {} is not in the file", call.label);
            return Some((
                line,
                ReadRemark::new(
                    *at,
                    message,
                    "append its lines to the program, or give the file that has it",
                ),
            ));
        }
        let capture = self.capture.as_ref()?;
        let message = format!("what o<{}> begins here has no end", capture.label);
        let remark = ReadRemark::new(0, message, "end it: endsub, endwhile, endif, endrepeat");
        Some((capture.lines.first()?, remark))
    }

    /// Returns the labels and first lines of the subprograms that nothing called, in the order of lines.
    pub(super) fn uncalled(&self) -> Vec<(&str, &NumberedLine)> {
        let own = self.subs.iter().filter(|(label, sub)| {
            sub.file.is_none() && !label.contains(' ') && !self.called.contains(*label)
        });
        let first = own.filter_map(|(label, sub)| Some((&**label, sub.lines.first()?)));
        let mut uncalled: Vec<_> = first.collect();
        uncalled.sort_by_key(|(_, line)| line.number);
        uncalled
    }

    /// Returns true if a subprogram was read.
    pub(super) fn has_subs(&self) -> bool {
        !self.subs.is_empty()
    }
}

impl CallFrame {
    /// Returns true if the lines have parameters of their own.
    pub(super) fn is_scoped(&self) -> bool {
        matches!(self.of, FrameKind::Sub | FrameKind::Numbered { scoped: true, .. })
    }

    /// Finds the line of a label with one of some keywords, from a line on.
    pub(super) fn find(&self, label: &str, keywords: &[OKeyword], from: usize) -> Option<usize> {
        let is = |line: &NumberedLine| {
            label::o_word(&line.text, 0)
                .is_some_and(|word| *word.label == *label && keywords.contains(&word.keyword))
        };
        self.lines.iter().skip(from).position(is).map(|at| at + from)
    }

    /// Returns true if the innermost loop has this label and kind.
    pub(super) fn in_loop(&self, label: &str, is: fn(LoopKind) -> bool) -> bool {
        self.loops.last().is_some_and(|last| *last.label == *label && is(last.kind))
    }

    /// Leaves all loops from the one of a label on; returns that loop.
    pub(super) fn leave(&mut self, label: &str) -> Option<OpenLoop> {
        // Loops inside of the one that is left are over as well.
        let at = self.loops.iter().rposition(|inner| *inner.label == *label)?;
        self.loops.truncate(at + 1);
        self.loops.pop()
    }
}

/// Returns the keyword that ends the structure another one begins.
pub(super) fn closer(keyword: OKeyword) -> OKeyword {
    match keyword {
        OKeyword::Sub => OKeyword::EndSub,
        // `do` ends with a `while` of its own label.
        OKeyword::Do => OKeyword::While,
        OKeyword::If => OKeyword::EndIf,
        OKeyword::Repeat => OKeyword::EndRepeat,
        _ => OKeyword::EndWhile,
    }
}
