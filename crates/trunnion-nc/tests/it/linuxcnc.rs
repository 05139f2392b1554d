//! `LinuxCNC` programs against the moves that its own interpreter makes of them (`fixtures/linuxcnc`).

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::readings;

use readings::options;
use std::fs;
use std::path::{Path, PathBuf};
use trunnion_nc::read::{
    CodeRemap, Dialect, Frame, Move, Offset, OffsetKind, Pace, ReadOptions, ReadRemedy, Step,
    SubprogramFile, ToolRow, Way, ini_file, read, tool_rows,
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
    // M6 stops the spindle.
    let before = "T1 M6\nG21 G90 G17 F100 S500 M3\nG0 X10 Y10 Z10\n";
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
    let broken = file("outer", "o<outer> sub\nG1 X#1 F60\n  G88 Z1 R2\no<outer> endsub\n");
    let faults = read("G0 X0\no<outer> call [1]\nM2\n", &with(vec![broken])).unwrap_err();
    assert_eq!(faults[0].line, 2);
    assert!(faults[0].message.starts_with("in outer, line 3, column 3: "), "{}", faults[0]);
}

#[test]
fn a_file_of_subprograms_alone_says_that_it_moves_nothing() {
    let program = read("o<hole> sub\nG0 X1\no<hole> endsub\n", &linuxcnc()).unwrap();
    let reported: Vec<_> = program.warnings.iter().map(|warning| &*warning.message).collect();
    assert_eq!(reported, ["subprogram hole is defined in line 1 and never called"]);
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

/// Axis positions at the end of a program that begins at zero, and the length of its cuts.
fn run_from_zero(text: &str, options: ReadOptions) -> ([f64; 5], f64) {
    let options = ReadOptions { start: Some([0.0; 5]), ..options };
    let program = read(text, &options).unwrap();
    let mut machine = PlainMachine::default();
    let mut cut = 0.0;
    for step in &program.steps {
        let before = machine.at;
        machine.take(step);
        if matches!(step, Step::Move(step) if step.pace != Pace::Rapid) {
            cut += (0..3).map(|slot| (machine.at[slot] - before[slot]).powi(2)).sum::<f64>().sqrt();
        }
    }
    (machine.at, cut)
}

fn near(found: &[f64], expected: &[f64]) {
    let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9, "{found:?} is not {expected:?}");
}

#[test]
fn a_control_that_was_switched_on_stands_at_its_start() {
    let plain = || options(Dialect::LinuxCnc, "XYZAC");
    // Each is refused where nothing is known of the start.
    let cases = [
        ("G92 X1 Y2\nG92.2\nG0 X3 Y4\nM2\n", [3.0, 4.0, 0.0]),
        ("G10 L2 P2 X5\nG55\nG0 Y7\nG28.1\nG0 X9\nG28\nM2\n", [0.0, 7.0, 0.0]),
        ("G30\nM2\n", [0.0, 0.0, 0.0]),
        ("G18 S800 M3\nG0 X5 Z5\nG76 P1 Z-10 I-1 J0.2 K0.6\nG0 X8\nM2\n", [8.0, 0.0, -10.0]),
        ("G0 Y5\nG41 D0 G1 X5 F100\nX9\nG40 X10\nM2\n", [10.0, 5.0, 0.0]),
    ];
    for (text, expected) in cases {
        let (at, _) = run_from_zero(text, plain());
        near(&at[..3], &expected);
        assert!(
            text.contains("G92.2") || read(text, &plain()).is_err() || text.contains("G28"),
            "{text}"
        );
    }
}

#[test]
fn g53_behind_compensation_leads_to_where_the_control_takes_the_axes_to_be() {
    // The cutter ends 1.5 mm beside X20 Y0; the control takes it to be there.
    let text = "T1 M6\nG10 L2 P1 X100 Y200 Z300\nG0 X-10 Y0 Z0\nG41 G1 X0 F100\nX20\nG40\nG53 G0 Z50\nM2\n";
    let (at, _) = run_from_zero(text, linuxcnc());
    near(&at[..3], &[120.0, 200.0, 50.0]);
    let unknown = read(&text.replace("G10 L2 P1 X100 Y200 Z300\n", ""), &linuxcnc()).unwrap_err();
    assert!(unknown[0].message.contains("G53 as the first move"), "{}", unknown[0]);
}

#[test]
fn upright_arcs_run_in_a_turned_work_offset() {
    // A half circle of radius 10 in the plane of Z and X, which the offset turns by 30 degrees.
    let text = "G10 L2 P1 X0 Y0 R30\nG18 G0 X0 Y0 Z0\nG2 X20 Z0 I10 K0 F100\nM2\n";
    let (at, cut) = run_from_zero(text, options(Dialect::LinuxCnc, "XYZAC"));
    let (sin, cos) = 30_f64.to_radians().sin_cos();
    near(&at[..3], &[20.0 * cos, 20.0 * sin, 0.0]);
    let arc = 10.0 * std::f64::consts::PI;
    assert!(cut < arc && arc - cut < 0.01, "{cut}");
}

#[test]
fn g10_l11_along_z_needs_no_unturned_offsets() {
    // At Z-30 the fixture, whose zero is at Z-27, reads -3: that is the length of the tool.
    let text = "G10 L2 P1 X1 Y2 Z-5 R10\nG10 L2 P9 X25 Y26 Z-27 R0\nG53 G0 Z-30\nG10 L11 P1 Z0\nT1 M6\nG43\nG0 Z0\nM2\n";
    let options = ReadOptions { tools: vec![tools()[0]], ..options(Dialect::LinuxCnc, "XYZAC") };
    let (at, _) = run_from_zero(text, options);
    near(&at[..3], &[0.0, 0.0, -8.0]);
}

/// The sample of the control touches off a second time with the length of the first in force.
#[test]
fn g10_l11_takes_no_part_of_a_length_in_force() {
    let text = "G10 L2 P1 X1 Y2 Z-5 R10\nG10 L2 P9 X25 Y26 Z-27 R0\nT1 M6\nG43\nG53 G0 Z-30\nG10 L11 P1 Z1\nG43\nG0 Z0\nM2\n";
    let options = ReadOptions { tools: vec![tools()[0]], ..options(Dialect::LinuxCnc, "XYZAC") };
    let (at, _) = run_from_zero(text, options);
    near(&at[..3], &[0.0, 0.0, -9.0]);
}

#[test]
fn remapped_codes_run_their_subprograms() {
    let ini = ini_file(
        "[RS274NGC]\nREMAP = M400 modalgroup=10 argspec=Pq ngc=feed_by\nREMAP=G88.1 modalgroup=1 argspec=@XYp ngc=hole\n\
         REMAP=M401 modalgroup=10 py=something\n",
    );
    assert_eq!(ini.remaps.len(), 3);
    let file =
        |name: &str, text: &str| SubprogramFile { name: name.to_owned(), text: text.to_owned() };
    let subprograms = vec![
        file("feed_by", "o<feed_by> sub\nG91 G1 X#<p> F60\nG90\no<feed_by> endsub\nM2\n"),
        file("hole", "o<hole> sub\nG0 X#1 Y[#2 + #3]\no<hole> endsub\nM2\n"),
    ];
    let with =
        ReadOptions { subprograms, remaps: ini.remaps, ..options(Dialect::LinuxCnc, "XYZAC") };
    let (at, cut) = run_from_zero("G0 X1\nM400 P4\nG88.1 X8 Y2 P3\nM400 P2 M30\n", with.clone());
    near(&at[..3], &[10.0, 5.0, 0.0]);
    near(&[cut], &[6.0]);
    let refusals = [
        ("M400 Q1\nM2\n", "M400 without P"),
        ("M401\nM2\n", "remapped to Python"),
        ("M400 P1 G0 X1\nM2\n", "beside another code"),
    ];
    for (text, part) in refusals {
        let faults = read(text, &with).unwrap_err();
        assert!(faults[0].message.contains(part), "{}", faults[0]);
        assert!(!faults[0].help.is_empty() && faults[0].line == 1, "{}", faults[0]);
    }
    let none = ReadOptions { remaps: Vec::<CodeRemap>::new(), ..with };
    assert!(read("M400 P4\nM2\n", &none).is_err());
}

#[test]
fn what_the_interpreter_does_not_run_is_refused() {
    let cases = [
        ("G0 X1\n(abort, no tool)\nX2\nM2\n", 2, "the program aborts here"),
        ("#<_ini[a]b> = 3\nG0 X1\nM2\n", 1, "cannot be set"),
    ];
    for (text, line, part) in cases {
        let faults = read(text, &linuxcnc()).unwrap_err();
        assert!(faults[0].line == line && faults[0].message.contains(part), "{}", faults[0]);
        assert!(!faults[0].help.is_empty(), "{}", faults[0]);
    }
    // A comment that is not reached aborts nothing.
    let passed = "o1 if [0]\n(ABORT, never)\no1 endif\nG0 X1\nM2\n";
    assert!(read(passed, &linuxcnc()).is_ok());
}

/// A probe reaches the end of its line, as in the interpreter that runs alone; the step says that it is one.
#[test]
fn a_probe_moves_to_its_end_and_says_so() {
    let text = "G21 F60\nG0 X1 Y2 Z5\nG38.2 Z-5\nG1 X[#5061+10] Y[#5070] Z#5063\nM2\n";
    let program = read(text, &linuxcnc()).unwrap();
    let moves = readings::moves(&program);
    let words = moves.last().unwrap().words;
    assert_eq!(words[..3], [Some(11.0), Some(0.0), Some(-5.0)]);
    let probes = program.steps.iter().filter(|step| matches!(step, Step::Probe { line: 3 }));
    assert_eq!(probes.count(), 1);
    assert!(
        program.warnings[0].message.contains("where the probe stops"),
        "{:?}",
        program.warnings
    );
}
