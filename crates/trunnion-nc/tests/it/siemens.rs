//! Sinumerik programs against hand-reckoned cases.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::readings;

use proptest::prelude::*;
use readings::{moves, options, places};
use std::f64::consts::{PI, TAU};
use trunnion_nc::read::{Dialect, Frame, Pace, Program, ReadOptions, Step, Turning};

const DIALECT: Dialect = Dialect::Siemens;

fn read(text: &str) -> Program {
    readings::read(text, &options(DIALECT, "XYZAC"))
}

fn refuses(text: &str, line: u32, part: &str) {
    let with = options(DIALECT, "XYZAC");
    let found = trunnion_nc::read::read(&format!("{text}\nM30\n"), &with).unwrap_err();
    let all: Vec<_> = found.iter().map(ToString::to_string).collect();
    assert!(found[0].line == line && all[0].contains(part), "{text:?}: {all:?}");
}

#[test]
fn the_worked_cut_by_vectors_and_by_axes() {
    for (file, turning) in
        [("siemens.mpf", Turning::GreatCircle), ("siemens-axes.mpf", Turning::Rotary)]
    {
        let text = readings::fixture(file);
        assert_eq!(Dialect::guess(text.lines()), DIALECT, "{file}");
        let program = read(&text);
        readings::is_the_worked_cut(
            &program,
            2e-7_f64.max(if turning == Turning::Rotary { 2e-5 } else { 0.0 }),
        );
        let last = moves(&program).last().copied().unwrap();
        assert_eq!(
            (last.turning, last.frame),
            (turning, Frame::Work { offset: 0, length: true, tcp: true })
        );
        assert_eq!(last.pace, Pace::PerMinute { speed: 800.0 / 60.0 });
        assert_eq!(program.tools.len(), 1);
        assert!(program.steps.contains(&Step::Spindle {
            line: if file == "siemens.mpf" { 7 } else { 6 },
            speed: 8000.0
        }));
    }
}

#[test]
fn parameters_are_reckoned_with() {
    let program = read(
        "R1=10 R2=R1*2\nR2=R1/4 + SQRT(4)\nG0 X=R1 Y=-R2 Z=(R1 - 1)*2\nX=IC(R1) Z=AC(1)\nG91 X1 Y=AC(7)\nM30\n",
    );
    assert_eq!(places(&program), [[10.0, -4.5, 18.0], [20.0, -4.5, 1.0], [21.0, 7.0, 1.0]]);
    refuses("G0 X=R7", 1, "has no value");
    refuses("G0 X=1/0", 1, "finite");
    refuses("X1", 1, "without G0");
    let with =
        ReadOptions { parameters: vec![("R7".to_owned(), 3.0)], ..options(DIALECT, "XYZAC") };
    let [[x, ..]] = places(&readings::read("G0 X=R7\nM30\n", &with))[..] else { unreachable!() };
    assert!((x - 3.0).abs() < 1e-15);
}

#[test]
fn rotary_axes_take_the_way_they_are_told() {
    let program = read("G0 C350\nC=DC(10)\nC=ACN(350)\nC=ACP(340)\nC=DC(150)\nC=IC(-20)\nM30\n");
    let found: Vec<_> =
        moves(&program).iter().map(|m| (m.words[4].unwrap().to_degrees(), m.incremental)).collect();
    let expected = [
        (350.0, false),
        (370.0, false),
        (350.0, false),
        (700.0, false),
        (870.0, false),
        (-20.0, true),
    ];
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found.0 - expected.0).abs() < 1e-9 && found.1 == expected.1,
            "{found:?} is not {expected:?}"
        );
    }
    refuses("G0 X=DC(10)", 1, "rotary axes");
}

#[test]
fn arcs_by_centre_radius_and_turns() {
    let program = read(
        "G17 G0 X10 Y0 Z0\nG1 F600\nG3 X0 Y10 I-10 J0\nG2 X10 Y0 CR=10\nG3 X0 Y-10 CR=-10\nG2 X0 Y-10 I=AC(0) J=AC(0) Z-5 TURN=2\n\
         G18 G3 X0 Z-5 K5 I0\nM30\n",
    );
    let expected = [
        ([0, 1], [-10.0, 0.0], 0.5),
        ([0, 1], [0.0, -10.0], -0.5),
        ([0, 1], [-10.0, 0.0], 1.5),
        ([0, 1], [0.0, 10.0], -6.0),
        ([2, 0], [5.0, 0.0], 2.0),
    ];
    let arcs = readings::arcs(&program, &expected);
    assert_eq!(arcs.len(), 5);
}

#[test]
fn words_without_motion_are_kept_or_refused() {
    let program = read(
        "; a head\nMSG(\"cut; and run\")\nN10 G64 FFWON SOFT\nT3 D1\nM6\nG0 SUPA Z0 D0\nG54 TRANS X5\nG0 X1\nTRANS\nX1\nG4 F2\nG500\nX0\nM17\n",
    );
    assert_eq!(program.tools, [3]);
    let found = moves(&program);
    assert_eq!(found[0].frame, Frame::Machine);
    assert_eq!([found[1].words[0], found[2].words[0]], [Some(6.0), Some(1.0)]);
    assert!(matches!(found[3].frame, Frame::Work { offset: 255, .. }));
    assert!(program.steps.contains(&Step::Dwell { line: 11, seconds: 2.0 }));
    let kept: Vec<_> = program
        .steps
        .iter()
        .filter_map(|step| match step {
            Step::Words { text, .. } => Some(text.to_string()),
            _ => None,
        })
        .collect();
    assert_eq!(kept, ["MSG(\"cut; and run\")", "G64", "FFWON", "SOFT"]);
    refuses("G0 X1\nROT X30", 2, "out of the active plane");
    refuses("G1 X1 A3=1 F5", 1, "without TRAORI");
    refuses("TRAORI\nG1 X1 A3=0 B3=0 F5", 2, "length zero");
    refuses("TRAORI(2)", 1, "TRAORI with");
    let named = read("DEF REAL _FEED, _X\n_FEED=600. _X=5\nG1 X=_X F=_FEED\nM30\n");
    assert_eq!(moves(&named)[0].pace, Pace::PerMinute { speed: 10.0 });
    refuses("MSG(\"open", 1, "not closed");
    refuses("TOROT", 1, "not understood");
    refuses("G0 B10", 1, "machine's axes");
    refuses("G0 X1 X2", 1, "second X");
}

#[test]
fn polar_coordinates_count_from_their_pole() {
    let cases: [(&str, [f64; 3]); 6] = [
        ("G111 X40 Y50\nG0 RP=30 AP=60 Z3", [55.0, 50.0 + 30.0 * 0.75_f64.sqrt(), 3.0]),
        ("G111 X40 Y50\nRP=30 AP=60\nAP=IC(30)", [40.0, 80.0, 9.0]),
        ("G110 X1\nRP=30 AP=0", [38.0, 8.0, 9.0]),
        ("G111 X40 Y50\nG112 X1 Y2\nRP=10 AP=180", [31.0, 52.0, 9.0]),
        ("RP=10 AP=90", [0.0, 10.0, 9.0]),
        ("G700 G111 X1\nRP=1 AP=0", [50.8, 0.0, 9.0]),
    ];
    for (lines, expected) in cases {
        let program = read(&format!("G17 G90 G0 X7 Y8 Z9\n{lines}\nM30\n"));
        let found = *places(&program).last().unwrap();
        let off = found.iter().zip(expected).map(|(found, wanted)| (found - wanted).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{lines}: {found:?} is not {expected:?}");
    }
    let arc = read("G17 G0 X70 Y50 Z0\nG111 X40 Y50\nG3 RP=30 AP=90 F100\nM30\n");
    readings::arcs(&arc, &[([0, 1], [-30.0, 0.0], 0.5)]);
}

#[test]
fn sections_are_repeated_between_labels() {
    let ends = |lines: &str| -> Vec<f64> {
        let text = format!("G91 G0 X0\n{lines}\nM30\n");
        places(&read(&text)).iter().map(|[x, ..]| *x).skip(1).collect()
    };
    let is = |found: &[f64], expected: &[f64]| {
        let same = found.iter().zip(expected).all(|(x, at)| (x - at).abs() < 1e-12);
        assert!(same && found.len() == expected.len(), "{found:?}");
    };
    is(
        &ends("FIRST: X1\nLAST: X2\nX10\nREPEAT FIRST LAST P=2\nX100"),
        &[1.0, 3.0, 13.0, 14.0, 16.0, 17.0, 19.0, 119.0],
    );
    is(&ends("FIRST: X1\nX2\nREPEATB FIRST P=3\nX100"), &[1.0, 3.0, 4.0, 5.0, 6.0, 106.0]);
    is(
        &ends("FIRST: X1\nENDLABEL: X2\nX10\nREPEAT FIRST\nX100"),
        &[1.0, 3.0, 13.0, 14.0, 16.0, 116.0],
    );
    is(&ends("FIRST: X1\nX2\nREPEAT FIRST\nX100"), &[1.0, 3.0, 4.0, 6.0, 106.0]);
}

#[test]
fn what_the_control_alone_knows_is_refused_with_the_reason() {
    let cases = [
        ("$P_UIFR[1,X,TR]=5", "system variables", "offsets at the control"),
        ("$TC_DP3[1,1]=100", "system variables", "offsets at the control"),
        ("TRANSMIT", "TRANSMIT", "machine data"),
        ("G41 G1 X5 F100", "G41", "path of the tool centre"),
        ("G33 Z-5 K1", "G33", "CYCLE84"),
        ("G1 X5 F100 RND=2", "RND", "arc"),
        ("CIP X5 Y5 I1=3 J1=1", "CIP", "centre or radius"),
        ("R1=$AA_IW[X]", "a system variable", "write the value"),
        ("DIAMON", "DIAMON", "lathes"),
        ("SPOS=90", "SPOS", "spindle"),
        ("WHEN $AA_IW[X]>5 DO M8", "", ""),
        ("POCKET3(10,0,2,-5)", "POCKET3", "post their moves"),
        ("L100 P2", "L100", "put their lines here"),
        ("CONTOUR1", "CONTOUR1", "put their lines here"),
        ("RP=5", "alone", "both"),
        ("G91 AP=5 RP=3", "G91", "AC(..)"),
        ("X5 AP=5 RP=3", "beside axis words", "one of them"),
    ];
    for (line, part, help) in cases {
        let with = options(DIALECT, "XYZAC");
        let found = trunnion_nc::read::read(&format!("G0 X1 Y1 Z1\n{line}\nM30\n"), &with);
        let fault = found.unwrap_err()[0].clone();
        let said = fault.message.contains(part) && fault.help.contains(help);
        assert!(fault.line == 2 && fault.column > 0 && said, "{line}: {fault}");
        assert!(!fault.help.is_empty(), "{line}: {fault}");
    }
}

#[test]
fn words_of_posts_that_move_nothing_are_kept() {
    let text = "%_N_PART_MPF\n;$PATH=/_N_MPF_DIR\nPROC PART SAVE DISPLOF\nG26 S3000\nG25 X-10 Y-20\nS1=800 M1=3\n\
        FGREF[A]=10\nFGROUP(X,Y,Z,A,C)\nRTLION CDOF\nG0 X1\nRET\n";
    let program = read(text);
    assert_eq!(places(&program), [[1.0, 0.0, 0.0]]);
    assert!(program.steps.contains(&Step::Spindle { line: 6, speed: 800.0 }));
}

#[test]
fn frames_shift_turn_mirror_and_scale_words() {
    let half = 0.75_f64.sqrt();
    let cases: [(&str, [f64; 3]); 9] = [
        ("ROT Z30\nX10 Y4 Z1", [10.0 * half - 2.0, 5.0 + 4.0 * half, 1.0]),
        ("ROT RPL=30\nX10 Y4 Z1", [10.0 * half - 2.0, 5.0 + 4.0 * half, 1.0]),
        ("TRANS X100 Y50\nAROT Z90\nX10 Y4", [96.0, 60.0, 9.0]),
        // A shift behind a turn runs along the turned axes.
        ("ROT Z90\nATRANS X100 Y50\nX10 Y4", [-54.0, 110.0, 9.0]),
        ("MIRROR X0\nX10 Y4", [-10.0, 4.0, 9.0]),
        ("SCALE X2 Y2 Z3\nX10 Y4 Z1", [20.0, 8.0, 3.0]),
        // A single word moves both axes, from where they stand.
        ("ROT Z90\nX0 Y0\nX10", [0.0, 10.0, 9.0]),
        ("ROT Z90\nG91 X10\nG90", [7.0, 18.0, 9.0]),
        ("ROT Z90\nX10 Y4\nROT\nX10", [10.0, 10.0, 9.0]),
    ];
    for (lines, expected) in cases {
        let program = read(&format!("G17 G90 G0 X7 Y8 Z9\n{lines}\nM30\n"));
        let found = *places(&program).last().unwrap();
        let off = found.iter().zip(expected).map(|(found, wanted)| (found - wanted).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{lines}: {found:?} is not {expected:?}");
    }
    // A quarter about the origin, turned by 90 degrees; mirrored it runs clockwise.
    let turned = read("G0 X10 Y0 Z0\nF100\nROT Z90\nG1 X10 Y0\nG3 X0 Y10 I-10 J0\nM30\n");
    readings::arcs(&turned, &[([0, 1], [0.0, -10.0], 0.5)]);
    let mirrored = read("G0 X10 Y0 Z0\nF100\nMIRROR X0\nG1 X10 Y0\nG3 X0 Y10 I-10 J0\nM30\n");
    readings::arcs(&mirrored, &[([0, 1], [10.0, 0.0], -0.5)]);
    refuses("G0 X1 Y0 Z0\nSCALE X2\nF9\nG2 X4.5 Y0 I2 J0", 4, "stretch");
    refuses("G0 X1 Y0 Z0\nSCALE X0", 2, "above 0");
    refuses("ROT Z30\nG0 X1", 2, "not stated");
}

#[test]
fn feeds_are_inch_under_g700_alone_and_keep_their_unit() {
    let text =
        "G70 G0 X1 C0\nG1 X2 F600\nG700 X3\nX4 F60\nG71 X5\nG70 X6\nF600\nX7\nG700 C60 F6\nM30\n";
    let speeds: Vec<_> = moves(&read(text))
        .iter()
        .filter_map(|step| match step.pace {
            Pace::PerMinute { speed } => Some(speed),
            _ => None,
        })
        .collect();
    // 600 mm/min; 60 inch/min, which a later G71 or G70 leaves as it is; 6 degrees a minute.
    let inch = 60.0 * 25.4 / 60.0;
    let expected = [10.0, 10.0, inch, inch, inch, 10.0, 0.1];
    assert_eq!(speeds.len(), expected.len());
    for (found, expected) in speeds.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{speeds:?}");
    }
}

proptest! {
    #[test]
    fn shortest_ways_are_at_most_half_a_turn(from in -2000.0..2000.0_f64, to in 0.0..360.0_f64) {
        let program = read(&format!("G0 C{from:.6}\nC=DC({to:.6})\nM30\n"));
        let found: Vec<_> = moves(&program).iter().map(|m| m.words[4].unwrap()).collect();
        prop_assert!((found[1] - found[0]).abs() <= PI + 1e-9);
        let off = (found[1] - to.to_radians()).rem_euclid(TAU);
        prop_assert!(off.min(TAU - off) < 1e-7);
    }

    #[test]
    fn token_soup_ends_and_never_panics(
        tokens in prop::collection::vec(prop::sample::select(vec![
            "G0", "G1", "G2", "G3", "X1", "Y-2", "Z=R1", "R1=5", "R1=R1*2", "A3=1", "B3=", "C3=0", "TRAORI", "TRAFOOF", "C=DC(10)",
            "C=ACP(", ")", "(", "IC(1)", "X=IC(1)", "I1", "J=AC(2)", "CR=5", "TURN=1", "F100", "M3", "M30", "MSG(\"", "\"", ";", "\n",
            "\n", "SUPA", "G4", "TRANS", "T=\"A\"", "D1", "é", "%", "/", "G91", "G70", "--", "=", "==", "N1", "CYCLE832(1,2)",
            "ROT", "Z30", "MIRROR", "SCALE", "AROT", "ATRANS", "MCALL", "CYCLE81(20,0,2,-5)", "CYCLE86(20,0,2,-5,,0,3,1)", "G18", "G19",
            "CYCLE83(20,0,2,-30,,,5,-0.5,0,0,1,0)", "CYCLE84(20,0,2,-5,,0,3,8)", "HOLES1(0,0,5,0,1,3)", "HOLES2(0,0,5,0,0,3)", "G111", "G110",
            "AP=IC(30)", "RP=5", "REPEATB AA", "AA:", "REPEAT AA BB", "BB:", "CYCLE800(0,\"T\",0,57,0,0,0,0,30)", "FGREF[A]=1", "$P=1", "X[1]=",
        ]), 0..60),
    ) {
        let _ = trunnion_nc::read::read(&tokens.join(" "), &options(DIALECT, "XYZAC"));
    }
}
