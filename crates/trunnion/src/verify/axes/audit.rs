//! Axes against travel, velocity and acceleration limits, from the text's own times.

use super::block_course::BlockCourse;
use super::block_timing::BlockTiming;
use super::linuxcnc::LinuxCncModel;
use super::mean_acceleration::MeanAcceleration;
use super::within_block::WithinBlock;
use crate::machine::{Axis, FIRST_ROTARY};
use crate::nc::read::ProgramSource;
use crate::types::{AXES, AxisVector, TRAVEL_ROUNDING};
use crate::verify::error::VerifyError;
use crate::verify::replay::control::Control;
use crate::verify::replay::controls::Controls;
use crate::verify::replay::orient::Choices;
use crate::verify::replay::segment::{Block, BlockTime, Course, FeedLength, Segment};
use crate::verify::replay::segments::Run;
use crate::verify::replay::tables::Changes;
use crate::verify::report::{Audit, AuditedMotion, AxisAudit, LimitRatio, TravelOverrun};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Mean motion of the axes over one feed block, or over one chord of an arc.
struct MeanMotion {
    /// Line of the program.
    line: u32,
    /// Mean velocity \[mm/s, rad/s\].
    velocity: AxisVector,
    /// Time \[s\].
    duration: f64,
    /// Block that it belongs to.
    block: Block,
    /// Velocity that the rounding of the words can have added \[mm/s, rad/s\].
    slack: AxisVector,
    /// Time that it can have taken away or added \[s\].
    time_slack: f64,
}

/// Results of one replay of a program.
pub(crate) struct ReplayAudit {
    pub(crate) audit: Audit,
    pub(crate) choices: Choices,
    pub(crate) changes: Changes,
}

/// Audits all moves of a program.
pub(crate) fn audit(
    controls: &Controls,
    run: &Run<'_>,
    program: &dyn ProgramSource,
) -> Result<ReplayAudit, VerifyError> {
    let mut replay = run.replay().ok_or(VerifyError::NoMotion)?;
    let mut auditor = AxisAuditor::new(controls.first());
    while let Some(segment) = replay.next() {
        let segment = &segment?;
        auditor.linuxcnc.smooth(replay.smoothing);
        auditor.take(controls.of(segment.tool), segment, program)?;
    }
    let audit = auditor.finish()?;
    Ok(ReplayAudit { audit, choices: replay.choices, changes: replay.changes })
}

/// Audit in progress: running results over the segments replayed so far.
struct AxisAuditor<'a> {
    axes: [AxisState<'a>; AXES],
    within: WithinBlock,
    timing: BlockTiming<'a>,
    linuxcnc: LinuxCncModel<'a>,
    /// Mean motion of the feed block before; `None` at a standstill.
    block: Option<MeanMotion>,
    /// Mean motion of the last feed segment.
    chord: Option<MeanMotion>,
    /// Axis positions at which the current block began.
    start: AxisVector,
    /// Mean acceleration into the feed block before.
    acceleration: MeanAcceleration,
    motion: AuditedMotion,
    course: BlockCourse,
    /// Time of all blocks, and of the rapids among them \[s\].
    duration: f64,
    rapid: f64,
}

impl<'a> AxisAuditor<'a> {
    /// Starts at a standstill.
    fn new(control: &'a Control) -> Self {
        Self {
            axes: control.real().machine().axes.each_ref().map(AxisState::new),
            within: WithinBlock::default(),
            timing: BlockTiming::new(control),
            linuxcnc: LinuxCncModel::new(control),
            block: None,
            chord: None,
            start: AxisVector::zeros(),
            acceleration: MeanAcceleration::STANDSTILL,
            motion: AuditedMotion::default(),
            course: BlockCourse::default(),
            duration: 0.0,
            rapid: 0.0,
        }
    }

    /// Takes in the next segment.
    fn take(
        &mut self,
        control: &Control,
        segment: &Segment,
        program: &dyn ProgramSource,
    ) -> Result<(), VerifyError> {
        self.count(control, segment)?;
        self.duration += segment.duration;
        self.rapid += if segment.rapid { segment.duration } else { 0.0 };
        self.visit(control, segment)?;
        if segment.rapid || matches!(segment.course, Course::Rest) {
            // The machine rests before and after: the feed block before runs into a standstill.
            let before = self.block.take();
            self.difference(before.as_ref(), None);
            self.acceleration = MeanAcceleration::STANDSTILL;
            if segment.rapid {
                self.linuxcnc.rapid(control, segment);
            } else {
                self.linuxcnc.rest(segment.duration);
            }
            return Ok(());
        }
        // Without time there is no velocity; a move of no length is not judged.
        if segment.duration <= 0.0 {
            return Ok(());
        }
        self.feed(control, segment, program)
    }

    /// Counts a segment and the travel of the tip in it.
    fn count(&mut self, control: &Control, segment: &Segment) -> Result<(), VerifyError> {
        let motion = &mut self.motion;
        let (moves, length) = if segment.rapid {
            (&mut motion.rapids, &mut motion.rapid_length)
        } else {
            (&mut motion.cuts, &mut motion.cut_length)
        };
        *moves += usize::from(segment.block.begins);
        if matches!(segment.course, Course::Rest) {
            return Ok(());
        }
        if segment.is_unknown() {
            self.course.take(segment, None);
            return Ok(());
        }
        let ends = [control.pose(segment, 0.0)?, control.pose(segment, 1.0)?];
        *length += (ends[1].tip - ends[0].tip).norm();
        self.course.take(segment, Some(ends));
        Ok(())
    }

    /// Takes in the positions of a segment, where they are known.
    fn visit(&mut self, control: &Control, segment: &Segment) -> Result<(), VerifyError> {
        if segment.is_unknown() {
            return Ok(());
        }
        self.within.sample(control, segment)?;
        for q in self.within.joints() {
            self.axes.iter_mut().zip(q.iter()).for_each(|(axis, &q)| axis.visit(q, segment.line));
        }
        Ok(())
    }

    /// Takes in a feed segment: a block, or one chord of an arc.
    fn feed(
        &mut self,
        control: &Control,
        segment: &Segment,
        program: &dyn ProgramSource,
    ) -> Result<(), VerifyError> {
        let motion = mean_motion(control, segment, program)?;
        let fastest = self.within.fastest(motion.duration);
        for (index, axis) in self.axes.iter_mut().enumerate() {
            axis.velocity.take(fastest[index], motion.slack[index], axis.axis.vel, motion.line);
        }
        self.timing.take(control, segment, &fastest)?;
        self.linuxcnc.chord(control, segment, &fastest);
        if segment.block.begins {
            self.start = segment.joints[0];
        } else if let Some(chord) = &self.chord {
            within_arc(&mut self.axes, chord, &motion);
        }
        self.chord = Some(motion);
        if !segment.block.ends {
            return Ok(());
        }
        // Between blocks the whole block counts, not its last chord: its ends, over its own time.
        let (joints, duration) = ([self.start, segment.joints[1]], segment.block.duration);
        let motion = mean_motion(control, &Segment { joints, duration, ..*segment }, program)?;
        let before = self.block.take();
        self.difference(before.as_ref(), Some(&motion));
        self.linuxcnc.end(motion.line, motion.duration, [motion.velocity, motion.slack]);
        self.block = Some(motion);
        Ok(())
    }

    /// Judges acceleration from one block to the next, and jerk since the one before; `None` is a standstill.
    ///
    /// The divided difference of two mean velocities is a weighted mean of the acceleration over both
    /// blocks (weights form a trapezoid of area 1), so it cannot exceed a limit that is kept. That of two such
    /// accelerations, over a third of the time of all three blocks, is one of the jerk (weights form a B-spline
    /// of the second degree).
    fn difference(&mut self, from: Option<&MeanMotion>, to: Option<&MeanMotion>) {
        let at = |motion: Option<&MeanMotion>| {
            motion.map_or((AxisVector::zeros(), AxisVector::zeros(), 0.0), |motion| {
                (motion.velocity, motion.slack, motion.duration)
            })
        };
        let ((v1, slack1, time1), (v2, slack2, time2)) = (at(from), at(to));
        let Some(line) = to.or(from).map(|motion| motion.line) else { return };
        // Mean velocities belong to the middles of both blocks, which are (T1 + T2) / 2 apart.
        let time = 0.5 * (time1 + time2);
        let acceleration = (v2 - v1) / time;
        // The times of both blocks may be off as well, which changes the quotient by the same share.
        let time_slack: f64 = [from, to].into_iter().flatten().map(|of| of.time_slack).sum();
        let slack = (slack1 + slack2) / time + acceleration.abs() * (0.5 * time_slack / time);
        let next = MeanAcceleration { acceleration, slack, first: time1 };
        let last = &self.acceleration;
        // j = (a2 - a1) / ((T0 + T1 + T2) / 3).
        let whole = (last.first + time1 + time2) / 3.0;
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let (acceleration, slack) = (next.acceleration[index], next.slack[index]);
            axis.acceleration.take(acceleration, slack, axis.axis.acc, line);
            let jerk = (acceleration - last.acceleration[index]) / whole;
            axis.jerk.take(jerk, (slack + last.slack[index]) / whole, axis.axis.jerk, line);
        }
        self.acceleration = next;
    }

    /// Runs the last block into a standstill, and returns the results.
    fn finish(mut self) -> Result<Audit, VerifyError> {
        let before = self.block.take();
        self.difference(before.as_ref(), None);
        self.course.end_tool();
        let moves = self.motion.rapids + self.motion.cuts;
        if moves == 0 {
            return Err(VerifyError::NoMotion);
        }
        Ok(Audit {
            axes: self.axes.map(AxisState::finish),
            duration: self.duration,
            rapid: self.rapid,
            moves,
            motion: self.motion,
            held: self.timing.held + self.rapid,
            linuxcnc: self.linuxcnc.finish(),
            brief: self.timing.short,
            singular: self.timing.singular,
            unended: self.course.unended,
            slow: self.course.slow,
            fast: self.course.finish_fast(),
        })
    }
}

/// Judges the acceleration from one chord of an arc to the next, at the feed programmed.
///
/// The control reaches the feed at the ends of the arc by its own rules, which are not judged.
fn within_arc(axes: &mut [AxisState<'_>; AXES], from: &MeanMotion, to: &MeanMotion) {
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

/// Returns the mean velocity of a segment and its slack: both ends may be off by the rounding, and the time by
/// the last digit of the feed word.
fn mean_motion(
    control: &Control,
    segment: &Segment,
    program: &dyn ProgramSource,
) -> Result<MeanMotion, VerifyError> {
    let duration = segment.duration;
    let velocity = (segment.joints[1] - segment.joints[0]) / duration;
    let words = rounded(program.rounding());
    let error = joint_rounding(control, segment, &words)?;
    // What rounding does to a block goes through all of its chords evenly.
    let block = segment.block;
    let share = time_rounding(&block, &words, program.feed_rounding());
    // Both ends may be off by the error in opposite directions.
    let slack = error * (2.0 / block.duration) + velocity.abs() * share;
    Ok(MeanMotion {
        line: segment.line,
        velocity,
        duration,
        block,
        slack,
        time_slack: share * duration,
    })
}

/// Bounds the share by which rounding of words can change the time of a block; at most 1.
fn time_rounding(block: &Block, words: &AxisVector, feed: f64) -> f64 {
    let share = match block.time {
        BlockTime::Exact => 0.0,
        // F off by e changes the time T = 60 / F by the share e / (F - e), at most twice e / F = e T / 60 up to F = 2 e.
        BlockTime::Stated => 2.0 * feed * block.duration / 60.0,
        // T = 60 L / F: both ends of L may be off in opposite directions. F itself is run as it stands.
        BlockTime::OverLength(length) => {
            let ends = match length {
                FeedLength::Linear(_) => words.fixed_rows::<3>(0).norm(),
                FeedLength::Degrees(_) => words.fixed_rows::<2>(FIRST_ROTARY).norm().to_degrees(),
            };
            2.0 * ends / length.value()
        }
    };
    share.min(1.0)
}

/// Half of a last digit from which words are taken as exact \[mm, degrees\]: no path that has a tolerance is rounded so
/// coarsely.
const COARSE: f64 = 0.05;

/// Returns the rounding of the axis words; 0 for words that are taken as exact.
fn rounded(words: &AxisVector) -> AxisVector {
    // One decimal has a half digit of COARSE itself: the factor keeps it coarse whatever its own rounding.
    let coarse = |slot: usize| if slot < FIRST_ROTARY { COARSE } else { COARSE.to_radians() };
    AxisVector::from_fn(|slot, _| if words[slot] < 0.99 * coarse(slot) { words[slot] } else { 0.0 })
}

/// Bounds the error of the joints at a block's end by the rounding of its words \[mm, rad\].
///
/// Without TCP it is the rounding itself. With it the linear axes follow
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
    // The tip is linear in X, Y and Z, so a step of 1 mm is a column of the Jacobian J.
    let column = |axis: usize| tip(axis, 1.0) - here;
    let inverse = Matrix3::from_columns(&[column(0), column(1), column(2)])
        .try_inverse()
        .ok_or(VerifyError::LinearAxes)?;
    // Half a turn moves the tip by the diameter of its circle about the axis: half of that is its lever.
    let swing = |axis: usize| 0.5 * (tip(axis, PI) - here).norm() * rounding[axis];
    let error = rounding.fixed_rows::<3>(0).norm() + swing(3) + swing(4);
    // A row of the inverse times an error of any direction is at most its norm times the length of the error.
    let linear: Vector3<f64> = Vector3::from_fn(|row, _| inverse.row(row).norm() * error);
    Ok(AxisVector::new(linear.x, linear.y, linear.z, rounding[3], rounding[4]))
}

/// Running results of an axis.
struct AxisState<'a> {
    axis: &'a Axis,
    range: [f64; 2],
    travel: Option<TravelOverrun>,
    velocity: LimitRatio,
    acceleration: LimitRatio,
    jerk: LimitRatio,
}

impl<'a> AxisState<'a> {
    fn new(axis: &'a Axis) -> Self {
        Self {
            axis,
            range: [f64::INFINITY, f64::NEG_INFINITY],
            travel: None,
            velocity: LimitRatio::NONE,
            acceleration: LimitRatio::NONE,
            jerk: LimitRatio::NONE,
        }
    }

    /// Takes in a position.
    fn visit(&mut self, q: f64, line: u32) {
        self.range = [self.range[0].min(q), self.range[1].max(q)];
        let [low, high] = self.axis.limits.ends();
        // Positive beyond either end; at most one of both is.
        let excess = (low - q).max(q - high);
        if excess > TRAVEL_ROUNDING && self.travel.is_none_or(|worst| excess > worst.excess) {
            self.travel = Some(TravelOverrun { line, kind: self.axis.kind, value: q, excess });
        }
    }

    fn finish(self) -> AxisAudit {
        AxisAudit {
            name: self.axis.name.clone(),
            range: self.range.into(),
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

impl LimitRatio {
    /// Nothing moves.
    pub(crate) const NONE: Self = Self { raw: 0.0, worst: 0.0, line: 0, broken: 0 };

    /// Takes in a rate.
    pub(crate) fn take(&mut self, rate: f64, slack: f64, limit: f64, line: u32) {
        let raw = rate.abs() / limit;
        // The least rate that unrounded words can have: a limit counts as broken only if that breaks it.
        let worst = (rate.abs() - slack).max(0.0) / limit;
        self.raw = self.raw.max(raw);
        if worst > self.worst {
            self.worst = worst;
            self.line = line;
        }
        self.broken += usize::from(worst > 1.0 + RATE_ROUNDING);
    }
}
