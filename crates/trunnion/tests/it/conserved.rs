//! Every cut of a program is posted or refused: none is lost over a tool change, none begins nowhere.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test stops on surprise")]

use crate::posted;

use nalgebra::Vector3;
use proptest::prelude::*;
use std::fmt::Write as _;
use trunnion::blocks::BlockInterpolation;
use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::control::NumberedLength;
use trunnion::nc::read::{self, AxisWords, Dialect, ReadOptions};
use trunnion::nc::write::{OUTPUT_FORMATS, OutputFormat, Style, Template};
use trunnion::post::{
    InputOutput, PostError, PostMove, PostOptions, PostPace, PostReport, PostSource, Poster,
    ProgramHead, ProgramMoves, control_of,
};
use trunnion::types::{AxisVector, PoseTolerance};
use trunnion::verify::{self, CheckInput, Tool, VerifyError};

const LENGTHS: [f64; 3] = [100.0, 80.0, 130.0];

fn kinematics(length: f64) -> Kinematics {
    let (_, text) = BUILT_IN.into_iter().find(|(name, _)| *name == "ac-trunnion").unwrap();
    let setup = Setup::new(Vector3::new(-25.0, -50.0, -430.0), [0.0; 3], length);
    Kinematics::new(&parse(text).unwrap().machine, &setup)
}

fn program(text: &str, dialect: Dialect) -> read::Program {
    let axes = AxisWords::of(kinematics(0.0).machine()).unwrap();
    read::read(text, &ReadOptions::new(dialect, axes, 5))
        .unwrap_or_else(|faults| panic!("{dialect}: {faults:?}"))
}

fn post(text: &str, dialect: Dialect) -> Result<Vec<PostMove>, PostError> {
    let numbered = |(number, length): (u32, &f64)| NumberedLength { number, length: *length };
    let lengths: Vec<NumberedLength> = (1..).zip(&LENGTHS).map(numbered).collect();
    let moves = ProgramMoves::new(&kinematics(LENGTHS[0]), 1e-3).unwrap();
    let (mut moves, mut out) = (moves.with_lengths(&lengths), Vec::new());
    for step in &program(text, dialect).steps {
        moves.step(step, &mut out)?;
    }
    Ok(out)
}

/// Ends of all moves with feed \[mm\], workpiece frame.
fn cuts(text: &str, dialect: Dialect) -> Vec<[f64; 3]> {
    let moves = post(text, dialect).unwrap();
    let cut = |one: &&PostMove| one.pace != PostPace::Rapid;
    moves.iter().filter(cut).map(|one| one.pose.tip.coords.into()).collect()
}

fn assert_near(found: &[[f64; 3]], expected: &[[f64; 3]]) {
    assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((0..3).all(|k: usize| (a[k] - b[k]).abs() < 1e-9), "{found:?} {expected:?}");
    }
}

#[test]
fn a_tool_that_is_only_given_a_height_cuts_where_the_last_one_stood() {
    let klartext = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S3000\n2 L X+10 Y+10 Z+25 R0 FMAX M3\n\
                    3 L Z-1 F200\n4 L X+20\n5 L Z+25 FMAX\n6 L Z-10 R0 FMAX M91\n\
                    7 TOOL CALL 2 Z S3000\n8 L Z+2 FMAX M3\n9 L Z-8 F98\n10 L X+29 F196\n\
                    11 L Z+25 FMAX\n12 END PGM T MM\n";
    let expected = [[10.0, 10.0, -1.0], [20.0, 10.0, -1.0], [20.0, 10.0, -8.0], [29.0, 10.0, -8.0]];
    assert_near(&cuts(klartext, Dialect::Heidenhain), &expected);
    let gcode = "G21 G90 G94 G54 G17\nT1 M6\nG43 H1\nS600 M3\nG0 X10 Y10 Z25\nG1 Z-1 F200\nX20\n\
                 G0 Z25\nT2 M6\nG43 H2\nG0 Z2\nG1 Z-8 F98\nX29\nG0 Z25\nM30\n";
    for dialect in [Dialect::LinuxCnc, Dialect::Fanuc, Dialect::Haas] {
        assert_near(&cuts(gcode, dialect), &expected);
    }
}

#[test]
fn a_cut_from_nowhere_is_refused_with_its_line() {
    let start = "G21 G90 G94 G54 G17\nT1 M6\nG43 H1\nS600 M3\n";
    for text in ["G0 Z5\nG1 Z-5 F100\n", "G1 X0 Y0 Z-5 F100\n", "G0 X0 Y0\nG1 Z-5 F100\nX60\n"] {
        let error = post(&format!("{start}{text}M30\n"), Dialect::LinuxCnc).unwrap_err();
        assert!(matches!(error, PostError::Refused { line: 5..=6, .. }), "{error:?}");
        assert!(error.to_string().contains("X, Y and Z"), "{error}");
    }
    // A leaning tool of another length stands elsewhere in X and Y.
    let leaning = "G0 X0 Y0 Z50\nG1 Z-5 F100\nG0 Z50\nG0 A30\nT2 M6\nG43 H2\nG0 Z5\nG1 Z-5\nM30\n";
    let error = post(&format!("{start}{leaning}"), Dialect::LinuxCnc).unwrap_err();
    assert!(matches!(error, PostError::Refused { line: 12, .. }), "{error:?}");
}

#[test]
fn the_check_follows_a_tool_that_is_only_given_a_height() {
    let text = "G21 G90 G94 G54 G17\nT1 M6\nG43 H1\nG0 X10 Y10 Z25\nG1 Z-1 F200\nX20\nG0 Z25\n\
                T2 M6\nG43 H2\nG0 Z2\nG1 Z-8 F98\nX29\nG0 Z25\nG0 A30\nT1 M6\nG43 H1\nG0 Z2\nG1 Z1\nM30\n";
    let cutters =
        LENGTHS.map(|length| Cutter::new(CutterSpec { length, ..CutterSpec::flat(8.0) }).unwrap());
    let tools: Vec<Tool<'_>> =
        (1..).zip(&cutters).map(|(number, cutter)| Tool { number, cutter }).collect();
    let believed = kinematics(LENGTHS[0]);
    let tracks = |text: &str| {
        let program = program(text, Dialect::LinuxCnc);
        let input = CheckInput::program(&program, &believed, &cutters[0]).machine(&believed);
        verify::track(&input.tools(&tools), 100.0)
    };
    // The last tool starts leaning: X and Y are not known, so its cut is refused.
    assert!(matches!(tracks(text), Err(VerifyError::Unfollowed { line: 18 })));
    let fair = text.replace("G0 A30\n", "");
    let ends: Vec<[f64; 3]> = tracks(&fair)
        .unwrap()
        .iter()
        .filter(|track| !track.rapid && track.tool == 1)
        .filter_map(|track| track.poses.last().map(|at| at.pose.tip.coords.into()))
        .collect();
    assert_near(&ends, &[[29.0, 10.0, -8.0]]);
}

/// A tool of a random program.
#[derive(Debug, Clone)]
struct ToolRun {
    number: u32,
    /// X and Y are commanded after the change, and not only Z.
    is_placed: bool,
    /// Axis and word of each cut.
    cuts: Vec<(usize, i32)>,
}

fn tools() -> impl Strategy<Value = Vec<ToolRun>> {
    let cuts = prop::collection::vec((0..3usize, -40..40i32), 1..6);
    let tool = (1..4u32, any::<bool>(), cuts).prop_map(|(number, is_placed, cuts)| ToolRun {
        number,
        is_placed,
        cuts,
    });
    prop::collection::vec(tool, 1..6)
}

proptest! {
    /// Ends of all cuts, followed by hand: one word a block, heights from the safe plane.
    #[test]
    fn no_cut_is_lost(tools in tools()) {
        let (mut text, mut expected) = ("G21 G90 G94 G54 G17\n".to_owned(), Vec::new());
        let mut at = [0.0; 3];
        for (index, ToolRun { number, is_placed, cuts }) in tools.iter().enumerate() {
            writeln!(text, "T{number} M6\nG43 H{number}").unwrap();
            if *is_placed || index == 0 {
                [at[0], at[1]] = [f64::from(*number), -3.0];
                writeln!(text, "G0 X{} Y{}", at[0], at[1]).unwrap();
            }
            at[2] = 50.0;
            writeln!(text, "G0 Z50").unwrap();
            for (axis, value) in cuts {
                at[*axis] = f64::from(*value);
                writeln!(text, "G1 {}{value} F300", ["X", "Y", "Z"][*axis]).unwrap();
                expected.push(at);
            }
            writeln!(text, "G0 Z50").unwrap();
        }
        text.push_str("M30\n");
        assert_near(&cuts(&text, Dialect::LinuxCnc), &expected);
    }
}

/// Axis positions of a random program, off the pole, and the speed that leads there.
fn five_axis_moves() -> impl Strategy<Value = Vec<PostMove>> {
    let place = (-30.0..30.0f64, -30.0..30.0f64, -30.0..30.0f64, 0.15..0.6f64, -1.0..1.0f64)
        .prop_map(|(x, y, z, a, c)| AxisVector::from([x, y, z - 300.0, a, c]));
    let pace = prop_oneof![
        1 => Just(PostPace::Rapid),
        4 => (1.0..80.0f64).prop_map(PostPace::Feed),
    ];
    prop::collection::vec((place, pace), 2..14).prop_map(|places| {
        let kinematics = kinematics(LENGTHS[0]);
        let one = |(index, (q, pace)): (u32, (AxisVector, PostPace))| {
            let pace = if index == 0 { PostPace::Rapid } else { pace };
            let way = BlockInterpolation::GreatCircle;
            PostMove { line: index + 1, pose: kinematics.forward(&q), q: None, pace, way }
        };
        (0..).zip(places).map(one).collect()
    })
}

/// Posts moves; returns the text and what was counted.
fn written(
    moves: &[PostMove],
    source: PostSource,
    dialect: OutputFormat,
) -> Result<(String, PostReport), PostError> {
    let kinematics = kinematics(LENGTHS[0]);
    let options = PostOptions {
        window: 256,
        ..PostOptions::within(control_of(&kinematics, dialect), PoseTolerance::new(0.01, 1e-3))
    };
    let style = Style::of(&kinematics, dialect, AxisWords::of(kinematics.machine()).unwrap());
    let template = Template::of(dialect).unwrap();
    let head = ProgramHead { note: &posted::NOTE, template: &template };
    let mut poster = Poster::new(&kinematics, source, &options, &style)?;
    let mut text = String::new();
    for one in moves {
        poster.push(&mut text, one, head)?;
    }
    let report = poster.finish(&mut text, head)?;
    Ok((text, report))
}

/// Returns the moves of a program that was written.
fn read_again(text: &str, dialect: OutputFormat) -> Vec<PostMove> {
    let mut moves = ProgramMoves::new(&kinematics(LENGTHS[0]), 1e-3).unwrap();
    let mut out = Vec::new();
    for step in &program(text, dialect.dialect()).steps {
        moves.step(step, &mut out).unwrap();
    }
    out
}

/// Ends of the moves of one kind, each with where it leads.
fn ends(moves: &[PostMove], is_rapid: bool) -> Vec<[f64; 3]> {
    let kind = |one: &&PostMove| (one.pace == PostPace::Rapid) == is_rapid;
    moves.iter().skip(1).filter(kind).map(|one| one.pose.tip.coords.into()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// From one dialect to another and back: each cut and each rapid move is still there, in order and in its length.
    #[test]
    fn all_motion_survives_from_dialect_to_dialect_and_back(
        moves in five_axis_moves(),
        pair in (0..9usize, 0..9usize),
    ) {
        let programs: Vec<OutputFormat> =
            OUTPUT_FORMATS.iter().map(|(_, of)| *of).filter(|of| *of != OutputFormat::Apt).collect();
        let [there, back] = [programs[pair.0], programs[pair.1]];
        let (mut now, mut source) = (moves.clone(), PostSource::Locations);
        for dialect in [there, back, there] {
            let (text, report) = written(&now, source, dialect).unwrap();
            let InputOutput { input, output } = report.motion;
            prop_assert!(report.unread.is_none(), "{dialect:?}: {:?}", report.unread);
            prop_assert_eq!([input.tools, output.tools], [1, 1]);
            let lengths = [input, output].map(|of| [of.rapid_length, of.cut_length]);
            for (a, b) in lengths[0].into_iter().zip(lengths[1]) {
                prop_assert!((a - b).abs() <= 1e-3 * a + 0.01, "{dialect:?}: {a} mm became {b} mm");
            }
            now = read_again(&text, dialect);
            source = PostSource::Program(Box::new(kinematics(LENGTHS[0])));
        }
        for is_rapid in [false, true] {
            // Moves may be divided: the ends of the first program come one after another among those of the last.
            let mut found = ends(&now, is_rapid).into_iter();
            for wanted in ends(&moves, is_rapid) {
                let near = |end: [f64; 3]| (0..3).all(|k: usize| (end[k] - wanted[k]).abs() < 2e-3);
                prop_assert!(found.any(near), "{there:?}, {back:?}: {wanted:?} is lost");
            }
        }
    }
}

/// A probing move never becomes a cut.
#[test]
fn a_probe_is_not_posted() {
    let text = "T1 M6\nG0 X0 Y0 Z20\nG38.2 Z-5 F60\nG0 Z20\nM2\n";
    let refused = post(text, Dialect::LinuxCnc).unwrap_err().to_string();
    assert!(refused.contains("a probing move"), "{refused}");
}
