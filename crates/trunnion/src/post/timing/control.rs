//! Times of a program on its own control, with or without look-ahead.

use super::timed_point::TimedPoint;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine};
use crate::nc::control::{BlendClock, BlendTolerance, ClockedBlock, ClockedKind};
use crate::nc::write::{Coordinates, OutputFormat, Style};
use crate::post::axis_point::AxesPose;
use crate::types::{AXES, AxisVector, PoseTolerance};
use nalgebra::UnitVector3;

/// Servo period of a machine that states none \[s\]: the usual one of the control.
const SERVO_PERIOD: f64 = 0.001;

/// Time of a program on `LinuxCNC` 2.9, block by block as its trajectory planner takes them.
#[derive(Debug, Clone)]
pub(crate) struct ControlClock {
    velocity: AxisVector,
    rapid: AxisVector,
    acceleration: AxisVector,
    tolerance: BlendTolerance,
    clock: BlendClock,
}

impl ControlClock {
    /// Creates the clock of a program for this machine, which may leave its path as far as the style states.
    pub(crate) fn new(machine: &Machine, style: &Style) -> Self {
        let within = |blend: PoseTolerance| BlendTolerance::Within(blend.tip);
        Self {
            velocity: machine.vector(|axis| axis.vel),
            rapid: machine.vector(|axis| axis.rapid),
            acceleration: machine.vector(|axis| axis.acc),
            tolerance: style.blend.map_or(BlendTolerance::Unbounded, within),
            clock: BlendClock::new(machine.cycle.servo_period.unwrap_or(SERVO_PERIOD)),
        }
    }

    /// Takes in a feed block whose words change by `words` \[mm, rad\] and which is programmed to take `seconds`.
    pub(crate) fn feed(&mut self, words: &AxisVector, seconds: f64) {
        let least = over(words, &self.velocity);
        self.push(words, seconds.max(least));
    }

    /// Takes a feed block into two clocks of one program; see [`Self::feed`].
    pub(crate) fn feed_both(clocks: [&mut Self; 2], words: &AxisVector, seconds: f64) {
        let [one, other] = clocks;
        let block = one.block(words, seconds.max(over(words, &one.velocity)));
        BlendClock::push_to_both([&mut one.clock, &mut other.clock], block, one.tolerance);
    }

    /// Takes in a rapid block.
    pub(crate) fn rapid(&mut self, words: &AxisVector) {
        let least = over(words, &self.rapid);
        self.push(words, least);
    }

    /// Takes in a block that lasts `seconds` without regard to acceleration.
    fn push(&mut self, words: &AxisVector, seconds: f64) {
        let block = self.block(words, seconds);
        self.clock.push(block, self.tolerance);
    }

    /// Returns a block that lasts `seconds` without regard to acceleration.
    fn block(&self, words: &AxisVector, seconds: f64) -> ClockedBlock {
        let linear = words.fixed_rows::<FIRST_ROTARY>(0).into_owned();
        let turn = words.fixed_rows::<{ AXES - FIRST_ROTARY }>(FIRST_ROTARY).norm();
        // F counts along X, Y, Z, and along the rotaries where these stand.
        let tip = linear.norm();
        let length = if tip > 0.0 { tip } else { turn };
        let directions = UnitVector3::try_new(linear, 0.0).map(|along| [along; 2]);
        let kind = if turn > 0.0 { ClockedKind::Rotary } else { ClockedKind::Linear };
        ClockedBlock {
            length,
            velocity: length / seconds,
            acceleration: length / over(words, &self.acceleration),
            directions,
            kind,
        }
    }

    /// Returns the time of the blocks but the last, whose end depends on the next \[s\].
    pub(crate) fn seconds(&self) -> f64 {
        self.clock.seconds()
    }

    /// Runs the last block into a standstill, and returns the time so far \[s\].
    pub(crate) fn stop(&mut self) -> f64 {
        self.clock.stop();
        self.clock.seconds()
    }
}

/// Returns the largest ratio of a change of words to the limits of the axes.
fn over(words: &AxisVector, limits: &AxisVector) -> f64 {
    words.abs().component_div(limits).amax()
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

/// Time that the control of the program takes over each part of a cut.
///
/// `LinuxCNC` is timed by its clock; other controls look ahead and are timed by the limits of the axes.
#[derive(Debug)]
pub(crate) struct ControlTiming<'a> {
    kinematics: &'a Kinematics,
    dialect: OutputFormat,
    clock: Option<ControlClock>,
    /// End of the last block, and the part that it belongs to.
    block: AxesPose,
    part: usize,
    /// Time since then \[s\].
    waiting: f64,
}

impl<'a> ControlTiming<'a> {
    /// Creates the timing of a program that starts at `start`.
    pub(crate) fn new(kinematics: &'a Kinematics, style: &Style, start: AxesPose) -> Self {
        let clock = Self::by_model(kinematics, style)
            .then(|| ControlClock::new(kinematics.machine(), style));
        Self { kinematics, dialect: style.dialect, clock, block: start, part: 0, waiting: 0.0 }
    }

    /// Returns true if the program runs on `LinuxCNC`, by its dialect or by the machine file.
    pub(crate) fn by_model(kinematics: &Kinematics, style: &Style) -> bool {
        let own = OutputFormat::from_name(&kinematics.machine().dialect.name);
        let linuxcnc = OutputFormat::LinuxCnc;
        style.dialect == linuxcnc || (style.dialect == OutputFormat::G93 && own == Some(linuxcnc))
    }

    /// Adds the time of a point with feed to the parts, once it is known \[s\].
    pub(crate) fn pass(&mut self, one: &TimedPoint, parts: &mut [f64]) {
        let feed = one.point.least.is_some();
        let Some(clock) = &mut self.clock else {
            if feed {
                add(parts, one.point.part, one.seconds);
            }
            return;
        };
        self.waiting += one.seconds;
        if !one.point.block {
            return;
        }
        let to = one.point.end();
        let words = word_travel(self.kinematics, self.dialect, &self.block, &to);
        self.block = to;
        let waited = std::mem::take(&mut self.waiting);
        let before = clock.seconds();
        if feed {
            clock.feed(&words, waited);
        } else {
            clock.stop();
        }
        // How the block before ends depends on this one: only now is its time known.
        add(parts, self.part, clock.seconds() - before);
        self.part = one.point.part;
    }

    /// Adds the time of the last block.
    pub(crate) fn finish(mut self, parts: &mut [f64]) {
        let Some(clock) = &mut self.clock else { return };
        let before = clock.seconds();
        add(parts, self.part, clock.stop() - before);
    }
}

/// Adds a time to a part \[s\].
fn add(parts: &mut [f64], part: usize, seconds: f64) {
    if let Some(sum) = parts.get_mut(part) {
        *sum += seconds;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Setup;
    use crate::nc::write::AxisWords;
    use crate::sample_machine::ac_trunnion;

    #[test]
    fn blocks_take_the_time_of_their_slowest_axis_and_its_ramps() {
        let machine = &Machine::new(ac_trunnion()).unwrap();
        let kinematics = Kinematics::new(machine, &Setup::default());
        let axes = AxisWords::of(machine).unwrap();
        let style = Style::of(&kinematics, OutputFormat::LinuxCnc, axes);
        let [velocity, acceleration] = [machine.axes[0].vel, machine.axes[0].acc];
        let cycle = 2.0 * machine.cycle.servo_period.unwrap_or(SERVO_PERIOD);
        let words = AxisVector::from([100.0, 0.0, 0.0, 0.0, 0.0]);
        // At the velocity of the axis, with a ramp at either end.
        let mut clock = ControlClock::new(machine, &style);
        clock.feed(&words, 0.0);
        let wanted = 100.0 / velocity + velocity / acceleration;
        assert!((clock.stop() - wanted).abs() < cycle);
        // Short blocks with a rotary: half of the acceleration for each of two that blend.
        let mut clock = ControlClock::new(machine, &style);
        for _ in 0..1000 {
            clock.feed(&AxisVector::from([0.01, 0.0, 0.0, 0.0, 1e-9]), 0.0);
        }
        let least = (2.0 * 0.01 / acceleration).sqrt();
        assert!(clock.stop() > 999.0 * least);
    }
}
