//! Speeds the user gives: times, axis values, and where limits break.

use crate::property;
use crate::waves;

use nalgebra::Vector1;
use proptest::prelude::*;
use trunnion::feed::{
    BindingLimit, FeedError, FeedPlan, GivenSpeed, LimitBreach, Limits, given, optimal,
};
use trunnion::setpoint::sample;
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Silent};
use waves::{FREE, any_waves, machine};

/// 100 mm by one axis.
fn line() -> AxisPath<1> {
    let [zero, one] = [Vector1::zeros(), Vector1::new(1.0)];
    let at = |s: f64| AxisNode {
        s,
        q: [Vector1::new(s), one, zero, zero],
        tip_rate: 1.0,
        feed_rate: 1.0,
    };
    let nodes = vec![at(0.0), at(50.0), at(100.0)];
    AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
}

fn limits(velocity: f64, acceleration: f64) -> Limits<1> {
    let velocity = Vector1::new(velocity);
    Limits {
        velocity,
        rapid: velocity,
        acceleration: Vector1::new(acceleration),
        jerk: None,
        minus: None,
    }
}

/// Up to 100 mm/s over 10 mm, and down again: 500 mm/s².
fn trapezoid() -> GivenSpeed {
    GivenSpeed { s: vec![0.0, 10.0, 90.0, 100.0], speed: vec![0.0, 100.0, 100.0, 0.0] }
}

fn run(speed: GivenSpeed, limits: &Limits<1>) -> Result<(FeedPlan, Vec<LimitBreach>), FeedError> {
    given(&line(), &[speed], limits, &FREE, &Silent)
}

#[test]
fn a_trapezoid_takes_its_time_and_keeps_wide_limits() {
    let (plan, breaches) = run(trapezoid(), &limits(100.0, 500.0)).unwrap();
    assert!((plan.schedule.duration() - 1.2).abs() < 1e-12);
    assert_eq!(breaches, []);
    assert!((plan.ratios.velocity - 1.0).abs() < 1e-12);
    assert!((plan.bounds.acceleration - 1.0).abs() < 1e-12);
    // It is the fastest there is.
    assert!((plan.lower_bound - 1.2).abs() < 1e-9, "{}", plan.lower_bound);
}

#[test]
fn a_breach_has_place_limit_and_size() {
    let (_, breaches) = run(trapezoid(), &limits(80.0, 400.0)).unwrap();
    let [speeding_up, fast, slowing_down] = breaches.as_slice() else { panic!("{breaches:?}") };
    for (breach, s) in [(speeding_up, [0.0, 10.0]), (slowing_down, [90.0, 100.0])] {
        assert_eq!(breach.limit, BindingLimit::Acceleration(0));
        assert!((breach.ratio - 1.25).abs() < 1e-12, "{breach:?}");
        assert!((breach.s.low - s[0]).abs() < 1e-9 && (breach.s.high - s[1]).abs() < 1e-9);
    }
    // 80 mm/s is passed after 6.4 mm; found to an eighth of the time over 10 mm.
    assert_eq!(fast.limit, BindingLimit::Velocity(0));
    assert!((fast.ratio - 1.25).abs() < 1e-12);
    assert!((6.4..8.0).contains(&fast.s.low) && (92.0..=93.6).contains(&fast.s.high), "{fast:?}");
    assert!((10.0..=90.0).contains(&fast.worst));
}

/// Paper 000, table 1 and (40)-(43): speed and time under constant acceleration; values of the
/// reference cases.
#[test]
fn constant_acceleration_is_the_reference() {
    for [start, acceleration, length, end, time, half_time, half] in [
        [
            0.0,
            200.0,
            72.755_809_974_713_34,
            170.594_032_691_314_68,
            0.852_970_163_456_573_4,
            0.454_897_746_638_832_5,
            20.693_195_989_708_74,
        ],
        [
            60.0,
            -3.0,
            77.973_176_578_086_82,
            55.965_712_186_404_62,
            1.344_762_604_531_791_7,
            0.424_010_037_274_570_76,
            25.170_925_468_909_87,
        ],
    ] {
        let mut path = line();
        for node in &mut path.pieces[0].nodes {
            node.s *= length / 100.0;
            node.q[0][0] = node.s;
        }
        let speed = GivenSpeed { s: vec![0.0, length], speed: vec![start, end] };
        let limits = limits(500.0, 500.0);
        let (plan, _) = given(&path, &[speed], &limits, &FREE, &Silent).unwrap();
        assert!((plan.schedule.duration() - time).abs() < 1e-10 * time);
        let state = plan.schedule.pieces[0].at_time(half_time).unwrap();
        assert!((state.s - half).abs() < 1e-10 * length, "{state:?}");
        assert!((state.acceleration - acceleration).abs() < 1e-8, "{state:?}");
    }
}

#[test]
fn wrong_speeds_are_named() {
    let error = |speed: GivenSpeed| run(speed, &limits(80.0, 400.0)).unwrap_err().in_one_line();
    let mut stop = trapezoid();
    stop.speed[1] = 0.0;
    assert!(error(stop).contains("zero from s = 0 to 10"));
    let mut short = trapezoid();
    short.s[3] = 99.0;
    assert!(error(short).contains("runs from s = 0 to 100"));
    let mut negative = trapezoid();
    negative.speed[2] = -1.0;
    assert!(error(negative).contains("row 2"));
    let mut back = trapezoid();
    back.s[2] = 5.0;
    assert!(error(back).contains("s = 5 after 10"));
    assert!(error(GivenSpeed::default()).contains("at least two rows"));
    let none = given(&line(), &[], &limits(80.0, 400.0), &FREE, &Silent).unwrap_err();
    assert_eq!(none, FeedError::GivenPieces { path: 1, given: 0 });
}

proptest! {
    #![proptest_config(property::cases(32))]

    /// The optimum given back is the optimum; run faster it breaks what was binding.
    #[test]
    fn the_optimum_given_back_breaks_nothing_and_a_faster_one_does(
        waves in any_waves(),
        faster in 1.01..3.0f64,
    ) {
        let path = waves.path(60);
        let limits = Limits { jerk: None, ..machine() };
        let best = optimal(&path, &limits, &FREE, &Silent).unwrap();
        let rows = &best.schedule.pieces[0];
        let speed = GivenSpeed { s: rows.s.clone(), speed: rows.speed.clone() };
        let (again, breaches) = given(&path, &[speed], &limits, &FREE, &Silent).unwrap();
        prop_assert!((again.schedule.duration() / best.schedule.duration() - 1.0).abs() < 1e-6);
        prop_assert!(breaches.iter().all(|breach| breach.ratio < 1.0 + 1e-6), "{breaches:?}");
        let speed = rows.speed.iter().map(|speed| speed * faster).collect();
        let speed = GivenSpeed { s: rows.s.clone(), speed };
        let (fast, breaches) = given(&path, &[speed], &limits, &FREE, &Silent).unwrap();
        let time = best.schedule.duration() / faster;
        prop_assert!((fast.schedule.duration() / time - 1.0).abs() < 1e-6);
        prop_assert!(!breaches.is_empty());
        prop_assert!(fast.lower_bound <= best.schedule.duration());
        let worst = breaches.iter().map(|breach| breach.ratio).fold(0.0, f64::max);
        prop_assert!(worst <= faster * faster * (1.0 + 1e-6), "{worst}");
        for pair in breaches.windows(2) {
            prop_assert!(pair[0].s.low <= pair[1].s.low);
        }
    }

    /// Every breach is one in the axis values a controller would get there.
    #[test]
    fn a_breach_is_seen_in_the_setpoints(waves in any_waves(), speed in 20.0..400.0f64) {
        let path = waves.path(40);
        let speed = GivenSpeed { s: vec![0.0, waves.length], speed: vec![speed; 2] };
        let limits = machine();
        let (plan, breaches) = given(&path, &[speed], &limits, &FREE, &Silent).unwrap();
        let duration = plan.schedule.duration();
        let setpoints: Vec<_> = sample(&path, &plan.schedule, duration / 5000.0).unwrap().collect();
        let of = |limit: BindingLimit| {
            let largest = |value: &dyn Fn(usize) -> f64| (0..setpoints.len()).map(value).fold(0.0, f64::max);
            match limit {
                BindingLimit::Velocity(axis) => {
                    let axis = usize::from(axis);
                    largest(&|k| setpoints[k].velocity[axis].abs() / limits.velocity[axis])
                }
                BindingLimit::Acceleration(axis) => {
                    let axis = usize::from(axis);
                    largest(&|k| setpoints[k].acceleration[axis].abs() / limits.acceleration[axis])
                }
                // Jerk is compared by the planner's own check; other limits are not set.
                _ => plan.ratios.jerk.unwrap(),
            }
        };
        for breach in &breaches {
            let seen = of(breach.limit);
            prop_assert!(breach.ratio <= seen * 1.02 + 0.02, "{breach:?}, seen {seen}");
        }
        for axis in 0..5_u8 {
            for limit in [BindingLimit::Velocity(axis), BindingLimit::Acceleration(axis)] {
                let found = breaches.iter().any(|breach| breach.limit == limit);
                prop_assert!(found || of(limit) <= 1.02, "{limit:?}");
            }
        }
    }
}
