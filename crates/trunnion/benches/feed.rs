//! Time per point of the optimal schedule with its guarantee, lower bound and dense check, for five
//! axes. Budget: 500 ns a point and core on paths whose nodes suffice (`smooth`); a whip near the
//! pole of the rotary axes inserts rows and costs more. Peers on like paths: 1.1 to 4 us.
//! Planning alone, with the same guarantee, is `schedule<true>`, 300 ns, or through a window of 512 rows
//! `stream`, 220 ns; with limits at rows alone `schedule<false>`, 120 ns, which is what peers do.
//! With jerk limits (`jerk_smooth`): 25 us a point; the strongest peer takes 1.1 to 5.1 ms a pass.

use divan::Bencher;
use nalgebra::SVector;
use trunnion::feed::{
    FeedOptions, FeedStream, Limits, StreamOptions, jerk, optimal, optimal_schedule,
};
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Silent};

fn main() {
    divan::main();
}

/// Axes and derivatives: `f` is X, Y, Z as waves of about 10 mm, and the last axis.
fn path(points: u32, last: impl Fn(f64) -> [f64; 4]) -> AxisPath {
    let nodes = (0..points).map(|k| {
        let s = 0.1 * f64::from(k);
        let mut q = [SVector::zeros(); 4];
        for axis in 0..4 {
            let w = [0.31, 0.17, 0.23, 0.05][axis];
            let size = if axis < 3 { 2.0 } else { 0.1 };
            let (sin, cos) = (w * s).sin_cos();
            let values = [sin, w * cos, -w * w * sin, -w * w * w * cos];
            for (order, value) in values.into_iter().enumerate() {
                q[order][axis] = size * value;
            }
        }
        for (order, value) in last(s).into_iter().enumerate() {
            q[order][4] = value;
        }
        q[0][0] += s;
        q[1][0] += 1.0;
        AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
    });
    AxisPath { pieces: vec![AxisPiece { motion: Motion::Cut, source: 0, nodes: nodes.collect() }] }
}

fn limits() -> Limits<5> {
    let velocity = SVector::from([500.0, 500.0, 500.0, 6.0, 10.0]);
    let acceleration = SVector::from([5000.0, 5000.0, 5000.0, 60.0, 100.0]);
    Limits { velocity, rapid: velocity, acceleration, jerk: None, minus: None }
}

const OPTIONS: FeedOptions =
    FeedOptions { time_tolerance: 5e-3, ..FeedOptions::fastest().with_feed(300.0) };

fn plan(bencher: Bencher, points: u32, path: &AxisPath) {
    let limits = limits();
    bencher
        .counter(divan::counter::ItemsCount::new(points))
        .bench(|| optimal(path, &limits, &OPTIONS, &Silent));
}

fn smooth_path(points: u32) -> AxisPath {
    path(points, |s| {
        let (sin, cos) = (0.1 * s).sin_cos();
        [0.3 * sin, 0.03 * cos, -0.003 * sin, -0.0003 * cos]
    })
}

#[divan::bench(args = [1_000, 10_000, 100_000])]
fn smooth(bencher: Bencher, points: u32) {
    plan(bencher, points, &smooth_path(points));
}

/// Limits at rows alone: what the peers do.
#[divan::bench(args = [1_000, 10_000, 100_000])]
fn smooth_at_rows(bencher: Bencher, points: u32) {
    let path = smooth_path(points);
    let (limits, options) = (limits(), FeedOptions { guarantee: false, ..OPTIONS });
    bencher
        .counter(divan::counter::ItemsCount::new(points))
        .bench(|| optimal(&path, &limits, &options, &Silent));
}

/// The schedules alone, which is what peers give: limits everywhere, and at rows alone.
#[divan::bench(args = [1_000, 10_000, 100_000], consts = [true, false])]
fn schedule<const GUARANTEE: bool>(bencher: Bencher, points: u32) {
    let path = smooth_path(points);
    let options = FeedOptions { guarantee: GUARANTEE, time_tolerance: 1.0, ..OPTIONS };
    bencher
        .counter(divan::counter::ItemsCount::new(points))
        .bench(|| optimal_schedule(&path, &limits(), &options, &Silent));
}

/// Node by node through a window; time a point must not depend on their number.
#[divan::bench(args = [10_000, 100_000])]
fn stream(bencher: Bencher, points: u32) {
    let path = smooth_path(points);
    let options = StreamOptions { speeds: OPTIONS.speeds, ..StreamOptions::fastest(512, 1.0) };
    bencher.counter(divan::counter::ItemsCount::new(points)).bench(|| {
        let mut stream = FeedStream::new(limits(), options)?;
        let mut nodes = path.pieces.iter().flat_map(|piece| &piece.nodes);
        stream.begin(Motion::Cut);
        loop {
            while stream.wants() {
                let Some(node) = nodes.next() else { break };
                stream.push(*node)?;
            }
            if stream.next().is_none() {
                return Ok::<f64, trunnion::feed::FeedError>(stream.time());
            }
        }
    });
}

#[divan::bench(args = [1_000, 10_000], sample_count = 10)]
fn jerk_smooth(bencher: Bencher, points: u32) {
    let path = smooth_path(points);
    let limits = Limits { jerk: Some(SVector::from([1e5, 1e5, 1e5, 1200.0, 2000.0])), ..limits() };
    bencher
        .counter(divan::counter::ItemsCount::new(points))
        .bench(|| jerk(&path, &limits, &OPTIONS, &Silent));
}

#[divan::bench(args = [1_000, 10_000, 100_000])]
fn whips(bencher: Bencher, points: u32) {
    // Half a turn within about a millimetre, every 100 mm.
    let path = path(points, |s| {
        let x = (s + 50.0).rem_euclid(100.0) - 50.0;
        let d = 0.25 + x * x;
        let angle = (x / 0.5).atan() + ((s + 50.0) / 100.0).floor() * 2.0 * (100.0_f64).atan();
        [angle, 0.5 / d, -x / (d * d), 0.5 * (6.0 * x * x - 0.5) / (d * d * d)]
    });
    plan(bencher, points, &path);
}
