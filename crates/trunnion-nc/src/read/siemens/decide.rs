//! Order of lines: `GOTOF`, `GOTOB`, `IF`, `WHILE`, `FOR`, `LOOP`, `REPEAT`.

use super::flow::{SiemensLoop, SiemensSeek};
use super::head::{BlockHead, FlowWord, StructureKind, blanks, jump_in, name_at};
use super::reader::SiemensReader;
use super::{value, word};
use crate::read::arithmetic;
use crate::read::arithmetic::FormulaText;
use crate::read::log::{ReadRemark, excerpt};
use crate::read::number::DecimalMark;
use crate::read::state::ReaderState;

/// Deepest nesting of loops.
const DEEPEST: usize = 100;

impl SiemensReader {
    /// Runs a statement that decides the order of lines.
    pub(super) fn decide(
        &mut self,
        state: &ReaderState,
        code: &str,
        head: &BlockHead<'_>,
        word: FlowWord,
    ) -> Result<(), ReadRemark> {
        let line = state.log.line;
        match word {
            FlowWord::Jump => self.jump(line, code, head.at),
            FlowWord::If => {
                let at = jump_in(code, head.at).unwrap_or(code.len());
                if self.holds(code, head.at + "IF".len(), at)? {
                    return self.jump(line, code, at);
                }
                Ok(())
            }
            FlowWord::Open(StructureKind::If) => {
                // A condition that does not hold skips to its ELSE or ENDIF; an ELSE that is
                // reached skips to ENDIF.
                if !self.holds(code, head.at + "IF".len(), code.len())? {
                    self.flow
                        .seek(SiemensSeek::End { kind: StructureKind::If, or_else: true }, line);
                }
                Ok(())
            }
            FlowWord::Else => {
                self.flow.seek(SiemensSeek::End { kind: StructureKind::If, or_else: false }, line);
                Ok(())
            }
            FlowWord::Close(StructureKind::If) => Ok(()),
            FlowWord::Open(kind) => self.open(line, code, head.at, kind),
            FlowWord::Close(kind) => self.close(code, head.at, kind),
            FlowWord::Section => self.section(line, code, head.at),
            FlowWord::Define => self.define(code, head.at),
        }
    }

    /// Evaluates a condition between two offsets of a line.
    fn holds(&self, code: &str, from: usize, to: usize) -> Result<bool, ReadRemark> {
        Ok(self.reckon(code, from, to)?.abs() > 0.0)
    }

    fn reckon(&self, code: &str, from: usize, to: usize) -> Result<f64, ReadRemark> {
        let text = code.get(..to).unwrap_or_default().trim_end();
        let from = from + blanks(text, from);
        if from >= text.len() {
            return Err(ReadRemark::new(from, "a condition is missing here", "such as IF R1 < 5"));
        }
        let written = FormulaText {
            text: text.get(from..).unwrap_or_default(),
            from: 0,
            at: from,
            mark: DecimalMark::Point,
        };
        arithmetic::value(&written, &self.variables)
    }

    /// Runs `GOTOF LABEL`, from a byte offset on.
    fn jump(&mut self, line: u32, code: &str, at: usize) -> Result<(), ReadRemark> {
        let word = name_at(code, at);
        let from = at + word.len();
        let from = from + blanks(code, from);
        let target = name_at(code, from);
        let behind = code.get(from + target.len()..).unwrap_or_default().trim();
        if target.len() < 2 || !behind.is_empty() {
            let message = format!("{} is no label", excerpt(code.get(from..).unwrap_or_default()));
            return Err(ReadRemark::new(
                from,
                message,
                "write a label of this file, or N and a number",
            ));
        }
        if !["GOTO", "GOTOF", "GOTOB"].iter().any(|known| word.eq_ignore_ascii_case(known)) {
            let message = format!("{word} is not understood as siemens");
            return Err(ReadRemark::new(at, message, "write GOTOF or GOTOB and a label"));
        }
        let back = word.eq_ignore_ascii_case("GOTOB");
        // GOTOB searches backwards, GOTOF forwards; for GOTO the lines already read are searched
        // first.
        if back || word.eq_ignore_ascii_case("GOTO") {
            if self.jump_back(line, target)? {
                return Ok(());
            }
            if back {
                let message = format!("{target} does not stand before this jump");
                let help =
                    "GOTOF jumps forward; block numbers are known from the first R parameter on";
                return Err(ReadRemark::new(from, message, help));
            }
        }
        self.flow.seek(SiemensSeek::Label(target.to_ascii_uppercase().into()), line);
        Ok(())
    }

    /// Goes on at a label before a line, if there is one.
    fn jump_back(&mut self, line: u32, target: &str) -> Result<bool, ReadRemark> {
        let is = |text: &str| {
            let code = word::without_comment(text);
            let from = code.len() - code.trim_start().len();
            BlockHead::of(code, from).is(target)
        };
        // A line may jump to itself.
        let Some(to) = self.flow.tape.back(line.saturating_add(1), is)? else { return Ok(false) };
        // Loops that begin at or behind the target are left by the jump.
        self.flow.loops.retain(|inner| inner.line < to);
        self.flow.tape.go_to(to);
        Ok(true)
    }

    /// Runs `WHILE`, `FOR`, `LOOP`, `REPEAT`.
    fn open(
        &mut self,
        line: u32,
        code: &str,
        at: usize,
        kind: StructureKind,
    ) -> Result<(), ReadRemark> {
        let name = name_at(code, at);
        let mut last = 0.0;
        // LOOP and REPEAT run at least once; WHILE and FOR are asked before.
        let runs = match kind {
            StructureKind::While => self.holds(code, at + name.len(), code.len())?,
            StructureKind::For => {
                last = self.first_of(code, at + name.len())?;
                self.flow_variable(code, at).is_some_and(|(_, value)| value <= last)
            }
            _ => true,
        };
        // A loop that begins here or further down was left by a jump.
        self.flow.loops.retain(|inner| inner.line < line);
        if !runs {
            self.flow.seek(SiemensSeek::End { kind, or_else: false }, line);
            return Ok(());
        }
        if self.flow.loops.len() >= DEEPEST {
            let message = format!("more than {DEEPEST} loops in each other");
            return Err(ReadRemark::new(
                at,
                message,
                "does a jump lead into a loop again and again?",
            ));
        }
        self.flow.loops.push(SiemensLoop { kind, line, last });
        Ok(())
    }

    /// Sets the variable of `FOR R1 = 1 TO 5`; returns its last value.
    fn first_of(&mut self, code: &str, at: usize) -> Result<f64, ReadRemark> {
        let upper = code.to_ascii_uppercase();
        let rest = upper.get(at..).unwrap_or_default();
        let (Some(equals), Some(to)) = (rest.find('='), rest.find(" TO ")) else {
            return Err(ReadRemark::new(at, "FOR without = and TO", "write FOR R1 = 1 TO 5"));
        };
        let name = rest.get(..equals).unwrap_or_default().trim();
        let first = self.reckon(code, at + equals + 1, at + to)?;
        let last = self.reckon(code, at + to + " TO ".len(), code.len())?;
        self.variables.insert(name.into(), first);
        Ok(last)
    }

    /// Returns the variable of a `FOR` and its value.
    fn flow_variable(&self, code: &str, at: usize) -> Option<(String, f64)> {
        let rest = code.get(at + "FOR".len()..)?;
        let name = rest.split('=').next()?.trim().to_ascii_uppercase();
        let value = *self.variables.get(name.as_str())?;
        Some((name, value))
    }

    /// Runs `ENDWHILE`, `ENDFOR`, `ENDLOOP`, `UNTIL`.
    fn close(&mut self, code: &str, at: usize, kind: StructureKind) -> Result<(), ReadRemark> {
        let name = name_at(code, at);
        let Some(inner) = self.flow.loops.pop().filter(|inner| inner.kind == kind) else {
            let message = format!("{name}: nothing was begun that it could end");
            return Err(ReadRemark::new(at, message, "loops must lie inside of each other"));
        };
        let first = inner.line;
        let again = match kind {
            // UNTIL: runs again while its condition does not hold.
            StructureKind::Repeat => !self.holds(code, at + name.len(), code.len())?,
            StructureKind::For => {
                let head = self.flow.tape.line(first);
                let code = word::without_comment(head.as_deref().unwrap_or_default());
                let from = code.len() - code.trim_start().len();
                let variable = self.flow_variable(code, BlockHead::of(code, from).at);
                // FOR counts by one, and leaves the variable at its last value.
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
            if kind == StructureKind::While {
                self.flow.tape.go_to(first);
            } else {
                self.flow.loops.push(inner);
                self.flow.tape.go_to(first.saturating_add(1));
            }
        }
        Ok(())
    }

    /// Runs `DEF REAL LENGTH = 5, WIDTH`.
    fn define(&mut self, code: &str, at: usize) -> Result<(), ReadRemark> {
        let from = at + "DEF".len();
        let from = from + blanks(code, from);
        let kind = name_at(code, from);
        if !["REAL", "INT", "BOOL"].iter().any(|known| known.eq_ignore_ascii_case(kind)) {
            let message =
                format!("{} is not understood", excerpt(code.get(at..).unwrap_or_default()));
            return Err(ReadRemark::new(at, message, "DEF REAL, INT and BOOL are"));
        }
        let mut from = from + kind.len();
        for part in code.get(from..).unwrap_or_default().split(',') {
            let start = from + blanks(code, from);
            let name = name_at(code, start);
            // Each name may have a value of its own: `DEF REAL A = 5, B`.
            let equals = part.find('=').map(|equals| from + equals + 1);
            let behind = equals.map_or(from + part.len(), |equals| equals - 1);
            let alone =
                code.get(start + name.len()..behind).is_some_and(|rest| rest.trim().is_empty());
            if name.len() < 2 || !alone {
                let message = format!("{} is no variable", excerpt(part));
                return Err(ReadRemark::new(start, message, "write its name and = its value"));
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

    /// Runs `REPEAT LABEL P=3` (from the label to this line), `REPEAT FIRST LAST P=3` (from one label to
    /// the block of the other), `REPEATB LABEL P=3` (the block of the label): as many times again.
    fn section(&mut self, line: u32, code: &str, at: usize) -> Result<(), ReadRemark> {
        let word = name_at(code, at);
        let from = at + word.len();
        let from = from + blanks(code, from);
        let target = name_at(code, from);
        let mut next = from + target.len();
        next += blanks(code, next);
        // A name and no P= behind it is the second label.
        let second = Some(name_at(code, next)).filter(|name| name.len() > 1);
        next += second.map_or(0, str::len);
        let behind = code.get(next..).unwrap_or_default();
        let count_at = behind.find('=').map(|equals| next + equals + 1);
        let plain = behind.trim().is_empty()
            || behind.trim_start().starts_with(['P', 'p']) && count_at.is_some();
        let block = word.eq_ignore_ascii_case("REPEATB");
        if !plain || block && second.is_some() {
            let help = "write REPEAT LABEL P=3, REPEAT FIRST LAST P=3 or REPEATB LABEL P=3";
            return Err(ReadRemark::new(at, format!("{} is not understood", excerpt(code)), help));
        }
        // The line is reached again after each repetition: it then counts down what is left.
        self.flow.returns.retain(|(_, of)| *of != line);
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
            return Err(ReadRemark::new(
                from,
                message,
                "write the label at the first line to repeat",
            ));
        }
        self.flow.sections.push((line, left));
        // ENDLABEL ends every section that names no end.
        let end = if block { target } else { second.unwrap_or("ENDLABEL") };
        self.flow.returns.push((end.into(), line));
        Ok(())
    }
}
