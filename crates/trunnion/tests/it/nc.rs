//! Programs written, read back, and read from hand-made text.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::posted;
use crate::property;
use crate::shop;

use nalgebra::{Point3, UnitVector3, Vector3};
use proptest::prelude::*;
use shop::Layout;
use trunnion::machine::Kinematics;
use trunnion::nc::read::{self, ClMotion, Dialect, Frame, Move, Pace, Program, ReadOptions, Step};
use trunnion::nc::write::{
    self, AxisWords, Coolant, Coordinates, Note, Style, ToolNote, WriteError,
};
use trunnion::types::{
    AxisVector, Block, Diagnostics, Leg, Motion, PoseTolerance, Station, ToolPose,
};

const LINUXCNC: write::OutputFormat = write::OutputFormat::LinuxCnc;

fn words(layout: Layout, reversed: bool) -> AxisWords {
    let words = AxisWords::of(&shop::machine(layout)).unwrap();
    if reversed { words.with_reversed_rotaries() } else { words }
}

fn read(text: &str) -> Result<Program, Diagnostics> {
    let axes = words(Layout::TableTable, false);
    read::read(text, &ReadOptions::new(Dialect::LinuxCnc, axes, 50))
}

fn note(budget: &[(String, f64)]) -> Note<'_> {
    Note {
        name: "a (strange) jöb $ name\nG0 X99",
        tool: ToolNote { number: 3, major: 10.0, minor: 6.0 },
        spindle: 8000.0,
        coolant: Coolant::Flood,
        feed: 50.0,
        budget,
        duration: 12.5,
        remarks: &[],
    }
}

fn block(kinematics: &Kinematics, q: AxisVector, duration: f64) -> Block {
    Block { motion: Motion::Cut, q, pose: kinematics.forward(&q), duration }
}

/// Line, words, pace of all moves.
fn moves(program: &Program) -> Vec<Move> {
    let step = |step: &Step| match step {
        Step::Move(found) => Some(*found),
        _ => None,
    };
    program.steps.iter().filter_map(step).collect()
}

#[test]
fn hand_written_modes_are_followed() {
    let program = read(
        "%\nO0001 (demo)\nN10 G20 G90 G54 G94\nT4 M6\nG0 X1 C90\nG21\nG1 Y-2.5 F600 ; feed\nG91 X.5\n\
         G90 G43 H4 Z3\nM428\nG93 G1 B10. F30\nX1 F60\nG53 G0 Z-1\nG55\nG4 P1.5\nG49 G0 Z2\nM30\nnonsense\n",
    )
    .unwrap();
    let work = |offset, length, tcp| Frame::Work { offset, length, tcp };
    let inch = Some(25.4);
    let expected = [
        (5, [inch, None, None, Some(90f64.to_radians()), None], work(0, false, false), Pace::Rapid),
        (
            7,
            [None, Some(-2.5), None, None, None],
            work(0, false, false),
            Pace::PerMinute { speed: 10.0 },
        ),
        (
            8,
            [Some(0.5), None, None, None, None],
            work(0, false, false),
            Pace::PerMinute { speed: 10.0 },
        ),
        (
            9,
            [None, None, Some(3.0), None, None],
            work(0, true, false),
            Pace::PerMinute { speed: 10.0 },
        ),
        (
            11,
            [None, None, None, None, Some(10f64.to_radians())],
            work(0, true, true),
            Pace::Inverse { seconds: 2.0 },
        ),
        (
            12,
            [Some(1.0), None, None, None, None],
            work(0, true, true),
            Pace::Inverse { seconds: 1.0 },
        ),
        (13, [None, None, Some(-1.0), None, None], Frame::Machine, Pace::Rapid),
        (16, [None, None, Some(2.0), None, None], work(1, false, false), Pace::Rapid),
    ];
    let found: Vec<_> =
        moves(&program).iter().map(|m| (m.line, m.words, m.frame, m.pace)).collect();
    assert_eq!(found, expected);
    let incremental: Vec<_> = moves(&program).iter().map(|m| m.incremental).collect();
    assert_eq!(incremental, [false, false, true, false, false, false, false, false]);
    assert_eq!(program.tools, [4]);
    assert!(program.steps.contains(&Step::Dwell { line: 15, seconds: 1.5 }));
    // X was written as .5 mm: its last digit is 0.1 mm, half of it the rounding.
    assert!((program.rounding[0] - 0.05).abs() < 1e-15);
}

#[test]
fn motion_that_is_not_understood_is_never_skipped() {
    let cases = [
        ("G2 X1 F100", 1, "centre or radius"),
        ("G2 X1 I1 F100", 1, "does not state"),
        ("G1 F100\nA10", 2, "machine's axes"),
        ("G1 F100\nX1 X2", 2, "second X"),
        ("X1", 1, "without G0 or G1"),
        ("G1 X1", 1, "without a feed"),
        ("G93 F10\nG1 X1", 2, "without a feed"),
        ("G0 G1 X1 F1", 1, "contradicts"),
        ("G0 X#<_unset>", 1, "no value"),
        ("/G0 X1", 1, "block delete"),
        ("G0 X1 % Y2", 1, "% must stand alone"),
        ("G0 X1e3", 1, "e3 is not understood"),
        ("M430", 1, "may move"),
        ("G38.2 Z0", 1, "without a feed"),
        ("G0 X12345678", 1, "beyond"),
        ("G4", 1, "without a time"),
        ("G0 X1 P3", 1, "P word"),
        ("O1 G0 X1", 1, "O1"),
        ("G1 X1 F0", 1, "without a feed"),
    ];
    for (text, line, part) in cases {
        let faults = read(&format!("{text}\nM2\n")).unwrap_err();
        let all: Vec<_> = faults.iter().map(|fault| format!("{fault}")).collect();
        assert!(faults.iter().any(|f| f.line == line), "{text}: {all:?}");
        assert!(all.iter().any(|fault| fault.contains(part)), "{text}: {all:?}");
    }
    let faults = read("G0 X1\nG2 X1\nQ\nG1 Y1\n").unwrap_err();
    let places: Vec<_> = faults.iter().map(|fault| (fault.line, fault.column)).collect();
    assert_eq!(places, [(2, 4), (3, 1), (4, 4)]);
    assert!(read("G0 X1\n").unwrap_err()[0].message.contains("no end"));
}

#[test]
fn the_tcp_program_is_as_the_documentation_says() {
    let kinematics = shop::kinematics(Layout::TableTable);
    let start = AxisVector::new(-300.0, -200.0, -200.0, 0.1, 0.2);
    let next = start + AxisVector::new(0.5, 0.25, 0.0, 0.01, 0.0);
    let blocks = [
        block(&kinematics, start, 0.0),
        block(&kinematics, next, 0.03),
        block(&kinematics, next, 0.5),
    ];
    let axes = words(Layout::TableTable, true);
    let style =
        Style { blend: Some(PoseTolerance::new(0.001, 0.0)), ..posted::style(LINUXCNC, axes) };
    let text = posted::text(&kinematics, &blocks, (&note(&[]), &style)).unwrap();
    let body: Vec<&str> = text.lines().filter(|line| !line.starts_with('(')).collect();
    let tip = kinematics.setup().rotation * blocks[1].pose.tip.coords;
    let x = format!("X{:.4}", tip.x);
    let motion = body.iter().find(|line| line.starts_with("G1")).unwrap();
    assert!(motion.contains(x.trim_end_matches('0')), "{motion} has {x}");
    assert!(motion.ends_with(" F2000."), "{motion}");
    assert!(!motion.contains('B'), "{motion}: B does not change");
    assert!(body.contains(&"G64 P0.001 Q0"));
    assert!(body.contains(&"G0 B-11.4592 C-5.7296"), "rotaries are reversed: {body:?}");
    assert!(text.contains("(job      a [strange] j?b $ name?G0 X99)"));
    assert!(text.is_ascii());
}

#[test]
fn the_setup_sheet_has_the_numbers() {
    let layout = Layout::TableTable;
    let kinematics = shop::kinematics(layout);
    let budget = [("strip".to_owned(), 0.016), ("rounding".to_owned(), 0.001)];
    let mut text = String::new();
    let dialects = [write::OutputFormat::Heidenhain, write::OutputFormat::LinuxCnc];
    let programs =
        write::SheetPrograms { axes: words(layout, false), dialects: &dialects, tools: &[] };
    write::setup_sheet(&mut text, &kinematics, &note(&budget), programs).unwrap();
    assert!(text.contains("X -381.0000  Y -254.0000  Z -500.0000"), "{text}");
    assert!(text.contains("Z 120.0000"), "{text}");
    assert!(text.contains("rounding                     0.001000"), "{text}");
    assert!(
        text.contains("program.heidenhain.h") && text.contains("program.linuxcnc.ngc"),
        "{text}"
    );
    assert!(!text.contains("program.g93.nc") && !text.contains("-0.0000"), "{text}");
}

#[test]
fn blocks_that_no_program_can_say_are_refused() {
    let kinematics = shop::kinematics(Layout::TableTable);
    let q = AxisVector::zeros();
    let moved = AxisVector::repeat(0.1);
    let style = posted::style(write::OutputFormat::G93, words(Layout::TableTable, false));
    let write = |blocks: &[Block]| posted::text(&kinematics, blocks, (&note(&[]), &style));
    assert_eq!(write(&[]), Err(WriteError::Empty));
    let still = [block(&kinematics, q, 0.0), block(&kinematics, moved, 0.0)];
    assert_eq!(write(&still), Err(WriteError::Duration { block: 1, duration: 0.0 }));
    let lost = [block(&kinematics, AxisVector::repeat(f64::NAN), 0.0)];
    assert!(matches!(write(&lost), Err(WriteError::Number { block: 0, .. })));
}

/// However little a planned time is above that of a round word: a program never asks for more than was planned.
#[test]
fn a_block_by_time_is_never_quicker_than_planned() {
    let kinematics = shop::kinematics(Layout::TableTable);
    let axes = words(Layout::TableTable, false);
    for share in [0.0, 1e-15, 1e-12, 5e-10, 1e-6] {
        let times = [0.001, 0.03, 1.0, 4.8].map(|time: f64| time * (1.0 + share));
        let at = |k: usize| AxisVector::new(-300.0 + k as f64, -200.0, -200.0, 0.1, 0.2);
        let mut blocks = vec![block(&kinematics, at(0), 0.0)];
        blocks.extend((1..).zip(times).map(|(k, time)| block(&kinematics, at(k), time)));
        let text = posted::plain(&kinematics, &blocks, (axes, false));
        let program = read::read(&text, &ReadOptions::new(Dialect::LinuxCnc, axes, 5)).unwrap();
        let read = moves(&program).into_iter().filter_map(|step| match step.pace {
            Pace::Inverse { seconds } => Some(seconds),
            _ => None,
        });
        let read: Vec<_> = read.collect();
        assert_eq!(read.len(), times.len());
        for (read, time) in read.iter().zip(times) {
            assert!((time..time * 1.001).contains(read), "{read} for {time}");
        }
    }
}

/// Axis values near a workpiece, and times.
fn any_blocks() -> impl Strategy<Value = Vec<(AxisVector, f64)>> {
    let q = (prop::array::uniform3(-80.0..80.0f64), prop::array::uniform2(-1.5..1.5f64));
    let q = q.prop_map(|([x, y, z], [a, b])| {
        AxisVector::new(x - 380.0, y - 250.0, z - 250.0, 2.0 * a, b)
    });
    prop::collection::vec((q, 1e-3..5.0f64), 2..20)
}

fn any_layout() -> impl Strategy<Value = Layout> {
    prop_oneof![Just(Layout::TableTable), Just(Layout::HeadHead)]
}

proptest! {
    #![proptest_config(property::cases(64))]

    /// Written and read back, every target and time is the same within rounding, and time is
    /// never shorter.
    #[test]
    fn a_program_read_back_says_what_was_written(
        layout in any_layout(), given in any_blocks(), reversed: bool, tip: bool,
        decimals in (2u8..6, 2u8..6),
    ) {
        let kinematics = shop::kinematics(layout);
        let blocks: Vec<_> = given.iter().map(|(q, t)| block(&kinematics, *q, *t)).collect();
        let axes = words(layout, reversed).with_decimals(decimals.0, decimals.1);
        let text = posted::plain(&kinematics, &blocks, (axes, tip));
        let program = read::read(&text, &ReadOptions::new(Dialect::LinuxCnc, axes, 5)).unwrap();
        let shift = write::work_offset(&kinematics).unwrap()
            + Vector3::z() * kinematics.setup().tool_length;
        let mut found = [0.0; 5];
        let mut at = 0;
        for step in moves(&program).into_iter().filter(|step| step.frame != Frame::Machine) {
            for (value, word) in found.iter_mut().zip(step.words) {
                *value = word.unwrap_or(*value);
            }
            if let Pace::Inverse { seconds } = step.pace {
                at += 1;
                prop_assert!(seconds >= blocks[at].duration && seconds < blocks[at].duration * 1.001);
            } else if step.words[0].is_none() {
                continue; // the rotaries are placed first
            }
            let linear = if tip {
                kinematics.setup().rotation * blocks[at].pose.tip.coords
            } else {
                blocks[at].q.fixed_rows::<3>(0) - shift
            };
            let meant = [linear.x, linear.y, linear.z, blocks[at].q[3], blocks[at].q[4]];
            for ((meant, found), half) in meant.iter().zip(found).zip(axes.rounding().iter()) {
                prop_assert!((meant - found).abs() <= half * (1.0 + 1e-9) + 1e-11);
            }
        }
        prop_assert_eq!(at + 1, blocks.len());
        prop_assert!(program.rounding.iter().zip(axes.rounding().iter()).all(|(r, h)| r >= &(h * 0.99)));
    }

    /// The rounding bound holds for the pose that the rounded words give.
    #[test]
    fn rounding_moves_no_point_farther_than_its_bound(
        layout in any_layout(), given in any_blocks(), tip: bool,
        part in prop::array::uniform5(-1.0..1.0f64), around in prop::array::uniform3(-1.0..1.0f64),
    ) {
        let kinematics = shop::kinematics(layout);
        let axes = words(layout, false).with_decimals(2, 2);
        let coordinates = if tip { Coordinates::Tip } else { Coordinates::Axes };
        let half = axes.rounding();
        for (q, _) in &given {
            let change = AxisVector::from(part).component_mul(&half);
            let lever = 20.0;
            let bound = write::rounding(&kinematics, q, &axes, coordinates, lever);
            let exact = kinematics.forward(q);
            let mut rounded = kinematics.forward(&(q + change));
            if tip {
                rounded.tip = exact.tip + change.fixed_rows::<3>(0);
            }
            // A point fixed to the tool, carried along by the turn of the axis.
            let local = Vector3::from(around) * (lever / 3f64.sqrt());
            let turn = nalgebra::Rotation3::rotation_between(&exact.axis, &rounded.axis).unwrap();
            let moved = (rounded.tip + turn * local - (exact.tip + local)).norm();
            prop_assert!(moved <= bound * (1.0 + 1e-3), "{moved} > {bound}");
        }
    }

    /// CL files come back within rounding.
    #[test]
    fn a_cl_file_read_back_says_what_was_written(
        stations in prop::collection::vec(
            (prop::array::uniform3(-500.0..500.0f64), prop::array::uniform3(-1.0..1.0f64)), 2..20),
    ) {
        let stations: Vec<_> = stations.iter().map(|(tip, [i, j, k])| {
            let axis = UnitVector3::new_normalize(Vector3::new(*i, *j, 1.5 + k));
            Station { pose: ToolPose { tip: Point3::from(*tip), axis }, contact: Point3::from(*tip) }
        }).collect();
        let last = stations[stations.len() - 1];
        let legs = [
            Leg { motion: Motion::Cut, stations: stations.clone() },
            Leg { motion: Motion::Link, stations: vec![last, stations[0]] },
        ];
        let mut text = String::new();
        let note = note(&[]);
        let section = write::LegSection { note: &note, legs: &legs };
        write::apt(&mut text, &[section], 5).unwrap();
        let file = read::cl(&text, 5).unwrap();
        prop_assert_eq!(file.records.len(), stations.len() + 1);
        prop_assert_eq!(file.cutter, Some([32.0, 6.0]));
        prop_assert_eq!(file.tool, Some(3));
        let rapid: Vec<_> = file.records.iter().map(|r| r.motion == ClMotion::Rapid).collect();
        prop_assert!(rapid[0] && rapid[stations.len()] && !rapid[1]);
        for (record, station) in file.records.iter().zip(&stations) {
            prop_assert!((record.pose.tip - station.pose.tip).norm() < 1e-5);
            prop_assert!((record.pose.axis.into_inner() - station.pose.axis.into_inner()).norm() < 2e-9);
        }
    }

    /// Whatever happens to a program's text, reading it ends in a result.
    #[test]
    fn mutated_text_never_stops_the_readers(
        cuts in prop::collection::vec((any::<prop::sample::Index>(), any::<char>()), 1..8),
        remove: bool,
    ) {
        let kinematics = shop::kinematics(Layout::TableTable);
        let blocks: Vec<_> = (0..5)
            .map(|i| block(&kinematics, AxisVector::repeat(f64::from(i)), 0.1)).collect();
        let axes = words(Layout::TableTable, false);
        let text = posted::plain(&kinematics, &blocks, (axes, true));
        let mut letters: Vec<char> = text.chars().collect();
        for (at, letter) in cuts {
            let at = at.index(letters.len());
            if remove { letters.remove(at); } else { letters[at] = letter; }
        }
        let text: String = letters.into_iter().collect();
        let _ = read::read(&text, &ReadOptions::new(Dialect::LinuxCnc, axes, 5));
        let _ = read::cl(&text.replace("G1 ", "GOTO/"), 5);
    }
}
