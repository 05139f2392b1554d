//! What the audit of a program says beside velocity and acceleration: jerk, short blocks, singular directions,
//! time. Faults are planted in one block and have to be reported there.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::audited;
use crate::shop;

use shop::Layout;
use std::f64::consts::PI;
use std::fmt::Write;
use trunnion::machine::{Kinematics, Machine};
use trunnion::nc::read::{AxisWords, Dialect};
use trunnion::verify::{Audit, Finding, Report};

fn machine() -> Machine {
    shop::machine(Layout::TableTable)
}

fn audit(text: &str, machine: &Machine) -> Audit {
    check(text, machine).audit.unwrap()
}

fn check(text: &str, machine: &Machine) -> Report {
    let words = AxisWords::of(machine).unwrap().with_decimals(6, 6);
    let kinematics = Kinematics::new(machine, &shop::setup(Layout::TableTable));
    audited::check(&kinematics, words, (text, Dialect::LinuxCnc))
}

const JERK: f64 = 5000.0;
const BLOCKS: u32 = 10;
const TIME: f64 = 0.01;
/// Lines before the first block that moves.
const HEAD: u32 = 2;

/// From rest to rest with jerk `+J -J -J +J`, exact at the ends of all blocks; one of them off by `fault`.
fn s_curve(wrong: u32, fault: f64) -> String {
    let mut text = String::from("G21 G90 G93\nG1 X0 F60\n");
    let (mut x, mut v, mut a) = (0.0, 0.0, 0.0);
    for block in 0..4 * BLOCKS {
        let jerk = if (BLOCKS..3 * BLOCKS).contains(&block) { -JERK } else { JERK };
        x += v * TIME + 0.5 * a * TIME * TIME + jerk * TIME.powi(3) / 6.0;
        v += a * TIME + 0.5 * jerk * TIME * TIME;
        a += jerk * TIME;
        let off = if block == wrong { fault } else { 0.0 };
        writeln!(text, "G1 X{:.6} F{:.5}", x + off, 60.0 / TIME).unwrap();
    }
    text + "M2\n"
}

fn limited() -> Machine {
    let mut machine = machine();
    machine.axes[0].jerk = JERK;
    machine
}

#[test]
fn a_jerk_that_is_kept_is_reported_as_kept() {
    let jerk = audit(&s_curve(0, 0.0), &limited()).axes[0].jerk;
    assert!(jerk.broken == 0 && jerk.worst <= 1.0, "{jerk:?}");
    // A micrometre of rounding in 10 ms blocks is a jerk of 1e-6 * 8 / 1e-6 s3.
    assert!((jerk.raw - 1.0).abs() < 0.01, "{jerk:?}");
    assert!(jerk.worst > 0.99, "{jerk:?}");
}

#[test]
fn a_block_that_is_off_shows_as_jerk_at_its_line() {
    let wrong = 17;
    let jerk = audit(&s_curve(wrong, 2e-3), &limited()).axes[0].jerk;
    // The third difference of a spike is 3 at its worst: over 10 ms, 2 um are 6 m/s3 more.
    assert!((jerk.worst - (1.0 + 3.0 * 2e-3 / TIME.powi(3) / JERK)).abs() < 0.02, "{jerk:?}");
    let line = HEAD + wrong + 1;
    assert!((line..=line + 2).contains(&jerk.line), "{jerk:?}");
    assert!(jerk.broken >= 1 && jerk.broken <= 4, "{jerk:?}");
}

#[test]
fn a_block_shorter_than_the_servo_period_is_named() {
    let mut machine = machine();
    let text = "G21 G90 G93\nG1 X1 F600\nG1 X1.01 F120000\nG1 X2 F600\nM2\n";
    assert_eq!(audit(text, &machine).brief, None);
    machine.cycle.servo_period = Some(0.001);
    let brief = audit(text, &machine).brief.unwrap();
    assert_eq!((brief.count, brief.line), (1, 3));
    assert!((brief.shortest - 0.0005).abs() < 1e-9, "{brief:?}");
}

/// A finger that slips at one F word costs time, and is found whether the feed is a speed or an inverse time.
#[test]
fn a_block_far_slower_than_its_neighbours_is_named() {
    let row = |k: usize, feed: f64| format!("G1 X{k} F{feed}\n");
    let program = |head: &str, feeds: [f64; 6]| {
        let rows: String = feeds.iter().enumerate().map(|(k, feed)| row(k + 1, *feed)).collect();
        format!("G21 G90 {head}\nG0 X0 Y0 Z0\n{rows}G0 Z5\nM2\n")
    };
    for (head, feed) in [("G94", 600.0), ("G93", 600.0)] {
        let even = [feed; 6];
        assert_eq!(audit(&program(head, even), &machine()).slow, None);
        // A ramp of planned feeds is no fault, however steep.
        let ramp = [10.0, 80.0, feed, feed, 70.0, 9.0];
        assert_eq!(audit(&program(head, ramp), &machine()).slow, None);
        let mut slipped = even;
        slipped[3] = 0.01 * feed;
        let slow = audit(&program(head, slipped), &machine()).slow.unwrap();
        assert_eq!((slow.count, slow.line), (1, 6));
        // 1 mm at 6 mm/min takes 10 s instead of 0.1 s.
        assert!((slow.ratio - 100.0).abs() < 1e-6 && (slow.lost - 9.9).abs() < 1e-6, "{slow:?}");
    }
}

#[test]
fn a_cut_that_nothing_leads_off_from_is_named() {
    let unended = |end: &str| {
        let text = format!("G21 G90 G94\nG0 X0 Y0 Z5\nG1 Z0 F600\nX8\n{end}M2\n");
        audit(&text, &machine()).unended.map(|of| of.line)
    };
    assert_eq!(unended(""), Some(4));
    assert_eq!(unended("G4 P1\n"), Some(4), "a pause leads nowhere");
    assert_eq!(unended("G1 Y9\n"), Some(5), "sideways is a cut as well");
    assert_eq!(unended("G1 Z5\n"), None);
    assert_eq!(unended("G0 Z5\n"), None);
    assert_eq!(unended("G53 G0 Z0\n"), None);
}

#[test]
fn passages_by_the_singular_direction_are_counted() {
    // B is the angle between tool and C; the cone is 3 degrees. The last move runs through it and out again.
    let mut machine = machine();
    machine.axes[4].home = 20.0 * PI / 180.0;
    let text = "G21 G90 G93\nG1 B2 F60\nG1 B0.5 C40 F60\nG1 B10 F60\nG1 B-10 F60\nM2\n";
    let singular = audit(text, &machine).singular.unwrap();
    assert_eq!((singular.passages, singular.line), (2, 5));
    assert!(singular.angle < 0.4 * PI / 180.0, "{singular:?}");
    assert!((singular.turn - 40.0 * PI / 180.0).abs() < 1e-9, "{singular:?}");
    assert_eq!(audit("G21 G90 G93\nG1 B8 F60\nM2\n", &machine).singular, None);
}

#[test]
fn what_asks_too_much_takes_longer() {
    let mut machine = machine();
    machine.axes[0].vel = 10.0;
    // To the origin in a minute; 10 mm in half a second, at 10 mm/s; the last block is slow enough.
    let text = "G21 G90 G93\nG1 X0 F1\nG1 X10 F120\nG1 X15 F60\nM2\n";
    let audit = audit(text, &machine);
    assert!((audit.duration - 61.5).abs() < 1e-6, "{}", audit.duration);
    assert!((audit.held - 62.0).abs() < 1e-4, "{}", audit.held);
}

#[test]
fn short_blocks_that_turn_are_slow_on_linuxcnc() {
    // Blocks of 0.1 mm in 1 ms, as fast as 100 mm/s; the rotary hardly moves.
    let machine = machine();
    let head = "G21 G90 G93\nG1 X0 F1\nG4 P1\n";
    let blocks = |turn: f64| {
        let block =
            |k: i32| format!("G1 X{:.6} B{:.6} F60000\n", 0.1 * f64::from(k), turn * f64::from(k));
        let text = head.to_owned() + &(1..=5).map(block).collect::<String>() + "M2\n";
        audit(&text, &machine).linuxcnc
    };
    // A dwell and a minute to the origin beside them. Both stops cost a cycle or two each.
    let straight = blocks(0.0);
    let acceleration = machine.axes[0].acc;
    // 0.5 mm in a straight line: half of it to speed up, half to slow down.
    let ramps = 2.0 * (0.5 / acceleration).sqrt();
    assert!((straight.seconds - 61.0 - ramps).abs() < 0.005, "{straight:?}");
    let turning = blocks(1e-5);
    // 2500 mm/s2: sqrt(a L / 2) is 11.2 mm/s. The last block comes to rest in as long as it took to reach its speed.
    let one = (2.0 * 0.1 / acceleration).sqrt();
    assert!((turning.seconds - 61.0 - 6.0 * one).abs() < 0.005, "{turning:?}");
    // From rest to that speed in the first half of a block is just what the axis can; words round by a micrometre.
    let [speed, change] = [&turning.velocity, &turning.acceleration];
    assert_eq!((speed.axis.as_str(), change.axis.as_str()), ("X", "X"));
    assert!((speed.ratio.raw - 0.1 / one / machine.axes[0].vel).abs() < 1e-4, "{speed:?}");
    assert!((change.ratio.raw - 1.0).abs() < 1e-3 && change.ratio.broken == 0, "{change:?}");
    assert_eq!(change.ratio.line, 4, "{change:?}");
    // That acceleration, twice speed over time, is there after a third of the first block.
    let jerk = &turning.jerk;
    let by_hand = 6.0 * (0.1 / one) / one.powi(2) / machine.axes[0].jerk;
    assert!(
        jerk.axis == "X" && (jerk.ratio.raw / by_hand - 1.0).abs() < 1e-3,
        "{jerk:?} {by_hand}"
    );
    assert_eq!((jerk.ratio.line, straight.jerk.ratio.broken), (4, 0), "{jerk:?}");
}

#[test]
fn slides_are_not_limited_on_linuxcnc_where_the_tip_is_programmed() {
    // The tip stands at the origin while the table tilts about a place some way off: slides follow.
    let machine = machine();
    let blocks = (1..=20).map(|k| format!("G1 B{:.6} F60000\n", 0.02 * f64::from(k)));
    let text = format!(
        "G21 G90 G93\nG1 X0.000000 Y0.000000 Z0.000000 F1\nG4 P1\n{}M2\n",
        blocks.collect::<String>()
    );
    let joints = audit(&text, &machine).linuxcnc.acceleration;
    assert!(joints.axis == "B" && joints.ratio.worst <= 1.0, "{joints:?}");
    let mut quick = machine.clone();
    quick.axes[4].acc = 100.0;
    let text = text.replace("G93\n", "G93\nM428\n");
    let tip = audit(&text, &quick).linuxcnc.acceleration;
    // 35 mm and more from the axis to the tip: 3.5 m/s2 against 2.5.
    assert!(tip.axis != "B" && tip.ratio.worst > 1.2, "{tip:?}");
}

#[test]
fn a_pivot_that_is_off_moves_the_tool_by_no_more_than_is_reported() {
    let machine = machine();
    let text = "G21 G90 G93\nG1 B30 C20 F6\nG1 B-10 C-5 F6\nM2\n";
    let pivot = check(text, &machine).deviation.sensitivity.pivot.unwrap();
    assert!((pivot - 2.0 * (15.0 * PI / 180.0).sin()).abs() < 1e-9, "{pivot}");
    let setup = shop::setup(Layout::TableTable);
    let right = Kinematics::new(&machine, &setup);
    let q = trunnion::types::AxisVector::new(-300.0, -200.0, -150.0, 20.0 * PI / 180.0, PI / 6.0);
    for (axis, way) in [(3, [0.01, 0.0, 0.0]), (4, [0.0, 0.0, 0.01]), (4, [0.01, 0.0, 0.0])] {
        let mut off = machine.clone();
        off.axes[axis].point += nalgebra::Vector3::from(way);
        let wrong = Kinematics::new(&off, &setup);
        let by = (wrong.forward(&q).tip - right.forward(&q).tip).norm();
        assert!(by <= 0.01 * pivot * (1.0 + 1e-6), "{by}");
        assert!(by > 0.3 * 0.01 * pivot, "{by}");
    }
}

/// C turns at a thousandth below and two thousandths above its limit while the tip goes 5 mm, with the F word of `feed`:
/// how often that is reported.
fn too_fast(feed: &str, seconds: f64, decimals: usize) -> Vec<String> {
    let machine = machine();
    let limit = machine.axes[3].vel.to_degrees();
    let by = |share: f64| limit * seconds * share;
    let text = |turn: f64| {
        format!(
            "G21 G90 G94\nG1 X0 Y0 Z0 F1000\n{feed} X5.0 {}{turn:.decimals$}\nM2\n",
            machine.axes[3].name
        )
    };
    let reported = |share: f64| {
        let report = check(&text(by(share)), &machine);
        report.findings.iter().filter(|f| matches!(f, Finding::Velocity { .. })).count()
    };
    [0.999, 1.002].map(|share| format!("{share}: {}", reported(share))).to_vec()
}

#[test]
fn a_speed_is_run_as_it_stands_and_words_of_one_digit_are_meant() {
    // A path of 5 mm at 100 mm/min takes 3 s; half a unit of F is not its rounding, nor is half a degree that of C.
    for (feed, seconds, decimals) in [("F100", 3.0, 4), ("F100.", 3.0, 1), ("F20", 15.0, 1)] {
        assert_eq!(too_fast(feed, seconds, decimals), ["0.999: 0", "1.002: 1"], "{feed}");
    }
    // A time is rounded: 20.00 a minute may be 20.005.
    assert_eq!(too_fast("G93 F20.00", 3.0, 4), ["0.999: 0", "1.002: 1"]);
    assert_eq!(too_fast("G93 F20", 3.0, 4), ["0.999: 0", "1.002: 0"]);
}
