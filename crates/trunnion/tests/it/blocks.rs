//! Program blocks against a search for the nearest pose of the control.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::shop;
use crate::waves;

use nalgebra::{Point3, SVector, UnitVector3, Vector3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use shop::Layout;
use trunnion::axes::{AxesOptions, FeedPoint, follow};
use trunnion::blocks::{BlockInterpolation, BlockOptions, ReduceOptions, blocks, reduce};
use trunnion::feed::{FeedOptions, Limits, optimal};
use trunnion::machine::Kinematics;
use trunnion::math::angle::{angle_between, unwrap_near};
use trunnion::toolpath::{ToolPathOptions, through};
use trunnion::types::{
    AxisPath, AxisVector, Block, Leg, Motion, PoseTolerance, Schedule, Silent, Station, ToolPose,
};
use waves::{Waves, any_waves};

const TOLERANCE: f64 = 0.005;
/// So that the tolerance is 0.005 mm at the tip, or 0.01 degrees of the tool axis, or parts of both.
const LEVER: f64 = TOLERANCE / (0.01 * std::f64::consts::PI / 180.0);
const CONTROLS: [BlockInterpolation; 3] =
    [BlockInterpolation::Axes, BlockInterpolation::RotaryLinear, BlockInterpolation::GreatCircle];
const LAYOUTS: [Layout; 2] = [Layout::TableTable, Layout::HeadHead];

fn options(control: BlockInterpolation) -> BlockOptions {
    let mut options = BlockOptions::within(control, TOLERANCE);
    options.lever = LEVER;
    options
}

fn limits() -> Limits<5> {
    let velocity = SVector::from([500.0, 500.0, 500.0, 3.0, 3.0]);
    let acceleration = SVector::from([2500.0, 2500.0, 2500.0, 10.0, 10.0]);
    Limits { velocity, rapid: velocity, acceleration, jerk: None, minus: None }
}

fn planned(path: &AxisPath) -> Schedule {
    let options = FeedOptions { time_tolerance: 5e-3, ..FeedOptions::fastest().with_feed(50.0) };
    optimal(path, &limits(), &options, &Silent).unwrap().schedule
}

fn any_path(seed: usize) -> Waves {
    let mut runner = TestRunner::deterministic();
    (0..=seed).map(|_| any_waves().new_tree(&mut runner).unwrap().current()).last().unwrap()
}

/// Where a control is at a share of a block, written down independently.
fn control_pose(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    [from, to]: [&AxisVector; 2],
    share: f64,
) -> ToolPose {
    let mixed = kinematics.forward(&(from * (1.0 - share) + to * share));
    let [start, end] = [kinematics.forward(from), kinematics.forward(to)];
    let tip = start.tip + (end.tip - start.tip) * share;
    match control {
        BlockInterpolation::Axes => mixed,
        BlockInterpolation::RotaryLinear => ToolPose { tip, axis: mixed.axis },
        BlockInterpolation::GreatCircle => {
            let angle = start.axis.angle(&end.axis);
            if angle == 0.0 {
                return ToolPose { tip, axis: start.axis };
            }
            let [a, b] = [((1.0 - share) * angle).sin(), (share * angle).sin()];
            let axis = start.axis.scale(a) + end.axis.scale(b);
            ToolPose { tip, axis: UnitVector3::new_normalize(axis) }
        }
    }
}

/// Distance of a pose from the curve of the control: a grid, then golden sections.
fn distance(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    ends: [&AxisVector; 2],
    pose: &ToolPose,
) -> f64 {
    let at = |share: f64| {
        let moved = control_pose(kinematics, control, ends, share);
        let chord = (moved.axis.into_inner() - pose.axis.into_inner()).norm();
        (moved.tip - pose.tip).norm() + LEVER * 2.0 * (0.5 * chord).asin()
    };
    let near = (0..=32).map(|k| f64::from(k) / 32.0).min_by(|a, b| at(*a).total_cmp(&at(*b)));
    let near = near.unwrap();
    let [mut low, mut high] = [(near - 1.0 / 32.0).max(0.0), (near + 1.0 / 32.0).min(1.0)];
    for _ in 0..20 {
        let [left, right] = [high - 0.618 * (high - low), low + 0.618 * (high - low)];
        if at(left) < at(right) { high = right } else { low = left }
    }
    at(0.5 * (low + high))
}

/// Largest distance of 23 places of the path in `[from, to]` from the control's curve.
fn strays(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    path: &AxisPath,
    [from, to]: [f64; 2],
) -> f64 {
    let at = |s: f64| path.pieces[0].axes_at(s).unwrap()[0];
    let [start, end] = [at(from), at(to)];
    (1..24)
        .map(|k| from + (to - from) * f64::from(k) / 24.0)
        .map(|s| distance(kinematics, control, [&start, &end], &kinematics.forward(&at(s))))
        .fold(0.0, f64::max)
}

/// Path parameters of block ends, from their times.
fn ends(blocks: &[Block], schedule: &Schedule) -> Vec<f64> {
    let mut t = 0.0;
    let places = blocks.iter().map(|block| {
        t += block.duration;
        schedule.pieces[0].at_time(t).unwrap().s
    });
    places.collect()
}

#[test]
fn every_control_stays_within_tolerance_on_two_machines() {
    for (seed, layout) in LAYOUTS.into_iter().enumerate() {
        let kinematics = shop::kinematics(layout);
        let path = any_path(seed).path(80);
        let schedule = planned(&path);
        for control in CONTROLS {
            let blocks = blocks(&kinematics, &path, &schedule, &options(control), &Silent).unwrap();
            let ends = ends(&blocks, &schedule);
            let mut worst = 0.0_f64;
            for pair in ends.windows(2) {
                worst = worst.max(strays(&kinematics, control, &path, [pair[0], pair[1]]));
            }
            // Used well, and kept; s from time is right to about 1e-9 mm.
            assert!(worst <= TOLERANCE * 1.0001, "{layout:?} {control:?}: {worst} mm");
            assert!(worst > 0.6 * TOLERANCE, "{layout:?} {control:?}: {worst} mm");
            check_program(&kinematics, &blocks, &path, &schedule);
        }
    }
}

/// Ends on the path, durations of the schedule, mean velocities and their differences in limits.
fn check_program(kinematics: &Kinematics, blocks: &[Block], path: &AxisPath, schedule: &Schedule) {
    let total: f64 = blocks.iter().map(|block| block.duration).sum();
    assert!((total - schedule.duration()).abs() < 1e-9 * total);
    assert!(blocks[0].duration.abs() < f64::MIN_POSITIVE);
    let nodes = &path.pieces[0].nodes;
    assert_eq!(blocks[0].q, nodes[0].q[0]);
    assert_eq!(blocks.last().unwrap().q, nodes.last().unwrap().q[0]);
    let mut before = (AxisVector::zeros(), 0.0);
    for pair in blocks.windows(2) {
        let [from, to] = [&pair[0], &pair[1]];
        assert_eq!(to.pose, kinematics.forward(&to.q));
        let velocity = (to.q - from.q) / to.duration;
        let acceleration = (velocity - before.0) / (0.5 * (before.1 + to.duration));
        for (mean, limit) in [(velocity, limits().velocity), (acceleration, limits().acceleration)]
        {
            assert!(mean.component_div(&limit).amax() <= 1.0 + 1e-6, "{mean} of {limit}");
        }
        before = (velocity, to.duration);
    }
}

/// Fewest equal parts of `s` that keep the tolerance.
fn equal_parts(kinematics: &Kinematics, control: BlockInterpolation, path: &AxisPath) -> u32 {
    let [first, last] =
        [path.pieces[0].nodes.first(), path.pieces[0].nodes.last()].map(|node| node.unwrap().s);
    let good = |parts: u32| {
        let at = |k: u32| first + (last - first) * f64::from(k) / f64::from(parts);
        (0..parts).all(|k| strays(kinematics, control, path, [at(k), at(k + 1)]) <= TOLERANCE)
    };
    let [mut low, mut high] = [0, 8];
    while !good(high) {
        (low, high) = (high, 2 * high);
    }
    while high - low > 1 + high / 50 {
        let middle = u32::midpoint(low, high);
        if good(middle) { high = middle } else { low = middle }
    }
    high
}

#[test]
fn fewer_blocks_than_equal_parts() {
    let path = any_path(2).path(80);
    let schedule = planned(&path);
    for (layout, control) in
        LAYOUTS.into_iter().zip([BlockInterpolation::Axes, BlockInterpolation::RotaryLinear])
    {
        let kinematics = shop::kinematics(layout);
        let blocks = blocks(&kinematics, &path, &schedule, &options(control), &Silent).unwrap();
        let equal = equal_parts(&kinematics, control, &path) as usize;
        assert!(10 * (blocks.len() - 1) <= 8 * equal, "{} against {equal}", blocks.len() - 1);
    }
}

#[test]
fn knobs_limit_blocks_and_yield_in_order() {
    let path = any_path(3).path(80);
    let schedule = planned(&path);
    let kinematics = shop::kinematics(Layout::TableTable);
    let mut fine = options(BlockInterpolation::RotaryLinear);
    (fine.max_step, fine.max_turn, fine.max_duration) = (0.5, 0.01, 0.02);
    let all = blocks(&kinematics, &path, &schedule, &fine, &Silent).unwrap();
    for pair in all.windows(2) {
        assert!((pair[1].pose.tip - pair[0].pose.tip).norm() <= 0.5 + 1e-9);
        assert!((pair[1].q - pair[0].q).fixed_rows::<2>(3).amax() <= 0.01 + 1e-9);
        assert!(pair[1].duration <= 0.02 + 1e-9);
    }
    let mut slow = fine;
    (slow.min_duration, slow.tolerance) = (0.01, 1.0);
    let slow = blocks(&kinematics, &path, &schedule, &slow, &Silent).unwrap();
    assert!(
        slow[1..].iter().all(|block| block.duration >= 0.01 * (1.0 - 1e-9)),
        "tolerance does not bind"
    );
    assert!(slow.len() <= all.len());
}

#[test]
fn pieces_follow_one_another() {
    let waves = any_path(4);
    let pieces = [Motion::LeadIn, Motion::Cut].map(|motion| waves.piece(motion, 40));
    let path = AxisPath { pieces: pieces.to_vec() };
    let schedule = planned(&path);
    let kinematics = shop::kinematics(Layout::HeadHead);
    let all =
        blocks(&kinematics, &path, &schedule, &options(BlockInterpolation::GreatCircle), &Silent)
            .unwrap();
    let total: f64 = all.iter().map(|block| block.duration).sum();
    assert!((total - schedule.duration()).abs() < 1e-9 * total);
    let lead = all.iter().rposition(|block| block.motion == Motion::LeadIn).unwrap();
    assert_eq!(all[lead].q, path.pieces[0].nodes.last().unwrap().q[0]);
}

/// Half the chord and half the thickness of a blade \[mm\].
const HALF: [f64; 2] = [63.5, 4.0];

/// Over one side and both edges of a blade's section, 127 by 8 mm as in paper 003's listing, with noses of 0.25 mm: the
/// axis of the paper's machine along the blade, the tool leaning 12.5 degrees along it.
fn blade(kinematics: &Kinematics) -> AxisPath {
    let at = |k: i32| {
        // Half-way between even steps of the ellipse's parameter and of the angle of its normal.
        let even = std::f64::consts::TAU * f64::from(k) / 900.0;
        let own = (HALF[1] * even.sin()).atan2(HALF[0] * even.cos());
        let t = 0.5 * (even + unwrap_near(own, even));
        let tip = Point3::new(0.002 * f64::from(k), HALF[0] * t.cos(), HALF[1] * t.sin());
        let normal = Vector3::new(0.0, HALF[1] * t.cos(), HALF[0] * t.sin()).normalize();
        let lean = 12.5_f64.to_radians();
        let axis = normal * lean.cos() + Vector3::x() * lean.sin();
        Station { pose: ToolPose { tip, axis: UnitVector3::new_normalize(axis) }, contact: tip }
    };
    let stations = (-60..510).map(at).collect();
    let legs = [Leg { motion: Motion::Cut, stations }];
    let path = through(&legs, &ToolPathOptions::with_lever(10.0), &Silent).unwrap();
    let options = AxesOptions {
        max_rotary_step: 0.05,
        feed_at: FeedPoint::Contact,
        ..AxesOptions::within(PoseTolerance::new(1e-4, 1e-5), AxisVector::zeros())
    };
    follow(kinematics, &path, &options, &Silent).unwrap().path
}

/// Parameters that divide a path into parts of equal turn of the tool axis.
fn equal_turns(kinematics: &Kinematics, path: &AxisPath, parts: usize) -> Vec<f64> {
    let piece = &path.pieces[0];
    let [first, last] = [piece.nodes.first(), piece.nodes.last()].map(|node| node.unwrap().s);
    let fine: Vec<f64> =
        (0..=20_000).map(|k| first + (last - first) * f64::from(k) / 2e4).collect();
    let axis = |s: f64| kinematics.forward(&piece.position_at(s).unwrap()).axis;
    let mut turned = vec![0.0];
    for pair in fine.windows(2) {
        turned.push(turned.last().unwrap() + angle_between(&axis(pair[0]), &axis(pair[1])));
    }
    let whole = *turned.last().unwrap();
    let mut ends: Vec<f64> = (0..parts)
        .map(|k| fine[turned.partition_point(|&t| t < whole * k as f64 / parts as f64)])
        .collect();
    ends.push(last);
    ends
}

#[test]
fn a_blade_needs_a_third_of_the_blocks_of_equal_turns() {
    let kinematics = shop::kinematics(Layout::TableHead);
    let path = blade(&kinematics);
    assert_eq!(path.pieces.len(), 1);
    let schedule = planned(&path);
    for control in CONTROLS {
        let all = blocks(&kinematics, &path, &schedule, &options(control), &Silent).unwrap();
        let ends = ends(&all, &schedule);
        let stray = |pair: &[f64]| strays(&kinematics, control, &path, [pair[0], pair[1]]);
        let worst = ends.windows(2).map(stray).fold(0.0, f64::max);
        assert!(worst <= TOLERANCE * 1.0001 && worst > 0.6 * TOLERANCE, "{control:?}: {worst} mm");
        let count = all.len() - 1;
        let equal = equal_turns(&kinematics, &path, 3 * count);
        let broken = equal.windows(2).map(stray).find(|&off| off > TOLERANCE);
        assert!(broken.is_some(), "{control:?}: {count} blocks are not a third");
    }
}

/// An over-fine program, thinned out: against the nearest pose of the control with all blocks.
#[test]
fn an_over_fine_program_is_thinned_out_within_tolerance() {
    for (seed, layout) in LAYOUTS.into_iter().enumerate() {
        let kinematics = shop::kinematics(layout);
        let path = any_path(seed + 5).path(80);
        let schedule = planned(&path);
        for control in CONTROLS {
            let mut fine = options(control);
            fine.tolerance = 0.05 * TOLERANCE;
            let fine = blocks(&kinematics, &path, &schedule, &fine, &Silent).unwrap();
            let mut wanted = ReduceOptions::within(control, TOLERANCE);
            (wanted.lever, wanted.max_turn) = (LEVER, 0.5);
            let kept = reduce(&kinematics, &fine, &wanted, &Silent).unwrap();
            let ratio = (fine.len() - 1) as f64 / (kept.len() - 1) as f64;
            assert!(ratio > 2.5, "{layout:?} {control:?}: {ratio}");
            let total = |all: &[Block]| all.iter().map(|block| block.duration).sum::<f64>();
            assert!((total(&fine) - total(&kept)).abs() < 1e-9 * total(&fine));
            check_thinned(&kinematics, control, &fine, &kept);
        }
    }
}

fn check_thinned(
    kinematics: &Kinematics,
    control: BlockInterpolation,
    fine: &[Block],
    kept: &[Block],
) {
    let mut at = 0;
    let mut worst = 0.0_f64;
    for pair in kept.windows(2) {
        let to = at + fine[at..].iter().position(|block| block.q == pair[1].q).unwrap();
        assert_eq!((fine[to].pose, fine[to].motion), (pair[1].pose, pair[1].motion));
        for block in fine[at..=to].windows(2) {
            for k in 0..7 {
                let share = f64::from(k) / 7.0;
                let pose = control_pose(kinematics, control, [&block[0].q, &block[1].q], share);
                worst = worst.max(distance(kinematics, control, [&pair[0].q, &pair[1].q], &pose));
            }
        }
        at = to;
    }
    assert_eq!(at, fine.len() - 1, "the end is kept");
    assert!(worst <= TOLERANCE * 1.0001 && worst > 0.5 * TOLERANCE, "{control:?}: {worst} mm");
}
