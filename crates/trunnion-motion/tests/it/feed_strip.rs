//! A case that controls are slow at: one five-axis pass over a waved surface, in short blocks.

use nalgebra::SVector;
use num_dual::{Dual3_64, DualNum, third_derivative};
use trunnion::feed::{FeedError, FeedOptions, Limits, optimal};
use trunnion::types::{AxisNode, AxisPath, AxisPiece, Motion, Silent};

/// One straight pass of 253.5 mm over a surface waved along x, tool leaning 20 degrees ahead, on a
/// table-table machine that turns about X and Z: X, Y, Z, A, C over the pass's own x \[mm, rad\].
fn strip(x: Dual3_64) -> [Dual3_64; 5] {
    let wave = std::f64::consts::TAU / 80.0;
    let z = (x * wave).sin() * 3.0;
    let slope = (x * wave).cos() * (3.0 * wave);
    let tilt = -slope.atan() + 20_f64.to_radians();
    let (sin, cos) = tilt.sin_cos();
    // C stands at 90 degrees: the pass runs along Y of the machine.
    [x * 0.0, cos * x - sin * z, sin * x + cos * z, tilt, x * 0.0 + 0.25 * std::f64::consts::TAU]
}

/// `LinuxCNC` takes 12.7 s for this pass in blocks of 0.5 mm and 25.6 s in blocks of 0.125 mm; what the
/// axes and the feed of 3000 mm/min allow is 5.09 s, whatever the blocks.
#[test]
fn a_waved_pass_takes_what_its_feed_allows_whatever_the_blocks() -> Result<(), FeedError> {
    let turn = 100_f64.to_radians();
    let velocity = SVector::from([500.0, 500.0, 500.0, turn, turn]);
    let limits = Limits {
        velocity,
        rapid: velocity,
        acceleration: velocity * 10.0,
        jerk: None,
        minus: None,
    };
    let options = FeedOptions { time_tolerance: 2e-3, ..FeedOptions::fastest().with_feed(50.0) };
    for blocks in [507_u32, 2028] {
        let nodes = (0..=blocks).map(|block| {
            let s = 250.0 * f64::from(block) / f64::from(blocks);
            let mut q = [SVector::zeros(); 4];
            for (axis, jets) in (0..5).map(|axis| (axis, third_derivative(|x| strip(x)[axis], s))) {
                let orders = [jets.0, jets.1, jets.2, jets.3];
                for (derivative, value) in q.iter_mut().zip(orders) {
                    derivative[axis] = value;
                }
            }
            let wave = std::f64::consts::TAU / 80.0;
            let rate = (3.0 * wave * (wave * s).cos()).hypot(1.0);
            AxisNode { s, q, tip_rate: rate, feed_rate: rate }
        });
        let piece = AxisPiece { motion: Motion::Cut, source: 0, nodes: nodes.collect() };
        let plan = optimal(&AxisPath { pieces: vec![piece] }, &limits, &options, &Silent)?;
        let time = plan.schedule.duration();
        assert!((time / 5.09 - 1.0).abs() < 0.01, "{blocks} blocks: {time} s");
        assert!(plan.bounds.velocity <= 1.0 + 1e-9 && plan.bounds.acceleration <= 1.0 + 1e-9);
    }
    Ok(())
}
