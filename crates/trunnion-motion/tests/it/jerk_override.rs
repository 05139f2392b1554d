//! Feed hold, resume and override under jerk limits.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::waves;

use nalgebra::{SVector, Vector1};
use proptest::prelude::*;
use trunnion::feed::{
    FeedError, JerkStream, Limits, ProgrammedSpeeds, SpeedOverrides, StreamOptions, StreamStep,
};
use trunnion::types::{AxisNode, AxisPath, Motion};
use waves::{Event, any_event, any_waves, machine};

fn options(feed: Option<f64>, window: usize) -> StreamOptions {
    StreamOptions {
        speeds: ProgrammedSpeeds { feed, ..ProgrammedSpeeds::FASTEST },
        ..StreamOptions::fastest(window, 1.0)
    }
}

/// Largest velocity, acceleration and jerk over their limits, densely in time on the path's own
/// quintics in the power basis, and the largest gap between steps.
fn worst(path: &AxisPath, steps: &[StreamStep]) -> [f64; 4] {
    let limits = machine();
    let mut worst = [0.0_f64; 4];
    for step in steps {
        let piece = &path.pieces[step.piece];
        let velocity = if piece.motion.is_free() { limits.rapid } else { limits.velocity };
        let over =
            |values: SVector<f64, 5>, limits: &SVector<f64, 5>| values.component_div(limits).amax();
        let (origin, quintic) = piece.quintic(step.interval).unwrap();
        for k in 0..=6 {
            let m = step.at(step.duration * f64::from(k) / 6.0);
            let [_, t, c, l] = quintic.at(m.s - origin);
            let [v, a, j] = [m.speed, m.acceleration, m.jerk];
            let all = [
                over(t * v, &velocity),
                over(t * a + c * (v * v), &limits.acceleration),
                over(t * j + c * (3.0 * v * a) + l * v.powi(3), &limits.jerk.unwrap()),
            ];
            for (worst, value) in worst.iter_mut().zip(all) {
                *worst = worst.max(value);
            }
        }
    }
    for two in steps.windows(2) {
        let v = (two[0].speed.end - two[1].speed.start).abs() / two[0].speed.end.max(1.0);
        let a = (two[0].end_acceleration - two[1].acceleration).abs() / 1e4;
        let t = (two[0].t + two[0].duration - two[1].t).abs();
        let same = two[0].piece == two[1].piece;
        let s = if same { (two[0].s.high - two[1].s.low).abs() } else { 0.0 };
        worst[3] = worst[3].max(s).max(v).max(a).max(t);
    }
    worst
}

fn line(length: u32) -> impl Iterator<Item = AxisNode<1>> {
    let (zero, one) = (Vector1::zeros(), Vector1::new(1.0));
    (0..=length).map(move |s| {
        let s = f64::from(s);
        AxisNode { s, q: [Vector1::new(s), one, zero, zero], tip_rate: 1.0, feed_rate: 1.0 }
    })
}

fn straight(feed: f64) -> JerkStream<1> {
    let [velocity, acceleration, jerk] = [100.0, 500.0, 5000.0].map(Vector1::new);
    let limits = Limits { velocity, rapid: velocity, acceleration, jerk: Some(jerk), minus: None };
    let mut stream = JerkStream::new(limits, options(Some(feed), 128)).unwrap();
    stream.begin(Motion::Cut);
    stream
}

/// Takes steps until `done`, or until the stream rests.
fn until(
    stream: &mut JerkStream<1>,
    nodes: &mut impl Iterator<Item = AxisNode<1>>,
    done: impl Fn(&StreamStep) -> bool,
) -> Vec<StreamStep> {
    let mut steps = Vec::new();
    loop {
        while stream.wants() {
            let Some(node) = nodes.next() else { break };
            stream.push(node).unwrap();
        }
        let Some(step) = stream.next() else { return steps };
        steps.push(step);
        if done(&step) {
            return steps;
        }
    }
}

/// From 50 mm/s at 500 mm/s² and 5000 mm/s³: 0.1 s of jerk, nothing, 0.1 s of jerk, 5 mm. From 80 mm/s
/// 0.1 s, 0.06 s and 0.1 s: 10.4 mm.
#[test]
fn a_hold_stops_in_little_more_than_the_shortest_way() {
    for (feed, way) in [(50.0, 5.0), (80.0, 10.4)] {
        let mut stream = straight(feed);
        let mut nodes = line(400);
        let steps = until(&mut stream, &mut nodes, |step| step.s.high > 100.0);
        let from = steps.last().unwrap().s.high;
        assert!(stream.speed() > 0.98 * feed, "{}", stream.speed());
        stream.set_override(0.0).unwrap();
        let steps = until(&mut stream, &mut nodes, |_| false);
        assert!(stream.held() && stream.speed() <= 0.0);
        let stop = steps.last().unwrap().s.high;
        assert!(stop - from >= way * 0.98, "stopped after {} mm", stop - from);
        assert!(stop - from <= way * 1.35, "stopped after {} mm", stop - from);
        let fastest = steps.iter().map(|step| step.speed.end).fold(0.0, f64::max);
        assert!(fastest <= 1.01 * feed, "{fastest} mm/s after the hold");
        stream.set_override(1.0).unwrap();
        let steps = until(&mut stream, &mut nodes, |_| false);
        assert!(steps[0].s.low.to_bits() == stop.to_bits() && steps[0].speed.start <= 0.0);
        assert!(steps.last().unwrap().s.high >= 400.0 && !stream.held());
        let fastest = steps.iter().map(|step| step.speed.end).fold(0.0, f64::max);
        assert!(fastest > 0.98 * feed);
    }
}

/// At half the feed the path takes twice the time, at twice the feed half.
#[test]
fn a_changed_override_is_reached_without_a_stop() {
    for (value, feed) in [(0.5, 30.0), (1.5, 90.0)] {
        let mut stream = straight(60.0);
        let mut nodes = line(600);
        until(&mut stream, &mut nodes, |step| step.s.high > 100.0);
        stream.set_override(value).unwrap();
        let steps = until(&mut stream, &mut nodes, |step| step.s.high > 300.0);
        let slowest = steps.iter().map(|step| step.speed.end).fold(f64::INFINITY, f64::min);
        let last = steps.last().unwrap().speed.end;
        assert!((last - feed).abs() <= 0.01 * feed, "{value}: {last} mm/s");
        assert!(slowest >= 0.95 * feed.min(60.0), "{value}: down to {slowest} mm/s");
        // 5 mm and 3 mm would do from one speed to the other.
        let reached =
            steps.iter().find(|step| (step.speed.end - feed).abs() < 0.02 * feed).unwrap();
        assert!(reached.s.high < 125.0, "{value}: reached at {} mm", reached.s.high);
    }
}

#[test]
fn an_override_out_of_range_is_refused() {
    let error = straight(10.0).set_override(2.5).unwrap_err();
    assert!(matches!(error, FeedError::BadOverride { .. }), "{error}");
}

proptest! {
    #![proptest_config(property::cases(12))]

    #[test]
    fn limits_hold_whatever_the_feeder_and_the_operator_do(
        waves in any_waves(),
        intervals in prop::sample::select(vec![20_u32, 150, 400]),
        feed in prop::option::of(5.0..300.0f64),
        window in 8..300_usize,
        events in prop::collection::vec(any_event([120, 120]), 0..24),
    ) {
        let path = AxisPath {
            pieces: [Motion::Link, Motion::Cut].map(|motion| waves.piece(motion, intervals)).to_vec(),
        };
        let mut nodes = path.pieces.iter().flat_map(|piece| {
            piece.nodes.iter().enumerate().map(|(index, node)| (index, piece.motion, *node))
        });
        let mut stream = JerkStream::new(machine(), options(feed, window)).unwrap();
        let mut push = |stream: &mut JerkStream<5>| {
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
        loop {
            while stream.wants() && push(&mut stream) {}
            let Some(step) = stream.next() else { break };
            steps.push(step);
        }
        let last = steps.last().unwrap();
        prop_assert_eq!(last.piece, 1);
        prop_assert_eq!(last.s.high.to_bits(), path.pieces[1].nodes.last().unwrap().s.to_bits());
        prop_assert!(last.speed.end <= 0.0);
        let [velocity, acceleration, jerk, gap] = worst(&path, &steps);
        prop_assert!(velocity <= 1.0 + 1e-9, "velocity {velocity}");
        prop_assert!(acceleration <= 1.0 + 1e-7, "acceleration {acceleration}");
        prop_assert!(jerk <= 1.0 + 1e-6, "jerk {jerk}");
        prop_assert!(gap <= 1e-9, "gap {gap}");
    }
}

/// A straight path of one axis with the feed of 1 mm/s over its first half and 5 mm/s in tip speed over the second.
fn two_speeds(k: u32) -> AxisNode<1> {
    let (s, zero) = (f64::from(k) * 0.1, Vector1::zeros());
    let q = [Vector1::new(s), Vector1::new(1.0), zero, zero];
    let [feed_rate, tip_rate] = if k < 100 { [1.0, 0.0] } else { [0.0, 0.2] };
    AxisNode { s, q, tip_rate, feed_rate }
}

fn one_axis(window: usize) -> JerkStream<1> {
    let limits = Limits::symmetric(Vector1::new(50.0), Vector1::new(400.0), Vector1::new(1e4));
    let speeds = ProgrammedSpeeds { feed: Some(1.0), link_feed: None, tip: Some(1.0) };
    let options = StreamOptions { speeds, ..StreamOptions::fastest(window, f64::MAX) };
    let mut stream = JerkStream::new(limits, options).unwrap();
    stream.begin(Motion::Cut);
    stream
}

/// Feed and tip speed have overrides of their own, and the axes keep their speeds.
#[test]
fn feed_and_tip_speed_have_overrides_of_their_own() {
    for (feed, tip) in [(1.0, 1.0), (2.0, 0.5), (0.25, 0.1)] {
        let mut stream = one_axis(512);
        (0..=200).for_each(|k| stream.push(two_speeds(k)).unwrap());
        stream.set_speed_overrides(SpeedOverrides { feed, tip }).unwrap();
        let steps: Vec<StreamStep> = stream.by_ref().collect();
        let fastest = |low: f64, high: f64| {
            let inside = steps.iter().filter(|step| step.s.low >= low && step.s.high <= high);
            inside.map(|step| step.speed.start).fold(0.0, f64::max)
        };
        let [first, second] = [fastest(1.0, 9.0), fastest(11.0, 19.0)];
        assert!(first <= feed && first > 0.98 * feed, "{feed}: {first}");
        assert!(second <= 5.0 * tip && second > 0.98 * 5.0 * tip, "{tip}: {second}");
    }
    let refused = |feed, tip| one_axis(512).set_speed_overrides(SpeedOverrides { feed, tip });
    for (feed, tip) in [(0.0, 1.0), (1.0, 0.0), (2.5, 1.0), (1.0, 1.1), (f64::NAN, 1.0)] {
        assert!(matches!(refused(feed, tip), Err(FeedError::BadOverride { .. })));
    }
}

/// A stream runs the steps that it says are uncommitted, if nothing comes between.
#[test]
fn the_uncommitted_steps_are_those_that_follow() {
    let mut stream = one_axis(32);
    stream.go_on();
    (0..=60).for_each(|k| stream.push(two_speeds(k)).unwrap());
    stream.plan_ahead();
    assert!(!stream.is_due());
    for _ in 0..10 {
        let ahead = stream.uncommitted();
        let end = ahead.last().unwrap();
        assert!(end.speed.end <= 0.0, "the plan rests at its end");
        assert_eq!(stream.next_planned(), ahead.first().copied());
    }
    // The rest of the path, and the word that it is all.
    (61..=200).for_each(|k| stream.push(two_speeds(k)).unwrap());
    stream.complete();
    assert!(stream.is_due());
    let last = stream.by_ref().last().unwrap();
    assert!((last.s.high - 20.0).abs() < 1e-12 && !stream.is_due());
}

/// A slow source of nodes does not end the path: the plan goes on from where it is.
#[test]
fn a_path_that_goes_on_is_not_ended_by_a_slow_source() {
    let mut stream = one_axis(64);
    stream.go_on();
    let mut nodes = (0..201_u32).map(two_speeds);
    nodes.by_ref().take(20).for_each(|node| stream.push(node).unwrap());
    let mut slowest = f64::INFINITY;
    let mut end = 0.0;
    loop {
        // Three nodes a step: more than the path takes.
        nodes.by_ref().take(3).for_each(|node| stream.push(node).unwrap());
        if nodes.len() == 0 {
            stream.complete();
        }
        let Some(step) = stream.next() else { break };
        end = step.s.high;
        if (2.0..18.0).contains(&end) {
            slowest = slowest.min(step.speed.end);
        }
    }
    assert!((end - 20.0).abs() < 1e-12 && slowest > 0.5, "{end} {slowest}");
}
