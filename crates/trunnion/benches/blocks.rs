//! Program blocks from an axis path, and point reduction: blocks per second for each kind of control.

#![expect(clippy::print_stdout, reason = "the figures are what it is for")]

#[path = "../tests/it/shop/mod.rs"]
mod shop;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use shop::Layout;
use trunnion::blocks::{BlockInterpolation, BlockOptions, ReduceOptions, blocks, reduce};
use trunnion::types::{
    AxisNode, AxisPath, AxisPiece, AxisVector, Block, Motion, Schedule, SchedulePiece, Silent,
};

const CONTROLS: [BlockInterpolation; 3] =
    [BlockInterpolation::Axes, BlockInterpolation::RotaryLinear, BlockInterpolation::GreatCircle];

fn main() {
    divan::main();
}

/// Ten metres of waves of all axes, at 50 mm/s.
fn path() -> (AxisPath, Schedule) {
    let at = |s: f64| {
        let value = |axis: usize, order: u32| {
            let (size, rate) = if axis < 3 { (5.0, 0.05_f64) } else { (0.3, 0.02) };
            let turned = rate * s + axis as f64 + f64::from(order) * std::f64::consts::FRAC_PI_2;
            size * rate.powf(f64::from(order)) * turned.sin()
        };
        let mut q = [0, 1, 2, 3].map(|order| AxisVector::from_fn(|axis, _| value(axis, order)));
        q[0][0] += 0.1 * s;
        q[1][0] += 0.1;
        AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
    };
    let nodes: Vec<AxisNode> = (0..=10_000_u32).map(|k| at(f64::from(k))).collect();
    let rows = SchedulePiece {
        s: vec![0.0, 1e4],
        t: vec![0.0, 200.0],
        speed: vec![50.0; 2],
        acceleration: vec![0.0; 2],
        ..SchedulePiece::default()
    };
    let piece = AxisPiece { motion: Motion::Cut, source: 0, nodes };
    (AxisPath { pieces: vec![piece] }, Schedule { pieces: vec![rows] })
}

fn options(control: BlockInterpolation, tolerance: f64) -> BlockOptions {
    let mut options = BlockOptions::within(control, tolerance);
    (options.link_tolerance, options.lever) = (1.0, 16.0);
    options
}

fn broken(control: BlockInterpolation, tolerance: f64) -> Vec<Block> {
    let (path, schedule) = path();
    let kinematics = shop::kinematics(Layout::TableTable);
    blocks(&kinematics, &path, &schedule, &options(control, tolerance), &Silent).unwrap_or_default()
}

#[divan::bench(args = CONTROLS)]
fn breaking(bencher: Bencher, control: BlockInterpolation) {
    let (path, schedule) = path();
    let kinematics = shop::kinematics(Layout::TableTable);
    let count = broken(control, 0.005).len();
    let options = options(control, 0.005);
    let run = || blocks(&kinematics, black_box(&path), &schedule, &options, &Silent);
    bencher.counter(ItemsCount::new(count)).bench(run);
}

/// Points per second of a program with some four times the blocks it needs.
#[divan::bench(args = CONTROLS)]
fn reducing(bencher: Bencher, control: BlockInterpolation) {
    let kinematics = shop::kinematics(Layout::TableTable);
    let fine = broken(control, 0.005 / 16.0);
    let mut options = ReduceOptions::within(control, 0.005);
    (options.lever, options.max_turn) = (16.0, 1.0);
    let run = || reduce(&kinematics, black_box(&fine), &options, &Silent);
    let kept = run().map_or(0, |kept| kept.len());
    println!("{control:?}: {} blocks to {kept}", fine.len());
    bencher.counter(ItemsCount::new(fine.len())).bench(run);
}
