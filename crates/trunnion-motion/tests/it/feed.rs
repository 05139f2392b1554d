//! Speed schedules against pencil cases, an independent planner and finite differences.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;
use crate::waves;

use nalgebra::{SVector, Vector1};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use rayon::prelude::*;
use serde_json::Value;
use std::ops::ControlFlow;
use std::path::Path;
use trunnion::feed::{
    FeedError, FeedOptions, FeedPlan, Limits, ProgrammedSpeeds, ceiling, optimal, optimal_schedule,
};
use trunnion::setpoint::sample;
use trunnion::types::{
    AxisNode, AxisPath, AxisPiece, Motion, Progress, SchedulePiece, Setpoint, Silent, Stage,
};
use waves::{FREE, Waves, any_waves, machine};

fn plan<const N: usize>(path: &AxisPath<N>, limits: &Limits<N>, options: &FeedOptions) -> FeedPlan {
    optimal(path, limits, options, &Silent).unwrap()
}

/// The schedule alone is that of the plan.
#[test]
fn a_schedule_alone_is_that_of_the_plan() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for intervals in [3, 300] {
        let path = any_waves().new_tree(&mut runner).unwrap().current().path(intervals);
        for (guarantee, time_tolerance) in WAYS {
            let options = FeedOptions { guarantee, time_tolerance, ..FREE };
            let whole = plan(&path, &machine(), &options).schedule;
            let alone = optimal_schedule(&path, &machine(), &options, &Silent).unwrap();
            let [whole, alone] = [whole, alone].map(|mut plan| plan.pieces.remove(0));
            assert_eq!(whole.s, alone.s);
            for (a, b) in whole.t.iter().zip(&alone.t) {
                assert!((a - b).abs() <= 1e-12 * whole.t.last().unwrap(), "{a} {b}");
            }
        }
    }
}

fn cases(group: &str) -> Vec<Value> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/feed/cases.json");
    let cases: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let list = cases[group].as_array().unwrap().clone();
    assert!(!list.is_empty());
    list
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn vector(value: &Value) -> SVector<f64, 5> {
    SVector::from_iterator(value.as_array().unwrap().iter().map(number))
}

/// Straight from 0 over the given displacements; `s` is the length, also at the programmed point.
fn straight<const N: usize>(steps: &[(f64, SVector<f64, N>)]) -> AxisPath<N> {
    let zero = SVector::zeros();
    let direction = steps[0].1 / steps[0].0;
    let mut nodes = vec![(0.0, zero)];
    for (length, step) in steps {
        let (s, q) = *nodes.last().unwrap();
        nodes.push((s + length, q + step));
    }
    let node =
        |(s, q)| AxisNode { s, q: [q, direction, zero, zero], tip_rate: 1.0, feed_rate: 1.0 };
    let nodes = nodes.into_iter().map(node).collect();
    AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] }
}

#[test]
fn constant_acceleration_takes_the_time_of_the_law() {
    for case in cases("time_law") {
        let get = |name: &str| number(&case[name]);
        let (start, acceleration) = (get("V0"), get("A_const"));
        let piece = SchedulePiece {
            s: vec![0.0, get("S")],
            t: vec![0.0, get("t_end")],
            speed: vec![start, get("V_end")],
            acceleration: vec![acceleration; 2],
            ..SchedulePiece::default()
        };
        let half = piece.at_time(get("t_half")).unwrap();
        assert!((half.s - get("S_half")).abs() < 1e-10 * get("S"));
        assert!((piece.time_at(get("S_half")) - get("t_half")).abs() < 1e-10);
        assert!((piece.time_at(get("S")) - get("t_end")).abs() < 1e-10);
    }
}

#[test]
fn straight_blocks_take_the_time_worked_out_by_hand() {
    for case in cases("single_block") {
        let get = |name: &str| number(&case[name]);
        let limits = Limits {
            velocity: Vector1::new(get("F")),
            rapid: Vector1::new(get("F")),
            acceleration: Vector1::new(get("A")),
            jerk: None,
            minus: None,
        };
        let path = straight(&[(get("L"), Vector1::new(get("L")))]);
        let plan = plan(&path, &limits, &FREE);
        let total = get("total");
        assert!((plan.schedule.duration() - total).abs() < 1e-9 * total, "{}", case["id"]);
        assert!((plan.lower_bound - total).abs() < 1e-9 * total, "{}", case["id"]);
    }
}

#[test]
fn collinear_blocks_are_run_as_one() {
    for case in cases("straight") {
        let per_degree = number(&case["kw_mm_per_deg"]);
        let steps: Vec<(f64, SVector<f64, 5>)> = case["moves"]
            .as_array()
            .unwrap()
            .iter()
            .map(vector)
            .map(|q| (q.fixed_rows::<3>(0).norm().hypot(per_degree * q[3].hypot(q[4])), q))
            .filter(|(length, _)| *length > 0.0)
            .collect();
        let velocity = vector(&case["vmax"]);
        let acceleration = vector(&case["amax"]);
        let limits = Limits { velocity, rapid: velocity, acceleration, jerk: None, minus: None };
        let options = FREE.with_feed(number(&case["F"]));
        let plan = plan(&straight(&steps), &limits, &options);
        let total = number(&case["total"]);
        assert!((plan.schedule.duration() - total).abs() < 1e-9 * total, "{}", case["id"]);
    }
}

#[test]
fn ceilings_of_coordinated_motion() {
    for case in cases("ceiling") {
        let [velocity, acceleration] = ["vmax", "amax"].map(|name| vector(&case[name]));
        let limits = Limits { velocity, rapid: velocity, acceleration, jerk: None, minus: None };
        let got = ceiling(&vector(&case["t"]), &vector(&case["K"]), &limits);
        for (got, want) in
            [(got.velocity, &case["velocity"]), (got.acceleration, &case["acceleration"])]
        {
            let want = number(want);
            assert!((got - want).abs() < 1e-9 * want, "{}: {got} {want}", case["id"]);
        }
    }
}

/// A planner of another kind: collocation on an even grid, feasible sets by bisection on `x`.
fn collocated(waves: &Waves, limits: &Limits<5>, intervals: u32) -> f64 {
    let h = waves.length / f64::from(intervals);
    let jets: Vec<_> = (0..=intervals)
        .map(|k| waves.at(waves.length * f64::from(k) / f64::from(intervals)))
        .collect();
    // The range of u at a node for a given x, and whether the velocity allows x.
    let range = |node: usize, x: f64| -> Option<[f64; 2]> {
        let [_, rate, curvature, _] = &jets[node];
        let mut range = [f64::NEG_INFINITY, f64::INFINITY];
        for axis in 0..5 {
            if x * rate[axis].powi(2) > limits.velocity[axis].powi(2) {
                return None;
            }
            let ends = [-1.0, 1.0]
                .map(|sign| (sign * limits.acceleration[axis] - curvature[axis] * x) / rate[axis]);
            range = [range[0].max(ends[0].min(ends[1])), range[1].min(ends[0].max(ends[1]))];
        }
        (range[0] <= range[1]).then_some(range)
    };
    let mut reach = vec![0.0; jets.len()];
    for node in (0..jets.len() - 1).rev() {
        let next = reach[node + 1];
        let allowed = |x: f64| {
            range(node, x)
                .is_some_and(|[low, high]| x + 2.0 * h * low <= next && x + 2.0 * h * high >= 0.0)
        };
        let [mut low, mut high] = [0.0, 1e6];
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if allowed(middle) { low = middle } else { high = middle }
        }
        reach[node] = low;
    }
    let [mut x, mut time] = [0.0_f64, 0.0];
    for node in 0..jets.len() - 1 {
        let [_, high] = range(node, x).unwrap();
        let next = (x + 2.0 * h * high).min(reach[node + 1]);
        time += 2.0 * h / (x.sqrt() + next.sqrt());
        x = next;
    }
    time
}

#[test]
fn another_planner_finds_the_same_time() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    for _ in 0..4 {
        let waves = any_waves().new_tree(&mut runner).unwrap().current();
        let plan = plan(&waves.path(400), &machine(), &FREE);
        let [ours, theirs] = [plan.schedule.duration(), collocated(&waves, &machine(), 4000)];
        assert!((ours / theirs - 1.0).abs() < 4e-3, "{ours} s against {theirs} s");
        assert!(plan.lower_bound <= theirs * 1.002, "{} above {theirs}", plan.lower_bound);
        assert!(plan.lower_bound > 0.99 * ours, "{} of {ours}", plan.lower_bound);
    }
}

/// Largest velocity and acceleration over their limits, from differences of positions alone. Both
/// are means of what happens in between, so they cannot exceed a limit that is kept.
fn differences(setpoints: &[Setpoint], limits: &Limits<5>) -> [f64; 2] {
    let mut worst = [0.0_f64; 2];
    for three in setpoints.windows(3) {
        let [p, q, r] = [&three[0], &three[1], &three[2]];
        let [before, after] = [q.t - p.t, r.t - q.t];
        let [v, w] = [(q.position - p.position) / before, (r.position - q.position) / after];
        let a = (w - v) / (0.5 * (before + after));
        // The last interval may be much shorter than a period: its rounding grows with 1 / dt².
        let rounding = 1e-12 / (before.min(after) * (before + after));
        worst[0] = worst[0].max(v.component_div(&limits.velocity).amax());
        worst[1] = worst[1].max(a.component_div(&limits.acceleration).amax() - rounding);
    }
    worst
}

proptest! {
    #![proptest_config(property::cases(96))]

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
        let plan = plan(&path, &machine(), &options);
        for bound in [plan.bounds.velocity, plan.bounds.acceleration] {
            prop_assert!(bound <= 1.0 + 1e-9, "{bound}");
        }
        prop_assert!(plan.ratios.velocity <= plan.bounds.velocity * (1.0 + 1e-9));
        prop_assert!(plan.ratios.acceleration <= plan.bounds.acceleration * (1.0 + 1e-9));
        prop_assert!(plan.ratios.jerk.is_some());
        prop_assert!(plan.lower_bound <= plan.schedule.duration());
        let period = plan.schedule.duration() / 1777.0;
        let setpoints: Vec<Setpoint> = sample(&path, &plan.schedule, period).unwrap().collect();
        let [velocity, acceleration] = differences(&setpoints, &machine());
        prop_assert!(velocity <= 1.0 + 1e-9, "velocity {velocity}");
        prop_assert!(acceleration <= 1.0 + 1e-6, "acceleration {acceleration}");
        if let Some(feed) = feed {
            for row in 0..plan.schedule.pieces[0].s.len() {
                let piece = &plan.schedule.pieces[0];
                let rate = waves.at(piece.s[row])[1].fixed_rows::<3>(0).norm();
                // Between nodes the feed rate is linear, so only nodes are exact.
                let at_node = path.pieces[0].nodes.iter().any(|n| n.s.to_bits() == piece.s[row].to_bits());
                prop_assert!(!at_node || piece.speed[row] * rate <= feed * (1.0 + 1e-9));
            }
        }
    }

    #[test]
    fn units_do_not_matter(waves in any_waves(), unit in prop::sample::select(vec![1e-3, 1e3])) {
        let path = waves.path(60);
        let mut scaled = path.clone();
        for node in &mut scaled.pieces[0].nodes {
            node.s *= unit;
            for (order, derivative) in node.q.iter_mut().enumerate() {
                *derivative /= f64::powi(unit, i32::try_from(order).unwrap());
                derivative.fixed_rows_mut::<3>(0).scale_mut(unit);
            }
        }
        let mut limits = machine();
        for limit in [&mut limits.velocity, &mut limits.rapid, &mut limits.acceleration] {
            limit.fixed_rows_mut::<3>(0).scale_mut(unit);
        }
        let [one, two] = [plan(&path, &machine(), &FREE), plan(&scaled, &limits, &FREE)];
        let [one, two] = [&one.schedule.pieces[0], &two.schedule.pieces[0]];
        prop_assert_eq!(one.t.len(), two.t.len());
        let duration = one.t.last().unwrap();
        for (a, b) in one.t.iter().zip(&two.t) {
            prop_assert!((a - b).abs() <= 1e-9 * duration, "{a} {b}");
        }
    }

    #[test]
    fn setpoints_integrate_to_positions(waves in any_waves()) {
        let path = waves.path(50);
        let plan = plan(&path, &machine(), &FREE);
        let period = plan.schedule.duration() / 4000.3;
        let setpoints: Vec<Setpoint> = sample(&path, &plan.schedule, period).unwrap().collect();
        let mut position = setpoints[0].position;
        for two in setpoints.windows(2) {
            let dt = two[1].t - two[0].t;
            position += (two[0].velocity + two[1].velocity) * (0.5 * dt);
            // Trapezoids are wrong by at most a dt² / 4 where the acceleration reverses.
            let allowed = machine().acceleration * (0.25 * period * two[1].t);
            let off = (position - two[1].position).abs();
            prop_assert!(off.iter().zip(allowed.iter()).all(|(off, allowed)| off <= allowed));
        }
        let last = setpoints.last().unwrap();
        prop_assert_eq!(last.position, path.pieces[0].nodes.last().unwrap().q[0]);
        prop_assert_eq!(last.velocity, SVector::<f64, 5>::zeros());
    }
}

/// The same path and limits with lengths in another unit.
fn in_unit(path: &AxisPath, limits: &Limits<5>, unit: f64) -> (AxisPath, Limits<5>) {
    let (mut path, mut limits) = (path.clone(), *limits);
    for node in path.pieces.iter_mut().flat_map(|piece| &mut piece.nodes) {
        node.s *= unit;
        for (order, derivative) in node.q.iter_mut().enumerate() {
            *derivative /= f64::powi(unit, i32::try_from(order).unwrap());
            derivative.fixed_rows_mut::<3>(0).scale_mut(unit);
        }
    }
    for limit in [&mut limits.velocity, &mut limits.rapid, &mut limits.acceleration] {
        limit.fixed_rows_mut::<3>(0).scale_mut(unit);
    }
    (path, limits)
}

/// Ways to plan: rows alone, limits everywhere, rows inserted as well.
const WAYS: [(bool, f64); 3] = [(false, 1.0), (true, 1.0), (true, 2e-3)];

/// What is wrong with the plans of one path in mm, m and um.
fn wrong_in_units(path: &AxisPath, options: &FeedOptions) -> Option<String> {
    let one = plan(path, &machine(), options);
    // Rates of the programmed point are per unit of s, and so is the feed.
    let others = [1e-3, 1e3].map(|unit| {
        let (path, limits) = in_unit(path, &machine(), unit);
        let mut options = *options;
        options.speeds.feed = options.speeds.feed.map(|feed| feed * unit);
        plan(&path, &limits, &options)
    });
    for two in [&one, &others[0], &others[1]] {
        let bounds = [two.bounds.velocity, two.bounds.acceleration];
        if options.guarantee && bounds.iter().any(|bound| *bound > 1.0 + 1e-9) {
            return Some(format!("{bounds:?}"));
        }
        let [from, to] = [&one, two].map(|plan| &plan.schedule.pieces[0].t);
        let off = from.iter().zip(to).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let share = off / one.schedule.duration();
        if from.len() != to.len() || share > 1e-9 {
            return Some(format!("{} and {} rows, {share:e}", from.len(), to.len()));
        }
    }
    None
}

/// 2000 paths, 100 000 with `TRUNNION_TORTURE`.
#[test]
fn no_path_fails_and_every_unit_gives_the_same_schedule() {
    let count = if std::env::var_os("TRUNNION_TORTURE").is_some() { 100_000 } else { 2000 };
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let intervals = prop::sample::select(vec![1_u32, 2, 9, 30, 60]);
    let strategy = (any_waves(), intervals, prop::option::of(5.0..300.0f64));
    let cases: Vec<_> =
        (0..count).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect();
    let wrong: Vec<String> = cases
        .par_iter()
        .enumerate()
        .filter_map(|(index, (waves, intervals, feed))| {
            let (guarantee, time_tolerance) = WAYS[index % WAYS.len()];
            let mut options = FeedOptions { guarantee, time_tolerance, ..FREE };
            options.speeds.feed = *feed;
            let wrong = wrong_in_units(&waves.path(*intervals), &options)?;
            Some(format!("{wrong}: {waves:?} {intervals} {options:?}"))
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {count}: {:?}", wrong.len(), wrong.first());
}

/// A straight pass whose tool axis nearly passes the pole: C turns half round within 0.1 mm.
#[test]
fn a_whip_near_the_pole_keeps_limits_on_a_coarse_grid() {
    let offset = 0.05_f64;
    let at = |s: f64| {
        // C = atan(s / offset) and its derivatives.
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
        let mut s = -10.0;
        while nodes.len() as f64 <= count {
            nodes.push(AxisNode { s, q: at(s), tip_rate: 1.0, feed_rate: 1.0 });
            s += spacing;
        }
        let path = AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] };
        let plan = plan(&path, &machine(), &FREE.with_feed(50.0));
        assert!(plan.bounds.acceleration <= 1.0 + 1e-9, "{spacing}: {:?}", plan.bounds);
        assert!(plan.ratios.acceleration > 0.9, "{spacing}: {:?}", plan.ratios);
        let period = plan.schedule.duration() / 20_000.0;
        let setpoints: Vec<Setpoint> = sample(&path, &plan.schedule, period).unwrap().collect();
        let [velocity, acceleration] = differences(&setpoints, &machine());
        assert!(velocity <= 1.0 + 1e-9 && acceleration <= 1.0 + 1e-4, "{spacing}: {acceleration}");
        assert!(plan.lower_bound <= plan.schedule.duration());
    }
}

#[test]
fn pieces_rest_where_they_meet_and_any_number_of_threads_gives_the_same() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let waves = any_waves().new_tree(&mut runner).unwrap().current();
    let piece = |motion| waves.piece(motion, 50);
    let pieces = [Motion::Link, Motion::LeadIn, Motion::Cut, Motion::LeadOut].map(piece);
    let path = AxisPath { pieces: pieces.to_vec() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| plan(&path, &machine(), &FREE))
    };
    let [one, four] = [run(1), run(4)];
    assert_eq!(one, four);
    for pair in one.schedule.pieces.windows(2) {
        assert_eq!(pair[0].t.last(), pair[1].t.first());
        assert!(pair[0].speed.last().unwrap().abs() + pair[1].speed[0].abs() < f64::MIN_POSITIVE);
    }
    for (rows, binding) in one.schedule.pieces.iter().zip(&one.binding) {
        assert_eq!(rows.s.len(), binding.len());
    }
}

#[test]
fn a_stop_asked_for_is_a_stop() {
    struct Stop;
    impl Progress for Stop {
        fn report(&self, _: Stage, _: u64, _: u64) -> ControlFlow<()> {
            ControlFlow::Break(())
        }
    }
    let path = straight(&[(1.0, Vector1::new(1.0))]);
    let one = Vector1::new(1.0);
    let limits = Limits { velocity: one, rapid: one, acceleration: one, jerk: None, minus: None };
    let error = optimal(&path, &limits, &FREE, &Stop).unwrap_err();
    assert!(matches!(error, FeedError::Cancelled(_)));
}
