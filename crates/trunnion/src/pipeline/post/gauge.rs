//! What a program asks of the axes, and what it takes on a control without look-ahead.

use super::pace::Timed;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine};
use crate::nc::write::{Coordinates, Dialect, Style};
use crate::types::{AXES, AxisVector, ToolPose};

/// Largest velocities, and changes of those that blocks have in the mean over the time between their middles, over the limits of
/// the axes. The machine rests before and after.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gauge {
    velocity: AxisVector,
    acceleration: AxisVector,
    /// Mean velocity and time of the block before.
    before: Option<(AxisVector, f64)>,
    /// Velocity, acceleration; 1 is the limit.
    pub(super) worst: [f64; 2],
}

impl Gauge {
    pub(super) fn new(machine: &Machine) -> Self {
        Self {
            velocity: machine.vector(|axis| axis.vel),
            acceleration: machine.vector(|axis| axis.acc),
            before: None,
            worst: [0.0; 2],
        }
    }

    /// A block that moves the axes so far in a time.
    pub(super) fn push(&mut self, travel: &AxisVector, seconds: f64) {
        let seconds = if seconds > 0.0 { seconds } else { self.least(travel) };
        if seconds <= 0.0 {
            return;
        }
        let velocity = travel / seconds;
        self.worst[0] = self.worst[0].max(velocity.component_div(&self.velocity).amax());
        let (last, time) = self.before.unwrap_or((AxisVector::zeros(), 0.0));
        self.change(&(velocity - last), 0.5 * (time + seconds));
        self.before = Some((velocity, seconds));
    }

    /// A part of the block, in which the axes come to velocities with which they would travel so far.
    pub(super) fn inside(&mut self, travel: &AxisVector, seconds: f64) {
        if seconds > 0.0 {
            let velocity = travel / seconds;
            self.worst[0] = self.worst[0].max(velocity.component_div(&self.velocity).amax());
        }
    }

    /// The machine rests.
    pub(super) fn rest(&mut self) {
        if let Some((velocity, seconds)) = self.before.take() {
            self.change(&velocity, 0.5 * seconds);
        }
    }

    fn change(&mut self, by: &AxisVector, seconds: f64) {
        let ratio = by.component_div(&self.acceleration).amax() / seconds;
        self.worst[1] = self.worst[1].max(ratio);
    }

    /// Least time by the velocities of the axes.
    pub(super) fn least(&self, travel: &AxisVector) -> f64 {
        travel.component_div(&self.velocity).amax()
    }
}

/// `LinuxCNC` 2.9 as measured: where rotaries move it does not look ahead, and passes a block of length L at no more
/// than `sqrt(a L / 2)`, whatever comes next.
#[derive(Debug, Clone, Copy)]
pub(super) struct ControlModel {
    velocity: AxisVector,
    acceleration: AxisVector,
}

impl ControlModel {
    pub(super) fn new(machine: &Machine) -> Self {
        Self {
            velocity: machine.vector(|axis| axis.vel),
            acceleration: machine.vector(|axis| axis.acc),
        }
    }

    /// Time of a block whose words change by `words` \[mm, rad\], and which is programmed to take `seconds`.
    pub(super) fn seconds(&self, words: &AxisVector, seconds: f64) -> f64 {
        let tip = words.fixed_rows::<3>(0).norm();
        let turn = words.fixed_rows::<2>(FIRST_ROTARY).norm();
        let length = if tip > 0.0 { tip } else { turn };
        if length <= 0.0 {
            return seconds;
        }
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

/// Words by which a dialect's block moves, from one place to another \[mm, rad\].
pub(super) fn words(
    kinematics: &Kinematics,
    dialect: Dialect,
    [from, to]: [&(AxisVector, ToolPose); 2],
) -> AxisVector {
    let mut words = to.0 - from.0;
    if dialect.coordinates() == Coordinates::Tip {
        let tip = kinematics.setup().rotation * (to.1.tip - from.1.tip);
        words.fixed_rows_mut::<3>(0).copy_from(&tip);
    }
    words
}

/// Time that a program's own control takes: `LinuxCNC`'s by its model, others look ahead and are timed by the limits
/// of the axes.
#[derive(Debug)]
pub(super) struct Clock<'a> {
    kinematics: &'a Kinematics,
    dialect: Dialect,
    model: Option<ControlModel>,
    /// Where the last block ended, and time since.
    block: (AxisVector, ToolPose),
    waiting: f64,
}

impl<'a> Clock<'a> {
    pub(super) fn new(
        kinematics: &'a Kinematics,
        style: &Style,
        start: (AxisVector, ToolPose),
    ) -> Self {
        let model =
            Self::by_model(kinematics, style).then(|| ControlModel::new(kinematics.machine()));
        Self { kinematics, dialect: style.dialect, model, block: start, waiting: 0.0 }
    }

    /// The program runs on `LinuxCNC`, as its dialect or the machine file says.
    pub(super) fn by_model(kinematics: &Kinematics, style: &Style) -> bool {
        let own = Dialect::from_name(&kinematics.machine().dialect.name);
        let linuxcnc = Dialect::LinuxCnc;
        style.dialect == linuxcnc || (style.dialect == Dialect::G93 && own == Some(linuxcnc))
    }

    /// Time with feed that a place adds \[s\].
    pub(super) fn seconds(&mut self, one: &Timed) -> f64 {
        let feed = one.place.least.is_some();
        let Some(model) = &self.model else { return if feed { one.seconds } else { 0.0 } };
        self.waiting += one.seconds;
        if !one.place.block {
            return 0.0;
        }
        let to = (one.place.q, one.place.pose);
        let words = words(self.kinematics, self.dialect, [&self.block, &to]);
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
    fn two_blocks_of_one_axis_are_a_pencil_calculation() {
        let machine = Machine::new(ac_trunnion()).unwrap();
        let [velocity, acceleration] = [machine.axes[0].vel, machine.axes[0].acc];
        let mut gauge = Gauge::new(&machine);
        // 1 mm in 0.1 s, then 3 mm in 0.1 s: 10 and 30 mm/s; 20 mm/s in 0.1 s, and 30 mm/s to rest in 0.05 s.
        for travel in [1.0, 3.0] {
            gauge.push(&AxisVector::from([travel, 0.0, 0.0, 0.0, 0.0]), 0.1);
        }
        gauge.rest();
        assert!((gauge.worst[0] - 30.0 / velocity).abs() < 1e-12);
        assert!((gauge.worst[1] - 600.0 / acceleration).abs() < 1e-12);
    }

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
