//! `LinuxCNC` programs against the moves that its own interpreter makes of them (`fixtures/linuxcnc`).

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::readings;

use readings::options;
use std::fs;
use std::path::{Path, PathBuf};
use trunnion_nc::read::{
    Dialect, Frame, Move, Offset, OffsetKind, Pace, ReadOptions, ReadRemedy, Step, SubprogramFile,
    ToolRow, Way, read, tool_rows,
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

#[test]
fn the_table_of_the_book_is_true() {
    let rows = readings::rows_of_the_book("linuxcnc.md");
    assert!(rows.len() > 45, "{} rows", rows.len());
    let before = "G21 G90 G17 F100 S500 M3\nT1 M6\nG0 X10 Y10 Z10\n";
    let program = readings::ExampleProgram { before, behind: "\nM2\n", options: linuxcnc() };
    for row in rows {
        program.holds(&row);
    }
}

#[test]
fn subprograms_of_other_files_run_and_are_named() {
    let file =
        |name: &str, text: &str| SubprogramFile { name: name.to_owned(), text: text.to_owned() };
    let with = |files: Vec<SubprogramFile>| ReadOptions { subprograms: files, ..linuxcnc() };
    let text = "G0 X0\no<Outer> call [4]\no200 call\nG0 X9\nM2\n";
    let outer =
        file("outer", "o<outer> sub\nG1 X#1 F60\no<inner> call [#1]\no<outer> endsub\nM2\n");
    let inner = file("inner", "o<inner> sub\nG1 Y[2 * #1]\no<inner> endsub\n");
    let hundred = file("200", "(a number)\no200 sub\nG1 Z1\no200 endsub\n");
    let program = read(text, &with(vec![outer.clone(), inner, hundred])).unwrap();
    let moves = readings::moves(&program);
    let lines: Vec<u32> = moves.iter().map(|step| step.line).collect();
    // Moves count as those of the line that calls.
    assert_eq!(lines, [1, 2, 2, 3, 4]);
    assert_eq!((moves[1].words[0], moves[2].words[1]), (Some(4.0), Some(8.0)));
    let faults = read(text, &with(vec![outer])).unwrap_err();
    assert!(faults[0].message.contains("inner is not in the file"), "{}", faults[0]);
    let broken = file("outer", "o<outer> sub\nG1 X#1 F60\n  G38.2 Z1\no<outer> endsub\n");
    let faults = read("G0 X0\no<outer> call [1]\nM2\n", &with(vec![broken])).unwrap_err();
    assert_eq!(faults[0].line, 2);
    assert!(faults[0].message.starts_with("in outer, line 3, column 3: "), "{}", faults[0]);
}

#[test]
fn a_file_of_subprograms_alone_says_that_it_moves_nothing() {
    let program = read("o<hole> sub\nG0 X1\no<hole> endsub\n", &linuxcnc()).unwrap();
    let told: Vec<_> = program.warnings.iter().map(|warning| &*warning.message).collect();
    assert_eq!(told, ["subprogram hole is defined in line 1 and never called"]);
}

#[test]
fn compensation_asks_for_the_radius_and_for_room() {
    let refused = |text: &str, options: &ReadOptions| match read(text, options) {
        Err(faults) => faults[0].clone(),
        Ok(program) => panic!("{text} is read: {:?}", readings::moves(&program)),
    };
    let plain = options(Dialect::LinuxCnc, "XYZAC");
    let text = "T1 M6\nG0 X0 Y0 Z0\nG41 G1 X10 F100\nM2\n";
    let fault = refused(text, &plain);
    assert_eq!(ReadRemedy::of(&fault), Some(ReadRemedy::GiveTools));
    assert_eq!((fault.line, fault.column), (3, 1));
    // Tool 1 has a radius of 1.5 mm.
    let cases = [
        ("G41 G1 X1 F100", "not longer than the radius"),
        ("G41 G1 X10 F100\nX20\nX19.9 Y1\nX25", "without gouging"),
        ("G41 G1 X10 F100\nG3 X10 Y2 I0 J1", "does not fit"),
        ("G41 G1 X10 F100\nG54", "G54 with cutter compensation on"),
        ("G41 G1 X10 F100\nX20\nG40\nG2 X30 Y0 I5 J0", "an arc as the first move behind"),
        ("G19 G41 G1 Y10 F100", "G19"),
    ];
    for (lines, part) in cases {
        let fault = refused(&format!("T1 M6\nG0 X0 Y0 Z0\n{lines}\nM2\n"), &linuxcnc());
        assert!(fault.message.contains(part), "{lines}: {fault}");
    }
}
