//! Paper 002's own check (its table 4), on all twelve layouts: cutter locations to axes, written as
//! a program, read back, and forward to the same cutter locations.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::posted;

use nalgebra::Vector3;
use trunnion::files::machine::{BUILT_IN, parse};
use trunnion::inverse::Inverse;
use trunnion::machine::{Kinematics, Setup};
use trunnion::nc::read::{self, Dialect, Frame, Pace, ReadOptions, Step};
use trunnion::nc::write::{self, AxisWords, Coordinates};
use trunnion::types::{AxisVector, Block, Motion, ToolPose};

/// Cutter locations round a dome on the middle of the machine's travel, and the axes for them.
fn blocks(kinematics: &Kinematics, inverse: &Inverse, start: &AxisVector) -> Vec<Block> {
    let ToolPose { tip, axis } = kinematics.forward(start);
    let across = axis.cross(&Vector3::new(0.3, 0.5, 0.7)).normalize();
    let other = axis.cross(&across);
    let mut near = *start;
    (0..60)
        .map(|step| {
            let (sin, cos) = (0.21 * f64::from(step)).sin_cos();
            let lean = (across * cos + other * sin) * 0.15;
            let axis = axis.into_inner() + lean;
            let pose = ToolPose::new((tip.coords + lean * 90.0).into(), axis.into()).unwrap();
            near = inverse.near_inside(&pose, &near).unwrap();
            Block { motion: Motion::Cut, q: near, pose, duration: 0.25 }
        })
        .collect()
}

#[test]
fn there_and_back_through_the_program() {
    let mut layouts = 0;
    for (name, text) in BUILT_IN.iter().filter(|(name, _)| name.starts_with("layout-")) {
        let machine = parse(text).unwrap().machine;
        let middle = AxisVector::from_fn(|row, _| {
            let [low, high] = machine.axes[row].limits.ends();
            if low.is_finite() { 0.5 * (low + high) } else { 0.0 }
        });
        let setup = Setup::new(Vector3::new(12.0, -34.0, -400.0), [0.0; 3], 90.0);
        let kinematics = Kinematics::new(&machine, &setup);
        let inverse = Inverse::new(&kinematics).unwrap();
        // Away from the pole, where a table may be any way round.
        let start = middle + AxisVector::from([0.0, 0.0, 0.0, 0.3, 0.3]);
        let blocks = blocks(&kinematics, &inverse, &start);
        let axes = AxisWords::of(&machine).unwrap();
        let program = posted::plain(&kinematics, &blocks, (axes, false));
        let read = read::read(&program, &ReadOptions::new(Dialect::LinuxCnc, axes, 5)).unwrap();
        let shift = write::work_offset(&kinematics).unwrap() + Vector3::z() * setup.tool_length;
        let mut q = [0.0; 5];
        let mut cut = Vec::new();
        for step in &read.steps {
            let Step::Move(step) = step else { continue };
            if step.frame == Frame::Machine {
                continue;
            }
            for (value, word) in q.iter_mut().zip(step.words) {
                *value = word.unwrap_or(*value);
            }
            if matches!(step.pace, Pace::Inverse { .. }) {
                let mut q = AxisVector::from(q);
                for row in 0..3 {
                    q[row] += shift[row];
                }
                cut.push(q);
            }
        }
        // The first location is where the program starts; every further one is a block.
        assert_eq!(cut.len() + 1, blocks.len(), "{name}");
        for (q, block) in cut.iter().zip(&blocks[1..]) {
            let again = kinematics.forward(q);
            let bound = write::rounding(&kinematics, &block.q, &axes, Coordinates::Axes, 0.0);
            let off = (again.tip - block.pose.tip).norm();
            assert!(off <= bound * (1.0 + 1e-3) + 1e-9, "{name}: tip off by {off} mm > {bound}");
            let turn = (*again.axis - *block.pose.axis).norm();
            let half = axes.rounding();
            assert!(turn <= half[3] + half[4] + 1e-12, "{name}: axis off by {turn}");
            assert!(bound < 0.002, "{name}: the bound says nothing");
        }
        layouts += 1;
    }
    assert_eq!(layouts, 12);
}
