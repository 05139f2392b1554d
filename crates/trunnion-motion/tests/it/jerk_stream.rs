//! Jerk-limited schedules of a path that arrives bit by bit.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::waves;

use nalgebra::SVector;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use std::ops::ControlFlow;
use trunnion::feed::{
    FeedError, FeedOptions, JerkStream, Limits, StepSampler, StreamOptions, StreamStep, jerk,
    jerk_through_window,
};
use trunnion::setpoint::sample;
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Progress, Setpoint, Silent, Stage};
use waves::{FREE, Waves, any_waves, machine, whip};

fn options(window: usize) -> StreamOptions {
    StreamOptions::fastest(window, 1.0)
}

fn run(path: &AxisPath, window: usize) -> Vec<StreamStep> {
    run_with(path, options(window))
}

fn run_with(path: &AxisPath, options: StreamOptions) -> Vec<StreamStep> {
    let mut stream = JerkStream::new(machine(), options).unwrap();
    let mut nodes = path.pieces.iter().flat_map(|piece| {
        piece.nodes.iter().enumerate().map(|(index, node)| (index == 0, piece.motion, *node))
    });
    let mut steps = Vec::new();
    loop {
        while stream.wants() {
            let Some((first, motion, node)) = nodes.next() else { break };
            if first {
                stream.begin(motion);
            }
            stream.push(node).unwrap();
        }
        let Some(step) = stream.next() else { break };
        steps.push(step);
    }
    assert!(stream.speed() <= 0.0);
    steps
}

/// Largest velocity, acceleration and jerk over their limits, from the path's own functions and the
/// steps' own motion, densely in time; and the largest jump from step to step.
fn worst(waves: &Waves, steps: &[StreamStep]) -> [f64; 4] {
    let limits = machine();
    let mut worst = [0.0_f64; 4];
    let over =
        |values: SVector<f64, 5>, limits: &SVector<f64, 5>| values.component_div(limits).amax();
    for step in steps {
        for k in 0..=6 {
            let m = step.at(step.duration * f64::from(k) / 6.0);
            let [_, t, c, l] = waves.at(m.s);
            let [v, a, j] = [m.speed, m.acceleration, m.jerk];
            let all = [
                over(t * v, &limits.velocity),
                over(t * a + c * (v * v), &limits.acceleration),
                over(t * j + c * (3.0 * v * a) + l * v.powi(3), &limits.jerk.unwrap()),
            ];
            for (worst, value) in worst.iter_mut().zip(all) {
                *worst = worst.max(value);
            }
        }
    }
    for two in steps.windows(2).filter(|two| two[0].piece == two[1].piece) {
        let s = (two[0].s.high - two[1].s.low).abs();
        let v = (two[0].speed.end - two[1].speed.start).abs() / two[0].speed.end.max(1.0);
        let a = (two[0].end_acceleration - two[1].acceleration).abs() / 1e4;
        worst[3] = worst[3].max(s).max(v).max(a);
    }
    worst
}

/// Observer that stops at a count of steps.
struct StopAt(u64);

impl Progress for StopAt {
    fn report(&self, _: Stage, done: u64, _: u64) -> ControlFlow<()> {
        if done >= self.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn a_plan_through_a_window_ends_on_request() {
    let path = whip(150);
    for rows in [0, 100] {
        let stopped = jerk_through_window(&path, &machine(), &FREE, 64, &StopAt(rows));
        assert!(matches!(stopped, Err(FeedError::Cancelled(_))), "{rows}");
    }
    assert!(jerk_through_window(&path, &machine(), &FREE, 64, &Silent).is_ok());
}

/// Sampled step by step, a path has the setpoints of the whole: two pieces, one after the other.
#[test]
fn steps_have_the_setpoints_of_the_whole() {
    let piece = whip(300).pieces.remove(0);
    let back = AxisPiece { motion: Motion::Link, ..piece.clone() };
    let path = AxisPath { pieces: vec![piece, back] };
    let plan = jerk_through_window(&path, &machine(), &FREE, 512, &Silent).unwrap();
    let wanted: Vec<Setpoint> = sample(&path, &plan.schedule, 0.001).unwrap().collect();
    let steps = run_with(
        &path,
        StreamOptions { speeds: FREE.speeds, ..StreamOptions::fastest(512, f64::MAX) },
    );
    let mut sampler = StepSampler::new(0.001);
    let mut found: Vec<Setpoint> = Vec::new();
    for step in &steps {
        let nodes = &path.pieces[step.piece].nodes;
        sampler.take(step, &[nodes[step.interval], nodes[step.interval + 1]], &mut found);
    }
    sampler.finish(&mut found);
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(&wanted) {
        assert!((found.t - wanted.t).abs() < 1e-12);
        let pairs = [
            (found.position, wanted.position, 1e-9),
            (found.velocity, wanted.velocity, 1e-7),
            (found.acceleration, wanted.acceleration, 1e-4),
        ];
        for (found, wanted, most) in pairs {
            assert!((found - wanted).amax() < most, "{found} {wanted}");
        }
    }
}

/// Through a window of 512 nodes a path takes a thousandth longer at most than planned as a whole.
#[test]
fn a_window_of_512_loses_a_thousandth() {
    let mut runner = TestRunner::deterministic();
    for _ in 0..4 {
        let mut waves = any_waves().new_tree(&mut runner).unwrap().current();
        // Long enough for five windows, with as many more waves.
        let length = waves.length;
        waves.length *= 5.0;
        for axis in &mut waves.axes {
            for wave in axis[1..].chunks_mut(3) {
                wave[1] *= waves.length / length;
            }
        }
        let path = waves.path(2600);
        let free = FeedOptions::fastest();
        let whole = jerk(&path, &machine(), &free, &Silent).unwrap().schedule.duration();
        let steps = run(&path, 512);
        let last = steps.last().unwrap();
        let got = last.t + last.duration;
        let [velocity, acceleration, jerk, jump] = worst(&waves, &steps);
        assert!(last.s.high.to_bits() == path.pieces[0].nodes[2600].s.to_bits());
        assert!(got <= 1.001 * whole, "{got} s through a window, {whole} s as a whole");
        // The quintics between nodes are not quite the waves: 1e-4 of their third derivatives.
        assert!(velocity <= 1.0 + 1e-6 && acceleration <= 1.0 + 1e-5, "{velocity} {acceleration}");
        assert!(jerk <= 1.0 + 1e-4, "{jerk}");
        assert!(jump <= 1e-9, "{jump}");
    }
}

/// Where the axes whip the way to stop is several windows long, and what was a stop has to dissolve in a place that is
/// slow in any case.
#[test]
fn a_window_loses_a_thousandth_where_the_axes_whip() {
    for rows in [1000, 1500, 2500] {
        let path = whip(rows);
        let whole = jerk(&path, &machine(), &FREE, &Silent).unwrap().schedule.duration();
        let got = run(&path, 512).last().map(|last| last.t + last.duration).unwrap();
        assert!(
            got <= 1.001 * whole,
            "{rows} rows: {got} s through a window, {whole} s as a whole"
        );
    }
}

/// From 500 mm/s a stop takes 37.5 mm, far more than the 25 mm of the window: it grows as it has to.
#[test]
fn a_window_grows_to_the_way_to_stop() {
    let node = |k: u32| {
        let s = 0.2 * f64::from(k);
        let q = [s, 1.0, 0.0, 0.0].map(|x| SVector::from([x, 0.0, 0.0, 0.0, 0.0]));
        AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
    };
    let nodes = (0..=1000).map(node).collect();
    let path = AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] };
    let steps = run(&path, 128);
    // 0.15 s each way over 37.5 mm, and 125 mm at full speed.
    let last = steps.last().unwrap();
    let [got, best] = [last.t + last.duration, 0.55];
    // The last stop but one leaves a little, a millimetre and a half before the end.
    assert!(got <= 1.03 * best, "{got} s, {best} s at best");
    let fastest = steps.iter().map(|step| step.speed.end).fold(0.0, f64::max);
    assert!(fastest > 499.0, "{fastest}");
}

/// Pieces rest where they meet, and short ones, short windows and paths are no special cases.
#[test]
fn pieces_of_any_length_are_run_to_their_ends() {
    let mut runner = TestRunner::deterministic();
    for (intervals, window) in [([1, 3, 40], 4), ([200, 1, 90], 16), ([300, 300, 2], 64)] {
        let waves = any_waves().new_tree(&mut runner).unwrap().current();
        let motions = [Motion::Link, Motion::LeadIn, Motion::Cut];
        let pieces = motions.into_iter().zip(intervals).map(|(m, count)| waves.piece(m, count));
        let path = AxisPath { pieces: pieces.collect() };
        let steps = run(&path, window);
        for (index, piece) in path.pieces.iter().enumerate() {
            let own: Vec<&StreamStep> = steps.iter().filter(|step| step.piece == index).collect();
            let [first, last] = [own.first().unwrap(), own.last().unwrap()];
            assert!(first.s.low.to_bits() == piece.nodes[0].s.to_bits());
            assert!(last.s.high.to_bits() == piece.nodes.last().unwrap().s.to_bits());
            assert!(first.speed.start <= 0.0 && last.speed.end <= 0.0);
            for step in own {
                let nodes = &piece.nodes[step.interval..=step.interval + 1];
                assert!(nodes[0].s <= step.s.low && step.s.high <= nodes[1].s);
            }
        }
        assert!(worst(&waves, &steps)[3] <= 1e-9);
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let error = |limits, options| JerkStream::new(limits, options).unwrap_err();
    let without = Limits { jerk: None, ..machine() };
    assert_eq!(error(without, options(512)), FeedError::NoJerkLimit);
    assert!(matches!(error(machine(), options(1)), FeedError::BadWindow { .. }));
}
