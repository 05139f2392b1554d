//! Times of a program on its own control, with or without look-ahead.

use super::timed_point::TimedPoint;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine};
use crate::nc::write::{Coordinates, OutputFormat, Style};
use crate::post::axis_point::AxesPose;
use crate::types::{AXES, AxisVector};

/// Model of `LinuxCNC` 2.9, from measurements.
///
/// Where rotaries move it does not look ahead, and passes a block of length L at no more than `sqrt(a L / 2)`,
/// whatever comes next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ControlModel {
    velocity: AxisVector,
    acceleration: AxisVector,
}

impl ControlModel {
    /// Creates the model for the axes of a machine.
    pub(crate) fn new(machine: &Machine) -> Self {
        Self {
            velocity: machine.vector(|axis| axis.vel),
            acceleration: machine.vector(|axis| axis.acc),
        }
    }

    /// Returns the time of a block whose words change by `words` \[mm, rad\] and which is programmed to take `seconds`.
    pub(crate) fn seconds(&self, words: &AxisVector, seconds: f64) -> f64 {
        let tip = words.fixed_rows::<3>(0).norm();
        let turn = words.fixed_rows::<2>(FIRST_ROTARY).norm();
        // F counts along X, Y, Z, and along the rotaries where these stand.
        let length = if tip > 0.0 { tip } else { turn };
        if length <= 0.0 {
            return seconds;
        }
        // Largest speed or acceleration along the block that every axis allows.
        let along = |limits: &AxisVector| {
            (0..AXES)
                .filter(|&axis| words[axis] != 0.0)
                .map(|axis| limits[axis] * length / words[axis].abs())
                .fold(f64::INFINITY, f64::min)
        };
        let mut speed = along(&self.velocity);
        if turn > 0.0 {
            speed = speed.min((0.5 * along(&self.acceleration) * length).sqrt());
        }
        seconds.max(length / speed)
    }
}

/// Returns the change of a dialect's words from one point to another \[mm, rad\].
pub(crate) fn word_travel(
    kinematics: &Kinematics,
    dialect: OutputFormat,
    from: &AxesPose,
    to: &AxesPose,
) -> AxisVector {
    let mut words = to.q - from.q;
    if dialect.coordinates() == Coordinates::Tip {
        // Words of the tip are in the table frame, which the setup rotation turns.
        let tip = kinematics.setup().rotation * (to.pose.tip - from.pose.tip);
        words.fixed_rows_mut::<3>(0).copy_from(&tip);
    }
    words
}

/// Time that the control of the program takes.
///
/// `LinuxCNC` is timed by its model; other controls look ahead and are timed by the limits of the axes.
#[derive(Debug)]
pub(crate) struct ControlTiming<'a> {
    kinematics: &'a Kinematics,
    dialect: OutputFormat,
    model: Option<ControlModel>,
    /// End of the last block.
    block: AxesPose,
    /// Time since then \[s\].
    waiting: f64,
}

impl<'a> ControlTiming<'a> {
    /// Creates the timing of a program that starts at `start`.
    pub(crate) fn new(kinematics: &'a Kinematics, style: &Style, start: AxesPose) -> Self {
        let model =
            Self::by_model(kinematics, style).then(|| ControlModel::new(kinematics.machine()));
        Self { kinematics, dialect: style.dialect, model, block: start, waiting: 0.0 }
    }

    /// Returns true if the program runs on `LinuxCNC`, by its dialect or by the machine file.
    pub(crate) fn by_model(kinematics: &Kinematics, style: &Style) -> bool {
        let own = OutputFormat::from_name(&kinematics.machine().dialect.name);
        let linuxcnc = OutputFormat::LinuxCnc;
        style.dialect == linuxcnc || (style.dialect == OutputFormat::G93 && own == Some(linuxcnc))
    }

    /// Returns the time with feed that a point adds \[s\].
    pub(crate) fn seconds(&mut self, one: &TimedPoint) -> f64 {
        let feed = one.point.least.is_some();
        let Some(model) = &self.model else { return if feed { one.seconds } else { 0.0 } };
        self.waiting += one.seconds;
        if !one.point.block {
            return 0.0;
        }
        let to = one.point.end();
        let words = word_travel(self.kinematics, self.dialect, &self.block, &to);
        self.block = to;
        let waited = std::mem::take(&mut self.waiting);
        if feed { model.seconds(&words, waited) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample_machine::ac_trunnion;

    #[test]
    fn short_blocks_with_rotaries_are_slow_on_the_model() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let model = ControlModel::new(&machine);
        // Straight blocks run at the speed of the axis, if the program allows it.
        let straight = AxisVector::from([0.01, 0.0, 0.0, 0.0, 0.0]);
        let fastest = 0.01 / machine.axes[0].vel;
        assert!((model.seconds(&straight, 2.0 * fastest) - 2.0 * fastest).abs() < 1e-15);
        assert!((model.seconds(&straight, 0.0) - fastest).abs() < 1e-15);
        let turning = AxisVector::from([0.01, 0.0, 0.0, 0.0, 1e-9]);
        let acceleration = machine.axes[0].acc;
        let least = (0.01 / (0.5 * acceleration * 0.01).sqrt()).max(fastest);
        assert!((model.seconds(&turning, 0.0) - least).abs() < 1e-12);
    }
}
