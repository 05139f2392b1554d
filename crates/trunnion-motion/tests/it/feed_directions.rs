//! Limits that differ between the directions of an axis.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::waves;

use nalgebra::{SVector, Vector1};
use proptest::prelude::*;
use trunnion::feed::{
    FeedPlan, FeedStream, GivenSpeed, Limits, MinusLimits, StreamOptions, ceiling, given, jerk,
    optimal,
};
use trunnion::setpoint::sample;
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Silent};
use waves::{FREE, any_waves, machine};

fn plan<const N: usize>(path: &AxisPath<N>, limits: &Limits<N>) -> FeedPlan {
    optimal(path, limits, &FREE, &Silent).unwrap()
}

/// 100 mm straight, towards plus or minus.
fn line(towards: f64) -> AxisPath<1> {
    let at = |s: f64| {
        let q = [towards * s, towards, 0.0, 0.0].map(Vector1::new);
        AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
    };
    let nodes = vec![at(0.0), at(100.0)];
    AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
}

/// A falling axis: 50 mm/s and 500 mm/s² up, 40 mm/s and 250 mm/s² down.
fn falling() -> Limits<1> {
    let [velocity, acceleration] = [50.0, 500.0].map(Vector1::new);
    let minus = [40.0, 250.0].map(Vector1::new);
    let minus = MinusLimits { velocity: minus[0], rapid: minus[0], acceleration: minus[1] };
    let jerk = Some(Vector1::new(1e4));
    Limits { velocity, rapid: velocity, acceleration, jerk, minus: Some(minus) }
}

/// Up: 0.1 s to 50 mm/s over 2.5 mm, 0.2 s back over 5 mm. Down: 0.16 s to 40 mm/s over 3.2 mm, and 0.08 s over
/// 1.6 mm, as braking a fall is an acceleration towards plus.
#[test]
fn a_line_takes_what_each_direction_allows() {
    for (towards, time) in [(1.0, 0.3 + 92.5 / 50.0), (-1.0, 0.24 + 95.2 / 40.0)] {
        let plan = plan(&line(towards), &falling());
        let got = plan.schedule.duration();
        assert!((got - time).abs() < 1e-9 * time, "towards {towards}: {got} s");
        assert!(plan.lower_bound <= got && plan.lower_bound > 0.9 * got);
        assert!(plan.ratios.acceleration <= 1.0 + 1e-12 && plan.ratios.acceleration > 0.999);
        let jerk = jerk(&line(towards), &falling(), &FREE, &Silent).unwrap();
        assert!(jerk.ratios.acceleration <= 1.0 && jerk.schedule.duration() > got);
    }
    let wrong = Limits {
        minus: falling().minus.map(|m| MinusLimits { rapid: -m.rapid, ..m }),
        ..falling()
    };
    let error = optimal(&line(1.0), &wrong, &FREE, &Silent).unwrap_err().to_string();
    assert!(error.contains("rapid velocity limit of axis 0 is -40"), "{error}");
}

/// Two axes that bend to opposite sides: each needs what the other has on its own side.
#[test]
fn a_ceiling_looks_at_the_side_each_axis_needs() {
    let vector = SVector::<f64, 2>::from;
    let plus = vector([100.0, 100.0]);
    let minus = MinusLimits { velocity: plus, rapid: plus, acceleration: vector([10.0, 30.0]) };
    let limits =
        Limits { velocity: plus, rapid: plus, acceleration: plus, jerk: None, minus: Some(minus) };
    // Axis 0: -10 <= A + x <= 100; axis 1: -30 <= A - x <= 100. So 2 x <= 100 + 30.
    let most = ceiling(&vector([1.0, 1.0]), &vector([1.0, -1.0]), &limits).acceleration;
    assert!((most * most - 65.0).abs() < 1e-12, "{most}");
    // The other way round, 2 x <= 100 + 10; and an axis that only turns round stops at 30.
    let most = ceiling(&vector([1.0, 1.0]), &vector([-1.0, 1.0]), &limits).acceleration;
    assert!((most * most - 55.0).abs() < 1e-12, "{most}");
    let most = ceiling(&vector([1.0, 0.0]), &vector([0.0, -2.0]), &limits).acceleration;
    assert!((most * most - 15.0).abs() < 1e-12, "{most}");
}

/// Towards minus, so many times what is allowed towards plus.
fn uneven(shares: [f64; 10]) -> Limits<5> {
    let limits = machine();
    let scaled = |of: SVector<f64, 5>, first: usize| {
        SVector::<f64, 5>::from_fn(|axis, _| of[axis] * shares[first + axis])
    };
    let minus = MinusLimits {
        velocity: scaled(limits.velocity, 0),
        rapid: scaled(limits.rapid, 0),
        acceleration: scaled(limits.acceleration, 5),
    };
    Limits { minus: Some(minus), ..limits }
}

fn mirrored(path: &AxisPath<5>) -> AxisPath<5> {
    let mut path = path.clone();
    for node in path.pieces.iter_mut().flat_map(|piece| &mut piece.nodes) {
        node.q = node.q.map(|q| -q);
    }
    path
}

/// Plus and minus exchanged.
fn exchanged(limits: &Limits<5>) -> Limits<5> {
    let minus = limits.minus.unwrap();
    let back = MinusLimits {
        velocity: limits.velocity,
        rapid: limits.rapid,
        acceleration: limits.acceleration,
    };
    let MinusLimits { velocity, rapid, acceleration } = minus;
    Limits { velocity, rapid, acceleration, minus: Some(back), ..*limits }
}

/// The larger of both directions, in both.
fn larger(limits: &Limits<5>) -> Limits<5> {
    let minus = limits.minus.unwrap();
    Limits {
        velocity: limits.velocity.sup(&minus.velocity),
        rapid: limits.rapid.sup(&minus.rapid),
        acceleration: limits.acceleration.sup(&minus.acceleration),
        minus: None,
        ..*limits
    }
}

/// Largest share of any limit at setpoints, each side by itself.
fn worst(path: &AxisPath<5>, plan: &FeedPlan, limits: &Limits<5>) -> f64 {
    let minus = limits.minus.unwrap();
    let share = |value: f64, plus: f64, minus: f64| value / if value < 0.0 { -minus } else { plus };
    let period = plan.schedule.duration() / 2000.0;
    let points = sample(path, &plan.schedule, period).unwrap();
    let mut worst = 0.0_f64;
    for point in points {
        for axis in 0..5 {
            let [v, a] = [point.velocity[axis], point.acceleration[axis]];
            worst = worst.max(share(v, limits.velocity[axis], minus.velocity[axis]));
            worst = worst.max(share(a, limits.acceleration[axis], minus.acceleration[axis]));
        }
    }
    worst
}

/// The speeds of a stream through a window.
fn streamed(path: &AxisPath<5>, limits: &Limits<5>) -> FeedPlan {
    let options = StreamOptions::fastest(64, 1e6);
    let mut stream = FeedStream::new(*limits, options).unwrap();
    let mut nodes = path.pieces[0].nodes.iter();
    let mut speeds = GivenSpeed { s: vec![0.0], speed: vec![0.0] };
    stream.begin(Motion::Cut);
    loop {
        while stream.wants() {
            let Some(node) = nodes.next() else { break };
            stream.push(*node).unwrap();
        }
        let Some(step) = stream.next() else { break };
        speeds.s.push(step.s.high);
        speeds.speed.push(step.speed.end);
    }
    given(path, &[speeds], limits, &FREE, &Silent).unwrap().0
}

proptest! {
    #![proptest_config(property::cases(40))]

    /// Kept everywhere and used; no slower than with the smaller limit of both directions, no faster than with the
    /// larger; the same in a mirror.
    #[test]
    fn both_directions_are_kept_and_used(
        waves in any_waves(),
        shares in prop::array::uniform10(0.3..3.0f64),
    ) {
        let (path, limits) = (waves.path(300), uneven(shares));
        let own = plan(&path, &limits);
        let time = own.schedule.duration();
        prop_assert!(own.bounds.velocity <= 1.0 + 1e-9 && own.bounds.acceleration <= 1.0 + 1e-9);
        let most = worst(&path, &own, &limits);
        prop_assert!(most <= 1.0 + 1e-9 && most > 0.97, "{most}");
        let [slow, fast] = [limits.smaller(), larger(&limits)]
            .map(|limits| plan(&path, &limits).schedule.duration());
        prop_assert!(fast <= time * 1.01 && time <= slow * 1.01, "{fast} {time} {slow}");
        prop_assert!(own.lower_bound <= time);
        let mirror = plan(&mirrored(&path), &exchanged(&limits)).schedule.duration();
        prop_assert!((mirror - time).abs() <= 1e-3 * time, "{mirror} {time}");
        let stream = streamed(&path, &limits);
        prop_assert!(stream.bounds.acceleration <= 1.0 + 1e-9, "{:?}", stream.bounds);
        prop_assert!(stream.bounds.velocity <= 1.0 + 1e-9, "{:?}", stream.bounds);
    }
}
