//! How posting finds times, against pencil calculations.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::posted;

use nalgebra::Vector3;
use trunnion::blocks::BlockInterpolation;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::AxisWords;
use trunnion::nc::write::{OutputFormat, Style, Template};
use trunnion::post::{
    PostMethod, PostMove, PostOptions, PostPace, PostReport, PostSource, Poster, ProgramHead,
};
use trunnion::types::{PoseTolerance, ToolPose};

/// A rapid move to the first place, and moves with feed to the others, tool upright.
fn post(
    dialect: OutputFormat,
    (method, window): (PostMethod, usize),
    (places, feed): (&[[f64; 2]], f64),
) -> (String, PostReport) {
    let machine = parse(BUILT_IN[0].1).unwrap().machine;
    let setup = Setup::new(Vector3::new(0.0, 0.0, -500.0), [0.0; 3], 100.0);
    let kinematics = Kinematics::new(&machine, &setup);
    let options = PostOptions {
        method,
        window,
        ..PostOptions::within(BlockInterpolation::RotaryLinear, PoseTolerance::new(0.01, 1e-3))
    };
    let axes = AxisWords::of(&machine).unwrap();
    let style = Style::of(&kinematics, dialect, axes);
    let template = Template::of(dialect).unwrap();
    let mut poster = Poster::new(&kinematics, PostSource::Locations, &options, &style).unwrap();
    let mut text = String::new();
    for (line, &[x, y]) in (1..).zip(places) {
        let pace = if line == 1 { PostPace::Rapid } else { PostPace::Feed(feed) };
        let pose = ToolPose::new([x, y, 0.0], [0.0, 0.0, 1.0]).unwrap();
        let one = PostMove { line, pose, q: None, pace, way: BlockInterpolation::GreatCircle };
        poster
            .push(&mut text, &one, ProgramHead { note: &posted::NOTE, template: &template })
            .unwrap();
    }
    let report =
        poster.finish(&mut text, ProgramHead { note: &posted::NOTE, template: &template }).unwrap();
    (text, report)
}

/// Acceleration of X and Y of that machine \[mm/s^2\].
fn acceleration() -> f64 {
    parse(BUILT_IN[0].1).unwrap().machine.axes[0].acc
}

#[test]
fn blocks_in_line_are_one_ramp_up_and_one_down_whatever_the_window() {
    let line: Vec<[f64; 2]> = (0..=100).map(|k| [f64::from(k), 0.0]).collect();
    let (feed, a) = (50.0, acceleration());
    let wanted = 100.0 / feed + feed / a;
    for window in [4, 16, 4096] {
        let (_, report) = post(OutputFormat::LinuxCnc, (PostMethod::Blocks, window), (&line, feed));
        assert!((report.seconds.output - wanted).abs() < 1e-9, "{window}: {report:?}");
        assert!((report.seconds.input - 2.0).abs() < 1e-9);
    }
}

#[test]
fn blocks_pass_a_corner_at_what_an_axis_changes_in_a_servo_period() {
    let corner = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]];
    let (feed, a) = (50.0, acceleration());
    let machine = parse(BUILT_IN[0].1).unwrap().machine;
    let slow = a * machine.cycle.servo_period.unwrap_or(1e-3);
    // Up to the feed from rest, and down to the speed of the corner; the same backwards.
    let [up, down] = [feed * feed, feed * feed - slow * slow].map(|square| square / (2.0 * a));
    let leg = feed / a + (feed - slow) / a + (10.0 - up - down) / feed;
    let (_, report) = post(OutputFormat::LinuxCnc, (PostMethod::Blocks, 64), (&corner, feed));
    assert!((report.seconds.output - 2.0 * leg).abs() < 1e-9, "{} {leg}", report.seconds.output);
}

#[test]
fn programmed_feeds_stay_as_they_are() {
    let zigzag: Vec<[f64; 2]> = (0..=50).map(|k| [f64::from(k), f64::from(k % 2)]).collect();
    let (text, report) = post(OutputFormat::Fanuc, (PostMethod::Programmed, 64), (&zigzag, 100.0));
    assert!((report.seconds.output - report.seconds.input).abs() < 1e-9);
    let feeds: Vec<&str> = text
        .split_whitespace()
        .filter(|word| word.starts_with("F6") || word.starts_with("F5"))
        .collect();
    assert_eq!(feeds, ["F6000."], "{text}");
    assert!(report.loads.output.acceleration > 1.0, "corners at full speed are reported");
}

/// Inverse time says nothing quicker than 0.6 ms: what comes before and behind such blocks slows down in time.
#[test]
fn blocks_quicker_than_inverse_time_can_say_are_planned_as_they_are_written() {
    let steps = [[0.5; 40], [0.02; 40], [0.5; 40]].concat();
    let mut x = 0.0;
    let mut line = vec![[0.0, 0.0]];
    for step in &steps {
        x += step;
        line.push([x, 0.0]);
    }
    let a = acceleration();
    for method in [PostMethod::Optimal, PostMethod::Jerk, PostMethod::Blocks] {
        let (text, report) = post(OutputFormat::G93, (method, 4096), (&line, 100.0));
        let words = text.split_whitespace().filter_map(|word| word.strip_prefix('F'));
        let times: Vec<f64> = words.map(|word| 60.0 / word.parse::<f64>().unwrap()).collect();
        assert_eq!(times.len(), steps.len(), "{text}");
        let whole: f64 = times.iter().sum();
        assert!((whole - report.seconds.output).abs() < 1e-4 * whole, "{whole} {report:?}");
        assert!(times.iter().all(|time| *time > 5.9e-4), "{times:?}");
        let blocks: Vec<(f64, f64)> = steps.iter().zip(&times).map(|(l, t)| (l / t, *t)).collect();
        for pair in blocks.windows(2) {
            let [(v, t), (next, later)] = [pair[0], pair[1]];
            let rate = (next - v).abs() / (0.5 * (t + later));
            assert!(rate < 1.02 * a, "{method:?}: {rate} of {a} at {v} mm/s");
        }
    }
}

/// The last move is shorter than half a digit, so that no word of it changes.
#[test]
fn the_time_of_a_last_block_without_words_is_named_and_not_counted() {
    let ends_short = [[0.0, 0.0], [10.0, 0.0], [10.000_01, 0.0]];
    let (_, report) = post(OutputFormat::Fanuc, (PostMethod::Programmed, 64), (&ends_short, 1.0));
    assert!((report.unwritten_seconds - 1e-5).abs() < 1e-12, "{}", report.unwritten_seconds);
    assert!((report.seconds.output - 10.0).abs() < 1e-9, "{}", report.seconds.output);
    assert!((report.seconds.input - 10.000_01).abs() < 1e-9);
    // A further cut takes the time over.
    let goes_on = [ends_short[0], ends_short[1], ends_short[2], [20.0, 0.0]];
    let (_, report) = post(OutputFormat::Fanuc, (PostMethod::Programmed, 64), (&goes_on, 1.0));
    assert!(report.unwritten_seconds.abs() < 1e-15, "{}", report.unwritten_seconds);
    assert!((report.seconds.output - 20.0).abs() < 1e-6, "{}", report.seconds.output);
}
