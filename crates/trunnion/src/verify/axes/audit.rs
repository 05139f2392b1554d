//! Axes against travel, velocity and acceleration limits, from the text's own times.

use crate::machine::{Axis, FIRST_ROTARY};
use crate::nc::read::ProgramSource;
use crate::types::{AXES, AxisVector, TRAVEL_ROUNDING};
use crate::verify::axes::blocks::Blocks;
use crate::verify::axes::linuxcnc::Model;
use crate::verify::axes::within_block::Inner;
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::controls::Controls;
use crate::verify::replay::orient::Choices;
use crate::verify::replay::segment::{Block, Course, Segment};
use crate::verify::replay::segments::Run;
use crate::verify::replay::tables::Changes;
use crate::verify::report::{Audit, AxisAudit, Overrun, Ratio};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// What a stretch of a program asks of the axes.
struct Stretch {
    line: u32,
    velocity: AxisVector,
    duration: f64,
    /// That it is of.
    block: Block,
    /// Velocity that the rounding of the words can have added.
    slack: AxisVector,
}

/// What running a program once tells.
pub(crate) struct Audited {
    pub(crate) audit: Audit,
    pub(crate) choices: Choices,
    pub(crate) changes: Changes,
}

/// Audits all moves.
pub(crate) fn audit(
    controls: &Controls,
    run: &Run<'_>,
    program: &dyn ProgramSource,
) -> Result<Audited, VerifyError> {
    let control = controls.first();
    let mut replay = run.replay().ok_or(VerifyError::NoMotion)?;
    let mut axes = control.real().machine().axes.each_ref().map(AxisState::new);
    let mut before = None;
    let (mut chord, mut start): (Option<Stretch>, _) = (None, AxisVector::zeros());
    let mut change = Change::REST;
    let mut inner = Inner::default();
    let (mut blocks, mut model) = (Blocks::new(control), Model::new(control));
    let (mut moves, mut all, mut rapid) = (0, 0.0, 0.0);
    for segment in replay.by_ref() {
        let segment = &segment?;
        let control = controls.of(segment.tool);
        moves += usize::from(segment.block.begins);
        all += segment.duration;
        rapid += if segment.rapid { segment.duration } else { 0.0 };
        visit(control, segment, (&mut inner, &mut axes))?;
        if segment.rapid || matches!(segment.course, Course::Rest) {
            // The machine rests before and after: the stretch before runs into a standstill.
            between(&mut axes, before.take().as_ref(), None, &mut change);
            change = Change::REST;
            model.rest(segment.duration);
            continue;
        }
        if segment.duration <= 0.0 {
            continue;
        }
        let stretch = stretch(control, segment, program)?;
        let fastest = fastest(&inner, &stretch, &mut axes);
        blocks.take(control, segment, &fastest)?;
        model.chord(control, segment, &fastest);
        if segment.block.begins {
            start = segment.joints[0];
        } else if let Some(chord) = &chord {
            within(&mut axes, chord, &stretch);
        }
        chord = Some(stretch);
        if !segment.block.ends {
            continue;
        }
        let (joints, duration) = ([start, segment.joints[1]], segment.block.duration);
        let stretch = self::stretch(control, &Segment { joints, duration, ..*segment }, program)?;
        between(&mut axes, before.as_ref(), Some(&stretch), &mut change);
        model.end(stretch.line, stretch.duration, [stretch.velocity, stretch.slack]);
        before = Some(stretch);
    }
    between(&mut axes, before.as_ref(), None, &mut change);
    if moves == 0 {
        return Err(VerifyError::NoMotion);
    }
    let audit = Audit {
        axes: axes.map(AxisState::finish),
        duration: all,
        rapid,
        moves,
        held: blocks.held + rapid,
        linuxcnc: model.finish(),
        brief: blocks.brief,
        singular: blocks.singular,
    };
    Ok(Audited { audit, choices: replay.choices, changes: replay.changes })
}

/// Takes the positions of a move in, where they are known.
fn visit(
    control: &Control,
    segment: &Segment,
    (inner, axes): (&mut Inner, &mut [AxisState<'_>; AXES]),
) -> Result<(), VerifyError> {
    if segment.is_unknown() {
        return Ok(());
    }
    inner.look(control, segment)?;
    for q in inner.joints() {
        axes.iter_mut().zip(q.iter()).for_each(|(axis, &q)| axis.visit(q, segment.line));
    }
    Ok(())
}

/// Takes the largest velocities of a move in.
fn fastest(inner: &Inner, stretch: &Stretch, axes: &mut [AxisState<'_>; AXES]) -> AxisVector {
    let fastest = inner.fastest(stretch.duration);
    for (index, axis) in axes.iter_mut().enumerate() {
        axis.velocity.take(fastest[index], stretch.slack[index], axis.axis.vel, stretch.line);
    }
    fastest
}

/// Mean velocity of a block and its slack: both ends may be off by the rounding, and the time by
/// the last digit of the feed word.
fn stretch(
    control: &Control,
    segment: &Segment,
    program: &dyn ProgramSource,
) -> Result<Stretch, VerifyError> {
    let duration = segment.duration;
    let velocity = (segment.joints[1] - segment.joints[0]) / duration;
    let error = joint_rounding(control, segment, &rounded(program.rounding()))?;
    // F = 60 / duration in inverse time; a speed is run as it stands. What rounding does to a block goes through all of
    // its chords evenly.
    let block = segment.block;
    let feed = if block.timed { program.feed_rounding() } else { 0.0 };
    let feed = 2.0 * feed * block.duration / 60.0;
    let slack = error * (2.0 / block.duration) + velocity.abs() * feed.min(1.0);
    Ok(Stretch { line: segment.line, velocity, duration, block, slack })
}

/// Half of a last digit from which words say what is meant \[mm, degrees\]: no path of which a tolerance is asked is
/// rounded so coarsely.
const COARSE: f64 = 0.05;

/// Rounding of the axis words, as far as they are rounded.
fn rounded(words: &AxisVector) -> AxisVector {
    let coarse = |slot: usize| if slot < FIRST_ROTARY { COARSE } else { COARSE.to_radians() };
    AxisVector::from_fn(|slot, _| if words[slot] < 0.99 * coarse(slot) { words[slot] } else { 0.0 })
}

/// What the rounding of the words does to the joints at a block's end \[mm, rad\].
///
/// Without TCP that is the rounding itself. With it the linear axes follow
/// `J dl = dtip - (d tip / d rotary) d rotary`, and the tip's distances from the rotary axes bound
/// the last term.
fn joint_rounding(
    control: &Control,
    segment: &Segment,
    rounding: &AxisVector,
) -> Result<AxisVector, VerifyError> {
    let Course::Tip { length, .. } = segment.course else { return Ok(*rounding) };
    let kinematics = control.model(length);
    let q = segment.joints[1];
    let tip = |axis: usize, by: f64| {
        let mut moved = q;
        moved[axis] += by;
        kinematics.forward(&moved).tip
    };
    let here = kinematics.forward(&q).tip;
    let column = |axis: usize| tip(axis, 1.0) - here;
    let inverse = Matrix3::from_columns(&[column(0), column(1), column(2)])
        .try_inverse()
        .ok_or(VerifyError::LinearAxes)?;
    let swing = |axis: usize| 0.5 * (tip(axis, PI) - here).norm() * rounding[axis];
    let error = rounding.fixed_rows::<3>(0).norm() + swing(3) + swing(4);
    let linear: Vector3<f64> = Vector3::from_fn(|row, _| inverse.row(row).norm() * error);
    Ok(AxisVector::new(linear.x, linear.y, linear.z, rounding[3], rounding[4]))
}

/// Mean acceleration from one stretch to the next, what rounding can have added to it, and when it begins: at
/// the beginning of the first of both.
struct Change {
    acceleration: AxisVector,
    slack: AxisVector,
    /// Time of the first of both \[s\].
    before: f64,
}

impl Change {
    /// A standstill.
    const REST: Self = Self {
        acceleration: AxisVector::new(0.0, 0.0, 0.0, 0.0, 0.0),
        slack: AxisVector::new(0.0, 0.0, 0.0, 0.0, 0.0),
        before: 0.0,
    };
}

/// Acceleration from one chord of an arc to the next, at the feed programmed. How the feed is reached at the ends of the
/// arc is the control's business.
fn within(axes: &mut [AxisState<'_>; AXES], from: &Stretch, to: &Stretch) {
    let time = 0.5 * (from.duration + to.duration);
    for (index, axis) in axes.iter_mut().enumerate() {
        let acceleration = (to.velocity[index] - from.velocity[index]) / time;
        // A radius or centre off by e adds e w to the velocity and e w² to the acceleration, w = sweep / time of the
        // block; slack is 2 e over that time, and it turns with w as well.
        let slack = to.slack[index] * to.block.sweep.max(0.5 * to.block.sweep.powi(2));
        let slack = slack / to.block.duration;
        axis.acceleration.take(acceleration, slack, axis.axis.acc, to.line);
    }
}

/// Acceleration from one stretch to the next, and jerk since the one before; `None` is a standstill.
///
/// The divided difference of two mean velocities is a weighted mean of the acceleration over both
/// stretches (weights form a trapezoid of area 1), so it cannot exceed a limit that is kept. That of two such
/// accelerations, over a third of the time of all three stretches, is one of the jerk (weights form a B-spline
/// of the second degree).
fn between(
    axes: &mut [AxisState<'_>; AXES],
    from: Option<&Stretch>,
    to: Option<&Stretch>,
    last: &mut Change,
) {
    let at = |stretch: Option<&Stretch>| {
        stretch.map_or((AxisVector::zeros(), AxisVector::zeros(), 0.0), |s| {
            (s.velocity, s.slack, s.duration)
        })
    };
    let ((v1, slack1, time1), (v2, slack2, time2)) = (at(from), at(to));
    let Some(line) = to.or(from).map(|s| s.line) else { return };
    let time = 0.5 * (time1 + time2);
    let change =
        Change { acceleration: (v2 - v1) / time, slack: (slack1 + slack2) / time, before: time1 };
    let whole = (last.before + time1 + time2) / 3.0;
    for (index, axis) in axes.iter_mut().enumerate() {
        let (acceleration, slack) = (change.acceleration[index], change.slack[index]);
        axis.acceleration.take(acceleration, slack, axis.axis.acc, line);
        let jerk = (acceleration - last.acceleration[index]) / whole;
        axis.jerk.take(jerk, (slack + last.slack[index]) / whole, axis.axis.jerk, line);
    }
    *last = change;
}

/// Running results of an axis.
struct AxisState<'a> {
    axis: &'a Axis,
    range: [f64; 2],
    travel: Option<Overrun>,
    velocity: Ratio,
    acceleration: Ratio,
    jerk: Ratio,
}

impl<'a> AxisState<'a> {
    fn new(axis: &'a Axis) -> Self {
        Self {
            axis,
            range: [f64::INFINITY, f64::NEG_INFINITY],
            travel: None,
            velocity: Ratio::NONE,
            acceleration: Ratio::NONE,
            jerk: Ratio::NONE,
        }
    }

    /// Takes a position in.
    fn visit(&mut self, q: f64, line: u32) {
        self.range = [self.range[0].min(q), self.range[1].max(q)];
        let [low, high] = self.axis.limits;
        let excess = (low - q).max(q - high);
        if excess > TRAVEL_ROUNDING && self.travel.is_none_or(|worst| excess > worst.excess) {
            self.travel = Some(Overrun { line, kind: self.axis.kind, value: q, excess });
        }
    }

    fn finish(self) -> AxisAudit {
        AxisAudit {
            name: self.axis.name.clone(),
            range: self.range,
            travel: self.travel,
            velocity: self.velocity,
            acceleration: self.acceleration,
            jerk: self.jerk,
        }
    }
}

/// A difference of joints (rounding 1e-12 mm) over the shortest step worth a block (1e-4 mm) is
/// known to 1e-8 of itself.
const RATE_ROUNDING: f64 = 1e-8;

impl Ratio {
    /// Nothing moves.
    pub(crate) const NONE: Self = Self { raw: 0.0, worst: 0.0, line: 0, broken: 0 };

    /// Takes a rate in.
    pub(crate) fn take(&mut self, rate: f64, slack: f64, limit: f64, line: u32) {
        let raw = rate.abs() / limit;
        let worst = (rate.abs() - slack).max(0.0) / limit;
        self.raw = self.raw.max(raw);
        if worst > self.worst {
            self.worst = worst;
            self.line = line;
        }
        self.broken += usize::from(worst > 1.0 + RATE_ROUNDING);
    }
}
