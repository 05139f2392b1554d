//! Klartext against hand-reckoned cases.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::readings;

use proptest::prelude::*;
use readings::{moves, options, places};
use std::f64::consts::TAU;
use trunnion_nc::read::{Dialect, Frame, Pace, Program, ReadOptions, Step, Turning};

const DIALECT: Dialect = Dialect::Heidenhain;

fn whole(text: &str) -> String {
    format!("0 BEGIN PGM T MM\n{text}\nEND PGM T MM\n")
}

fn read(text: &str) -> Program {
    readings::read(&whole(text), &options(DIALECT, "XYZAC"))
}

fn refuses(text: &str, line: u32, part: &str) {
    let with = options(DIALECT, "XYZAC");
    let found = trunnion_nc::read::read(&whole(text), &with).unwrap_err();
    let all: Vec<_> = found.iter().map(ToString::to_string).collect();
    assert!(found[0].line == line + 1 && all[0].contains(part), "{text:?}: {all:?}");
}

#[test]
fn the_worked_cut() {
    let text = readings::fixture("heidenhain.h");
    assert_eq!(Dialect::guess(text.lines()), DIALECT);
    let program = readings::read(&text, &options(DIALECT, "XYZAC"));
    readings::is_the_worked_cut(&program, 2e-7);
    let found = moves(&program);
    assert_eq!(found[0].pace, Pace::Rapid);
    assert_eq!(found[1].turning, Turning::GreatCircle);
    assert_eq!(found[2].pace, Pace::PerMinute { speed: 800.0 / 60.0 });
    assert_eq!((found[4].frame, found[4].words[2]), (Frame::Machine, Some(0.0)));
    assert_eq!(program.tools, [1]);
    let spindle =
        program.steps.iter().any(|step| matches!(step, Step::Spindle { speed: 8000.0, .. }));
    assert!(spindle);
}

#[test]
fn words_are_absolute_or_not_each_by_itself() {
    let program = read(
        "L X+1,5 Y+2 Z+3 FMAX\nL IX+1 Y-2 F500\nL IX+1 IZ-1\n12 L IY+1 ; and so on\nL X+0 ~\n  Y+9",
    );
    let expected =
        [[1.5, 2.0, 3.0], [2.5, -2.0, 3.0], [3.5, -2.0, 2.0], [3.5, -1.0, 2.0], [0.0, 9.0, 2.0]];
    assert_eq!(places(&program), expected);
    let pace: Vec<_> = moves(&program).iter().map(|m| m.pace == Pace::Rapid).collect();
    assert_eq!(pace, [true, false, false, false, false]);
}

#[test]
fn parameters_are_reckoned_with() {
    let program = read(
        "Q1 = +5\nFN 0: Q2 = -2,5\nFN 3: Q3 = +Q1 * +Q2\nFN 4: Q4 = +Q1 DIV +2\nL X+Q1 Y-Q2 Z+Q3 FMAX\nL X+Q4 F Q1",
    );
    assert_eq!(places(&program), [[5.0, 2.5, -12.5], [2.5, 2.5, -12.5]]);
    assert_eq!(moves(&program)[1].pace, Pace::PerMinute { speed: 5.0 / 60.0 });
    refuses("L X+Q9 FMAX", 1, "no value");
    refuses("FN 14: ERROR = 1000", 1, "not understood");
}

#[test]
fn circles_about_poles() {
    let program = read(
        "L X+10 Y+0 Z+0 FMAX\nCC X+0 Y+0\nC X+0 Y+10 DR+ F600\nCR X+10 Y+0 R+10 DR-\nCR X+0 Y-10 R-10 DR+\nC X+0 Y-10 DR-\n\
         CP IPA+720 DR+ IZ-5\nLP PR+20 PA+90\nCC IX+0 IY-20\nCP PA+0 DR-",
    );
    let expected = [
        ([0, 1], [-10.0, 0.0], 0.5),
        ([0, 1], [0.0, -10.0], -0.5),
        ([0, 1], [-10.0, 0.0], 1.5),
        ([0, 1], [0.0, 10.0], -2.0),
        ([0, 1], [0.0, 10.0], 4.0),
        ([0, 1], [0.0, -20.0], -0.5),
    ];
    assert_eq!(readings::arcs(&program, &expected).len(), expected.len());
    let ends = places(&program);
    let near = |at: usize, place: [f64; 3]| {
        let off = (0..3).map(|k| (ends[at][k] - place[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{:?} is not {place:?}", ends[at]);
    };
    near(5, [0.0, -10.0, -5.0]);
    near(6, [0.0, 20.0, -5.0]);
    near(7, [20.0, 0.0, -5.0]);
    refuses("L X+0 Y+0 FMAX\nC X+1 Y+1 DR+ F5", 2, "pole");
    refuses("L X+0 Y+0 FMAX\nCC X+1 Y+0\nC X+2 Y+0 F5", 3, "DR+ or DR-");
}

#[test]
fn tcpm_shifts_and_shortest_ways() {
    let program = read(
        "L C+350 FMAX\nL M126\nL C+10\nL M127\nL X+1 Y+1 Z+1 M128 F500\nL X+2\nL M129\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+5\nL X+1\n\
         CYCL DEF 247 DATUM SETTING ~\n Q339=+2 ; DATUM NUMBER\nL X+1\nCYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL 1.5"
            .replace("L C+10\n", "L C+10 F100\n")
            .as_str(),
    );
    let found = moves(&program);
    assert!((found[1].words[4].unwrap().to_degrees() - 370.0).abs() < 1e-9);
    assert!(matches!(found[2].frame, Frame::Work { tcp: true, .. }));
    assert_eq!(found[4].words[0], Some(6.0));
    assert_eq!(
        (found[5].frame, found[5].words[0]),
        (Frame::Work { offset: 1, length: true, tcp: false }, Some(1.0))
    );
    assert!(program.steps.iter().any(|step| matches!(step, Step::Dwell { seconds: 1.5, .. })));
}

#[test]
fn what_changes_motion_is_refused() {
    refuses("L X+1 RL FMAX", 1, "compensation");
    refuses("L X+1 M140 MB MAX", 1, "M140");
    refuses("PLANE AXIAL B+30 TURN", 1, "PLANE");
    refuses("CALL LBL 1 REP3", 1, "LBL 1 is not in the file");
    refuses("CYCL DEF 200 DRILLING Q200=2", 1, "without Q206");
    refuses("CYCL DEF 208 BORE MILLING Q200=2", 1, "not understood");
    refuses("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+30", 2, "rotation");
    refuses("L M99", 1, "without a drilling cycle");
    refuses("L M89", 1, "M89");
    refuses("CYCL CALL PAT FMAX", 1, "PAT");
    refuses("L C+30 FMAX\nL M140 MB MAX", 2, "turned tool");
    refuses("TOOL CALL 1 Z S1 DL+0.5", 1, "oversize");
    refuses("FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL A+5 FMAX", 2, "AXIS SPAT");
    refuses("LN X+1 Y+1 Z+1 TX+0 TY+0 TZ+1 FMAX", 1, "without TCPM");
    refuses("L X+1", 1, "without a feed");
    refuses("L B+1 FMAX", 1, "machine's axes");
    let cut = trunnion_nc::read::read("0 BEGIN PGM T MM\nL X+1 FMAX\n", &options(DIALECT, "XYZAC"));
    assert!(cut.unwrap_err()[0].message.contains("no end"));
}

/// Heights of the moves, and true for those in rapid.
fn heights(program: &Program) -> Vec<(f64, bool)> {
    let z = |found: trunnion_nc::read::Move| Some((found.words[2]?, found.pace == Pace::Rapid));
    moves(program).into_iter().filter_map(z).collect()
}

fn near_heights(text: &str, expected: &[(f64, bool)]) {
    let found = heights(&read(text));
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (one, other) in found.iter().zip(expected) {
        assert!((one.0 - other.0).abs() < 1e-9 && one.1 == other.1, "{found:?}");
    }
}

const RAPID: bool = true;
const FEED: bool = false;

#[test]
fn values_may_stand_apart_from_their_letters() {
    let program = read(
        "L  X + 10 Y 5 Z- 2.500 F MAX\nTOOL DEF1 L+30,000\nTOOL CALL 1 Z S 1500,000\nL Z 25.000 F 300 M 3",
    );
    assert_eq!(places(&program), [[10.0, 5.0, -2.5], [10.0, 5.0, 25.0]]);
    assert!(program.steps.iter().any(|step| matches!(step, Step::Spindle { speed: 1500.0, .. })));
    // Half of the last digit written: Z has three.
    assert!((program.rounding[2] - 0.0005).abs() < 1e-12);
}

/// The order of cycle 200 in the cycle manual: clearance, infeed, clearance, clearance above the last depth, infeed ..,
/// second clearance.
#[test]
fn cycle_200_pecks_and_leaves_for_the_second_clearance() {
    near_heights(
        "L X+1 Y+1 Z+50 FMAX\nCYCL DEF 200 DRILLING ~\n Q200=+2    ;SET-UP CLEARANCE ~\n Q201=-7 ;DEPTH ~\n Q206=+30 ;FEED ~\n\
         Q202=+5 ;INFEED ~\n Q210=+0 ;DWELL ~\n Q203=+1 ;SURFACE ~\n Q204=+11 ;2ND ~\n Q211=+0 ;DWELL\nL X+5 FMAX M99\nCYCL CALL M8",
        &[
            (50.0, RAPID),
            (3.0, RAPID),
            (-4.0, FEED),
            (3.0, RAPID),
            (-2.0, RAPID),
            (-6.0, FEED),
            (12.0, RAPID),
            (3.0, RAPID),
            (-4.0, FEED),
            (3.0, RAPID),
            (-2.0, RAPID),
            (-6.0, FEED),
            (12.0, RAPID),
        ],
    );
    let program = read(
        "L Z+50 FMAX\nCYCL DEF 200 Q200=2 Q201=-7 Q206=30 Q202=7 Q203=0 Q204=5 Q211=1.5\nL X+5 FMAX M99",
    );
    assert_eq!(moves(&program)[3].pace, Pace::PerMinute { speed: 0.5 });
    assert!(program.steps.iter().any(|step| matches!(step, Step::Dwell { seconds: 1.5, .. })));
}

#[test]
fn cycle_1_pecks_from_where_the_tool_stands() {
    // The surface is the set-up clearance below the start; 0.6 mm above the last depth the feed begins again.
    near_heights(
        "CYCLE DEF 1.0 PECKING\nCYCL DEF 1.1 SETUP 2\nCYCL DEF 1.2 DEPTH -8\nCYCL DEF 1.3 PECKG +5\nCYCL DEF 1.4 DWELL 0\nCYCL DEF 1.5 F100\n\
         L X+50 Y+86 Z+2 FMAX M99",
        &[(2.0, RAPID), (-5.0, FEED), (2.0, RAPID), (-4.4, RAPID), (-8.0, FEED), (2.0, RAPID)],
    );
}

#[test]
fn cycles_201_and_203_come_out_with_their_feed() {
    near_heights(
        "L Z+50 FMAX\nCYCL DEF 201 REAMING ~\nQ200=2 ~\nQ201=-10 ~\nQ206=100 ~\nQ211=0 ~\nQ208=0 ~\nQ203=0 ~\nQ204=20\nL X+1 FMAX M99",
        &[(50.0, RAPID), (2.0, RAPID), (-10.0, FEED), (2.0, FEED), (20.0, RAPID)],
    );
    // One chip break, then out of the hole.
    near_heights(
        "L Z+50 FMAX\nCYCL DEF 203 UNIVERSAL DRILLING ~\nQ200=2 ~\nQ201=-10 ~\nQ206=100 ~\nQ202=4 ~\nQ210=0 ~\nQ203=0 ~\nQ204=20 ~\nQ212=0 ~\n\
         Q213=1 ~\nQ205=4 ~\nQ211=0 ~\nQ208= MAX ~\nQ256=0.2\nL X+1 FMAX M99",
        &[
            (50.0, RAPID),
            (2.0, RAPID),
            (-4.0, FEED),
            (-3.8, RAPID),
            (-8.0, FEED),
            (2.0, RAPID),
            (-7.8, RAPID),
            (-10.0, FEED),
            (20.0, RAPID),
        ],
    );
}

#[test]
fn tapping_follows_pitch_and_speed() {
    let program = read(
        "TOOL CALL 1 Z S500\nL Z+50 FMAX M3\nCYCL DEF 207 RIGID TAPPING NEW ~\nQ200=2 ~\nQ201=-10 ~\nQ239=+1.5 ~\nQ203=0 ~\nQ204=2\nL X+1 FMAX M99",
    );
    let found = moves(&program);
    // 1.5 mm a turn, 500 turns a minute, in and out.
    assert_eq!(found[3].pace, Pace::PerMinute { speed: 12.5 });
    assert_eq!((found[4].words[2], found[4].pace), (Some(2.0), found[3].pace));
}

#[test]
fn retracts_along_the_tool_axis() {
    let text = "L X+1 Y+2 Z+3 FMAX\nL M140 MB 50 F750\nL M140 MB MAX";
    refuses(text, 3, "without a machine");
    let with = ReadOptions { retract_height: Some(-2.5), ..options(DIALECT, "XYZAC") };
    let program = readings::read(&whole(text), &with);
    let found = moves(&program);
    assert_eq!((found[1].words[2], found[1].incremental), (Some(50.0), true));
    assert_eq!(found[1].pace, Pace::PerMinute { speed: 12.5 });
    assert_eq!((found[2].words[2], found[2].frame), (Some(-2.5), Frame::Machine));
    assert_eq!(found[2].pace, Pace::Rapid);
}

#[test]
fn cancelled_transformations_change_nothing() {
    let program = read(
        "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\nCYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 1\n\
         CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+0 C+0\nL X+1 Y+2 Z+3 FMAX",
    );
    assert_eq!(places(&program), [[1.0, 2.0, 3.0]]);
}

proptest! {
    #[test]
    fn helices_end_where_their_angle_says(radius in 1.0..50.0_f64, from in 0.0..TAU, angle in 1.0..2000.0_f64, minus: bool) {
        let angle = if minus { -angle } else { angle };
        let [x, y] = [radius * from.cos(), radius * from.sin()];
        let sense = if minus { "DR-" } else { "DR+" };
        let program = read(&format!("CC X+0 Y+0\nL X{x:+.9} Y{y:+.9} Z+0 FMAX\nCP IPA{angle:+.6} IZ-3 {sense} F500"));
        let end = places(&program)[1];
        let to = from + angle.to_radians();
        prop_assert!((end[0] - radius * to.cos()).hypot(end[1] - radius * to.sin()) < 1e-5);
        prop_assert!((end[2] + 3.0).abs() < 1e-12);
    }

    #[test]
    fn token_soup_ends_and_never_panics(
        tokens in prop::collection::vec(prop::sample::select(vec![
            "BEGIN PGM A MM\n", "END PGM A MM", "L", "LN", "CC", "C", "CR", "CP", "LP", "X+1", "IX-2", "Y+Q1", "Q1 = 5", "Q1", "=", "FN 0:",
            "FN 4: Q1 = 1 DIV 0", "TX+1", "TY", "NZ+1", "F", "FMAX", "F MAX", "F500", "R0", "R+5", "DR+", "DR-", "PR+5", "IPA+400", "PA",
            "M128", "M129", "M91", "M126", "M3", "M30", "TOOL CALL 1 Z S500", "CYCL DEF 32.0", "CYCL DEF 7.1 X+5", "FUNCTION TCPM F TCP",
            "AXIS POS", "FUNCTION RESET TCPM", "A+5", "C-370", "IC+5", "~", "~\n", "\n", "\n", ";", "*", "/", "é", "\"", "12",
        ]), 0..60),
    ) {
        let _ = trunnion_nc::read::read(&tokens.join(" "), &options(DIALECT, "XYZAC"));
    }
}
