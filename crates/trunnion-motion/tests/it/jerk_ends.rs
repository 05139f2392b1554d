//! Jerk-limited schedules that start or end in motion.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::waves;

use nalgebra::Vector1;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use trunnion::feed::{FeedError, FeedOptions, FeedPlan, Limits, PathEnds, jerk, jerk_between};
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Silent};
use waves::{any_waves, machine};

const FREE: FeedOptions = FeedOptions::fastest();

/// Four fifths of the speed along the same path: what it does is inside the machine's limits.
fn gentle() -> Limits<5> {
    let Limits { velocity, rapid, acceleration, jerk, .. } = machine();
    Limits {
        velocity: velocity * 0.8,
        rapid: rapid * 0.8,
        acceleration: acceleration * 0.64,
        jerk: jerk.map(|jerk| jerk * 0.512),
        minus: None,
    }
}

fn keeps_limits(plan: &FeedPlan) {
    let pairs = [
        (plan.ratios.velocity, plan.bounds.velocity),
        (plan.ratios.acceleration, plan.bounds.acceleration),
        (plan.ratios.jerk.unwrap(), plan.bounds.jerk.unwrap()),
    ];
    for (ratio, bound) in pairs {
        assert!(bound <= 1.0 && ratio <= bound * (1.0 + 1e-9), "{:?}", plan.ratios);
    }
    assert!(plan.lower_bound <= plan.schedule.duration() * (1.0 + 1e-9));
}

/// A path cut where the plan of the whole is under way: each half can be run with the motion of the whole
/// at the cut, in hardly more time.
#[test]
fn halves_take_the_time_of_the_whole() {
    let mut runner = TestRunner::deterministic();
    for case in 0..40_usize {
        let waves = any_waves().new_tree(&mut runner).unwrap().current();
        let path = waves.path(120);
        let whole = jerk(&path, &gentle(), &FREE, &Silent).unwrap();
        let rows = &whole.schedule.pieces[0];
        let nodes = &path.pieces[0].nodes;
        let cut = 20 + (case * 37) % 80;
        let row = rows.s.iter().position(|s| s.to_bits() == nodes[cut].s.to_bits()).unwrap();
        let [speed, acceleration] = [rows.speed[row], rows.acceleration[row]];
        let half = |nodes: &[AxisNode]| AxisPath {
            pieces: vec![AxisPiece { nodes: nodes.to_vec(), ..path.pieces[0].clone() }],
        };
        let plan = |path: &AxisPath, ends: [f64; 2], accelerations: [f64; 2]| {
            let options = FeedOptions { end_speeds: ends.into(), ..FREE };
            jerk_between(path, &machine(), &options, accelerations.into(), &Silent).unwrap()
        };
        let first = plan(&half(&nodes[..=cut]), [0.0, speed], [0.0, acceleration]);
        let second = plan(&half(&nodes[cut..]), [speed, 0.0], [acceleration, 0.0]);
        for half in [&first, &second] {
            keeps_limits(half);
        }
        let [start, end] = [&second.schedule.pieces[0], &first.schedule.pieces[0]];
        let last = end.s.len() - 1;
        for (got, want) in [
            (start.speed[0], speed),
            (start.acceleration[0], acceleration),
            (end.speed[last], speed),
            (end.acceleration[last], acceleration),
        ] {
            assert!((got - want).abs() <= 1e-9 * (speed + acceleration.abs()), "{got} {want}");
        }
        let both = first.schedule.duration() + second.schedule.duration();
        let time = whole.schedule.duration();
        assert!(both < 1.002 * time, "{case}: {both} s in halves, {time} s");
    }
}

fn line(length: f64) -> AxisPath<1> {
    let zero = Vector1::zeros();
    let at = |k: u32| {
        let s = length * f64::from(k) / 100.0;
        let q = [Vector1::new(s), Vector1::new(1.0), zero, zero];
        AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
    };
    let nodes = (0..=100).map(at).collect();
    AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
}

/// 50 mm/s, 500 mm/s², 10^4 mm/s³: from rest to 50 mm/s in 0.15 s over 3.75 mm.
#[test]
fn a_line_from_motion_to_motion_is_a_pencil_calculation() {
    let one = |value| Vector1::new(value);
    let limits = Limits {
        velocity: one(50.0),
        rapid: one(50.0),
        acceleration: one(500.0),
        jerk: Some(one(1e4)),
        minus: None,
    };
    let time = |length: f64, ends: [f64; 2]| {
        let options = FeedOptions { end_speeds: ends.into(), ..FREE };
        let plan = jerk(&line(length), &limits, &options, &Silent)?;
        keeps_limits(&plan);
        Ok::<f64, FeedError>(plan.schedule.duration())
    };
    for (length, ends, want) in [
        (10.0, [50.0, 50.0], 0.2),
        (3.75 + 5.0, [50.0, 0.0], 0.15 + 0.1),
        (3.75 + 5.0, [0.0, 50.0], 0.15 + 0.1),
        // From 20 to 50 mm/s: 0.05 s of jerk to 500 mm/s² and 12.5 mm/s more, 0.01 s, 0.05 s; mean 35 mm/s.
        (0.11 * 35.0 + 5.0, [20.0, 50.0], 0.11 + 0.1),
    ] {
        let got = time(length, ends).unwrap();
        assert!(got >= want * (1.0 - 1e-9) && got <= want * 1.005, "{length}: {got} s, {want} s");
    }
    // 3.75 mm are needed to stop from 50 mm/s. From 20 mm/s it is 2 sqrt(20 / 1e4) s, 0.894 mm.
    let Err(FeedError::StartTooFast { speed, most }) = time(0.8, [20.0, 0.0]) else {
        panic!("started too fast");
    };
    let largest = (0.8 * 100.0_f64).powi(2).cbrt();
    assert!(speed.to_bits() == 20.0_f64.to_bits() && most <= largest, "{most} of {largest}");
    // What is named can be had.
    time(0.8, [most, 0.0]).unwrap();
    let Err(FeedError::EndTooFast { .. }) = time(0.8, [0.0, 20.0]) else {
        panic!("ended too fast");
    };
    let error = time(10.0, [60.0, 0.0]).unwrap_err();
    assert!(matches!(error, FeedError::StartTooFast { most, .. } if most <= 50.0), "{error}");
    let options = FeedOptions { end_speeds: PathEnds { start: 20.0, end: 0.0 }, ..FREE };
    let refused = |accelerations: [f64; 2]| {
        jerk_between(&line(5.0), &limits, &options, accelerations.into(), &Silent).unwrap_err()
    };
    assert!(refused([f64::NAN, 0.0]).to_string().contains("start acceleration is NaN"));
    assert!(refused([0.0, 1.0]).to_string().contains("end acceleration is 1 at speed 0"));
}
