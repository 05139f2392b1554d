//! Blocks that are short, or in which the rotaries do nearly all: every dialect states their time, and reads it again.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::dice;
use crate::posted;

use dice::Random;
use nalgebra::{Point3, Vector3};
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, Dialect, ReadOptions};
use trunnion::nc::write::{
    self, AxisWords, OUTPUT_FORMATS, OutputFormat, ProgramForm, Style, Template,
};
use trunnion::post::{PostPace, ProgramMoves, WrittenText, read_back};
use trunnion::types::{Block, Motion, ToolPose};

/// A cut of steps from a nanometre to a millimetre; in every third the rotaries do nearly all, in every fifth all.
fn blocks(inverse: &Inverse, random: &mut Random) -> Vec<Block> {
    let kinematics = inverse.kinematics();
    let start = kinematics.machine().vector(|axis| {
        let [low, high] = axis.limits.ends();
        if (high - low).is_finite() { 0.3 * low + 0.7 * high } else { 0.3 }
    });
    let mut q = start;
    let mut pose = kinematics.forward(&q);
    let mut blocks = vec![Block { motion: Motion::Cut, q, pose, duration: 0.0 }];
    for k in 1..300_u32 {
        // The last one has words of its own: no block is left to take its time over.
        let travel = if k == 299 { 1.0 } else { 10_f64.powf(random.within(-6.0, 0.0)) };
        let turn = if k % 3 == 0 { 0.02 } else { (0.3 * travel).min(0.02) };
        let mut near = q;
        for axis in [3, 4] {
            let by = turn * random.within(-1.0, 1.0);
            // Near the start, where both rotaries are far from their ends and from the pole.
            let away = q[axis] + by - start[axis];
            near[axis] += if away.abs() > 0.1 { -by } else { by };
        }
        let step = if k % 5 == 0 { Vector3::zeros() } else { random.direction().scale(travel) };
        let to = ToolPose { tip: pose.tip + step, axis: kinematics.forward(&near).axis };
        q = inverse.near(&to, &near).unwrap();
        pose = kinematics.forward(&q);
        // From a servo period to what a slow feed takes.
        let duration = 10_f64.powf(random.within(-3.0, -1.0)) + travel / 20.0;
        blocks.push(Block { motion: Motion::Cut, q, pose, duration });
    }
    blocks
}

/// Time of the cuts of a program as it is read \[s\].
fn seconds(kinematics: &Kinematics, axes: AxisWords, dialect: Dialect, text: &str) -> f64 {
    let mut moves = ProgramMoves::new(kinematics, 1e-3).unwrap();
    let mut tip = Point3::origin();
    let mut sum = 0.0;
    for step in read::read(text, &ReadOptions::new(dialect, axes, 5)).unwrap().steps {
        let mut out = Vec::new();
        moves.step(&step, &mut out).unwrap();
        for one in out {
            let length = (one.pose.tip - tip).norm();
            sum += match one.pace {
                PostPace::Rapid => 0.0,
                PostPace::Seconds(seconds) => seconds,
                PostPace::Feed(feed) => length / feed,
            };
            tip = one.pose.tip;
        }
    }
    sum
}

/// The text of every block means what was planned, and all of them take the planned time.
#[test]
fn every_dialect_states_the_time_of_short_moves() {
    let mut random = Random(dice::seed());
    for (name, text) in BUILT_IN {
        let machine = parse(text).unwrap().machine;
        let kinematics = Kinematics::new(&machine, &Setup::new(Vector3::zeros(), [0.0; 3], 120.0));
        let axes = AxisWords::of(&machine).unwrap();
        let blocks = blocks(&Inverse::new(&kinematics).unwrap(), &mut random);
        let planned: f64 = blocks.iter().map(|block| block.duration).sum();
        for (format, dialect) in OUTPUT_FORMATS {
            let style = Style::of(&kinematics, dialect, axes);
            let template = Template::of(dialect).unwrap();
            let form = ProgramForm {
                note: &posted::NOTE,
                style: &style,
                template: &template,
                changes: &[],
            };
            let mut text = String::new();
            let ends = write::program(&mut text, &kinematics, &blocks, form).unwrap();
            let written = WrittenText { text: &text, ends: &ends };
            let read = read_back(&kinematics, &style, &blocks, written);
            assert!(read.is_ok(), "{name} {format}: {read:?}");
            if dialect == OutputFormat::Apt {
                continue;
            }
            // The reference point is the machine's, not the part's.
            let text = text.replace("G91 G28 Z0.\nG90\n", "");
            let ratio = seconds(&kinematics, axes, dialect.dialect(), &text) / planned;
            // F is rounded down; turns of a millionth of a degree are lost in the digits of a vector.
            let most = if dialect.is_vector() { 0.2 } else { 0.01 };
            assert!((ratio - 1.0).abs() < most, "{name} {format}: {ratio}");
        }
    }
}

/// A move so small or so long that its speed has no digits has the least F there is, and ends sooner.
#[test]
fn a_move_that_nearly_stands_can_be_written() {
    let (_, text) = BUILT_IN.into_iter().find(|(name, _)| *name == "ac-trunnion").unwrap();
    let machine = parse(text).unwrap().machine;
    let kinematics = Kinematics::new(&machine, &Setup::default());
    let axes = AxisWords::of(&machine).unwrap();
    let block = |x: f64, duration: f64| {
        let mut q = machine.home();
        q[0] += x;
        Block { motion: Motion::Cut, q, pose: kinematics.forward(&q), duration }
    };
    let blocks = [block(0.0, 0.0), block(-1e-4, 60.0), block(-1.0, 1.0)];
    for (format, dialect) in OUTPUT_FORMATS {
        let style = Style::of(&kinematics, dialect, axes);
        let template = Template::of(dialect).unwrap();
        let form =
            ProgramForm { note: &posted::NOTE, style: &style, template: &template, changes: &[] };
        let mut text = String::new();
        let ends = write::program(&mut text, &kinematics, &blocks, form).unwrap();
        let written = WrittenText { text: &text, ends: &ends };
        let read = read_back(&kinematics, &style, &blocks, written);
        assert!(read.is_ok(), "{format}: {read:?}");
    }
}
