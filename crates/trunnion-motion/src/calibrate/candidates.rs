//! Readings that could be taken: rotary positions over the travel, with the sphere where it was found.

use super::reading::{ReadingKind, SphereReading};
use crate::machine::{Axis, FIRST_ROTARY, Kinematics, Machine, SECOND_ROTARY, Setup};
use crate::types::AxisVector;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Positions of a rotary axis that are tried over its travel, or over one turn.
const POSITIONS: u32 = 12;

/// Lengths by which another probe is longer or shorter \[mm\].
pub(super) const OTHER_LENGTHS: [f64; 2] = [50.0, -50.0];

/// Places of a second sphere beside the first \[mm\], workpiece frame.
pub(super) const OTHER_PLACES: [[f64; 3]; 4] =
    [[150.0, 0.0, 0.0], [0.0, 150.0, 0.0], [-150.0, 0.0, 0.0], [0.0, 0.0, 100.0]];

/// Sphere and tool of a reading that could be taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct SphereTarget {
    pub(super) sphere: usize,
    pub(super) center: Vector3<f64>,
    pub(super) tool_length: f64,
}

/// Returns readings of a target at rotary positions over the travel that the linear axes reach.
pub(super) fn over_travel(machine: &Machine, target: &SphereTarget) -> Vec<SphereReading> {
    let [.., first, second] = &machine.axes;
    let steps = |axis: &Axis| -> Vec<f64> {
        let [low, high] = axis.limits.ends();
        let [low, high] = if low.is_finite() && high - low < TAU {
            [low, high]
        } else {
            [axis.home, axis.home + TAU * f64::from(POSITIONS - 1) / f64::from(POSITIONS)]
        };
        (0..POSITIONS)
            .map(|step| low + (high - low) * f64::from(step) / f64::from(POSITIONS - 1))
            .collect()
    };
    let (first, second) = (steps(first), steps(second));
    let pairs = first.iter().flat_map(|&a| second.iter().map(move |&b| [a, b]));
    pairs.filter_map(|rotary| reading(machine, target, rotary)).collect()
}

/// Returns the reading of a target at a rotary position, if the linear axes reach it.
pub(super) fn reading(
    machine: &Machine,
    target: &SphereTarget,
    rotary: [f64; 2],
) -> Option<SphereReading> {
    let setup = Setup { tool_length: target.tool_length, ..Setup::default() };
    let kinematics = Kinematics::new(machine, &setup);
    let mut q = AxisVector::zeros();
    [q[FIRST_ROTARY], q[SECOND_ROTARY]] = rotary;
    // The tip is affine in the linear axes.
    let way = target.center - kinematics.forward(&q).tip.coords;
    let linear = Matrix3::from_columns(&kinematics.tip_levers(&q).linear).try_inverse()? * way;
    [q[0], q[1], q[2]] = linear.into();
    machine.out_of_travel(&q).is_none().then_some(SphereReading {
        q,
        tool_length: target.tool_length,
        sphere: target.sphere,
        kind: ReadingKind::Center { deviation: Vector3::zeros() },
    })
}
