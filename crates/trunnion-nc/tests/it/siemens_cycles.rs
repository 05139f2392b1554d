//! Drilling cycles of Sinumerik against heights and places reckoned by hand.

use crate::readings;

use readings::{moves, options, places};
use std::f64::consts::TAU;
use trunnion_nc::read::{Dialect, Pace, Program, Step};

fn read(text: &str) -> Program {
    readings::read(text, &options(Dialect::Siemens, "XYZAC"))
}

/// Z of every move, and its speed \[mm/min\]; 0: rapid.
fn heights(text: &str) -> Vec<(f64, f64)> {
    let program = read(text);
    let paces = moves(&program).into_iter().map(|step| match step.pace {
        Pace::PerMinute { speed } => 60.0 * speed,
        _ => 0.0,
    });
    places(&program).iter().map(|[.., z]| *z).zip(paces).collect()
}

fn are(found: &[(f64, f64)], expected: &[(f64, f64)], name: &str) {
    assert_eq!(found.len(), expected.len(), "{name}: {found:?}");
    for (found, expected) in found.iter().zip(expected) {
        let off = (found.0 - expected.0).abs().max((found.1 - expected.1).abs());
        assert!(off < 1e-9, "{name}: {found:?} is not {expected:?}");
    }
}

/// Heights of a cycle at one hole, behind `G0 X5 Y6 Z50`.
fn hole(call: &str) -> Vec<(f64, f64)> {
    let made = heights(&format!("G17 G90 G0 X5 Y6 Z50\nS500 M3 F100\n{call}\nM30\n"));
    made[1..].to_vec()
}

#[test]
fn a_modal_cycle_drills_behind_every_block_that_moves() {
    let text = "G17 G90\nG0 X0 Y0 Z50\nF100 S500 M3\nMCALL CYCLE82(30,2,3,-15,,0.5)\nX10 Y20\nY30\nMSG(\"no move\")\nMCALL\nX99\nM30\n";
    let program = read(text);
    let expected = [
        [0.0, 0.0, 50.0],
        [10.0, 20.0, 50.0],
        [10.0, 20.0, 5.0],
        [10.0, 20.0, -15.0],
        [10.0, 20.0, 30.0],
        [10.0, 30.0, 30.0],
        [10.0, 30.0, 5.0],
        [10.0, 30.0, -15.0],
        [10.0, 30.0, 30.0],
        [99.0, 30.0, 30.0],
    ];
    assert_eq!(places(&program), expected);
    let dwells: Vec<_> = program
        .steps
        .iter()
        .filter_map(|step| match step {
            Step::Dwell { line, seconds } => Some((*line, *seconds)),
            _ => None,
        })
        .collect();
    assert_eq!(dwells, [(5, 0.5), (6, 0.5)]);
}

#[test]
fn each_cycle_has_its_heights_and_feeds() {
    let cases: [(&str, &[(f64, f64)]); 8] = [
        ("CYCLE81(20,0,2,-10)", &[(2.0, 0.0), (-10.0, 100.0), (20.0, 0.0)]),
        ("CYCLE81(20,1,2,,10)", &[(3.0, 0.0), (-9.0, 100.0), (20.0, 0.0)]),
        ("CYCLE81(20,0,2,-10,0)", &[(2.0, 0.0), (-10.0, 100.0), (20.0, 0.0)]),
        ("CYCLE85(20,0,2,-10,,0,80,120)", &[(2.0, 0.0), (-10.0, 80.0), (2.0, 120.0), (20.0, 0.0)]),
        ("CYCLE89(20,0,2,-10)", &[(2.0, 0.0), (-10.0, 100.0), (2.0, 100.0), (20.0, 0.0)]),
        // 400 turns a minute of 1.25 mm in, twice as many out.
        (
            "CYCLE84(20,0,2,-10,,0,3,,1.25,0,400,800)",
            &[(2.0, 0.0), (-10.0, 500.0), (2.0, 1000.0), (20.0, 0.0)],
        ),
        // M8 has a pitch of 1.25 mm.
        (
            "CYCLE840(20,0,2,-10,,0,4,3,1,8)",
            &[(2.0, 0.0), (-10.0, 625.0), (2.0, 625.0), (20.0, 0.0)],
        ),
        (
            "CYCLE86(20,0,2,-10,,1,3,-0.5,0,0.2,0)",
            &[(2.0, 0.0), (-10.0, 100.0), (-9.8, 0.0), (2.0, 0.0), (20.0, 0.0)],
        ),
    ];
    for (call, expected) in cases {
        are(&hole(call), expected, call);
    }
    let bored = read("G0 X5 Y6 Z50\nS500 M3 F100\nCYCLE86(20,0,2,-10,,1,3,-0.5,0,0.2,0)\nM30\n");
    let ends = places(&bored);
    for (at, expected) in [(3, [4.5, 6.0, -9.8]), (5, [5.0, 6.0, 20.0])] {
        let off = ends[at].iter().zip(expected).map(|(found, wanted)| (found - wanted).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{ends:?}");
    }
}

#[test]
fn deep_holes_are_drilled_in_strokes() {
    // 20 mm deep, first 6 mm, then 2 mm less each: 6, 4, 2, 2, 2, 2, and the last two equal: 1 and 1.
    let shrinking = hole("CYCLE83(30,0,1,-20,,,6,2,0,0,1,0)");
    let depths: Vec<_> = shrinking.iter().filter(|(z, _)| *z < 0.0).map(|(z, _)| *z).collect();
    let expected =
        [-6.0, -5.0, -10.0, -9.0, -12.0, -11.0, -14.0, -13.0, -16.0, -15.0, -18.0, -17.0, -20.0];
    assert_eq!(depths, expected);
    // Out to clear the chips: back down to 0.6 mm above the last depth; the first stroke at half the feed.
    let clearing = hole("CYCLE83(30,0,1,-12,,-5,,0,0,0,0.5,1)");
    let expected = [
        (1.0, 0.0),
        (-5.0, 50.0),
        (1.0, 0.0),
        (-4.4, 0.0),
        (-10.0, 100.0),
        (1.0, 0.0),
        (-9.4, 0.0),
        (-12.0, 100.0),
        (30.0, 0.0),
    ];
    are(&clearing, &expected, "clearing");
    // A remainder between one and two shortest strokes is halved: 4, 2, then 1.5 and 1.5.
    let halved = hole("CYCLE83(30,0,1,-9,,,4,2,0,0,1,1)");
    let cuts: Vec<_> = halved.iter().filter(|(_, feed)| *feed > 0.0).map(|(z, _)| *z).collect();
    assert_eq!(cuts, [-4.0, -6.0, -7.5, -9.0]);
    // Deeper than 30 mm: a fiftieth of the depth.
    let deep = hole("CYCLE83(30,0,1,-100,,,50,0,0,0,1,1)");
    assert!(deep.iter().any(|(z, feed)| (z + 48.0).abs() < 1e-9 && *feed <= 0.0), "{deep:?}");
}

#[test]
fn patterns_lie_on_rows_and_circles() {
    let head = "G17 G90 G0 X0 Y0 Z50\nF100 S500 M3\nMCALL CYCLE81(20,0,2,-10)\n";
    let bottoms = |call: &str| -> Vec<[f64; 2]> {
        let program = read(&format!("{head}{call}\nMCALL\nM30\n"));
        let all = places(&program);
        all.iter().filter(|[.., z]| *z < 0.0).map(|[x, y, _]| [*x, *y]).collect()
    };
    let near = |found: &[[f64; 2]], expected: &[[f64; 2]]| {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-9, "{found:?}");
        }
    };
    let row = [0.0, 1.0, 2.0].map(|k: f64| {
        let along = 5.0 + 10.0 * k;
        [10.0 + along * 0.5, 20.0 + along * 0.75_f64.sqrt()]
    });
    near(&bottoms("HOLES1(10,20,60,5,10,3)"), &row);
    // From the other end, where that is nearer.
    let back = bottoms("G0 X100 Y200\nHOLES1(10,20,60,5,10,3)");
    near(&back[1..], &[row[2], row[1], row[0]]);
    let circle: Vec<_> = (0..6)
        .map(|k| {
            let (sin, cos) = (TAU / 12.0 + f64::from(k) * TAU / 6.0).sin_cos();
            [7.0 + 30.0 * cos, -3.0 + 30.0 * sin]
        })
        .collect();
    near(&bottoms("HOLES2(7,-3,30,30,0,6)"), &circle);
    near(&bottoms("HOLES2(7,-3,30,30,60,2)"), &circle[..2]);
}

#[test]
fn what_a_cycle_does_not_say_is_refused() {
    let cases = [
        ("CYCLE81(20,0,2)", "without a depth"),
        ("CYCLE81(20,0,2,10)", "bottom 10 mm"),
        ("CYCLE81(1,0,2,-10)", "retraction plane 1 mm"),
        ("CYCLE83(20,0,2,-10)", "without FDEP"),
        ("CYCLE83(20,0,2,-10,,,5,-0.1,0,0,1,1)", "too short"),
        ("CYCLE84(20,0,2,-10)", "without a pitch"),
        ("CYCLE84(20,0,2,-10,,0,3,7)", "no coarse thread"),
        ("CYCLE82(20,0,2,-10,,0,10,1,12)", "_GMODE"),
        ("CYCLE82(20,0,2,-10,,0,0,2,12)", "_DMODE"),
        ("HOLES1(0,0,0,0,10,3)", "without a modal cycle"),
        ("MCALL L100", "not understood"),
    ];
    for (call, part) in cases {
        let with = options(Dialect::Siemens, "XYZAC");
        let text = format!("G17 G90 G0 X5 Y6 Z50\nS500 M3 F100\n{call}\nM30\n");
        match trunnion_nc::read::read(&text, &with) {
            Err(found) => {
                let said = found[0].to_string();
                assert!(found[0].line == 3 && said.contains(part), "{call}: {said}");
                assert!(!found[0].help.is_empty(), "{call}");
            }
            Ok(_) => panic!("{call} is read"),
        }
    }
}

#[test]
fn the_table_of_the_book_is_true() {
    let rows = readings::rows_of_the_book("siemens.md");
    assert!(rows.len() > 55, "{} rows", rows.len());
    let before = "G17 G90 G71 F100 S500 M3\nT1 D1\nM6\nG0 X10 Y10 Z10\n";
    let with = options(Dialect::Siemens, "XYZAC");
    let program = readings::ExampleProgram { before, behind: "\nM30\n", options: with };
    for row in rows {
        program.holds(&row);
    }
}
