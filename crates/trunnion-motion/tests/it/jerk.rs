//! Jerk-limited schedules on random paths, in any unit, against differences of positions.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::waves;

use nalgebra::SVector;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use rayon::prelude::*;
use trunnion::feed::{
    BindingLimit, FeedOptions, FeedPlan, Limits, ProgrammedSpeeds, jerk, optimal,
};
use trunnion::setpoint::sample;
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Setpoint, Silent};
use waves::{FREE, Waves, any_waves, machine_in as machine, whip};

/// The same path with lengths in another unit.
fn scaled(path: &AxisPath, unit: f64) -> AxisPath {
    let mut path = path.clone();
    for node in path.pieces.iter_mut().flat_map(|piece| &mut piece.nodes) {
        node.s *= unit;
        for (order, derivative) in node.q.iter_mut().enumerate() {
            *derivative /= unit.powi(i32::try_from(order).unwrap());
            derivative.fixed_rows_mut::<3>(0).scale_mut(unit);
        }
    }
    path
}

fn broken_limits(plan: &FeedPlan) -> Option<String> {
    let jerks = [plan.ratios.jerk.unwrap(), plan.bounds.jerk.unwrap()];
    let all = [
        (plan.ratios.velocity, plan.bounds.velocity),
        (plan.ratios.acceleration, plan.bounds.acceleration),
        (jerks[0], jerks[1]),
    ];
    let kept = |(ratio, bound): &(f64, f64)| *bound <= 1.0 && *ratio <= bound * (1.0 + 1e-9);
    let slower = plan.lower_bound <= plan.schedule.duration();
    (!all.iter().all(kept) || !slower).then(|| format!("{:?} {:?}", plan.ratios, plan.bounds))
}

#[test]
fn no_path_fails_and_units_do_not_matter() {
    let mut runner = TestRunner::deterministic();
    let strategy = (any_waves(), prop::sample::select(vec![1_u32, 2, 5, 12, 30]));
    let count = if std::env::var_os("TRUNNION_TORTURE").is_some() { 100_000 } else { 2000 };
    let cases: Vec<(Waves, u32)> =
        (0..count).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect();
    let wrong: Vec<String> = cases
        .par_iter()
        .filter_map(|(waves, intervals)| {
            let path = waves.path(*intervals);
            let [mm, m, um] = [1.0, 1e-3, 1e3]
                .map(|unit| jerk(&scaled(&path, unit), &machine(unit), &FREE, &Silent).unwrap());
            let duration = mm.schedule.duration();
            for other in [&mm, &m, &um] {
                if let Some(broken) = broken_limits(other) {
                    return Some(broken);
                }
                let times = [&mm, other].map(|plan| &plan.schedule.pieces[0].t);
                let off = times[0].iter().zip(times[1]).map(|(a, b)| (a - b).abs());
                let off = off.fold(0.0, f64::max) / duration;
                if times[0].len() != times[1].len() || off > 1e-9 {
                    return Some(format!("{intervals} intervals: times differ by {off:e}"));
                }
            }
            None
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {}: {:?}", wrong.len(), cases.len(), wrong.first());
}

/// Largest jerk over its limit from third differences of positions, which are means of what happens
/// in between: they cannot exceed a limit that is kept.
fn third_differences(setpoints: &[Setpoint], limits: &Limits<5>) -> f64 {
    let dt = setpoints[1].t - setpoints[0].t;
    let mut worst = 0.0_f64;
    // The last interval is shorter than a period.
    for four in setpoints[..setpoints.len() - 1].windows(4) {
        let [p, q, r, s] = [0, 1, 2, 3].map(|k| four[k].position);
        let jerk = (s - r * 3.0 + q * 3.0 - p) / dt.powi(3);
        worst = worst.max(jerk.component_div(&limits.jerk.unwrap()).amax());
    }
    worst
}

proptest! {
    #![proptest_config(property::cases(48))]

    #[test]
    fn limits_hold_in_differences_of_setpoints(
        waves in any_waves(),
        intervals in prop::sample::select(vec![2_u32, 7, 40, 300]),
        feed in prop::option::of(5.0..300.0f64),
    ) {
        let path = waves.path(intervals);
        let options = FeedOptions {
 speeds: ProgrammedSpeeds { feed, tip: Some(400.0), ..FREE.speeds },
 ..FREE
 };
        let plan = jerk(&path, &machine(1.0), &options, &Silent).unwrap();
        prop_assert_eq!(broken_limits(&plan), None);
        let fastest = optimal(&path, &machine(1.0), &options, &Silent).unwrap();
        prop_assert!(plan.schedule.duration() >= fastest.lower_bound);
        let period = plan.schedule.duration() / 1777.3;
        let setpoints: Vec<Setpoint> = sample(&path, &plan.schedule, period).unwrap().collect();
        // Positions of 100 mm are right to 1e-14; eight roundings over dt³.
        let rounding = 8.0 * 1e-14 / period.powi(3) / 1200.0;
        let worst = third_differences(&setpoints, &machine(1.0));
        prop_assert!(worst <= 1.0 + 1e-6 + rounding, "{worst}");
        for two in setpoints.windows(2) {
            let dt = two[1].t - two[0].t;
            let change = (two[1].acceleration - two[0].acceleration).abs();
            let allowed = machine(1.0).jerk.unwrap() * (dt * (1.0 + 1e-6));
            prop_assert!(change.iter().zip(&allowed).all(|(c, a)| *c <= a + 1e-6));
        }
    }
}

/// A straight pass whose tool axis nearly passes the pole: C turns half round within 0.1 mm.
#[test]
fn a_whip_near_the_pole_keeps_limits_on_a_coarse_grid() {
    let offset = 0.05_f64;
    let at = |s: f64| {
        let d = offset * offset + s * s;
        let c = [
            (s / offset).atan(),
            offset / d,
            -2.0 * offset * s / (d * d),
            offset * (6.0 * s * s - 2.0 * offset * offset) / (d * d * d),
        ];
        let x = [s, 1.0, 0.0, 0.0];
        std::array::from_fn(|order| SVector::from([x[order], 0.0, 0.0, 0.0, c[order]]))
    };
    for spacing in [0.01, 0.1, 1.0] {
        let count = (20.0_f64 / spacing).round();
        let mut nodes = Vec::new();
        while nodes.len() as f64 <= count {
            let s = spacing * nodes.len() as f64 - 10.0;
            nodes.push(AxisNode { s, q: at(s), tip_rate: 1.0, feed_rate: 1.0 });
        }
        let path = AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] };
        let options = FREE.with_feed(50.0);
        let plan = jerk(&path, &machine(1.0), &options, &Silent).unwrap();
        assert_eq!(broken_limits(&plan), None);
        assert!(plan.ratios.jerk.unwrap() > 0.9, "{spacing}: {:?}", plan.ratios);
        assert!(plan.binding[0].contains(&BindingLimit::Jerk(4)), "{spacing}");
    }
}

/// More rows allow more: a search that came to a stand on many of them, as one did a fifth above the best, would show.
#[test]
fn more_rows_do_not_make_a_whip_slower() {
    let time = |rows| jerk(&whip(rows), &machine(1.0), &FREE, &Silent).unwrap().schedule.duration();
    let coarse = time(500);
    for rows in [1000, 2500, 4000] {
        let fine = time(rows);
        assert!(fine <= 1.001 * coarse, "{rows} rows: {fine} s, 500: {coarse} s");
    }
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let mut runner = TestRunner::deterministic();
    let waves = any_waves().new_tree(&mut runner).unwrap().current();
    let pieces = [Motion::Link, Motion::LeadIn, Motion::Cut].map(|motion| waves.piece(motion, 50));
    let path = AxisPath { pieces: pieces.to_vec() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| jerk(&path, &machine(1.0), &FREE, &Silent).unwrap())
    };
    assert_eq!(run(1), run(4));
}
