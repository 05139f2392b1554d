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
    refuses("FN 18: SYSREAD Q1 = ID1", 1, "not understood");
    // Sides 3 and 4: hypotenuse 5, angle atan(3 / 4); the angle of sides -1 and -1 is 225 degrees.
    let program = read(
        "FN 8: Q1 = +3 LEN +4\nFN 13: Q2 = +3 ANG +4\nFN 13: Q3 = -1 ANG -1\nL X+Q1 Y+Q2 Z+Q3 FMAX",
    );
    let place = places(&program)[0];
    let expected = [5.0, 0.75_f64.atan().to_degrees(), 225.0];
    assert!((0..3).all(|k| (place[k] - expected[k]).abs() < 1e-9), "{place:?}");
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
    refuses("CYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 0.5", 2, "scale");
    refuses("CYCL DEF 26.0 SCALING\nCYCL DEF 26.1 X1.4 Y1 CCX+5", 2, "scales of single axes");
    refuses("CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+30", 2, "which angles");
    refuses("L M94", 1, "M94");
    refuses("L M124", 1, "M124");
    refuses("L M143", 1, "M143");
    refuses("L X+1 FZ0.1", 1, "FZ0.1");
    refuses("L X+1 FU0.1", 1, "spindle that stands");
    refuses("L X+1 FAUTO", 1, "FAUTO without a feed");
    refuses("TOOL CALL 5.1 Z S100", 1, "5.1");
    refuses("TOOL CALL \"MILL_10\" Z\nTOOL CALL \"DRILL_10\" Z", 2, "both be tool 10");
    refuses("CALL PGM OTHER", 1, "CALL PGM");
    refuses("CYCL DEF 204 BACK BORING Q249=5", 1, "not understood");
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
        "M117\nM145\nTRANS DATUM RESET\nCYCL DEF 26.0 SCALING\nCYCL DEF 26.1 X1 Y1 CCX+5\nCYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\nCYCL DEF 11.0 SCALING\nCYCL DEF 11.1 SCL 1\n\
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
            "RND R2", "CHF 1\n", "CT", "CTP", "APPR LT", "APPR LCT", "DEP LT", "DEP LCT", "DEP", "LEN5", "R5", "X+9 Y+3\n", "STOP", "M136",
            "CYCL DEF 10.0\nCYCL DEF 10.1 ROT+30\n", "CYCL DEF 8.1 X\n", "FN 13: Q1 = +3 ANG +4\n", "FAUTO", "FU0.1", "TRANS DATUM",
            "%A G71 *\n", "G01", "G98 L1 *\n", "L1,2 *\n", "G200 Q200=2", "I+5",
            "M128", "M129", "M91", "M126", "M3", "M30", "TOOL CALL 1 Z S500", "CYCL DEF 32.0", "CYCL DEF 7.1 X+5", "FUNCTION TCPM F TCP",
            "AXIS POS", "FUNCTION RESET TCPM", "A+5", "C-370", "IC+5", "~", "~\n", "\n", "\n", ";", "*", "/", "é", "\"", "12",
        ]), 0..60),
    ) {
        let _ = trunnion_nc::read::read(&tokens.join(" "), &options(DIALECT, "XYZAC"));
    }
}

/// End of a move in X and Y; of an arc, its centre from the start and its sweep over half a turn.
type ContourMove = ([f64; 2], Option<([f64; 2], f64)>);

fn contour(text: &str) -> Vec<ContourMove> {
    let program = read(text);
    let ends = places(&program);
    let way = |found: trunnion_nc::read::Move| match found.way {
        trunnion_nc::read::Way::Line => None,
        trunnion_nc::read::Way::Arc(arc) => Some((arc.center, arc.sweep / std::f64::consts::PI)),
    };
    let ways = moves(&program).into_iter().map(way);
    ends.iter().map(|end| [end[0], end[1]]).zip(ways).collect()
}

fn is_contour(text: &str, expected: &[ContourMove]) {
    let found = contour(text);
    assert_eq!(found.len(), expected.len(), "{text}: {found:?}");
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9;
    for (found, expected) in found.iter().zip(expected) {
        let arcs = match (found.1, expected.1) {
            (None, None) => true,
            (Some(one), Some(other)) => near(one.0, other.0) && (one.1 - other.1).abs() < 1e-9,
            _ => false,
        };
        assert!(near(found.0, expected.0) && arcs, "{text}: {found:?} is not {expected:?}");
    }
}

#[test]
fn corners_are_rounded_and_cut_off() {
    let start = ([0.0, 0.0], None);
    is_contour(
        "L X+0 Y+0 FMAX\nL X+10 Y+0 F500\nRND R2 F100\nL X+10 Y+10\nCHF 3\nL IX-10\nRND R4\nL X+0 Y+0\nL M30",
        &[
            start,
            ([8.0, 0.0], None),
            ([10.0, 2.0], Some(([0.0, 2.0], 0.5))),
            ([10.0, 7.0], None),
            ([7.0, 10.0], None),
            ([4.0, 10.0], None),
            ([0.0, 6.0], Some(([0.0, -4.0], 0.5))),
            ([0.0, 0.0], None),
        ],
    );
    // A line, then a clockwise quarter about (20, 0): the arc R2 is 2 above the line and 12 from that centre.
    let x = 20.0 - 140.0_f64.sqrt();
    let touch = [20.0 + (x - 20.0) / 1.2, 2.0 / 1.2];
    let turned = (20.0 - touch[0]).atan2(touch[1]) / std::f64::consts::PI;
    let found = contour("CC X+20 Y+0\nL X+0 Y+0 FMAX\nL X+10 F500\nRND R2\nC X+20 Y+10 DR-");
    let (arc, last) = (found[2].1.unwrap(), found[3].1.unwrap());
    assert!((found[1].0[0] - x).abs() < 1e-9 && found[1].0[1].abs() < 1e-9, "{found:?}");
    assert!((found[2].0[0] - touch[0]).hypot(found[2].0[1] - touch[1]) < 1e-9, "{found:?}");
    assert!(arc.0[0].abs() < 1e-9 && (arc.0[1] - 2.0).abs() < 1e-9, "{found:?}");
    assert!((last.0[0] - (20.0 - touch[0])).abs() < 1e-9 && (last.1 + turned).abs() < 1e-9);
    let program = read("L X+0 Y+0 FMAX\nL X+10 F500\nRND R2 F100\nM8\nL Y+10");
    let paces: Vec<_> = moves(&program).iter().skip(1).map(|found| found.pace).collect();
    let per_minute = |feed: f64| Pace::PerMinute { speed: feed / 60.0 };
    assert_eq!(paces, [per_minute(500.0), per_minute(100.0), per_minute(500.0)]);
    refuses("L X+0 Y+0 FMAX\nL X+10 F500\nRND R20\nL Y+10", 4, "RND R20 does not fit");
    refuses("L X+0 Y+0 Z+0 FMAX\nL X+10 F500\nRND R2\nL Z+10", 4, "leaves the plane");
    refuses("L X+0 Y+0 FMAX\nL X+10 F500\nCHF 1\nL M30", 4, "no contour element follows");
    refuses("RND R2", 1, "without a contour element");
}

#[test]
fn arcs_go_on_in_the_direction_of_the_contour() {
    is_contour(
        "L X+0 Y+0 FMAX\nL X+10 F500\nCT X+20 Y+10\nCT IX-10 IY+10\nCT X+5 Y+20",
        &[
            ([0.0, 0.0], None),
            ([10.0, 0.0], None),
            ([20.0, 10.0], Some(([0.0, 10.0], 0.5))),
            ([10.0, 20.0], Some(([-10.0, 0.0], 0.5))),
            // Straight ahead.
            ([5.0, 20.0], None),
        ],
    );
    refuses("L X+0 Y+0 FMAX\nL Z+5 FMAX\nCT X+1 Y+1 F5", 3, "tangent");
    refuses("L X+0 Y+0 FMAX\nL X+5 FMAX\nCT X+1 F5", 3, "behind the contour");
}

#[test]
fn approaches_touch_the_contour() {
    is_contour(
        "L X+0 Y-20 FMAX\nAPPR LT X+0 Y+0 LEN5 R0 F100\nL X+10\nDEP LT LEN4 F200",
        &[
            ([0.0, -20.0], None),
            ([-5.0, 0.0], None),
            ([0.0, 0.0], None),
            ([10.0, 0.0], None),
            ([14.0, 0.0], None),
        ],
    );
    // Up to the auxiliary point as fast as the block before.
    let program = read("L X+0 Y-20 FMAX\nAPPR LT X+0 Y+0 LEN5 F100\nL X+10");
    assert_eq!(moves(&program)[1].pace, Pace::Rapid);
    assert_eq!(moves(&program)[2].pace, Pace::PerMinute { speed: 100.0 / 60.0 });
    // The manual's example: from (40, 10) to (10, 20) with R10, the contour goes on to (20, 35).
    let found = contour("L X+40 Y+10 FMAX\nAPPR LCT X+10 Y+20 R10 F100\nL X+20 Y+35");
    let ([x, y], Some((center, _))) = (found[1].0, found[2].1) else { panic!("{found:?}") };
    assert!((center[0].hypot(center[1]) - 10.0).abs() < 1e-9, "{found:?}");
    let way = [x - 40.0, y - 10.0];
    assert!((way[0] * center[0] + way[1] * center[1]).abs() < 1e-9, "a tangent");
    let out = [x + center[0] - 10.0, y + center[1] - 20.0];
    assert!((out[0] * 10.0 + out[1] * 15.0).abs() < 1e-9, "tangent to the contour");
    // Along X, then with R5 to the left up to (20, 10): the tangent from there to the circle about (10, 5) has length
    // sqrt(100 + 25 - 25) = 10, so it touches at (10, 10).
    is_contour(
        "L X+0 Y+0 FMAX\nL X+10 F100\nDEP LCT X+20 Y+10 R5",
        &[
            ([0.0, 0.0], None),
            ([10.0, 0.0], None),
            ([14.0, 2.0], Some(([0.0, 5.0], (0.8_f64).atan2(0.6) / std::f64::consts::PI))),
            ([20.0, 10.0], None),
        ],
    );
    refuses("L X+0 Y+0 FMAX\nAPPR CT X+5 Y+5 CCA90 R5 F5\nL X+9", 2, "APPR CT");
    refuses("L X+0 Y+0 FMAX\nAPPR LN X+5 Y+5 LEN5 F5\nL X+9", 2, "APPR LN");
    refuses("L X+0 Y+0 FMAX\nAPPR LT X+5 Y+5 LEN5 RL F5\nL X+9", 2, "compensation");
    refuses("L X+0 Y+0 Z+2 FMAX\nAPPR LT X+5 Y+5 Z-5 LEN5 F5\nL X+9", 2, "out of the plane");
    refuses("L X+0 Y+0 FMAX\nL X+10 F5\nDEP LCT X+11 Y+1 R5", 3, "does not reach");
}

#[test]
fn programs_are_rotated_and_mirrored() {
    // Turned by 90 degrees about the shifted datum (5, 0): X+10 is (5, 10), Y+10 is (-5, 0).
    is_contour(
        "TRANS DATUM AXIS X+5\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nL X+10 Y+0 FMAX\nCC X+0 Y+0\nC X+0 Y+10 DR+ F100\n\
         LP PR+10 PA+0\nL IX-4\nL Y+2\nCYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+0\nL X+1 Y+0",
        &[
            ([5.0, 10.0], None),
            ([-5.0, 0.0], Some(([0.0, -10.0], 0.5))),
            ([5.0, 10.0], None),
            ([5.0, 6.0], None),
            ([3.0, 6.0], None),
            ([6.0, 0.0], None),
        ],
    );
    is_contour(
        "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\nL X+10 Y+0 FMAX\nCC X+0 Y+0\nC X+0 Y+10 DR+ F100\nCP IPA+90 DR+\nLP PA+0\nCYCL DEF 8.0 MIRROR IMAGE\n\
         CYCL DEF 8.1\nL X+1",
        &[
            ([-10.0, 0.0], None),
            ([0.0, 10.0], Some(([10.0, 0.0], -0.5))),
            ([10.0, 0.0], Some(([0.0, -10.0], -0.5))),
            ([-10.0, 0.0], None),
            ([1.0, 0.0], None),
        ],
    );
    let turned = "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+30\n";
    refuses(&format!("{turned}L X+1 FMAX"), 3, "the other is not stated");
    refuses(&format!("{turned}L C+1 FMAX"), 3, "rotary words");
    refuses(&format!("{turned}CYCL DEF 7.0 SHIFT\nCYCL DEF 7.1 X+5"), 4, "a datum shift");
    refuses(&format!("{turned}CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 X"), 4, "rotated program");
    refuses(&format!("{turned}PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN FMAX"), 3, "PLANE");
    refuses("CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1 Z", 2, "mirror image of Z");
}

#[test]
fn feeds_have_their_units() {
    // F counts tenths of an inch a minute in INCH programs: 10 inches a minute.
    let text = "0 BEGIN PGM T INCH\nTOOL CALL 1 Z S1000 F50\nL X+1 Y+0 Z+1 F100 M3\nL X+2 FAUTO\nL X+3 FU0.01\nL X+4 F100\nM136\nL X+5 F0.02\n\
                M137\nL X+6 F100\nCYCL DEF 201 Q200=.1 Q201=-.5 Q206=20 Q211=0 Q208=0 Q203=0 Q204=1\nCYCL CALL\nEND PGM T INCH\n";
    let program = readings::read(text, &options(DIALECT, "XYZAC"));
    let inches = |found: &trunnion_nc::read::Move| match found.pace {
        Pace::PerMinute { speed } => (speed * 60.0 / 25.4 * 1e6).round() / 1e6,
        _ => 0.0,
    };
    let found: Vec<f64> = moves(&program).iter().map(inches).collect();
    assert_eq!(found, [10.0, 5.0, 10.0, 10.0, 20.0, 10.0, 0.0, 2.0, 2.0, 0.0]);
    let inch = |line: &str| format!("0 BEGIN PGM T INCH\n{line}\nEND PGM T INCH\n");
    let rotary = inch("L C+0 FMAX\nL C+30 F100");
    let faults = trunnion_nc::read::read(&rotary, &options(DIALECT, "XYZAC")).unwrap_err();
    assert!(faults[0].message.contains("rotary axes alone"), "{}", faults[0]);
}

#[test]
fn cycles_202_205_and_209_run() {
    near_heights(
        "L Z+50 FMAX\nCYCL DEF 202 BORING ~\nQ200=2 ~\nQ201=-10 ~\nQ206=100 ~\nQ211=0 ~\nQ208=0 ~\nQ203=0 ~\nQ204=20 ~\nQ214=0\nL X+1 FMAX M99",
        &[(50.0, RAPID), (2.0, RAPID), (-10.0, FEED), (2.0, FEED), (20.0, RAPID)],
    );
    near_heights(
        "L Z+50 FMAX\nCYCL DEF 205 PECKING ~\nQ200=2 ~\nQ201=-10 ~\nQ206=100 ~\nQ202=6 ~\nQ203=0 ~\nQ204=20 ~\nQ212=0 ~\nQ205=1 ~\nQ258=0.5 ~\n\
         Q259=0.5 ~\nQ257=0 ~\nQ256=0.2 ~\nQ211=0 ~\nQ379=0 ~\nQ253=750\nL X+1 FMAX M99",
        &[
            (50.0, RAPID),
            (2.0, RAPID),
            (-6.0, FEED),
            (2.0, RAPID),
            (-5.5, RAPID),
            (-10.0, FEED),
            (20.0, RAPID),
        ],
    );
    // Q256 times the pitch: 0.5 mm back at each break.
    near_heights(
        "TOOL CALL 1 Z S500\nL Z+50 FMAX M3\nCYCL DEF 209 TAPPING ~\nQ200=2 ~\nQ201=-10 ~\nQ239=+1 ~\nQ203=0 ~\nQ204=20 ~\nQ257=6 ~\nQ256=0.5 ~\nQ336=0\n\
         L X+1 FMAX M99",
        &[
            (50.0, RAPID),
            (2.0, RAPID),
            (-6.0, FEED),
            (-5.5, FEED),
            (-10.0, FEED),
            (2.0, FEED),
            (20.0, RAPID),
        ],
    );
    let bored = "CYCL DEF 202 Q200=2 Q201=-10 Q206=100 Q211=0 Q208=0 Q203=0 Q204=20 Q214=1";
    refuses(bored, 1, "Q214");
    let pecked = "CYCL DEF 205 Q200=2 Q201=-10 Q206=100 Q202=6 Q203=0 Q204=20 Q258=0.5 Q259=1";
    refuses(pecked, 1, "two advanced stop distances");
}

#[test]
fn values_stand_behind_names_of_any_language() {
    near_heights(
        "Q7=-8\nCYCL DEF 1.0 TIEFBOHREN\nCYCL DEF 1.1 ABST-2.000\nCYCL DEF 1.2 TIEFE Q7\nCYCL DEF 1.3 ZUSTLG-8\nCYCL DEF 1.4 V.ZEIT0.5\n\
         CYCL DEF 1.5 F100\nL X+1 Y+1 Z+2 FMAX M99",
        &[(2.0, RAPID), (-8.0, FEED), (2.0, RAPID)],
    );
    let program = read(
        "Q1 = 3\nCYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL Q1\nCYCL DEF 9.0 VERWEILZEIT\nCYCL DEF 9.1 V.ZEIT.5\nFUNCTION DWELL TIME1.5",
    );
    let seconds = |step: &Step| match step {
        Step::Dwell { seconds, .. } => Some(*seconds),
        _ => None,
    };
    let found: Vec<f64> = program.steps.iter().filter_map(seconds).collect();
    assert!(found.iter().zip([3.0, 0.5, 1.5]).all(|(one, other)| (one - other).abs() < 1e-12));
    assert_eq!(found.len(), 3);
    // A repeated section may hold the end of a subprogram: three times in all.
    let program = read("L X+0 FMAX\nLBL 1\nL IX+1 FMAX\nLBL 0\nCALL LBL 1 REP 2");
    let [x, ..] = *places(&program).last().unwrap();
    assert!((x - 3.0).abs() < 1e-12);
}

/// Two programs of the same moves, in DIN/ISO and in Klartext; steps without lines and columns.
fn is_klartext_of(iso: &str, klartext: &str) {
    let steps = |text: &str| -> Vec<String> {
        let program = readings::read(text, &options(DIALECT, "XYZAC"));
        let plain = |step: &Step| match step {
            Step::Move(found) => {
                format!("{:?}", trunnion_nc::read::Move { line: 0, column: 0, ..*found })
            }
            Step::Words { text, .. } => text.to_string(),
            Step::Spindle { speed, .. } => format!("spindle {speed}"),
            Step::Tool { number, .. } => format!("tool {number}"),
            Step::Dwell { seconds, .. } => format!("dwell {seconds}"),
            other => format!("{other:?}"),
        };
        program.steps.iter().map(plain).collect()
    };
    let (found, expected) = (steps(iso), steps(klartext));
    assert_eq!(found, expected, "{iso}");
}

#[test]
fn din_iso_is_read_as_klartext() {
    let text = "%DEMO G71 *\nN10 G30 G17 X+0 Y+0 Z-40 *\nN20 G31 G90 X+100 Y+100 Z+0 *\nN30 T1 G17 S5000 F200 *\nN40 G00 G40 G90 Z+250 M3 *\n\
                N50 X-30 Y+50 *\nN60 G01 Z-5 F200 *\nN70 X+0Y+50*\nN80 I+25 J+50 *\nN90 G02 X+50 *\nN100 G91 G03 X+10 Y+10 R+10 *\nN110 G90 G06 X+70 Y+80 *\n\
                N120 G25 R2 F50 *\nN130 G01 X+70 Y+20 *\nN140 G24 R3 *\nN150 X+100 *\nN160 I+0 J+0 *\nN170 G11 R+20 H+30 *\nN180 G13 G91 H+360 Z-2 *\n\
                N190 G04 F1.5 *\nN200 G200 Q200=2 Q201=-15 Q206=150 Q202=5 Q210=0 Q203=+0 Q204=50 Q211=0 *\nN210 G00 G90 X+5 Y+5 M99 *\nN220 G79 *\n\
                N230 G98 L1 *\nN240 G00 G91 X+5 *\nN250 L1,2 *\nN260 G00 G90 Z+250 M2 *\nN99999999 %DEMO G71 *\n";
    assert_eq!(Dialect::guess(text.lines()), DIALECT);
    is_klartext_of(
        text,
        "BEGIN PGM DEMO MM\nTOOL CALL 1 Z S5000 F200\nL Z+250 FMAX M3\nL X-30 Y+50 FMAX\nL Z-5 F200\nL X+0 Y+50\nCC X+25 Y+50\nC X+50 DR-\n\
         CR IX+10 IY+10 R+10 DR+\nCT X+70 Y+80\nRND R2 F50\nL X+70 Y+20\nCHF 3\nL X+100\nCC X+0 Y+0\nLP PR+20 PA+30\nCP IPA+360 IZ-2 DR+\n\
         CYCL DEF 9.0 DWELL\nCYCL DEF 9.1 DWELL 1.5\nCYCL DEF 200 Q200=2 Q201=-15 Q206=150 Q202=5 Q210=0 Q203=+0 Q204=50 Q211=0\nL X+5 Y+5 FMAX M99\n\
         CYCL CALL\nLBL 1\nL IX+5 FMAX\nCALL LBL 1 REP 2\nL Z+250 FMAX M2\nEND PGM DEMO MM\n",
    );
    let refused = |line: &str, part: &str| {
        let text = format!("%A G71 *\nN10 G00 X+0 Y+0 Z+0 *\nN20 {line} *\nN30 M2 *\n");
        let faults = trunnion_nc::read::read(&text, &options(DIALECT, "XYZAC")).unwrap_err();
        let fault = &faults[0];
        assert!(fault.message.contains(part) && !fault.help.is_empty(), "{line}: {fault}");
        assert_eq!(fault.line, 3);
    };
    refused("G01 G41 X+5 F5", "G41");
    refused("G26 R5", "G26");
    refused("G72 F0.5", "G72");
    refused("G83 P01 -2", "P01");
    refused("D00 Q1 P01 +5", "D00");
    refused("G05 X+5 F5", "G05");
    refused("G01 X+5", "without a feed");
    refused("G208 Q200=2", "CYCL DEF 208");
}

#[test]
fn a_stop_keeps_its_functions() {
    let program = read("TOOL CALL 1 Z S100\nL X+1 FMAX M3\nSTOP M5");
    let stops = |step: &Step| matches!(step, Step::Spindle { speed, .. } if speed.abs() <= 0.0);
    assert!(program.steps.iter().any(stops));
    let words = |step: &Step| matches!(step, Step::Words { text, .. } if &**text == "STOP");
    assert!(program.steps.iter().any(words));
}

proptest! {
    #[test]
    fn rounded_corners_touch_both_lines(angle in 0.2..2.8_f64, left: bool, radius in 0.1..2.0_f64) {
        let turn = if left { angle } else { -angle };
        let [x, y] = [100.0 + 80.0 * turn.cos(), 80.0 * turn.sin()];
        let found = contour(&format!("L X+0 Y+0 FMAX\nL X+100 F500\nRND R{radius:.9}\nL X{x:+.9} Y{y:+.9}"));
        // The tangents of a corner turned by an angle are r tan(angle / 2) long; the arc turns by the angle.
        let cut = radius * (0.5 * angle).tan();
        prop_assert!((found[1].0[0] - (100.0 - cut)).abs() < 1e-7);
        let (center, sweep) = found[2].1.unwrap();
        prop_assert!(center[0].abs() < 1e-7 && (center[1] - turn.signum() * radius).abs() < 1e-7);
        prop_assert!((sweep * std::f64::consts::PI - turn).abs() < 1e-7);
        let end = found[2].0;
        prop_assert!((end[0] - 100.0 - cut * turn.cos()).hypot(end[1] - cut * turn.sin()) < 1e-6);
    }
}
