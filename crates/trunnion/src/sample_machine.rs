//! A machine for unit tests.

use crate::machine::{AxisSpec, KinematicChain, MachineSpec};
use crate::types::Interval;
use std::f64::consts::TAU;

/// Returns the specification of a table C on a table A, both through the machine origin, with round limits.
pub(crate) fn ac_trunnion() -> MachineSpec {
    let slow = |axis: AxisSpec| AxisSpec { vel: 2.0, acc: 10.0, jerk: 100.0, ..axis };
    let linear = |name, dir| AxisSpec {
        limits: Some(Interval::new(-500.0, 500.0)),
        ..slow(AxisSpec::linear(name, dir))
    };
    let c = slow(AxisSpec::rotary("C", [0.0, 0.0, 1.0], [0.0; 3]));
    let a = slow(AxisSpec::rotary("A", [1.0, 0.0, 0.0], [0.0; 3]));
    let chain = KinematicChain::new()
        .with(AxisSpec { cyclic: Some(TAU), ..c })
        .with(AxisSpec { limits: Some(Interval::new(-3.0, 3.0)), cyclic: None, ..a })
        .bed()
        .with(linear("X", [1.0, 0.0, 0.0]))
        .with(linear("Y", [0.0, 1.0, 0.0]))
        .with(linear("Z", [0.0, 0.0, 1.0]));
    MachineSpec::from(chain)
}
