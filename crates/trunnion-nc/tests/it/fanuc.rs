//! Programs of Fanuc and Haas against positions reckoned by hand.

#![expect(clippy::panic, clippy::expect_used, reason = "a test stops on surprise")]

use crate::readings;

use proptest::prelude::*;
use readings::{moves, options, places};
use std::f64::consts::TAU;
use trunnion_nc::read::{Dialect, Frame, Offset, OffsetKind, Pace, Program, Step};

fn read_as(dialect: Dialect, text: &str) -> Program {
    readings::read(text, &options(dialect, "XYZAC"))
}

fn refused(dialect: Dialect, line: &str) -> String {
    let text = format!("G0 X1. Y1. Z1.\n{line}\nM30\n");
    match trunnion_nc::read::read(&text, &options(dialect, "XYZAC")) {
        Err(found) => {
            assert!(found[0].line == 2 && !found[0].help.is_empty(), "{line}: {}", found[0]);
            found[0].to_string()
        }
        Ok(_) => panic!("{line} is read"),
    }
}

fn ends_at(dialect: Dialect, lines: &str, expected: [f64; 3]) {
    let program = read_as(dialect, &format!("G17 G90 G0 X7. Y8. Z9.\n{lines}\nM30\n"));
    let found = *places(&program).last().expect("a move");
    let off = found.iter().zip(expected).map(|(found, wanted)| (found - wanted).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9, "{lines}: {found:?} is not {expected:?}");
}

#[test]
fn words_turn_and_are_mirrored() {
    let half = 0.75_f64.sqrt();
    // (10, 4) about (1, 2) by 30 degrees.
    let turned = [1.0 + 9.0 * half - 1.0, 2.0 + 4.5 + 2.0 * half, 9.0];
    for dialect in [Dialect::Fanuc, Dialect::Haas] {
        ends_at(dialect, "G68 X1. Y2. R30.\nX10. Y4.", turned);
        // About the place where the tool stands.
        ends_at(dialect, "G68 R90.\nX10. Y8.", [7.0, 11.0, 9.0]);
        ends_at(dialect, "G68 X0. Y0. R90.\nX10. Y4.\nG69\nX10.", [10.0, 10.0, 9.0]);
        ends_at(dialect, "G68 X0. Y0. R90.\nG91 X10.", [7.0, 18.0, 9.0]);
        ends_at(dialect, "G51.1 X5.\nX10. Y4.", [0.0, 4.0, 9.0]);
        ends_at(dialect, "G51.1 X5. Y1.\nX10. Y4.\nG50.1 X5.\nX10. Y4.", [10.0, -2.0, 9.0]);
        ends_at(dialect, "G51.1 X5.\nG50.1\nX10. Y4.", [10.0, 4.0, 9.0]);
        ends_at(
            dialect,
            "G52 X100.\nG68 X1. Y2. R30.\nX10. Y4.",
            [turned[0] + 100.0, turned[1], 9.0],
        );
    }
    ends_at(Dialect::Haas, "G101 X0.\nX10. Y4.\nG100\nY5.", [-10.0, 5.0, 9.0]);
    let arc = "G0 X10. Y0. Z0.\nG51.1 X0.\nG1 X10. Y0. F100.\nG3 X0. Y10. I-10. J0.\nM30\n";
    readings::arcs(&read_as(Dialect::Fanuc, arc), &[([0, 1], [10.0, 0.0], -0.5)]);
    // In G19 the turn is about X.
    ends_at(Dialect::Fanuc, "G19 G68 Y0. Z0. R90.\nY10. Z4.", [7.0, -4.0, 10.0]);
}

#[test]
fn a_bolt_circle_in_polar_coordinates() {
    let text = "G17 G90 G0 X0. Y0. Z50.\nG16\nG99 G81 X30. Y45. Z-5. R2. F100.\nY165.\nY285.\nG15 G80\nG0 X1. Y2.\nM30\n";
    let program = read_as(Dialect::Fanuc, text);
    let holes: Vec<_> = places(&program).into_iter().filter(|[.., z]| *z < 0.0).collect();
    assert_eq!(holes.len(), 3);
    for (k, [x, y, z]) in (0_u8..).zip(holes) {
        let (sin, cos) = (TAU / 8.0 + f64::from(k) * TAU / 3.0).sin_cos();
        let off = (x - 30.0 * cos).abs() + (y - 30.0 * sin).abs() + (z + 5.0).abs();
        assert!(off < 1e-9, "{x} {y} {z}");
    }
    let [x, y, _] = places(&program).pop().expect("a move");
    assert!((x - 1.0).abs() < 1e-12 && (y - 2.0).abs() < 1e-12);
    assert!(refused(Dialect::Fanuc, "G16 X30.").contains("alone"));
    assert!(refused(Dialect::Fanuc, "G91 G16 X30. Y5.").contains("G91"));
}

#[test]
fn cycles_repeat_as_often_as_they_are_told() {
    let bottoms = |dialect: Dialect, lines: &str| -> Vec<[f64; 3]> {
        let text = format!("G17 G90 G0 X0. Y0. Z50.\n{lines}\nG80\nM30\n");
        let all = places(&read_as(dialect, &text));
        all.into_iter().filter(|[.., z]| *z < 0.0).collect()
    };
    let three = [[10.0, 0.0, -5.0], [20.0, 0.0, -5.0], [30.0, 0.0, -5.0]];
    let is = |found: Vec<[f64; 3]>, expected: &[[f64; 3]]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            let off = found.iter().zip(expected).map(|(found, wanted)| (found - wanted).abs());
            assert!(off.fold(0.0, f64::max) < 1e-9, "{found:?} is not {expected:?}");
        }
    };
    // Fanuc counts by K, Haas by L; R and Z are distances in G91.
    is(bottoms(Dialect::Fanuc, "G91 G98 G81 X10. Z-7. R-48. K3 F100."), &three);
    is(bottoms(Dialect::Haas, "G91 G98 G81 X10. Z-7. R-48. L3 F100."), &three);
    is(bottoms(Dialect::Haas, "G81 X10. Z-5. R2. L2 F100."), &[three[0], three[0]]);
    is(bottoms(Dialect::Haas, "G81 Z-5. R2. L0 F100.\nX10.\nX20."), &three[..2]);
}

#[test]
fn local_subprograms_run_from_their_number() {
    let text = "G0 X0. Y0. Z9.\nM97 P100 L2\nG0 Y5.\nM30\nN100 G91 X3.\nG90 Z1.\nM99\n";
    let found = places(&read_as(Dialect::Haas, text));
    let expected =
        [[0.0, 0.0, 9.0], [3.0, 0.0, 9.0], [3.0, 0.0, 1.0], [6.0, 0.0, 1.0], [6.0, 0.0, 1.0]];
    for (found, expected) in found.iter().zip(expected) {
        let off = found.iter().zip(expected).map(|(found, wanted)| (found - wanted).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "{found:?} is not {expected:?}");
    }
    assert!((found[5][1] - 5.0).abs() < 1e-12 && found.len() == 6);
    assert!(refused(Dialect::Haas, "M97 P7").contains("7 is not in the file"));
}

#[test]
fn work_offsets_are_written_by_number() {
    let written = |dialect: Dialect, line: &str| -> Option<Offset> {
        let program = read_as(dialect, &format!("G90\n{line}\nG0 X1. Y1. Z1.\nM30\n"));
        program.steps.into_iter().find_map(|step| match step {
            Step::Offset(offset) => Some(offset),
            _ => None,
        })
    };
    for (dialect, line, number) in [
        (Dialect::Fanuc, "G10 L2 P2 X5.", 1),
        (Dialect::Fanuc, "G10 L20 P1 X5.", 9),
        (Dialect::Haas, "G10 L20 P4 X5.", 12),
    ] {
        let offset = written(dialect, line).expect("an offset");
        assert_eq!((offset.offset, offset.kind), (number, OffsetKind::Origin), "{line}");
    }
    let frames = |text: &str| moves(&read_as(Dialect::Haas, text)).last().map(|step| step.frame);
    let at = |offset| Some(Frame::Work { offset, length: false, tcp: false });
    assert_eq!(frames("G154 P4 G0 X1.\nM30\n"), at(12));
    assert_eq!(frames("G113 G0 X1.\nM30\n"), at(12));
    assert!(refused(Dialect::Fanuc, "G10 L2 P0 Z5.").contains("external"));
    assert!(refused(Dialect::Fanuc, "G10 L10 P1 R150.").contains("G10 other"));
}

#[test]
fn what_a_setting_decides_is_refused() {
    let cases = [
        (Dialect::Fanuc, "G51 X0. Y0. P2000", "settings say"),
        (Dialect::Fanuc, "G54.4 P1", "setting errors"),
        (Dialect::Fanuc, "G43.8 H1 Z5.", "contact point"),
        (Dialect::Fanuc, "G76 X1. Z-5. R2. Q0.2 F50.", "which way"),
        (Dialect::Fanuc, "G87 X1. Z-5. R2. Q0.2 F50.", "which way"),
        (Dialect::Fanuc, "G41 D1 G1 X5. F100.", "compensat"),
        (Dialect::Fanuc, "G12.1", "axis coordinates"),
        (Dialect::Fanuc, "G60 X5.", "parameter"),
        (Dialect::Fanuc, "M198 P5", "other devices"),
        (Dialect::Fanuc, "M97 P5", "Haas"),
        (Dialect::Haas, "G12 I5. F50. Z-1.", "pockets"),
        (Dialect::Haas, "G72 I5. J0. L3", "patterns"),
        (Dialect::Haas, "G150 P1 X1.", "pockets"),
        (Dialect::Haas, "G254", "own offsets"),
        (Dialect::Fanuc, "G68 X0. Y0.", "without R"),
        (Dialect::Fanuc, "G91 G68 X0. Y0. R5.", "G91"),
        (Dialect::Fanuc, "G31 Z-5. F10.", "probe"),
    ];
    for (dialect, line, part) in cases {
        let said = refused(dialect, line);
        assert!(said.contains(part), "{line}: {said}");
    }
}

#[test]
fn the_tables_of_the_book_are_true() {
    let rows = readings::rows_of_the_book("fanuc.md");
    assert!(rows.len() > 55, "{} rows", rows.len());
    let before = "G21 G90 G17 F100. S500 M3\nT1 M6\nG0 X10. Y10. Z10.\n";
    for row in rows {
        for dialect in [Dialect::Fanuc, Dialect::Haas] {
            let with = options(dialect, "XYZAC");
            let program = readings::ExampleProgram { before, behind: "\nM30\n", options: with };
            if row.heading != "Haas" || dialect == Dialect::Haas {
                program.holds(&row);
            }
        }
    }
}

#[test]
fn g80_goes_back_to_the_motion_before_the_cycle() {
    let text = "G0 G80 X0. Y0. Z9.\nG81 X5. Z-1. R2. F60.\nG80 Z20.\nM30\n";
    let program = read_as(Dialect::Fanuc, text);
    let last = moves(&program).pop().expect("a move");
    assert_eq!((last.words[2], last.pace), (Some(20.0), Pace::Rapid));
    assert!(refused(Dialect::Fanuc, "G81 G80 X5. Z-1. R2. F60.").contains("contradicts"));
}

/// Heights and speeds \[mm/min\] of the moves behind the first three; 0: rapid.
fn drilled(dialect: Dialect, line: &str) -> Vec<(f64, f64)> {
    let program = read_as(dialect, &format!("G0 X0. Y0. Z9.\n{line}\nG80\nM30\n"));
    let paces = moves(&program).into_iter().map(|step| match step.pace {
        Pace::PerMinute { speed } => 60.0 * speed,
        _ => 0.0,
    });
    places(&program).iter().map(|[.., z]| *z).zip(paces).skip(1).collect()
}

fn near(found: &[(f64, f64)], expected: &[(f64, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        let off = (found.0 - expected.0).abs().max((found.1 - expected.1).abs());
        assert!(off < 1e-9, "{found:?} is not {expected:?}");
    }
}

#[test]
fn threads_and_shrinking_pecks() {
    // A rigid tap turns the spindle itself: 500 turns a minute of 1.25 mm.
    let rigid = drilled(Dialect::Fanuc, "M29 S500\nG95 G84 Z-15. R5. F1.25");
    near(&rigid, &[(5.0, 0.0), (-15.0, 625.0), (5.0, 625.0), (9.0, 0.0)]);
    let fast = drilled(Dialect::Haas, "S500 M3\nG84 Z-15. R5. F625. J4");
    near(&fast, &[(5.0, 0.0), (-15.0, 625.0), (5.0, 2500.0), (9.0, 0.0)]);
    // 8 mm, then 2 mm less each, 5 mm at least: 8, 14, 19, 20 below R.
    let pecks = drilled(Dialect::Haas, "G83 Z-18. R2. I8. J2. K5. F100.");
    let cuts: Vec<_> = pecks.iter().filter(|(_, feed)| *feed > 0.0).map(|(z, _)| *z).collect();
    assert_eq!(cuts.len(), 4);
    for (cut, expected) in cuts.iter().zip([-6.0, -12.0, -17.0, -18.0]) {
        assert!((cut - expected).abs() < 1e-9, "{cuts:?}");
    }
    assert!(refused(Dialect::Haas, "G83 Z-18. R2. I8. F100.").contains("without J or K"));
}

#[test]
fn circles_of_holes_at_haas() {
    let bottoms = |line: &str| -> Vec<[f64; 3]> {
        let text = format!("G0 X3. Y4. Z9.\nG99 G81 Z-5. R2. F100. L0\n{line}\nG80\nM30\n");
        let all = places(&read_as(Dialect::Haas, &text));
        all.into_iter().filter(|[.., z]| *z < 0.0).collect()
    };
    for (line, apart, number) in
        [("G70 I30. J15. L6", TAU / 6.0, 6), ("G71 I30. J15. K20. L3", TAU / 18.0, 3)]
    {
        let found = bottoms(line);
        assert_eq!(found.len(), number, "{line}");
        for (k, [x, y, _]) in (0_u8..).zip(found) {
            let (sin, cos) = (TAU / 24.0 + f64::from(k) * apart).sin_cos();
            assert!((x - 3.0 - 30.0 * cos).hypot(y - 4.0 - 30.0 * sin) < 1e-9, "{line}: {x} {y}");
        }
    }
    assert!(refused(Dialect::Haas, "G70 I30. L6").contains("without a cycle"));
}

#[test]
fn short_statements_and_outputs_are_read() {
    let text =
        "#1=0\nG0 X0. Y0. Z9.\nWH [#1 LT 3] DO 1\n#1=#1+1\nG0 X#1\nEN 1\nDPRNT[X#1[33]]\nM30\n";
    let program = read_as(Dialect::Haas, text);
    let ends: Vec<f64> = places(&program).iter().map(|[x, ..]| *x).collect();
    assert_eq!(ends.len(), 4);
    assert!(ends.iter().zip([0.0, 1.0, 2.0, 3.0]).all(|(x, at)| (x - at).abs() < 1e-12));
    assert!(program.steps.iter().any(|step| matches!(step, Step::Words { line: 7, .. })));
    assert!(refused(Dialect::Fanuc, "G1 X5. ,R2. F9.").contains("next corner"));
}

#[test]
fn kept_codes_leave_the_motion_of_their_line() {
    ends_at(Dialect::Fanuc, "G62 G1 X10. F100.", [10.0, 8.0, 9.0]);
    ends_at(Dialect::Fanuc, "G22 X0. Y0. Z0. I-5. J-5. K-5.", [7.0, 8.0, 9.0]);
}

proptest! {
    #[test]
    fn token_soup_ends_and_never_panics(
        haas in any::<bool>(),
        tokens in prop::collection::vec(prop::sample::select(vec![
            "G0", "G1", "G2", "G3", "X1.", "Y-2.", "Z3.", "I1.", "J2.", "K3.", "R5.", "F100.", "G68", "G69", "R30.", "G51.1", "G50.1", "G101", "G100",
            "G16", "G15", "G17", "G18", "G19", "G81", "G83", "G84", "G70", "G71", "L3", "L0", "Q1.", "P2", "G80", "G90", "G91", "M97", "M98", "M99", "P100",
            "N100", "\n", "\n", "\n", "G10", "L20", "G54.1", "G110", "G154", "G52", "G53", "G43.4", "H1", "G68.2", "G53.1", "S500", "M3", "M29", "#1=1",
            "WH [#1 LT 3] DO 1", "EN 1", "DPRNT[", ",R2.", "M30", "G22", "G5", "O100", "A10.", "C5.",
        ]), 0..60),
    ) {
        let dialect = if haas { Dialect::Haas } else { Dialect::Fanuc };
        let with = options(dialect, "XYZAC");
        let _ = trunnion_nc::read::read(&tokens.join(" "), &with);
        let _ = trunnion_nc::read::read(&format!("G0 X0. Y0. Z9.\nF9. S9 M3\n{}", tokens.join(" ")), &with);
    }
}
