//! Machines for unit tests.

use super::spec::{AxisKind, AxisSpec, MachineSpec};

/// Creates an axis with round limits.
pub(crate) fn axis(name: &str, kind: AxisKind, dir: [f64; 3]) -> AxisSpec {
    // Travel to both sides, so that tests meet its ends.
    let (axis, limits) = match kind {
        AxisKind::Linear => (AxisSpec::linear(name, dir), [-500.0, 500.0]),
        AxisKind::Rotary => (AxisSpec::rotary(name, dir, [0.0; 3]), [-3.0, 3.0]),
    };
    AxisSpec { limits: Some(limits.into()), cyclic: None, vel: 2.0, acc: 10.0, jerk: 100.0, ..axis }
}

/// Creates a machine with that chain; X, Y, Z along the frame.
pub(crate) fn machine(chain: &[&str], rotary: [AxisSpec; 2]) -> MachineSpec {
    let linear = |name, dir| axis(name, AxisKind::Linear, dir);
    let mut axes = vec![
        linear("X", [1.0, 0.0, 0.0]),
        linear("Y", [0.0, 1.0, 0.0]),
        linear("Z", [0.0, 0.0, 1.0]),
    ];
    axes.extend(rotary);
    MachineSpec::new("sample", chain, axes)
}

/// Creates table C on A, both through the machine origin.
pub(crate) fn ac_trunnion() -> MachineSpec {
    let mut c = axis("C", AxisKind::Rotary, [0.0, 0.0, 1.0]);
    c.limits = None;
    c.cyclic = Some(std::f64::consts::TAU);
    let a = axis("A", AxisKind::Rotary, [1.0, 0.0, 0.0]);
    machine(&["w", "C", "A", "b", "X", "Y", "Z", "t"], [c, a])
}
