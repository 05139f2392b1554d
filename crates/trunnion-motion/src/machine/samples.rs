//! Machines for unit tests.

use super::settings::{Cycle, Dialect, FeedMode, Interpolation, Output, Retract, Singular};
use super::spec::{AxisKind, AxisSpec, MachineSpec};
use std::collections::BTreeMap;

/// An axis with round limits.
pub(crate) fn axis(name: &str, kind: AxisKind, dir: [f64; 3]) -> AxisSpec {
    AxisSpec {
        name: name.to_owned(),
        kind,
        dir,
        point: (kind == AxisKind::Rotary).then_some([0.0; 3]),
        limits: Some(if kind == AxisKind::Rotary { [-3.0, 3.0] } else { [-500.0, 500.0] }),
        cyclic: None,
        vel: 2.0,
        rapid: None,
        acc: 10.0,
        jerk: 100.0,
        sense: 1.0,
        home: None,
        prefer: None,
        output: Output::STANDARD,
    }
}

/// A machine with that chain; X, Y, Z along the frame.
pub(crate) fn machine(chain: &[&str], rotary: [AxisSpec; 2]) -> MachineSpec {
    let linear = |name, dir| axis(name, AxisKind::Linear, dir);
    let mut axes = vec![
        linear("X", [1.0, 0.0, 0.0]),
        linear("Y", [0.0, 1.0, 0.0]),
        linear("Z", [0.0, 0.0, 1.0]),
    ];
    axes.extend(rotary);
    MachineSpec {
        name: "sample".to_owned(),
        chain: chain.iter().map(|&word| word.to_owned()).collect(),
        tool_axis: [0.0, 0.0, 1.0],
        gauge: [0.0; 3],
        axes,
        cycle: Cycle::default(),
        singular: Singular::STANDARD,
        retract: Retract::standard(),
        dialect: Dialect {
            name: "linuxcnc".to_owned(),
            interpolation: Interpolation::RotaryLinear,
            feed: FeedMode::InverseTime,
            strings: BTreeMap::new(),
        },
    }
}

/// Table C on A, both through the machine origin.
pub(crate) fn ac_trunnion() -> MachineSpec {
    let mut c = axis("C", AxisKind::Rotary, [0.0, 0.0, 1.0]);
    c.limits = None;
    c.cyclic = Some(std::f64::consts::TAU);
    let a = axis("A", AxisKind::Rotary, [1.0, 0.0, 0.0]);
    machine(&["w", "C", "A", "b", "X", "Y", "Z", "t"], [c, a])
}
