//! Model of a control known by measurement: `LinuxCNC` 2.9, which does not look ahead where rotaries move.

use super::mean_acceleration::MeanAcceleration;
use crate::machine::{FIRST_ROTARY, Machine};
use crate::nc::control::{BlendClock, BlendTolerance, ClockedBlock, ClockedKind};
use crate::nc::read::Smoothing;
use crate::types::{AXES, AxisVector};
use crate::verify::replay::control::Control;
use crate::verify::replay::segment::{Course, Segment};
use crate::verify::report::{AxisRatio, LimitRatio, ModelAudit};
use nalgebra::UnitVector3;

/// Servo period of a machine that states none \[s\]: the usual one of the control.
const SERVO_PERIOD: f64 = 0.001;

/// Totals of a block up to its current chord.
#[derive(Debug, Default)]
struct BlockProgress {
    /// Length along the words \[mm, or rad where only rotaries move\].
    length: f64,
    /// Time by the velocity limits \[s\].
    least: f64,
    /// Acceleration of the axes over their limits, where the block is passed at 1 mm/s² \[s²/mm\].
    share: f64,
    /// A rotary axis moves.
    turns: bool,
    /// Directions of X, Y and Z in its first and last chord, where they move.
    directions: Option<[UnitVector3<f64>; 2]>,
    /// Largest velocities at the times programmed.
    fastest: AxisVector,
}

impl BlockProgress {
    /// Adds a chord by the changes of its words, under limits of velocity and acceleration.
    fn add(&mut self, words: &AxisVector, [velocity, acceleration]: &[AxisVector; 2]) {
        let linear = words.fixed_rows::<FIRST_ROTARY>(0).into_owned();
        let tip = linear.norm();
        let turn = words.fixed_rows::<{ AXES - FIRST_ROTARY }>(FIRST_ROTARY).norm();
        // The length of a block is that of X, Y and Z; only without one do the rotaries count.
        let length = if tip > 0.0 { tip } else { turn };
        let over = |limits: &AxisVector| words.abs().component_div(limits).amax();
        self.least += over(velocity);
        if length > 0.0 {
            self.share = self.share.max(over(acceleration) / length);
        }
        self.length += length;
        self.turns |= turn > 0.0;
        if let Some(direction) = UnitVector3::try_new(linear, 0.0) {
            let [first, _] = self.directions.unwrap_or([direction; 2]);
            self.directions = Some([first, direction]);
        }
    }

    /// Returns the block as the planner of the control takes it, programmed to take `seconds`.
    fn clocked(&self, seconds: f64) -> ClockedBlock {
        ClockedBlock {
            length: self.length,
            velocity: self.length / seconds.max(self.least),
            acceleration: 1.0 / self.share,
            directions: self.directions,
            kind: if self.turns { ClockedKind::Rotary } else { ClockedKind::Linear },
        }
    }

    /// Returns the time of a block that is programmed to take `seconds`.
    fn seconds(&self, seconds: f64) -> f64 {
        // Length over sqrt(a L / 2), a = 1 / share.
        let turning = if self.turns { (2.0 * self.length * self.share).sqrt() } else { 0.0 };
        seconds.max(self.least).max(turning)
    }
}

/// End of the block before.
#[derive(Debug, Clone, Copy)]
enum PreviousBlock {
    /// The machine stands.
    Rest,
    /// Without rotaries the control looks ahead and keeps its limits.
    Straight,
    /// A rotary moved at this mean velocity.
    Turning(MeanVelocity),
}

/// Mean velocity of a block at its modelled time.
#[derive(Debug, Clone, Copy)]
struct MeanVelocity {
    velocity: AxisVector,
    /// Velocity that rounding can have added.
    slack: AxisVector,
    /// Modelled time of the block \[s\].
    seconds: f64,
}

/// Model of the control, run block by block.
pub(crate) struct LinuxCncModel<'a> {
    machine: &'a Machine,
    block: BlockProgress,
    before: PreviousBlock,
    clock: BlendClock,
    velocity: [LimitRatio; AXES],
    acceleration: [LimitRatio; AXES],
    jerk: [LimitRatio; AXES],
    /// The last mean acceleration; `None` after blocks that the control looks ahead over.
    last: Option<MeanAcceleration>,
    line: u32,
    /// Distance from the path that the control may keep.
    tolerance: BlendTolerance,
}

impl<'a> LinuxCncModel<'a> {
    pub(crate) fn new(control: &'a Control) -> Self {
        let machine = control.real().machine();
        Self {
            machine,
            block: BlockProgress::default(),
            before: PreviousBlock::Rest,
            clock: BlendClock::new(machine.cycle.servo_period.unwrap_or(SERVO_PERIOD)),
            velocity: [LimitRatio::NONE; AXES],
            acceleration: [LimitRatio::NONE; AXES],
            jerk: [LimitRatio::NONE; AXES],
            last: Some(MeanAcceleration::STANDSTILL),
            line: 0,
            tolerance: BlendTolerance::Unbounded,
        }
    }

    /// Takes in a feed move that is a block or part of one, with its largest velocities at the time programmed.
    pub(crate) fn chord(&mut self, control: &Control, segment: &Segment, fastest: &AxisVector) {
        if segment.block.begins {
            self.block = BlockProgress::default();
        }
        let words = word_changes(control, segment);
        let machine = self.machine;
        let limits = [machine.vector(|axis| axis.vel), machine.vector(|axis| axis.acc)];
        self.block.add(&words, &limits);
        self.block.fastest = self.block.fastest.sup(fastest);
    }

    /// Ends the block, programmed to take `seconds`, with its mean velocity and what rounding can have added to it.
    pub(crate) fn end(&mut self, line: u32, seconds: f64, [velocity, slack]: [AxisVector; 2]) {
        self.clock.push(self.block.clocked(seconds), self.tolerance);
        let modelled = self.block.seconds(seconds);
        let slower = seconds / modelled;
        let fastest = self.block.fastest * slower;
        // A block that takes longer than programmed has its velocities in proportion.
        let mean =
            MeanVelocity { velocity: velocity * slower, slack: slack * slower, seconds: modelled };
        self.line = line;
        let axes = self.velocity.iter_mut().zip(&self.machine.axes).enumerate();
        axes.for_each(|(k, (ratio, axis))| ratio.take(fastest[k], mean.slack[k], axis.vel, line));
        if self.block.turns {
            self.difference(Some(mean));
            self.before = PreviousBlock::Turning(mean);
        } else {
            (self.before, self.last) = (PreviousBlock::Straight, None);
        }
    }

    /// Takes in `seconds` in which nothing moves.
    pub(crate) fn rest(&mut self, seconds: f64) {
        self.come_to_rest();
        self.clock.wait(seconds);
    }

    /// Takes in a rapid move, which the control blends as it does others; the loads of the axes count it as a rest.
    pub(crate) fn rapid(&mut self, control: &Control, segment: &Segment) {
        self.come_to_rest();
        if segment.is_unknown() {
            return;
        }
        let machine = self.machine;
        let limits = [machine.vector(|axis| axis.rapid), machine.vector(|axis| axis.acc)];
        let mut block = BlockProgress::default();
        block.add(&word_changes(control, segment), &limits);
        self.clock.push(block.clocked(0.0), self.tolerance);
    }

    /// Sets the distance from the path that the control may keep from here on.
    pub(crate) fn smooth(&mut self, smoothing: Option<Smoothing>) {
        self.tolerance = match smoothing {
            Some(Smoothing::Within(corners) | Smoothing::Blended { corners, .. }) => {
                BlendTolerance::Within(corners)
            }
            Some(Smoothing::Exact | Smoothing::Stop) => BlendTolerance::Stop,
            Some(Smoothing::Unbounded | Smoothing::OfMachine) | None => BlendTolerance::Unbounded,
        };
    }

    fn come_to_rest(&mut self) {
        self.difference(None);
        (self.before, self.last) = (PreviousBlock::Rest, Some(MeanAcceleration::STANDSTILL));
    }

    /// Judges the acceleration from the block before to this one, or to rest, and the jerk since the one before.
    fn difference(&mut self, to: Option<MeanVelocity>) {
        let rest = MeanVelocity {
            velocity: AxisVector::zeros(),
            slack: AxisVector::zeros(),
            seconds: 0.0,
        };
        let (from, to) = match (self.before, to) {
            (PreviousBlock::Straight, _) | (PreviousBlock::Rest, None) => {
                // The control plans these changes of velocity itself, within its limits.
                self.last = None;
                return;
            }
            (PreviousBlock::Rest, Some(to)) => (rest, to),
            (PreviousBlock::Turning(from), to) => (from, to.unwrap_or(rest)),
        };
        // Mean velocities belong to the middles of both blocks.
        let time = 0.5 * (from.seconds + to.seconds);
        let acceleration = (to.velocity - from.velocity) / time;
        let slack = (to.slack + from.slack) / time;
        let axes = self.acceleration.iter_mut().zip(&self.machine.axes).enumerate();
        axes.for_each(|(k, (ratio, axis))| {
            ratio.take(acceleration[k], slack[k], axis.acc, self.line);
        });
        let next = MeanAcceleration { acceleration, slack, first: from.seconds };
        if let Some(last) = self.last.replace(next) {
            // As in the audit: j = (a2 - a1) / ((T0 + T1 + T2) / 3).
            let whole = (last.first + from.seconds + to.seconds) / 3.0;
            let jerk = (acceleration - last.acceleration) / whole;
            let slack = (slack + last.slack) / whole;
            let axes = self.jerk.iter_mut().zip(&self.machine.axes).enumerate();
            axes.for_each(|(k, (ratio, axis))| ratio.take(jerk[k], slack[k], axis.jerk, self.line));
        }
    }

    /// Runs the last block into a standstill, and returns the worst axis of each rate.
    pub(crate) fn finish(mut self) -> ModelAudit {
        self.rest(0.0);
        let worst = |ratios: [LimitRatio; AXES]| {
            let named = ratios.into_iter().zip(&self.machine.axes);
            let worst = named.reduce(|a, b| if b.0.worst > a.0.worst { b } else { a });
            let (ratio, axis) = worst.map_or((LimitRatio::NONE, String::new()), |(ratio, axis)| {
                (ratio, axis.name.clone())
            });
            AxisRatio { axis, ratio }
        };
        let [velocity, acceleration, jerk] =
            [self.velocity, self.acceleration, self.jerk].map(worst);
        ModelAudit { seconds: self.clock.seconds(), velocity, acceleration, jerk }
    }
}

/// Returns the changes of the words over a move \[mm, rad\]: of the tip and the rotaries with tool-centre-point control,
/// else of the joints.
fn word_changes(control: &Control, segment: &Segment) -> AxisVector {
    let mut words = segment.joints[1] - segment.joints[0];
    let tip = match segment.course {
        Course::Tip { ends: [from, to], .. } => to - from,
        Course::Circle { ends: [from, to] } => {
            control.real().setup().rotation * (to.tip - from.tip)
        }
        Course::Joints | Course::Rest | Course::Unknown => return words,
    };
    words.fixed_rows_mut::<FIRST_ROTARY>(0).copy_from(&tip);
    words
}
