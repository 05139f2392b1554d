//! Jumps, loops and calls of Sinumerik, Klartext and Fanuc programs against the same written out in Rust.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::readings;

use proptest::prelude::*;
use readings::{options, places};
use trunnion_nc::read::{Dialect, ReadOptions};

fn run(dialect: Dialect, text: &str) -> Vec<[f64; 3]> {
    places(&readings::read(text, &options(dialect, "XYZAC")))
}

fn xs(dialect: Dialect, text: &str) -> Vec<f64> {
    run(dialect, text).into_iter().map(|[x, ..]| x).collect()
}

/// The first fault has a line and says a part.
fn refuses(dialect: Dialect, text: &str, line: u32, part: &str) {
    let few = ReadOptions { most_repeated: 1000, ..options(dialect, "XYZAC") };
    let found = trunnion_nc::read::read(text, &few).unwrap_err();
    let all: Vec<_> = found.iter().map(ToString::to_string).collect();
    assert!(found[0].line == line && all[0].contains(part), "{text:?}: {all:?}");
}

#[test]
fn sinumerik_jumps_to_labels_and_block_numbers() {
    let siemens = |text: &str| xs(Dialect::Siemens, text);
    let back = "R1=0\nN10 LOOP1: R1=R1+1\nG0 X=R1\nIF R1<3 GOTOB LOOP1\nX9\nM30\n";
    assert_eq!(siemens(back), [1.0, 2.0, 3.0, 9.0]);
    let numbers =
        "N5 R1=0\nN10 R1=R1+1\nN20 G0 X=R1\nN30 IF (R1<3) AND NOT (R1==2) GOTOB N10\nN40 M30\n";
    assert_eq!(siemens(numbers), [1.0, 2.0]);
    assert_eq!(siemens("G0 X1\nGOTOF ENDE ; past the next\nX2\nENDE: X3\nM30\n"), [1.0, 3.0]);
    assert_eq!(siemens("R1=1\nIF R1==1 GOTOF A1B\nG0 X5\nA1B:\nG0 X6\nM30\n"), [6.0]);
    // A jump out of the inner loop leaves it, and the outer goes on.
    let out = "R1=0\nWHILE R1<2\nR1=R1+1\nR2=0\nLOOP\nR2=R2+1\nG0 X=10*R1+R2\nIF R2==2 GOTOF OUT\nENDLOOP\nOUT: X=-R1\nENDWHILE\nM30\n";
    assert_eq!(siemens(out), [11.0, 12.0, -1.0, 21.0, 22.0, -2.0]);
}

#[test]
fn sinumerik_structures_nest() {
    let siemens = |text: &str| xs(Dialect::Siemens, text);
    let branches = "FOR R1=1 TO 4\nIF R1==2\nG0 X20\nELSE\nIF R1>3\nG0 X40\nELSE\nG0 X=R1\nENDIF\nENDIF\nENDFOR\nM30\n";
    assert_eq!(siemens(branches), [1.0, 20.0, 3.0, 40.0]);
    assert_eq!(siemens("FOR R1=3 TO 2\nG0 X1\nENDFOR\nG0 X7\nM30\n"), [7.0]);
    assert_eq!(siemens("R1=5\nREPEAT\nG0 X=R1\nR1=R1-2\nUNTIL R1<0\nM30\n"), [5.0, 3.0, 1.0]);
    assert_eq!(
        siemens("R1=0\nPART: R1=R1+1\nG0 X=R1\nREPEAT PART P=2\nX0\nM30\n"),
        [1.0, 2.0, 3.0, 0.0]
    );
    assert_eq!(siemens("DEF REAL STEP = 2.5, AT\nAT=2*STEP\nG0 X=AT\nM30\n"), [5.0]);
}

#[test]
fn klartext_calls_labels() {
    let klartext = |text: &str| xs(Dialect::Heidenhain, text);
    let sub = "0 BEGIN PGM A MM\n1 CALL LBL 1\n2 L X+5 FMAX\n3 CALL LBL \"TWO\"\n4 L X+6 FMAX M30\n\
               5 LBL 1\n6 L X+1 FMAX\n7 CALL LBL \"TWO\"\n8 LBL 0\n9 LBL \"TWO\"\n10 L X+2 FMAX\n11 LBL 0\n12 END PGM A MM\n";
    assert_eq!(klartext(sub), [1.0, 2.0, 5.0, 2.0, 6.0]);
    let nested = "0 BEGIN PGM A MM\n1 L X+0 FMAX\n2 LBL 1\n3 L IX+1 FMAX\n4 LBL 2\n5 L IX+10 FMAX\n6 CALL LBL 2 REP 1\n\
                  7 CALL LBL 1 REP2\n8 END PGM A MM\n";
    let mut expected = vec![0.0];
    for _ in 0..3 {
        for step in [1.0, 10.0, 10.0] {
            expected.push(expected[expected.len() - 1] + step);
        }
    }
    assert_eq!(klartext(nested), expected);
    let conditions = "0 BEGIN PGM A MM\n1 FN 0: Q1 = +0\n2 LBL 5\n3 FN 1: Q1 = +Q1 + +1\n4 L X+Q1 FMAX\n\
                      5 FN 12: IF +Q1 LT +3 GOTO LBL 5\n6 FN 9: IF +Q1 EQU +3 GOTO LBL 6\n7 L X+99 FMAX\n8 LBL 6\n\
                      9 Q2 = SQRT 16 * SIN 30\n10 L X+Q2 FMAX\n11 END PGM A MM\n";
    let found = klartext(conditions);
    assert_eq!(found[..3], [1.0, 2.0, 3.0]);
    assert!((found[3] - 2.0).abs() < 1e-12);
}

#[test]
fn fanuc_macros_loop_and_jump() {
    let fanuc = |text: &str| xs(Dialect::Fanuc, text);
    let back = "O1\n#1=0\nN10 #1=#1+1\nG0 X#1\nIF [#1 LT 3] GOTO 10\nIF [#1 EQ 3] THEN #2=7\nX#2\nGOTO 20\nX8.\nN20 X9.\nM30\n";
    assert_eq!(fanuc(back), [1.0, 2.0, 3.0, 7.0, 9.0]);
    let loops = "O1\n#1=1\nWHILE [#1 LE 2] DO 1\n#2=1\nWHILE [#2 LE 2] DO 2\nG0 X[10*#1+#2]\n#2=#2+1\nEND 2\n#1=#1+1\nEND 1\nM30\n";
    assert_eq!(fanuc(loops), [11.0, 12.0, 21.0, 22.0]);
    let call = "O1\n#1=5\nG65 P100 A1. X2.\nG0 X#1\nM30\nO100\nG0 X[#1+#24]\n#3=0\nN1 #3=#3+1\nX[#3*100]\nIF [#3 LT 2] GOTO 1\nM99\n";
    assert_eq!(fanuc(call), [3.0, 100.0, 200.0, 5.0]);
    let modal = "O1\nG66 P100 A5.\nG0 X1.\nX2.\nG67\nX3.\nM30\nO100\nX[#1*10]\nX[#1*20]\nM99\n";
    assert_eq!(fanuc(modal), [1.0, 50.0, 100.0, 2.0, 50.0, 100.0, 3.0]);
    let past = "O1\nM98 P100\nG0 X8.\nN20 X9.\nM30\nO100\nG0 X1.\nM99 P20\n";
    assert_eq!(fanuc(past), [1.0, 9.0]);
    let back = "O1\n#1=0\nN10 #1=#1+1\nIF [#1 GT 2] GOTO 30\nM98 P100\nN30 G0 X9.\nM30\nO100\nG0 X#1\nM99 P10\n";
    assert_eq!(fanuc(back), [1.0, 2.0, 9.0]);
}

#[test]
fn what_cannot_be_followed_is_reported_with_its_line() {
    let siemens = |text: &str, line, part: &str| refuses(Dialect::Siemens, text, line, part);
    siemens("R1=1\nGOTOF NOWHERE\nG0 X1\nM30\n", 2, "NOWHERE does not stand behind");
    siemens("G0 X1\nGOTOB ABC\nM30\n", 2, "ABC does not stand before");
    siemens("WHILE 1\nG0 X1\n", 0, "no end");
    siemens("R1=2\nIF R1==1\nG0 X1\nM30\n", 2, "IF has no end");
    siemens("ENDWHILE\nM30\n", 1, "nothing was begun");
    siemens("LOOP\nR1=1\nENDLOOP\nM30\n", 3, "more than 1000 lines");
    siemens("L1A: G0 X1\nGOTOB L1A\nM30\n", 2, "more than 1000 lines");
    siemens("GOTOF R1\nM30\n", 1, "does not stand behind");
    siemens("GOTOF \"A\"<<R1\nM30\n", 1, "no label");
    let klartext = |text: &str, line, part: &str| refuses(Dialect::Heidenhain, text, line, part);
    klartext("CALL LBL 9\nEND PGM A MM\n", 1, "LBL 9 is not in the file");
    klartext("LBL 1\nCALL LBL 1\nEND PGM A MM\n", 2, "calls in each other");
    klartext("CALL PGM TNC:\\A.H\nEND PGM A MM\n", 1, "not understood");
    klartext("LBL 1\nL IX+1 FMAX\nCALL LBL 1 REP 60000\nEND PGM A MM\n", 1, "more than 1000 lines");
    klartext("FN 9: IF +1 GT +2 GOTO LBL 1\nEND PGM A MM\n", 1, "EQU");
    let fanuc = |text: &str, line, part: &str| refuses(Dialect::Fanuc, text, line, part);
    fanuc("O1\n#1=1\nN5 GOTO 5\nM30\n", 3, "more than 1000 lines");
    fanuc("O1\nGOTO 50\nG0 X1.\nM30\n", 2, "N50 is not in the file");
    fanuc("O1\nEND 1\nM30\n", 2, "nothing was begun");
    fanuc("O1\nWHILE [0] DO 1\nG0 X1.\nM30\n", 2, "DO 1 has no END 1");
    fanuc("O1\nG66 P7\nG0 X1.\nM30\n", 3, "subprogram 7");
    fanuc("O1\nG66 A1.\nM30\n", 2, "without a program");
    fanuc("O1\n#1=1\nN5 M99 P5\nM30\n", 3, "more than 1000 lines");
    fanuc("O1\n#3000=1(CHECK TOOL)\nM30\n", 2, "alarm");
}

proptest! {
    #![proptest_config(property::cases(64))]

    #[test]
    fn nested_loops_are_the_same_in_every_language(outer in 1..6_u32, inner in 0..6_u32, skip in 1..6_u32) {
        let mut expected = Vec::new();
        for a in 1..=outer {
            for b in 1..=inner {
                if b != skip {
                    expected.push(f64::from(10 * a + b));
                }
            }
        }
        expected.push(-1.0);
        let siemens = format!(
            "FOR R1=1 TO {outer}\nR2=1\nWHILE R2<={inner}\nIF R2<>{skip}\nG0 X=10*R1+R2\nENDIF\nR2=R2+1\nENDWHILE\nENDFOR\nG0 X-1\nM30\n"
        );
        prop_assert_eq!(&xs(Dialect::Siemens, &siemens), &expected);
        let fanuc = format!(
            "O1\n#1=1\nWHILE [#1 LE {outer}] DO 1\n#2=1\nWHILE [#2 LE {inner}] DO 2\nIF [#2 EQ {skip}] GOTO 7\nG0 X[10*#1+#2]\n\
             N7 #2=#2+1\nEND 2\n#1=#1+1\nEND 1\nG0 X-1.\nM30\n"
        );
        prop_assert_eq!(&xs(Dialect::Fanuc, &fanuc), &expected);
        let klartext = format!(
            "0 BEGIN PGM A MM\nQ1 = 1\nLBL 1\nQ2 = 1\nLBL 2\nFN 11: IF +Q2 GT +{inner} GOTO LBL 4\nFN 9: IF +Q2 EQU +{skip} GOTO LBL 3\n\
             Q3 = 10 * Q1 + Q2\nL X+Q3 FMAX\nLBL 3\nQ2 = Q2 + 1\nFN 10: IF +1 NE +0 GOTO LBL 2\nLBL 4\nQ1 = Q1 + 1\n\
             FN 12: IF +Q1 LT +{} GOTO LBL 1\nL X-1 FMAX\nEND PGM A MM\n",
            outer + 1
        );
        prop_assert_eq!(&xs(Dialect::Heidenhain, &klartext), &expected);
    }

    #[test]
    fn token_soup_ends_and_never_panics(
        tokens in prop::collection::vec(prop::sample::select(vec![
            "IF", "R1<5", "GOTOF", "GOTOB", "GOTO", "ABC", "ABC:", "N10", "WHILE", "ENDWHILE", "FOR", "R1=1", "TO", "3", "ENDFOR", "LOOP",
            "ENDLOOP", "REPEAT", "UNTIL", "P=2", "ELSE", "ENDIF", "DEF", "REAL", "G0", "X1", "M30", "LBL", "1", "0", "\"A\"", "CALL", "REP",
            "FN 9:", "+Q1", "EQU", "Q1 = 5", "L", "X+Q1", "FMAX", "[#1", "LT", "3]", "THEN", "#1=1", "#1=#1+1", "DO", "END", "G65", "P5", "O5",
            "M99", "M98", "AND", "NOT", "(", ")", "==", "~", "é", "\n", "\n", "\n", "\n", "\n",
        ]), 0..80),
    ) {
        let text = tokens.join(" ");
        for dialect in [Dialect::Siemens, Dialect::Heidenhain, Dialect::Fanuc, Dialect::Haas] {
            let options = ReadOptions { most_repeated: 500, most_faults: 5, ..options(dialect, "XYZAC") };
            let _ = trunnion_nc::read::read(&text, &options);
        }
    }
}
