//! Words that set the state of a control beside its motion, by the manuals of the controls.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::readings;

use readings::options;
use trunnion_nc::read::{Dialect, LengthEntry, ReadOptions, ReadRemedy, Smoothing, Step, read};

fn steps(dialect: Dialect, text: &str) -> Vec<Step> {
    trunnion_nc::read::read(text, &options(dialect, "XYZAC")).unwrap().steps
}

/// Lines and distances of all smoothing words.
fn smoothing(dialect: Dialect, text: &str) -> Vec<(u32, Smoothing)> {
    let of = |step: Step| match step {
        Step::Smoothing { line, smoothing } => Some((line, smoothing)),
        _ => None,
    };
    steps(dialect, text).into_iter().filter_map(of).collect()
}

fn entries(dialect: Dialect, text: &str) -> Vec<LengthEntry> {
    let of = |step: Step| match step {
        Step::LengthEntry { entry, .. } => Some(entry),
        _ => None,
    };
    steps(dialect, text).into_iter().filter_map(of).collect()
}

#[test]
fn linuxcnc_states_its_blending() {
    use Smoothing::{Blended, Exact, Stop, Unbounded};
    let text = "G21 G90 G94 G54\nG61\nG64\nG64 P0.02 Q0\nG61.1\nG20\nG64 P[0.001] Q0.0005\nG64 P0.001\nM2\n";
    let found = smoothing(Dialect::LinuxCnc, text);
    assert_eq!(found.len(), 6);
    assert_eq!(
        found[..4],
        [(2, Exact), (3, Unbounded), (4, Blended { corners: 0.02, lines: 0.0 }), (5, Stop)]
    );
    // In the units of the program; Q is P unless stated.
    for (at, expected) in [(4, [0.0254, 0.0127]), (5, [0.0254, 0.0254])] {
        let (_, Blended { corners, lines }) = found[at] else { panic!("{found:?}") };
        assert!((corners - expected[0]).abs() < 1e-12 && (lines - expected[1]).abs() < 1e-12);
        assert_eq!(found[at].1.bound(), Some(corners + lines));
    }
}

#[test]
fn other_controls_state_a_tolerance_or_their_own_setting() {
    use Smoothing::{Exact, OfMachine, Within};
    let haas = "G21 G90 G54\nG187 P2 E0.05\nG187 P3\nG64\nM30\n";
    assert_eq!(smoothing(Dialect::Haas, haas), [(2, Within(0.05)), (3, OfMachine), (4, OfMachine)]);
    let siemens = "R1=0.02\nCYCLE832(0.05,3,1)\nCYCLE832()\nCYCLE832(0)\nCTOL=R1\nG60\nG64\nG641 ADIS=0.1\nM30\n";
    let expected = [
        (2, Within(0.05)),
        (3, OfMachine),
        (4, OfMachine),
        (5, Within(0.02)),
        (6, Exact),
        (7, OfMachine),
        (8, OfMachine),
        (8, Within(0.1)),
    ];
    assert_eq!(smoothing(Dialect::Siemens, siemens), expected);
    let heidenhain = "0 BEGIN PGM A MM\n1 CYCL DEF 32.0 TOLERANCE\n2 CYCL DEF 32.1 T0,05\n3 CYCL DEF 32.2 HSC-MODE:0 TA0.5\n4 CYCL DEF 32.0 TOLERANCE\n5 CYCL DEF 32.1\n6 END PGM A MM\n";
    let found = smoothing(Dialect::Heidenhain, heidenhain);
    assert_eq!(found, [(3, Within(0.05)), (6, OfMachine)]);
}

#[test]
fn entries_of_the_length_table_are_kept() {
    use LengthEntry::{Edge, Row};
    let text = "G21 G90 G94 G54\nT1 M6\nG0 G43 H2 Z50.\nG49\nG43 H1 Z50.\nH0\nM30\n";
    assert_eq!(entries(Dialect::Fanuc, text), [Row(2), Row(1)]);
    assert_eq!(entries(Dialect::Siemens, "T1\nM6\nD2\nD1\nD0\nM30\n"), [Edge(2), Edge(1), Edge(0)]);
}

/// Codes of the builder are refused unless they are declared; then they are kept, and the rest of the line is run.
#[test]
fn declared_codes_are_kept_and_the_rest_of_the_line_runs() {
    let cases = [
        (Dialect::LinuxCnc, "G0 X1 Y2 Z3\nM400 P5\nG1 X9 M400 F60\nM2\n", "M400"),
        (Dialect::Siemens, "G0 X1 Y2 Z3\nCYCLE999(1,2)\nG1 X9 F60\nM30\n", "CYCLE999"),
        (
            Dialect::Heidenhain,
            "0 BEGIN PGM 1 MM\n1 L X+1 Y+2 Z+3 FMAX\n2 CYCL DEF 239 LOAD\n3 L X+9 F60\n4 M30\n5 END PGM 1 MM\n",
            "CYCL DEF 239",
        ),
    ];
    for (dialect, text, code) in cases {
        let plain = options(dialect, "XYZAC");
        let faults = read(text, &plain).unwrap_err();
        if dialect == Dialect::LinuxCnc {
            assert_eq!(ReadRemedy::of(&faults[0]), Some(ReadRemedy::DeclarePassive));
        }
        let declared = ReadOptions { passive: vec![code.to_lowercase()], ..plain };
        let program = read(text, &declared).unwrap_or_else(|faults| panic!("{}", faults[0]));
        let kept: Vec<&str> = program
            .steps
            .iter()
            .filter_map(|step| match step {
                Step::Words { text, .. } if text.contains(code) => Some(&**text),
                _ => None,
            })
            .collect();
        assert!(kept[0].starts_with(code) && kept[0].len() > code.len(), "{kept:?}");
        let ends: Vec<_> = readings::moves(&program).iter().map(|step| step.words[0]).collect();
        assert_eq!(ends, [Some(1.0), Some(9.0)], "{dialect}");
    }
}
