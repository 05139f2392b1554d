//! The classical planner: reference cases, what it does to a circle, and the paper's figure 4.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::property;

use nalgebra::{SVector, Vector2};
use proptest::prelude::*;
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;
use trunnion::feed::{
    FeedError, FeedOptions, Limits, LookAhead, LookAheadOptions, PathEnds, PlannedBlock, SpeedRamp,
    StraightMoves, TinyBlocks, blocks, look_ahead, optimal,
};
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Silent};

fn cases(group: &str) -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/feed/look_ahead.json");
    let all: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    all[group].as_array().unwrap().clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn vector<const N: usize>(value: &Value) -> SVector<f64, N> {
    SVector::from_vec(numbers(value))
}

fn near(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance * want.abs().max(1.0), "{what}: {got}, not {want}");
}

#[test]
fn single_blocks_are_the_reference() {
    let all = cases("single_block");
    assert_eq!(all.len(), 8);
    for case in all {
        let at = |name: &str| number(&case[name]);
        let ramp = SpeedRamp::new(at("L"), [at("vs"), at("ve")], at("F"), [at("A"), at("D")]);
        let (id, tolerance) = (case["id"].as_str().unwrap(), at("tol"));
        for (name, got) in ["vs", "vp", "ve"].into_iter().zip(ramp.speeds) {
            near(got, number(&case["expect"][name]), tolerance, &format!("{id} {name}"));
        }
        for (name, got) in ["T1", "T2", "T3"].into_iter().zip(ramp.times) {
            near(got, number(&case["expect"][name]), tolerance, &format!("{id} {name}"));
        }
        near(ramp.duration(), at("total"), tolerance, id);
    }
}

fn limits<const N: usize>(velocity: SVector<f64, N>, acceleration: SVector<f64, N>) -> Limits<N> {
    Limits { velocity, rapid: velocity, acceleration, jerk: None, minus: None }
}

fn whole(period: f64) -> LookAheadOptions {
    LookAheadOptions::whole(period)
}

fn total(planned: &[PlannedBlock]) -> f64 {
    planned.iter().map(|block| block.ramp.duration()).sum()
}

#[test]
fn sequences_are_the_reference() {
    let all = cases("sequence");
    assert_eq!(all.len(), 10);
    for case in all {
        let (id, want) = (case["id"].as_str().unwrap(), &case["expect"]);
        let moves: Vec<SVector<f64, 5>> =
            case["moves"].as_array().unwrap().iter().map(vector).collect();
        let weight = number(&case["kw_mm_per_deg"]);
        let weights = SVector::from([1.0, 1.0, 1.0, weight, weight]);
        let limits = limits(vector(&case["vmax"]), vector(&case["amax"]));
        let ends = ["v_start", "v_end"].map(|name| number(&case[name]));
        let options = whole(number(&case["T"]));
        let (limits, feed) = (&limits, number(&case["F"]));
        let planned = look_ahead(
            &StraightMoves { travels: &moves, weights: &weights },
            limits,
            feed,
            ends.into(),
            &options,
        )
        .unwrap();
        let tolerance = number(&case["tol"]);
        let check = |name: &str, got: Vec<f64>| {
            let want = numbers(&want[name]);
            assert_eq!(got.len(), want.len(), "{id} {name}");
            for (got, want) in got.into_iter().zip(want) {
                near(got, want, tolerance, &format!("{id} {name}"));
            }
        };
        let each = |of: fn(&PlannedBlock) -> f64| planned.iter().map(of).collect::<Vec<f64>>();
        check("L", each(|block| block.length));
        check("feed", each(|block| block.feed));
        check("accel", each(|block| block.acceleration));
        check("t", each(|block| block.ramp.duration()));
        let mut speeds = each(|block| block.ramp.speeds[0]);
        speeds.push(planned.last().unwrap().ramp.speeds[2]);
        check("v", speeds);
        near(total(&planned), number(&want["total"]), tolerance, id);
    }
}

/// 50 blocks in a row are one block; stopping at each takes seven times as long.
#[test]
fn looking_ahead_makes_many_blocks_one() {
    let moves = vec![Vector2::new(0.2, 0.0); 50];
    let limits = limits(Vector2::repeat(500.0), Vector2::repeat(800.0));
    let run = |ahead: LookAhead| {
        let options = LookAheadOptions { ahead, ..LookAheadOptions::whole(0.004) };
        total(
            &look_ahead(
                &StraightMoves { travels: &moves, weights: &Vector2::repeat(1.0) },
                &limits,
                100.0,
                PathEnds::REST,
                &options,
            )
            .unwrap(),
        )
    };
    near(run(LookAhead::Whole), 0.223_606_797_749_979, 1e-12, "whole");
    near(run(LookAhead::Stops), 1.581_138_830_084_19, 1e-12, "stops");
    let dynamic = run(LookAhead::Dynamic { blocks: 5, periods: 1000.0 });
    near(dynamic, run(LookAhead::Whole), 1e-12, "a window of four seconds holds it all");
    // Five blocks of 0.2 mm stop from 40 mm/s: slower than needed, but never too fast.
    assert!(
        run(LookAhead::Blocks(5)) > run(LookAhead::Whole)
            && run(LookAhead::Blocks(5)) < run(LookAhead::Stops)
    );
    near(run(LookAhead::Blocks(50)), run(LookAhead::Whole), 1e-12, "a window as long as the path");
}

/// So many chords of a circle of 10 mm, as its own axis path too.
fn circle(count: u32) -> (Vec<Vector2<f64>>, AxisPath<2>) {
    let radius = 10.0_f64;
    let node = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
        let (sin, cos) = angle.sin_cos();
        let [along, inward] = [Vector2::new(-sin, cos), Vector2::new(-cos, -sin)];
        let q = [-inward * radius, along, inward / radius, -along / (radius * radius)];
        AxisNode { s: radius * angle, q, tip_rate: 1.0, feed_rate: 1.0 }
    };
    let nodes: Vec<_> = (0..=count).map(node).collect();
    let moves = nodes.windows(2).map(|pair| pair[1].q[0] - pair[0].q[0]).collect();
    (moves, AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] })
}

const FEED: FeedOptions = FeedOptions::fastest().with_feed(100.0);

/// Where the paper falls short: its time depends on servo period and length of blocks, and where it
/// is fast the accelerations are not kept. The optimum of the circle takes 0.73 s.
#[test]
fn a_circle_depends_on_period_and_chord() {
    let limits = limits(Vector2::repeat(500.0), Vector2::repeat(1000.0));
    for (count, period, want, least) in
        [(63, 0.004, 1.30, 0.0), (63, 0.001, 2.73, 0.0), (628, 0.004, 0.48, 6.9)]
    {
        let (moves, path) = circle(count);
        let options = whole(period);
        let planned = look_ahead(
            &StraightMoves { travels: &moves, weights: &Vector2::repeat(1.0) },
            &limits,
            400.0,
            PathEnds::REST,
            &options,
        );
        let time = total(&planned.unwrap());
        assert!((time - want).abs() < 0.02, "{count} chords, {period} s: {time} s");
        // As a path the same blocks take about the same time, and are held against the circle.
        let feeds = FEED.with_feed(400.0);
        let plan = blocks(&path, &limits, &feeds, &options, &Silent).unwrap();
        let got = plan.schedule.duration();
        assert!((got / time - 1.0).abs() < 0.01, "{got} s against {time} s");
        let most = plan.ratios.acceleration;
        assert!(most >= least, "{most} times the limit");
        let best = optimal(&path, &limits, &feeds, &Silent).unwrap().schedule.duration();
        assert!(plan.lower_bound <= best && best < 0.73, "{} {best}", plan.lower_bound);
        let at_100 = optimal(&path, &limits, &FEED, &Silent).unwrap().schedule.duration();
        assert!((at_100 - 0.73).abs() < 0.005, "{at_100}");
    }
}

#[test]
fn runs_of_tiny_blocks_are_passed_without_wavering() {
    // Directions alternate a little, so that single blocks differ in feed and acceleration.
    let turn = |k: u32| if k.is_multiple_of(2) { 0.0 } else { 0.01 };
    let moves: Vec<Vector2<f64>> = (0..60).map(|k| Vector2::new(0.1, 0.1 * turn(k))).collect();
    let limits = limits(Vector2::new(50.0, 0.3), Vector2::new(500.0, 400.0));
    let run = |tiny: Option<TinyBlocks>| {
        let options = LookAheadOptions { tiny, ..whole(0.004) };
        look_ahead(
            &StraightMoves { travels: &moves, weights: &Vector2::repeat(1.0) },
            &limits,
            100.0,
            PathEnds::REST,
            &options,
        )
        .unwrap()
    };
    let tiny = Some(TinyBlocks { length: 0.5, count: 10 });
    let [plain, joined] = [run(None), run(tiny)];
    let feeds = |planned: &[PlannedBlock]| {
        planned.windows(2).filter(|pair| pair[0].feed.to_bits() != pair[1].feed.to_bits()).count()
    };
    assert_eq!((feeds(&plain), feeds(&joined)), (59, 0));
    assert!(total(&joined) >= total(&plain));
    assert_eq!(run(Some(TinyBlocks { length: 0.05, count: 10 })), plain);
    assert_eq!(run(Some(TinyBlocks { length: 0.5, count: 60 })), plain);
}

#[test]
fn wrong_data_is_named() {
    let limits = limits(Vector2::repeat(500.0), Vector2::repeat(1000.0));
    let one = Vector2::repeat(1.0);
    let run = |moves: &[Vector2<f64>], options: LookAheadOptions, ends| {
        look_ahead(&StraightMoves { travels: moves, weights: &one }, &limits, 100.0, ends, &options)
            .unwrap_err()
    };
    let error = run(&[one], whole(0.0), PathEnds::REST);
    assert_eq!(error, FeedError::BadBlockOption { name: "servo period", value: 0.0 });
    let error = run(&[one, Vector2::new(1.0, f64::INFINITY)], whole(1e-3), PathEnds::REST);
    assert_eq!(error, FeedError::BadMove { index: 1, axis: 1, value: f64::INFINITY });
    assert!(error.to_string().contains("move 1: axis 1 moves by inf"));
    let error = run(&[one], whole(1e-3), [-1.0, 0.0].into());
    assert_eq!(error, FeedError::BadBlockOption { name: "start speed", value: -1.0 });
}

#[test]
fn a_path_that_stands_still_takes_no_time() {
    let node = |s| AxisNode { s, q: [Vector2::zeros(); 4], tip_rate: 0.0, feed_rate: 0.0 };
    let nodes = vec![node(0.0), node(1.0)];
    let path = AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes }] };
    let limits = limits(Vector2::repeat(500.0), Vector2::repeat(1000.0));
    let plan = blocks(&path, &limits, &FEED, &whole(1e-3), &Silent).unwrap();
    assert!(plan.schedule.duration().abs() < f64::MIN_POSITIVE);
}

proptest! {
    #![proptest_config(property::cases(64))]

    /// Straight moves, in any unit: blocks keep their limits and speeds go on from block to block.
    #[test]
    fn blocks_keep_their_limits(
        moves in prop::collection::vec(prop::array::uniform3(-2.0..2.0f64), 1..40),
        count in 1_usize..40,
        unit in prop::sample::select(vec![1e-3, 1.0, 1e3]),
    ) {
        let moves: Vec<SVector<f64, 3>> =
            moves.into_iter().map(|travel| SVector::from(travel) * unit).collect();
        let limits = limits(SVector::repeat(50.0 * unit), SVector::repeat(400.0 * unit));
        for ahead in [LookAhead::Whole, LookAhead::Blocks(count)] {
            let options = LookAheadOptions { ahead, ..LookAheadOptions::whole(2e-3) };
            let one = SVector::repeat(1.0);
            let planned = look_ahead(&StraightMoves { travels: &moves, weights: &one }, &limits, 70.0 * unit, PathEnds::REST, &options).unwrap();
            prop_assert!(planned[0].ramp.speeds[0].abs() < f64::MIN_POSITIVE);
            prop_assert!(planned.last().unwrap().ramp.speeds[2].abs() < f64::MIN_POSITIVE);
            for pair in planned.windows(2) {
                let [before, after] = [pair[0].ramp.speeds[2], pair[1].ramp.speeds[0]];
                prop_assert!((before - after).abs() <= 1e-12 * before);
                let turn = moves[pair[1].source] / pair[1].length - moves[pair[0].source] / pair[0].length;
                prop_assert!(turn.amax() * after <= 400.0 * unit * 2e-3 * (1.0 + 1e-12));
            }
            for block in &planned {
                let rate = (moves[block.source] / block.length).abs();
                prop_assert!(rate.amax() * block.ramp.speeds[1] <= 50.0 * unit * (1.0 + 1e-12));
                prop_assert!(rate.amax() * block.acceleration <= 400.0 * unit * (1.0 + 1e-12));
            }
        }
    }
}

/// The paper's figure 4: speed over time with a stop at every block, and with look-ahead over five
/// blocks, at a servo period of 4 ms. The picture in `docs` is compared; set `TRUNNION_DRAW` to
/// draw it anew.
#[test]
fn figure_4_is_as_committed() {
    let moves: Vec<SVector<f64, 5>> = (0..24)
        .map(|k| {
            let angle = 0.9 * (0.26 * f64::from(k)).sin();
            let (sin, cos) = angle.sin_cos();
            SVector::from([0.6 * cos, 0.6 * sin, 0.05, 0.12, 0.2 * cos])
        })
        .collect();
    let vector = |linear: f64, rotary: f64| SVector::from([linear, linear, linear, rotary, rotary]);
    let limits = limits(vector(200.0, 60.0), vector(400.0, 400.0));
    let run = |ahead: LookAhead| {
        let options = LookAheadOptions { ahead, ..LookAheadOptions::whole(0.004) };
        let weights = vector(1.0, 1.0);
        look_ahead(
            &StraightMoves { travels: &moves, weights: &weights },
            &limits,
            19.0,
            PathEnds::REST,
            &options,
        )
        .unwrap()
    };
    let [stops, five] = [run(LookAhead::Stops), run(LookAhead::Blocks(5))];
    assert!(total(&five) < 0.7 * total(&stops), "{} {}", total(&five), total(&stops));
    let drawing =
        drawing([("stopping at every block", &stops), ("looking five blocks ahead", &five)]);
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/look-ahead.svg");
    if std::env::var_os("TRUNNION_DRAW").is_some() {
        std::fs::write(&place, &drawing).unwrap();
    }
    assert!(std::fs::read_to_string(&place).unwrap() == drawing, "TRUNNION_DRAW=1 draws it anew");
}

/// Speeds over time, one curve under the other.
fn drawing(curves: [(&str, &[PlannedBlock]); 2]) -> String {
    let mut out = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 720 420\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"720\" height=\"420\" fill=\"white\"/>\n",
    );
    let seconds = 2.0_f64.max(curves.iter().map(|(_, planned)| total(planned)).fold(0.0, f64::max));
    for (index, (title, planned)) in curves.into_iter().enumerate() {
        let base = 180.0 + 200.0 * index as f64;
        let [x, y] = [|t: f64| 50.0 + 640.0 * t, |v: f64| 150.0 * v];
        let place = |t: f64, v: f64| format!("{:.2},{:.2}", x(t / seconds), base - y(v / 20.0));
        let mut points = vec![place(0.0, 0.0)];
        let mut now = 0.0;
        for PlannedBlock { ramp, .. } in planned {
            for (time, speed) in
                ramp.times.into_iter().zip([ramp.speeds[1], ramp.speeds[1], ramp.speeds[2]])
            {
                now += time;
                points.push(place(now, speed));
            }
        }
        points.dedup();
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<path d=\"M50 {top}V{base}H690\" fill=\"none\" stroke=\"#888\"/>\n\
             <text x=\"56\" y=\"{text}\">{title}: {now:.3} s</text>\n\
             <text x=\"8\" y=\"{middle}\">mm/s</text><text x=\"28\" y=\"{base}\">0</text>\
             <text x=\"22\" y=\"{full}\">20</text>\n\
             <polyline points=\"{line}\" fill=\"none\" stroke=\"#06c\" stroke-width=\"1.5\"/>",
            top = base - 160.0,
            text = base - 162.0,
            middle = base - 75.0,
            full = base - 146.0,
            line = points.join(" "),
        );
    }
    let _ = writeln!(out, "<text x=\"600\" y=\"408\">0 to {seconds:.2} s</text>\n</svg>");
    out
}
