//! Which line comes next: `GOTOF`, `GOTOB`, `IF`, `WHILE`, `FOR`, `LOOP`, `REPEAT`.

use super::super::arithmetic::{self, Written};
use super::super::log::{Remark, excerpt};
use super::super::reader::State;
use super::super::tape::Tape;
use super::head::{Head, Kind, Word, blanks, jump_in, name_at};
use super::{Siemens, value, word};

/// Loops in loops.
const DEEPEST: usize = 100;

/// A loop that runs.
#[derive(Debug)]
struct Loop {
    kind: Kind,
    /// Its first line.
    line: u32,
    /// Last value of the variable of a `FOR`.
    last: f64,
}

/// What lines are passed over for.
#[derive(Debug)]
enum Seek {
    /// A label or block number, upper case.
    Label(Box<str>),
    /// The end of what a line began, or its `ELSE`.
    End { kind: Kind, or_else: bool },
}

/// Everything about the order of lines.
#[derive(Debug)]
pub(super) struct Flow {
    pub(super) tape: Tape,
    seek: Option<Seek>,
    /// What was opened and not closed on the way, and the line that asked for it.
    depth: u32,
    asked: u32,
    loops: Vec<Loop>,
    /// Lines with `REPEAT LABEL`, and how often they still jump.
    sections: Vec<(u32, u32)>,
}

impl Flow {
    pub(super) fn new(most: u64) -> Self {
        Self {
            tape: Tape::new(most),
            seek: None,
            depth: 0,
            asked: 0,
            loops: Vec::new(),
            sections: Vec::new(),
        }
    }

    fn seek(&mut self, what: Seek, line: u32) {
        (self.seek, self.depth, self.asked) = (Some(what), 0, line);
    }

    /// Whether a line is passed over.
    pub(super) fn passes(&mut self, head: &Head<'_>) -> bool {
        let Some(seek) = &self.seek else { return false };
        match (seek, head.word) {
            (Seek::Label(label), _) if head.is(label) => {
                self.seek = None;
                return false;
            }
            (Seek::Label(_), Some(Word::Open(_))) => self.depth += 1,
            (Seek::Label(_), Some(Word::Close(kind))) => {
                // A jump out of a loop leaves it.
                match self.depth.checked_sub(1) {
                    Some(depth) => self.depth = depth,
                    None if kind != Kind::If => _ = self.loops.pop(),
                    None => {}
                }
            }
            (Seek::End { kind, .. }, Some(Word::Open(other))) if *kind == other => self.depth += 1,
            (Seek::End { kind, .. }, Some(Word::Close(other))) if *kind == other => {
                match self.depth.checked_sub(1) {
                    Some(depth) => self.depth = depth,
                    None => self.seek = None,
                }
            }
            (Seek::End { or_else: true, .. }, Some(Word::Else)) if self.depth == 0 => {
                self.seek = None;
            }
            _ => {}
        }
        true
    }

    /// What is still looked for when the file is over.
    pub(super) fn open(&self) -> Option<(u32, Remark)> {
        let remark = match self.seek.as_ref()? {
            Seek::Label(label) => {
                let message = format!("{label} does not stand behind this jump");
                Remark::new(0, message, "GOTOB jumps back; labels of other files are not known")
            }
            Seek::End { kind, .. } => {
                let word = format!("{kind:?}").to_uppercase();
                Remark::new(
                    0,
                    format!("{word} has no end"),
                    "end it: ENDIF, ENDWHILE, ENDFOR, ENDLOOP",
                )
            }
        };
        Some((self.asked, remark))
    }
}

impl Siemens {
    /// Does what a line says that decides which comes next.
    pub(super) fn decide(
        &mut self,
        state: &State,
        (code, head): (&str, &Head<'_>),
        word: Word,
    ) -> Result<(), Remark> {
        let line = state.log.line;
        match word {
            Word::Jump => self.jump(line, code, head.at),
            Word::If => {
                let at = jump_in(code, head.at).unwrap_or(code.len());
                if self.holds(code, head.at + "IF".len(), at)? {
                    return self.jump(line, code, at);
                }
                Ok(())
            }
            Word::Open(Kind::If) => {
                if !self.holds(code, head.at + "IF".len(), code.len())? {
                    self.flow.seek(Seek::End { kind: Kind::If, or_else: true }, line);
                }
                Ok(())
            }
            Word::Else => {
                self.flow.seek(Seek::End { kind: Kind::If, or_else: false }, line);
                Ok(())
            }
            Word::Close(Kind::If) => Ok(()),
            Word::Open(kind) => self.open(line, (code, head.at), kind),
            Word::Close(kind) => self.close((code, head.at), kind),
            Word::Section => self.section(line, code, head.at),
            Word::Define => self.define(code, head.at),
        }
    }

    /// A condition between two places of a line.
    fn holds(&self, code: &str, from: usize, to: usize) -> Result<bool, Remark> {
        Ok(self.reckon(code, from, to)?.abs() > 0.0)
    }

    fn reckon(&self, code: &str, from: usize, to: usize) -> Result<f64, Remark> {
        let text = code.get(..to).unwrap_or_default().trim_end();
        let from = from + blanks(text, from);
        if from >= text.len() {
            return Err(Remark::new(from, "a condition is missing here", "such as IF R1 < 5"));
        }
        let written =
            Written { text: text.get(from..).unwrap_or_default(), from: 0, at: from, comma: false };
        arithmetic::value(&written, &self.variables)
    }

    /// `GOTOF LABEL`, from a byte offset on.
    fn jump(&mut self, line: u32, code: &str, at: usize) -> Result<(), Remark> {
        let word = name_at(code, at);
        let from = at + word.len();
        let from = from + blanks(code, from);
        let target = name_at(code, from);
        let behind = code.get(from + target.len()..).unwrap_or_default().trim();
        if target.len() < 2 || !behind.is_empty() {
            let message = format!("{} is no label", excerpt(code.get(from..).unwrap_or_default()));
            return Err(Remark::new(
                from,
                message,
                "write a label of this file, or N and a number",
            ));
        }
        if !["GOTO", "GOTOF", "GOTOB"].iter().any(|known| word.eq_ignore_ascii_case(known)) {
            let message = format!("{word} is not understood as siemens");
            return Err(Remark::new(at, message, "write GOTOF or GOTOB and a label"));
        }
        let back = word.eq_ignore_ascii_case("GOTOB");
        if back || word.eq_ignore_ascii_case("GOTO") {
            if self.jump_back(line, target)? {
                return Ok(());
            }
            if back {
                let message = format!("{target} does not stand before this jump");
                let help =
                    "GOTOF jumps forward; block numbers are known from the first R parameter on";
                return Err(Remark::new(from, message, help));
            }
        }
        self.flow.seek(Seek::Label(target.to_ascii_uppercase().into()), line);
        Ok(())
    }

    /// Goes on at a label before a line, if there is one.
    fn jump_back(&mut self, line: u32, target: &str) -> Result<bool, Remark> {
        let is = |text: &str| {
            let code = word::without_comment(text);
            let from = code.len() - code.trim_start().len();
            Head::of(code, from).is(target)
        };
        // A line may jump to itself.
        let Some(to) = self.flow.tape.back(line.saturating_add(1), is)? else { return Ok(false) };
        self.flow.loops.retain(|inner| inner.line < to);
        self.flow.tape.go_to(to);
        Ok(true)
    }

    /// `WHILE`, `FOR`, `LOOP`, `REPEAT`.
    fn open(&mut self, line: u32, (code, at): (&str, usize), kind: Kind) -> Result<(), Remark> {
        let name = name_at(code, at);
        let mut last = 0.0;
        let runs = match kind {
            Kind::While => self.holds(code, at + name.len(), code.len())?,
            Kind::For => {
                last = self.first_of(code, at + name.len())?;
                self.flow_variable(code, at).is_some_and(|(_, value)| value <= last)
            }
            _ => true,
        };
        self.flow.loops.retain(|inner| inner.line < line);
        if !runs {
            self.flow.seek(Seek::End { kind, or_else: false }, line);
            return Ok(());
        }
        if self.flow.loops.len() >= DEEPEST {
            let message = format!("more than {DEEPEST} loops in each other");
            return Err(Remark::new(at, message, "does a jump lead into a loop again and again?"));
        }
        self.flow.loops.push(Loop { kind, line, last });
        Ok(())
    }

    /// `FOR R1 = 1 TO 5`: sets the variable; its last value.
    fn first_of(&mut self, code: &str, at: usize) -> Result<f64, Remark> {
        let upper = code.to_ascii_uppercase();
        let rest = upper.get(at..).unwrap_or_default();
        let (Some(equals), Some(to)) = (rest.find('='), rest.find(" TO ")) else {
            return Err(Remark::new(at, "FOR without = and TO", "write FOR R1 = 1 TO 5"));
        };
        let name = rest.get(..equals).unwrap_or_default().trim();
        let first = self.reckon(code, at + equals + 1, at + to)?;
        let last = self.reckon(code, at + to + " TO ".len(), code.len())?;
        self.variables.insert(name.into(), first);
        Ok(last)
    }

    /// The variable of a `FOR` and its value.
    fn flow_variable(&self, code: &str, at: usize) -> Option<(String, f64)> {
        let rest = code.get(at + "FOR".len()..)?;
        let name = rest.split('=').next()?.trim().to_ascii_uppercase();
        let value = *self.variables.get(name.as_str())?;
        Some((name, value))
    }

    /// `ENDWHILE`, `ENDFOR`, `ENDLOOP`, `UNTIL`.
    fn close(&mut self, (code, at): (&str, usize), kind: Kind) -> Result<(), Remark> {
        let name = name_at(code, at);
        let Some(inner) = self.flow.loops.pop().filter(|inner| inner.kind == kind) else {
            let message = format!("{name}: nothing was begun that it could end");
            return Err(Remark::new(at, message, "loops must lie inside of each other"));
        };
        let first = inner.line;
        let again = match kind {
            Kind::Repeat => !self.holds(code, at + name.len(), code.len())?,
            Kind::For => {
                let head = self.flow.tape.line(first);
                let code = word::without_comment(head.as_deref().unwrap_or_default());
                let from = code.len() - code.trim_start().len();
                let variable = self.flow_variable(code, Head::of(code, from).at);
                let next = variable.map(|(name, value)| (name, value + 1.0));
                let next = next.filter(|(_, value)| *value <= inner.last);
                let runs = next.is_some();
                if let Some((name, value)) = next {
                    self.variables.insert(name.into(), value);
                }
                runs
            }
            _ => true,
        };
        if again {
            // WHILE is asked again, the others go on inside.
            if kind == Kind::While {
                self.flow.tape.go_to(first);
            } else {
                self.flow.loops.push(inner);
                self.flow.tape.go_to(first.saturating_add(1));
            }
        }
        Ok(())
    }

    /// `DEF REAL LENGTH = 5, WIDTH`.
    fn define(&mut self, code: &str, at: usize) -> Result<(), Remark> {
        let from = at + "DEF".len();
        let from = from + blanks(code, from);
        let kind = name_at(code, from);
        if !["REAL", "INT", "BOOL"].iter().any(|known| known.eq_ignore_ascii_case(kind)) {
            let message =
                format!("{} is not understood", excerpt(code.get(at..).unwrap_or_default()));
            return Err(Remark::new(at, message, "DEF REAL, INT and BOOL are"));
        }
        let mut from = from + kind.len();
        for part in code.get(from..).unwrap_or_default().split(',') {
            let start = from + blanks(code, from);
            let name = name_at(code, start);
            let equals = part.find('=').map(|equals| from + equals + 1);
            let behind = equals.map_or(from + part.len(), |equals| equals - 1);
            let alone =
                code.get(start + name.len()..behind).is_some_and(|rest| rest.trim().is_empty());
            if name.len() < 2 || !alone {
                let message = format!("{} is no variable", excerpt(part));
                return Err(Remark::new(start, message, "write its name and = its value"));
            }
            let value = match equals {
                Some(equals) => self.reckon(code, equals, from + part.len())?,
                None => 0.0,
            };
            self.variables.insert(name.to_ascii_uppercase().into(), value);
            from += part.len() + 1;
        }
        Ok(())
    }

    /// `REPEAT LABEL P=3`: from the label to this line, so often again.
    fn section(&mut self, line: u32, code: &str, at: usize) -> Result<(), Remark> {
        let from = at + "REPEAT".len();
        let from = from + blanks(code, from);
        let target = name_at(code, from);
        let behind = code.get(from + target.len()..).unwrap_or_default();
        let count_at = behind.find('=').map(|equals| from + target.len() + equals + 1);
        let plain = behind.trim().is_empty()
            || behind.trim_start().starts_with(['P', 'p']) && count_at.is_some();
        if !plain {
            let help = "write REPEAT LABEL P=3; a section between two labels is not repeated";
            return Err(Remark::new(at, format!("{} is not understood", excerpt(code)), help));
        }
        let left = match self.flow.sections.iter().position(|(of, _)| *of == line) {
            Some(at) => self.flow.sections.remove(at).1,
            None => match count_at {
                Some(from) => value::natural(self.reckon(code, from, code.len())?, from)?,
                None => 1,
            },
        };
        let Some(left) = left.checked_sub(1) else { return Ok(()) };
        if !self.jump_back(line, target)? {
            let message = format!("{target} does not stand before this line");
            return Err(Remark::new(from, message, "write the label at the first line to repeat"));
        }
        self.flow.sections.push((line, left));
        Ok(())
    }
}
