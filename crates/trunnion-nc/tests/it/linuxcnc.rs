//! `LinuxCNC` programs against the moves that its own interpreter makes of them (`fixtures/linuxcnc`).

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::readings;

use readings::options;
use std::fs;
use std::path::{Path, PathBuf};
use trunnion_nc::read::{
    Dialect, Frame, Move, Offset, OffsetKind, Pace, ReadOptions, Step, ToolRow, Way, read,
    tool_rows,
};

/// Digits of the interpreter's answers: four behind the point of inches.
const DIGITS: f64 = 3e-3;

/// A move as the interpreter makes it, with axis positions \[mm\].
#[derive(Debug, Clone, PartialEq)]
struct MadeMove {
    rapid: bool,
    end: [f64; 3],
    sweep: f64,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/linuxcnc")
}

/// Rows of `tools.tbl`.
fn tools() -> Vec<ToolRow> {
    tool_rows(&fs::read_to_string(folder().join("tools.tbl")).unwrap(), 1.0).unwrap()
}

fn linuxcnc() -> ReadOptions {
    ReadOptions { tools: tools(), ..options(Dialect::LinuxCnc, "XYZAC") }
}

/// A machine whose axes are its words, with work offsets at zero until the program writes them.
#[derive(Default)]
struct PlainMachine {
    at: [f64; 5],
    origins: [[f64; 5]; 9],
    length: f64,
    made: Vec<MadeMove>,
}

impl PlainMachine {
    fn take(&mut self, step: &Step) {
        match step {
            Step::Move(step) => self.go(step),
            Step::Tool { number, .. } => {
                let row = tools().into_iter().find(|row| row.number == *number);
                self.length = row.map_or(0.0, |row| row.offset[2]);
            }
            Step::Offset(offset) => self.write(offset),
            _ => {}
        }
    }

    fn write(&mut self, offset: &Offset) {
        let origin = &mut self.origins[usize::from(offset.offset)];
        for (slot, word) in offset.words.into_iter().enumerate() {
            match (word, offset.kind) {
                (Some(word), OffsetKind::Origin) => origin[slot] = word,
                (Some(word), OffsetKind::Reading) => origin[slot] = self.at[slot] - word,
                _ => {}
            }
        }
    }

    fn go(&mut self, step: &Move) {
        let before = self.at;
        for (slot, word) in step.words.into_iter().enumerate() {
            let Some(word) = word else { continue };
            let from = match step.frame {
                _ if step.incremental => self.at[slot],
                Frame::Machine => 0.0,
                Frame::Work { offset, length, .. } => {
                    let along = if length && slot == 2 { self.length } else { 0.0 };
                    self.origins[usize::from(offset)][slot] + along
                }
            };
            self.at[slot] = from + word;
        }
        let [x, y, z, ..] = self.at;
        let sweep = match step.way {
            Way::Line => 0.0,
            Way::Arc(arc) => arc.sweep,
        };
        let travel: f64 = before.iter().zip(self.at).map(|(from, to)| (to - from).abs()).sum();
        if travel > 2e-4 || sweep.abs() > 0.0 {
            let rapid = step.pace == Pace::Rapid;
            self.made.push(MadeMove { rapid, end: [x, y, z], sweep });
        }
    }
}

/// Moves that the interpreter made of a program.
fn expected(path: &Path) -> Vec<MadeMove> {
    let made = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let value = |at: usize| words[at].parse().unwrap();
        MadeMove {
            rapid: words[0] == "rapid",
            end: [value(1), value(2), value(3)],
            sweep: value(4),
        }
    };
    fs::read_to_string(path).unwrap().lines().map(made).collect()
}

#[test]
fn every_program_moves_as_the_interpreter_moves_it() {
    let mut count = 0;
    let mut files: Vec<_> =
        fs::read_dir(folder()).unwrap().map(|file| file.unwrap().path()).collect();
    files.sort();
    for path in files.iter().filter(|path| path.extension().is_some_and(|end| end == "moves")) {
        let name = path.display();
        let text = fs::read_to_string(path.with_extension("ngc")).unwrap();
        let program = read(&text, &linuxcnc())
            .unwrap_or_else(|faults| panic!("{name}: {}", faults.first().unwrap()));
        let mut machine = PlainMachine::default();
        program.steps.iter().for_each(|step| machine.take(step));
        let expected = expected(path);
        for (at, (found, expected)) in machine.made.iter().zip(&expected).enumerate() {
            let off = found
                .end
                .iter()
                .zip(expected.end)
                .map(|(found, expected)| (found - expected).abs());
            let off = off.fold((found.sweep - expected.sweep).abs(), f64::max);
            let same = found.rapid == expected.rapid && off < DIGITS;
            assert!(same, "{name}, move {}: {found:?} is not {expected:?}", at + 1);
        }
        assert_eq!(machine.made.len(), expected.len(), "{name}");
        count += 1;
    }
    assert!(count >= 6, "{count} programs");
}
