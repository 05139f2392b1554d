//! Smoothing of cutter locations: points per second. The budget is 300 000 on one core, with a window of
//! stations in memory whatever the length.

#![expect(clippy::print_stdout, reason = "the figures are what it is for")]

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use trunnion::toolpath::{PathSmoother, SmoothOptions};
use trunnion::types::{PoseTolerance, Station, ToolPose};

const POINTS: u32 = 100_000;

fn main() {
    divan::main();
}

fn options() -> SmoothOptions {
    SmoothOptions::within(PoseTolerance { tip: 0.005, axis: 2e-4 })
}

fn station(tip: [f64; 3], axis: [f64; 3]) -> Option<Station> {
    ToolPose::new(tip, axis).map(|pose| Station { pose, contact: pose.tip })
}

/// Waves over a part of 100 mm, steps of 0.05 mm.
fn wave(k: u32) -> Option<Station> {
    let s = 0.05 * f64::from(k);
    let [a, b] = [s / 60.0, s / 17.0];
    station(
        [100.0 * a.sin(), 100.0 * a.cos() + 2.0 * b.sin(), 3.0 * b.cos()],
        [0.3 * a.sin(), 0.3 * a.cos(), 1.0 + 0.05 * b.sin()],
    )
}

/// The same as a file has it: tips to three decimals, axes to five.
fn written(k: u32) -> Option<Station> {
    let exact = wave(k)?;
    let tip = exact.pose.tip.coords.map(|x| (x * 1e3).round() / 1e3);
    let axis = exact.pose.axis.map(|x| (x * 1e5).round() / 1e5);
    station(tip.into(), axis.into())
}

/// Straight lines of 40 points with corners of 30 degrees between them.
fn corners(k: u32) -> Option<Station> {
    let [line, along] = [f64::from(k / 40), f64::from(k % 40) * 0.1];
    let slope = 15.0_f64.to_radians();
    let y = if (k / 40).is_multiple_of(2) { along } else { 4.0 - along };
    station([(line * 4.0 + along) * slope.cos(), y * slope.sin(), 0.0], [0.1, 0.2, 1.0])
}

#[divan::bench(args = ["exact", "written", "corners"])]
fn smoothing(bencher: Bencher, kind: &str) {
    let make = match kind {
        "exact" => wave,
        "written" => written,
        _ => corners,
    };
    let stations: Vec<Station> = (0..POINTS).filter_map(make).collect();
    let report = run(&stations);
    println!("{kind}: {report:?}");
    bencher.counter(ItemsCount::new(POINTS)).bench(|| run(black_box(&stations)));
}

fn run(stations: &[Station]) -> Option<trunnion::toolpath::SmoothReport> {
    let mut smoother = PathSmoother::new(&options()).ok()?;
    for station in stations {
        smoother.push(station).ok()?;
        black_box(smoother.take());
    }
    smoother.finish().ok().map(|(_, report)| report)
}
