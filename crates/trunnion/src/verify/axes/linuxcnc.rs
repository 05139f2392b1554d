//! What a program is on a control that is known by measurement: `LinuxCNC` 2.9, which does not look ahead where rotaries
//! move.

use crate::machine::{FIRST_ROTARY, Machine};
use crate::types::{AXES, AxisVector};
use crate::verify::replay::control::Control;
use crate::verify::replay::segment::{Course, Segment};
use crate::verify::report::{AxisRatio, ModelAudit, Ratio};

/// A block so far.
#[derive(Debug, Default)]
struct Way {
    length: f64,
    /// Time by the velocities \[s\].
    least: f64,
    /// Acceleration of the axes over their limits, where the block is passed at 1 mm/s² \[s²/mm\].
    share: f64,
    turns: bool,
    /// Velocities at the times programmed.
    fastest: AxisVector,
}

impl Way {
    /// Time of a block that is programmed to take `seconds`.
    fn seconds(&self, seconds: f64) -> f64 {
        // Length over sqrt(a L / 2), a = 1 / share.
        let turning = if self.turns { (2.0 * self.length * self.share).sqrt() } else { 0.0 };
        seconds.max(self.least).max(turning)
    }
}

/// How the block before ended.
#[derive(Debug, Clone, Copy)]
enum Before {
    /// The machine stands.
    Rest,
    /// Without rotaries the control looks ahead and keeps its limits.
    Straight,
    Turning(Mean),
}

/// A block's mean velocity, what rounding can have added to it, and its time.
#[derive(Debug, Clone, Copy)]
struct Mean {
    velocity: AxisVector,
    slack: AxisVector,
    seconds: f64,
}

/// Runs the model block by block.
pub(crate) struct Model<'a> {
    machine: &'a Machine,
    way: Way,
    before: Before,
    seconds: f64,
    velocity: [Ratio; AXES],
    acceleration: [Ratio; AXES],
    jerk: [Ratio; AXES],
    /// The last mean acceleration; `None` behind moves that the control looks ahead over.
    change: Option<Change>,
    line: u32,
}

/// Mean acceleration over two moves, what rounding can have added to it, and the time of the first.
#[derive(Debug, Clone, Copy)]
struct Change {
    acceleration: AxisVector,
    slack: AxisVector,
    before: f64,
}

impl Change {
    fn standstill() -> Self {
        Self { acceleration: AxisVector::zeros(), slack: AxisVector::zeros(), before: 0.0 }
    }
}

impl<'a> Model<'a> {
    pub(crate) fn new(control: &'a Control) -> Self {
        Self {
            machine: control.real().machine(),
            way: Way::default(),
            before: Before::Rest,
            seconds: 0.0,
            velocity: [Ratio::NONE; AXES],
            acceleration: [Ratio::NONE; AXES],
            jerk: [Ratio::NONE; AXES],
            change: Some(Change::standstill()),
            line: 0,
        }
    }

    /// A feed move that is a block or part of one, and its largest velocities at the time programmed.
    pub(crate) fn chord(&mut self, control: &Control, segment: &Segment, fastest: &AxisVector) {
        if segment.block.begins {
            self.way = Way::default();
        }
        let words = words(control, segment);
        let tip = words.fixed_rows::<FIRST_ROTARY>(0).norm();
        let turn = words.fixed_rows::<{ AXES - FIRST_ROTARY }>(FIRST_ROTARY).norm();
        let length = if tip > 0.0 { tip } else { turn };
        let over = |limits: AxisVector| words.abs().component_div(&limits).amax();
        let way = &mut self.way;
        way.least += over(self.machine.vector(|axis| axis.vel));
        if length > 0.0 {
            way.share = way.share.max(over(self.machine.vector(|axis| axis.acc)) / length);
        }
        way.length += length;
        way.turns |= turn > 0.0;
        way.fastest = way.fastest.sup(fastest);
    }

    /// The block ends that is programmed to take `seconds`, with a mean velocity and what rounding can have added to it.
    pub(crate) fn end(&mut self, line: u32, seconds: f64, [velocity, slack]: [AxisVector; 2]) {
        let modelled = self.way.seconds(seconds);
        let slower = seconds / modelled;
        let fastest = self.way.fastest * slower;
        let mean = Mean { velocity: velocity * slower, slack: slack * slower, seconds: modelled };
        self.seconds += modelled;
        self.line = line;
        let axes = self.velocity.iter_mut().zip(&self.machine.axes).enumerate();
        axes.for_each(|(k, (ratio, axis))| ratio.take(fastest[k], mean.slack[k], axis.vel, line));
        if self.way.turns {
            self.change(Some(mean));
            self.before = Before::Turning(mean);
        } else {
            (self.before, self.change) = (Before::Straight, None);
        }
    }

    /// The machine rests before and after what takes `seconds`.
    pub(crate) fn rest(&mut self, seconds: f64) {
        self.change(None);
        (self.before, self.change) = (Before::Rest, Some(Change::standstill()));
        self.seconds += seconds;
    }

    /// Acceleration from the block before to this one, or to rest.
    fn change(&mut self, to: Option<Mean>) {
        let rest = Mean { velocity: AxisVector::zeros(), slack: AxisVector::zeros(), seconds: 0.0 };
        let (from, to) = match (self.before, to) {
            (Before::Straight, _) | (Before::Rest, None) => {
                self.change = None;
                return;
            }
            (Before::Rest, Some(to)) => (rest, to),
            (Before::Turning(from), to) => (from, to.unwrap_or(rest)),
        };
        let time = 0.5 * (from.seconds + to.seconds);
        let acceleration = (to.velocity - from.velocity) / time;
        let slack = (to.slack + from.slack) / time;
        let axes = self.acceleration.iter_mut().zip(&self.machine.axes).enumerate();
        axes.for_each(|(k, (ratio, axis))| {
            ratio.take(acceleration[k], slack[k], axis.acc, self.line);
        });
        let change = Change { acceleration, slack, before: from.seconds };
        if let Some(last) = self.change.replace(change) {
            // As in the audit: a third of the time of all three.
            let whole = (last.before + from.seconds + to.seconds) / 3.0;
            let jerk = (acceleration - last.acceleration) / whole;
            let slack = (slack + last.slack) / whole;
            let axes = self.jerk.iter_mut().zip(&self.machine.axes).enumerate();
            axes.for_each(|(k, (ratio, axis))| ratio.take(jerk[k], slack[k], axis.jerk, self.line));
        }
    }

    pub(crate) fn finish(mut self) -> ModelAudit {
        self.rest(0.0);
        let worst = |ratios: [Ratio; AXES]| {
            let named = ratios.into_iter().zip(&self.machine.axes);
            let worst = named.reduce(|a, b| if b.0.worst > a.0.worst { b } else { a });
            let (ratio, axis) = worst
                .map_or((Ratio::NONE, String::new()), |(ratio, axis)| (ratio, axis.name.clone()));
            AxisRatio { axis, ratio }
        };
        let [velocity, acceleration, jerk] =
            [self.velocity, self.acceleration, self.jerk].map(worst);
        ModelAudit { seconds: self.seconds, velocity, acceleration, jerk }
    }
}

/// By how much a move changes what its words say \[mm, rad\].
fn words(control: &Control, segment: &Segment) -> AxisVector {
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
