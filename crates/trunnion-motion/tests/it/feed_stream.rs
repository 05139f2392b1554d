//! Schedules of paths that arrive bit by bit: limits, stops, loss against the whole path, memory.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::waves;

use nalgebra::{SVector, Vector1};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use trunnion::feed::{
    FeedError, FeedOptions, FeedStream, Limits, ProgrammedSpeeds, StreamOptions, StreamStep,
    optimal,
};
use trunnion::types::{AxisNode, AxisPath, Motion, Silent};
use waves::{Event, any_event, any_waves};

fn machine() -> Limits<5> {
    let velocity = SVector::from([500.0, 500.0, 500.0, 6.0, 10.0]);
    Limits {
        velocity,
        rapid: velocity,
        acceleration: SVector::from([5000.0, 5000.0, 5000.0, 60.0, 100.0]),
        jerk: None,
        minus: None,
    }
}

fn options(feed: Option<f64>, window: usize) -> StreamOptions {
    StreamOptions {
        speeds: ProgrammedSpeeds { feed, ..ProgrammedSpeeds::FASTEST },
        ..StreamOptions::fastest(window, 1e3)
    }
}

/// Everything through a window, asked for as the stream wants it.
fn run(path: &AxisPath, options: StreamOptions) -> Vec<StreamStep> {
    let mut stream = FeedStream::new(machine(), options).unwrap();
    let mut nodes = path.pieces.iter().flat_map(|piece| {
        piece.nodes.iter().enumerate().map(|(index, node)| (index, piece.motion, *node))
    });
    let mut steps = Vec::new();
    loop {
        while stream.wants() {
            let Some((index, motion, node)) = nodes.next() else { break };
            if index == 0 {
                stream.begin(motion);
            }
            stream.push(node).unwrap();
        }
        let Some(step) = stream.next() else { break };
        steps.push(step);
    }
    assert!(nodes.next().is_none());
    steps
}

fn duration(steps: &[StreamStep]) -> f64 {
    steps.last().map_or(0.0, |step| step.t + step.duration)
}

/// Largest axis velocity and acceleration over the limits, by the path's power basis, and the largest
/// gap of place, time or speed between steps.
fn worst(path: &AxisPath, steps: &[StreamStep]) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    let limits = machine();
    for step in steps {
        let piece = &path.pieces[step.piece];
        let (origin, quintic) = piece.quintic(step.interval).unwrap();
        for k in 0..=6 {
            let state = step.at(step.duration * f64::from(k) / 6.0);
            let q = quintic.at(state.s - origin);
            let velocity = q[1] * state.speed;
            let acceleration = q[1] * state.acceleration + q[2] * state.speed.powi(2);
            worst[0] = worst[0].max(velocity.component_div(&limits.velocity).amax());
            worst[1] = worst[1].max(acceleration.component_div(&limits.acceleration).amax());
        }
    }
    for two in steps.windows(2) {
        let gap = if two[0].piece == two[1].piece {
            (two[0].s.high - two[1].s.low).abs()
        } else {
            two[0].speed.end + two[1].speed.start
        };
        let late = (two[0].t + two[0].duration - two[1].t).abs();
        let jump = (two[0].speed.end - two[1].speed.start).abs();
        worst[2] = worst[2].max(gap).max(late).max(jump);
    }
    worst
}

#[test]
fn a_window_of_512_rows_loses_next_to_nothing() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for feed in [None, Some(100.0)] {
        for _ in 0..4 {
            let path = any_waves().new_tree(&mut runner).unwrap().current().path(4000);
            let mut whole = FeedOptions { time_tolerance: 1.0, ..FeedOptions::fastest() };
            whole.speeds.feed = feed;
            let best = optimal(&path, &machine(), &whole, &Silent).unwrap().schedule.duration();
            let got = duration(&run(&path, options(feed, 512)));
            assert!(got <= best * 1.001 && got >= best * (1.0 - 1e-9), "{got} s, whole {best} s");
            let all = duration(&run(&path, options(feed, 5000)));
            assert!((all / best - 1.0).abs() < 1e-9, "{all} s, whole {best} s");
        }
    }
}

#[test]
fn a_line_is_a_trapezoid_however_it_arrives() {
    let [zero, one] = [Vector1::zeros(), Vector1::new(1.0)];
    let velocity = Vector1::new(50.0);
    let limits = Limits {
        velocity,
        rapid: velocity,
        acceleration: Vector1::new(500.0),
        jerk: None,
        minus: None,
    };
    for (count, step) in [(1_u32, 0.25), (40, 100.0), (40, 0.1)] {
        let options = StreamOptions::fastest(512, step);
        let mut stream = FeedStream::new(limits, options).unwrap();
        stream.begin(Motion::Cut);
        for k in 0..=count {
            let s = 10.0 * f64::from(k) / f64::from(count);
            let q = [Vector1::new(s), one, zero, zero];
            stream.push(AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }).unwrap();
        }
        let steps: Vec<StreamStep> = stream.by_ref().collect();
        // 10 mm at 50 mm/s and 0.1 s at both ends.
        assert!((duration(&steps) - 0.3).abs() < 1e-9, "{count}: {}", duration(&steps));
        assert!((stream.time() - 0.3).abs() < 1e-9 && stream.speed() <= 0.0);
    }
}

#[test]
fn half_the_override_takes_twice_the_time_and_none_holds() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let path = any_waves().new_tree(&mut runner).unwrap().current().path(2000);
    let slow = options(Some(4.0), 512);
    let full = duration(&run(&path, slow));
    let mut stream = FeedStream::new(machine(), slow).unwrap();
    stream.begin(Motion::Cut);
    for node in &path.pieces[0].nodes {
        stream.push(*node).unwrap();
    }
    stream.set_override(0.0).unwrap();
    assert!(stream.next().is_none() && stream.held());
    stream.set_override(0.5).unwrap();
    let steps: Vec<StreamStep> = stream.by_ref().collect();
    let ratio = duration(&steps) / full;
    assert!((ratio - 2.0).abs() < 0.02, "{ratio}");
    assert!(!stream.held());
}

#[test]
fn wrong_data_is_named() {
    let bad = StreamOptions { window: 3, ..options(None, 3) };
    assert!(matches!(
        FeedStream::new(machine(), bad).unwrap_err(),
        FeedError::BadWindow { window: 3, .. }
    ));
    let mut stream = FeedStream::new(machine(), options(None, 100)).unwrap();
    let error = stream.set_override(2.5).unwrap_err();
    assert!(error.to_string().contains("2.5"), "{error}");
    let zero = SVector::zeros();
    let node = AxisNode { s: 1.0, q: [zero; 4], tip_rate: 0.0, feed_rate: 0.0 };
    stream.begin(Motion::Cut);
    stream.push(node).unwrap();
    let error = stream.push(node).unwrap_err();
    assert!(matches!(error, FeedError::NotIncreasing { piece: 0, node: 1, .. }), "{error}");
    // The wrong node was not taken; nothing moves on the right one.
    stream.push(AxisNode { s: 2.0, ..node }).unwrap();
    let steps: Vec<StreamStep> = stream.by_ref().collect();
    assert!(duration(&steps) <= 0.0);
}

proptest! {
    #![proptest_config(property::cases(64))]

    #[test]
    fn limits_hold_whatever_the_feeder_and_the_operator_do(
        waves in any_waves(),
        intervals in prop::sample::select(vec![3_u32, 20, 150, 600]),
        feed in prop::option::of(5.0..300.0f64),
        window in 4..300_usize,
        step in prop::sample::select(vec![0.05, 0.5, 100.0]),
        events in prop::collection::vec(any_event([60, 80]), 0..60),
    ) {
        let path = AxisPath {
            pieces: [Motion::Link, Motion::Cut].map(|motion| waves.piece(motion, intervals)).to_vec(),
        };
        let mut nodes = path.pieces.iter().flat_map(|piece| {
            piece.nodes.iter().enumerate().map(|(index, node)| (index, piece.motion, *node))
        });
        let options = StreamOptions { step, ..options(feed, window) };
        let mut stream = FeedStream::new(machine(), options).unwrap();
        let mut push = |stream: &mut FeedStream| {
            let Some((index, motion, node)) = nodes.next() else { return false };
            if index == 0 {
                stream.begin(motion);
            }
            stream.push(node).unwrap();
            true
        };
        let mut steps = Vec::new();
        for event in events {
            match event {
                Event::Push(count) => {
                    let _ = (0..count).take_while(|_| stream.wants() && push(&mut stream)).count();
                }
                Event::Take(count) => steps.extend(stream.by_ref().take(count)),
                Event::Override(value) => stream.set_override(value).unwrap(),
            }
        }
        // A hold stops before the end of what is known, and a resumed path runs to its end.
        stream.set_override(0.0).unwrap();
        steps.extend(stream.by_ref());
        prop_assert!(stream.speed() <= 0.0);
        stream.set_override(1.3).unwrap();
        steps.extend(stream.by_ref());
        prop_assert!(stream.speed() <= 0.0);
        while push(&mut stream) {
            if !stream.wants() {
                steps.extend(stream.next());
            }
        }
        steps.extend(stream.by_ref());
        let last = steps.last().unwrap();
        prop_assert_eq!(last.piece, 1);
        prop_assert_eq!(last.s.high.to_bits(), path.pieces[1].nodes.last().unwrap().s.to_bits());
        prop_assert!(last.speed.end <= 0.0);
        let [velocity, acceleration, gap] = worst(&path, &steps);
        prop_assert!(velocity <= 1.0 + 1e-9, "velocity {velocity}");
        prop_assert!(acceleration <= 1.0 + 1e-7, "acceleration {acceleration}");
        prop_assert!(gap <= 1e-9, "gap {gap}");
    }

    #[test]
    fn a_steady_override_keeps_its_share_of_the_feed(
        waves in any_waves(),
        feed in 5.0..100.0f64,
        value in 0.1..2.0f64,
    ) {
        let path = waves.path(300);
        let mut stream = FeedStream::new(machine(), options(Some(feed), 128)).unwrap();
        stream.set_override(value).unwrap();
        stream.begin(Motion::Cut);
        let mut nodes = path.pieces[0].nodes.iter();
        loop {
            while stream.wants() {
                let Some(node) = nodes.next() else { break };
                stream.push(*node).unwrap();
            }
            let Some(step) = stream.next() else { break };
            let node = &path.pieces[0].nodes[step.interval];
            let speed = step.speed.start * node.feed_rate;
            prop_assert!(speed <= value * feed * (1.0 + 1e-9), "{speed} {value} {feed}");
        }
    }
}

/// Ten million points: the memory is the window's. Only with `TRUNNION_TORTURE`.
#[test]
fn a_path_without_end_needs_the_memory_of_its_window() {
    let long = std::env::var_os("TRUNNION_TORTURE").is_some();
    let count: u32 = if long { 10_000_000 } else { 20_000 };
    let mut stream = FeedStream::new(machine(), options(Some(100.0), 512)).unwrap();
    stream.begin(Motion::Cut);
    let mut nodes = (0..count).map(|k| {
        let s = 0.1 * f64::from(k);
        let mut q = [SVector::zeros(); 4];
        q[0][0] = s;
        q[1][0] = 1.0;
        for (axis, (w, size)) in
            [(0.31, 2.0), (0.17, 2.0), (0.23, 0.1), (0.11, 0.2)].iter().enumerate()
        {
            let (sin, cos) = (w * s).sin_cos();
            for (order, value) in [sin, w * cos, -w * w * sin].into_iter().enumerate() {
                q[order][axis + 1] = size * value;
            }
        }
        AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
    });
    let mut taken = 0;
    loop {
        while stream.wants() {
            let Some(node) = nodes.next() else { break };
            stream.push(node).unwrap();
        }
        if stream.next().is_none() {
            break;
        }
        taken += 1;
    }
    assert_eq!(taken, count - 1);
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak = peak.and_then(|peak| peak.split_whitespace().next()?.parse::<u64>().ok());
    if let Some(kilobytes) = peak {
        assert!(kilobytes < 200 * 1024, "{kilobytes} kB");
    }
}
