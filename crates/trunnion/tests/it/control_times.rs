//! Time of programs on `LinuxCNC` against times that were measured on it; `fixtures/linuxcnc-times` has their origin.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use trunnion::cutter::{Cutter, CutterSpec};
use trunnion::files::machine;
use trunnion::machine::{Kinematics, Machine, Setup};
use trunnion::nc::read::{self, AxisWords, Dialect, ReadOptions};
use trunnion::types::{Interval, Silent};
use trunnion::verify::{self, CheckInput, CheckOptions, DeviationTolerance};

const MACHINE: &str = include_str!("../../../../machines/ac-trunnion.toml");
const PROGRAMS: [(&str, f64); 3] = [
    (include_str!("../../../../fixtures/linuxcnc-times/random-1.ngc"), 5.123),
    (include_str!("../../../../fixtures/linuxcnc-times/random-2.ngc"), 4.993),
    (include_str!("../../../../fixtures/linuxcnc-times/random-3.ngc"), 7.832),
];
/// Largest share by which the model may be off.
const SHARE: f64 = 0.01;

/// The limits of the measurement, home at zero, travel without end.
fn measured_machine() -> Machine {
    let mut machine = machine::parse(MACHINE).unwrap().machine;
    for (index, axis) in machine.axes.iter_mut().enumerate() {
        let (velocity, acceleration) = if index < 3 {
            (500.0, 5000.0)
        } else {
            (100.0_f64.to_radians(), 1000.0_f64.to_radians())
        };
        (axis.vel, axis.rapid, axis.acc) = (velocity, velocity, acceleration);
        (axis.home, axis.limits) = (0.0, Interval::new(-1e4, 1e4));
    }
    machine
}

#[test]
fn the_model_keeps_within_a_percent_of_the_control() {
    let kinematics = Kinematics::new(&measured_machine(), &Setup::default());
    let words = AxisWords::of(kinematics.machine()).unwrap();
    let cutter = Cutter::new(CutterSpec::ball(6.0)).unwrap();
    let tolerance = DeviationTolerance { excess: 0.01, gouge: 0.001 };
    for (text, measured) in PROGRAMS {
        let options = ReadOptions::new(Dialect::LinuxCnc, words, 5);
        let program = read::read(text, &options).unwrap();
        let input = CheckInput::program(&program, &kinematics, &cutter);
        let options = CheckOptions::of_tolerance(tolerance, 1.0);
        let audit = verify::check(&input, &options, &Silent).unwrap().audit.unwrap();
        let share = audit.linuxcnc.seconds / measured - 1.0;
        assert!(share.abs() < SHARE, "{} s, measured {measured} s", audit.linuxcnc.seconds);
    }
}
