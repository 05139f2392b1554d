//! Machines that program and verification tests share.

#![allow(dead_code, reason = "benches use a part")]
#![allow(clippy::unwrap_used, reason = "a test stops on surprise")]

use nalgebra::Vector3;
use trunnion::machine::{AxisSpec, Kinematics, Machine, MachineSpec, Setup};
use trunnion::types::Interval;

/// Which machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    /// Table C on tilting B, both below the spindle.
    TableTable,
    /// Head C carrying A, offset pivot.
    HeadHead,
    /// Table A, head B, all through one point: the machine of paper 003.
    TableHead,
}

fn axis(name: &str, dir: [f64; 3], point: Option<[f64; 3]>) -> AxisSpec {
    let [reach, vel, acc] =
        if point.is_some() { [40.0, 3.0, 10.0] } else { [2000.0, 500.0, 2500.0] };
    let preset = match point {
        Some(point) => AxisSpec::rotary(name, dir, point),
        None => AxisSpec::linear(name, dir),
    };
    let limits = Some(Interval::new(-reach, reach));
    AxisSpec { limits, cyclic: None, vel, acc, jerk: 40.0 * acc, ..preset }
}

/// A machine of that layout with generous travel.
pub(crate) fn machine(layout: Layout) -> Machine {
    let mut axes = vec![
        axis("X", [1.0, 0.0, 0.0], None),
        axis("Y", [0.0, 1.0, 0.0], None),
        axis("Z", [0.0, 0.0, 1.0], None),
    ];
    let (chain, rotaries): (&[&str], _) = match layout {
        Layout::TableTable => (
            &["w", "C", "B", "b", "X", "Y", "Z", "t"],
            [
                axis("C", [0.0, 0.0, 1.0], Some([-381.0, -254.0, -560.0])),
                axis("B", [0.0, 1.0, 0.0], Some([-381.0, -254.0, -535.0])),
            ],
        ),
        Layout::HeadHead => (
            &["w", "b", "X", "Y", "Z", "C", "A", "t"],
            [
                axis("C", [0.0, 0.0, 1.0], Some([0.0; 3])),
                axis("A", [1.0, 0.0, 0.0], Some([0.0, 30.0, 90.0])),
            ],
        ),
        Layout::TableHead => (
            &["w", "A", "b", "X", "Y", "Z", "B", "t"],
            [
                axis("A", [1.0, 0.0, 0.0], Some([0.0; 3])),
                axis("B", [0.0, 1.0, 0.0], Some([0.0; 3])),
            ],
        ),
    };
    axes.extend(rotaries);
    Machine::new(MachineSpec::new("test", chain, axes)).unwrap()
}

/// A tilted workpiece, tool of 120 mm.
pub(crate) fn setup(layout: Layout) -> Setup {
    let origin = match layout {
        Layout::TableTable => Vector3::new(-381.0, -254.0, -500.0),
        Layout::HeadHead => Vector3::new(40.0, -30.0, -400.0),
        Layout::TableHead => return Setup::new(Vector3::zeros(), [0.0; 3], 0.0),
    };
    Setup::new(origin, [0.0, 20f64.to_radians(), 0.1], 120.0)
}

/// Machine and setup together.
pub(crate) fn kinematics(layout: Layout) -> Kinematics {
    Kinematics::new(&machine(layout), &setup(layout))
}
