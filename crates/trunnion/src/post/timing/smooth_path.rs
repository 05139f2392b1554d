//! Times of points along a smooth path of the axes through all of them, window by window.

use super::corner::CornerBlend;
use super::path_sampler::PathSampler;
use super::timed_point::TimedPoint;
use crate::feed::{AnyStream, Limits, ProgrammedSpeeds, StreamKind, StreamOptions, StreamStep};
use crate::machine::Kinematics;
use crate::math;
use crate::math::quintic::Quintic;
use crate::post::axis_point::AxisPoint;
use crate::post::constants::{LEVER, SMALLEST_LENGTH};
use crate::post::error::PostError;
use crate::post::options::{PostMethod, PostOptions};
use crate::types::{AxisNode, AxisVector, Motion, Setpoint};
use std::collections::VecDeque;

/// Longest distance of two rows, so that the speed can change between points \[mm\].
const STEP: f64 = 5.0;

/// Shortest run-up, as a share of its segment.
const SHORTEST: f64 = 1e-4;

/// Length of the quicker block over which the programmed speed changes \[mm\].
const CHANGE: f64 = 0.5;

/// Ratio from which programmed speeds count as different.
const DIFFERENT: f64 = 1.05;

/// Straight segment between two points.
#[derive(Debug, Clone, Copy)]
struct StraightSegment {
    point: AxisPoint,
    from: AxisVector,
    /// Derivative of the axes by the path parameter.
    rate: AxisVector,
    length: f64,
    /// Programmed time by the path parameter.
    feed_rate: f64,
    /// Travel of the tip by the path parameter.
    tip_rate: f64,
    /// Length of the bent part at its start; the whole length if all of it is bent.
    bent: f64,
    /// Upper bound on the length from rest to the programmed speed.
    run_up: f64,
}

/// Speed of the path at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NodeSpeed {
    /// The speed changes beside the node.
    Slow,
    /// The path passes the node at speed.
    Passing,
}

/// Interval between nodes that is being planned.
#[derive(Debug, Clone, Copy)]
struct PendingInterval {
    piece: usize,
    interval: usize,
    ends: Option<AxisPoint>,
}

/// Timer along a smooth path.
#[derive(Debug)]
pub(crate) struct SmoothPathTimer {
    kinematics: Kinematics,
    planner: AnyStream,
    /// Velocities and accelerations of the axes.
    limits: [AxisVector; 2],
    tolerance: [f64; 2],
    at: AxisVector,
    /// Kind of motion of the current piece.
    motion: Option<Motion>,
    /// Index of the piece.
    piece: usize,
    /// Number of nodes in it.
    nodes: usize,
    /// Path parameter in it.
    s: f64,
    /// Last node of the piece.
    last: Option<(AxisNode, NodeSpeed)>,
    held: Option<StraightSegment>,
    closing: VecDeque<PendingInterval>,
    seconds: f64,
    /// Samples the motion, where it is asked for.
    sampler: Option<PathSampler>,
}

impl SmoothPathTimer {
    pub(crate) fn new(
        kinematics: &Kinematics,
        options: &PostOptions,
        at: AxisVector,
    ) -> Result<Self, PostError> {
        let machine = kinematics.machine();
        let limits = Limits {
            velocity: machine.vector(|axis| axis.vel),
            rapid: machine.vector(|axis| axis.rapid),
            acceleration: machine.vector(|axis| axis.acc),
            jerk: Some(machine.vector(|axis| axis.jerk)),
            minus: None,
        };
        let stream = StreamOptions {
            // The programmed point moves a second a second.
            speeds: ProgrammedSpeeds {
                feed: Some(1.0),
                tip: machine.cycle.tip_speed_max,
                ..ProgrammedSpeeds::FASTEST
            },
            ..StreamOptions::fastest(options.window, STEP)
        };
        let kind = match options.method {
            PostMethod::Jerk => StreamKind::Jerk,
            _ => StreamKind::Optimal,
        };
        let planner = AnyStream::new(kind, limits, stream)?;
        Ok(Self {
            kinematics: kinematics.clone(),
            planner,
            limits: [limits.velocity, limits.acceleration],
            tolerance: options.tolerance.into(),
            at,
            motion: None,
            piece: 0,
            nodes: 0,
            s: 0.0,
            last: None,
            held: None,
            closing: VecDeque::new(),
            seconds: 0.0,
            sampler: None,
        })
    }

    /// Samples the motion along the path as well.
    pub(crate) fn with_sampler(self, sampler: PathSampler) -> Self {
        Self { sampler: Some(sampler), ..self }
    }

    /// Returns the setpoints since the last call.
    pub(crate) fn take_setpoints(&mut self) -> Vec<Setpoint> {
        self.sampler.as_mut().map(PathSampler::take).unwrap_or_default()
    }

    /// Takes in a point, and appends the points whose time is known.
    pub(crate) fn push(
        &mut self,
        point: &AxisPoint,
        out: &mut Vec<TimedPoint>,
    ) -> Result<(), PostError> {
        let motion = if point.least.is_some() { Motion::Cut } else { Motion::Link };
        let travel = point.q - self.at;
        // The path parameter is a length: that of the tip, and of the rotaries at a lever.
        let turn = LEVER * travel.fixed_rows::<2>(3).norm();
        let length = math::hypot(point.tip, turn);
        if self.motion != Some(motion) {
            self.end_piece(out)?;
        }
        if length <= self.least_gap() {
            // No word changes; the next segment starts from the same axes.
            return Ok(());
        }
        let mut straight = StraightSegment {
            point: *point,
            from: self.at,
            rate: travel / length,
            length,
            feed_rate: point.least.unwrap_or(0.0) / length,
            tip_rate: point.tip / length,
            bent: length,
            run_up: 0.0,
        };
        // Rows at the ends of run-ups let the speed change inside a long segment.
        straight.run_up = self.run_up(&straight);
        self.at = point.q;
        match self.held.take() {
            None => {
                self.motion = Some(motion);
                self.planner.begin(motion);
                (self.nodes, self.s) = (0, 0.0);
                // A piece starts from rest, so its first node may be sharp.
                let q = [straight.from, straight.rate, AxisVector::zeros(), AxisVector::zeros()];
                self.last = None;
                self.node(q, &straight, None, NodeSpeed::Slow)?;
                self.held = Some(straight);
            }
            Some(before) => self.corner(&before, straight)?,
        }
        self.planned(out);
        Ok(())
    }

    /// Ends the path, appends all remaining points, and returns the sampler.
    pub(crate) fn finish(
        mut self,
        out: &mut Vec<TimedPoint>,
    ) -> Result<Option<PathSampler>, PostError> {
        self.end_piece(out)?;
        while let Some(step) = self.planner.next() {
            self.step(&step, out);
        }
        self.close_before([usize::MAX, 0], out);
        Ok(self.sampler)
    }

    /// Ends a piece of one kind of motion, at rest.
    fn end_piece(&mut self, out: &mut Vec<TimedPoint>) -> Result<(), PostError> {
        if let Some(last) = self.held.take() {
            self.inner(&last, last.length)?;
            let end = last.point.q;
            let q = [end, last.rate, AxisVector::zeros(), AxisVector::zeros()];
            self.node(q, &last, Some(last.point), NodeSpeed::Slow)?;
            self.piece += 1;
        }
        self.motion = None;
        self.planned(out);
        Ok(())
    }

    /// Adds the node between two straight segments.
    ///
    /// It lies on the parabola through the corner and a point on either side, as far away as the timed path may leave
    /// the segments.
    fn corner(
        &mut self,
        before: &StraightSegment,
        mut after: StraightSegment,
    ) -> Result<(), PostError> {
        let change = after.rate - before.rate;
        let corner = CornerBlend {
            q: before.point.q,
            rates: [before.rate, after.rate],
            length: before.length.max(after.length),
        };
        let reach = corner.reach(&self.kinematics, self.tolerance);
        // Each half of a segment belongs to one of its corners, unless a corner may bend all of it.
        let within = |length: f64| if reach >= length { length } else { reach.min(0.5 * length) };
        let [near, far] = [within(before.length), within(after.length)];
        // Parabola through the points at -near and far and the corner at 0: its slope there is the mean of
        // both rates, each weighted with the other's distance; its second derivative twice their divided
        // difference.
        let weight = 1.0 / (near + far);
        let rate = (before.rate * far + after.rate * near) * weight;
        let second = change * (2.0 * weight);
        let slower = |one: f64, other: f64| one > DIFFERENT * other;
        // The quicker block keeps its own feed but for a brief part beside the slower one.
        let brief = |bent: f64, length: f64| bent.min(0.5 * length).min(CHANGE);
        let end = if slower(after.feed_rate, before.feed_rate) {
            brief(near, before.length)
        } else {
            near
        };
        after.bent =
            if slower(before.feed_rate, after.feed_rate) { brief(far, after.length) } else { far };
        self.inner(before, end)?;
        let q = [before.point.q, rate, second, AxisVector::zeros()];
        // At the node the slower programmed speed of both holds.
        let both = StraightSegment {
            feed_rate: before.feed_rate.max(after.feed_rate),
            tip_rate: before.tip_rate.max(after.tip_rate),
            ..*before
        };
        self.node(q, &both, Some(before.point), NodeSpeed::Passing)?;
        self.held = Some(after);
        Ok(())
    }

    /// Adds the nodes at which the straight part of a segment begins and ends; `end` is the length bent at its end.
    fn inner(&mut self, of: &StraightSegment, end: f64) -> Result<(), PostError> {
        let start = self.s;
        // Straight between the two bent ends.
        let [from, to] = [of.bent, of.length - end];
        // Two halves meet: rounding must not leave a sliver between them.
        let meet = to <= from * (1.0 + 4.0 * f64::EPSILON);
        let sharp = [of.bent < of.length, end < of.length && !(meet && of.bent < of.length)];
        let gap = self.least_gap();
        let mut last = 0.0;
        for (at, sharp) in [from, to].into_iter().zip(sharp) {
            if !sharp || at - last <= gap || of.length - at <= gap {
                continue;
            }
            last = at;
            self.s = start + at;
            let zero = AxisVector::zeros();
            let q = [of.from + of.rate * at, of.rate, zero, zero];
            self.node(q, of, None, NodeSpeed::Slow)?;
        }
        self.s = start + of.length;
        Ok(())
    }

    /// Returns the distance below which two rows are one \[mm\].
    ///
    /// It is less than the last digit of any word, and more than the rounding of the path parameter.
    fn least_gap(&self) -> f64 {
        SMALLEST_LENGTH + 16.0 * f64::EPSILON * self.s
    }

    /// Returns `v² / 2a` along a segment, by the programmed speed and the limits of the axes.
    fn run_up(&self, of: &StraightSegment) -> f64 {
        // Path speed and acceleration are bounded by the axis that comes first to its limit.
        let slowest = |limits: &AxisVector| of.rate.abs().component_div(limits).amax();
        let rate = slowest(&self.limits[0]).max(of.feed_rate);
        // A shorter run-up gains nothing, and rounding would show.
        (0.5 * slowest(&self.limits[1]) / (rate * rate)).max(SHORTEST * of.length)
    }

    /// Adds a node inside a segment, or at its end.
    ///
    /// At a slow node the speed changes beside it: extra nodes go to the ends of the run-ups.
    fn node(
        &mut self,
        q: [AxisVector; 4],
        of: &StraightSegment,
        point: Option<AxisPoint>,
        speed: NodeSpeed,
    ) -> Result<(), PostError> {
        let node = AxisNode { s: self.s, q, tip_rate: of.tip_rate, feed_rate: of.feed_rate };
        if let Some((last, before)) = self.last.replace((node, speed)) {
            let length = node.s - last.s;
            let run_up = of.run_up;
            // Extra nodes lie on the quintic that the planner would use between the two, so the path stays as
            // it is.
            let quintic = Quintic::new(length, jet(&last.q), jet(&node.q));
            let inside = [run_up, length - run_up];
            let fits = run_up < 0.45 * length && run_up > self.least_gap();
            let wanted = [before, speed].map(|speed| fits && speed == NodeSpeed::Slow);
            for at in inside.into_iter().zip(wanted).filter_map(|(at, wanted)| wanted.then_some(at))
            {
                let share = at / length;
                let between = |a: f64, b: f64| a + share * (b - a);
                let cut = AxisNode {
                    s: last.s + at,
                    q: quintic.at(at),
                    tip_rate: between(last.tip_rate, node.tip_rate),
                    feed_rate: between(last.feed_rate, node.feed_rate),
                };
                self.send(cut, None)?;
            }
        }
        self.send(node, point)
    }

    /// Hands a node to the planner; `ends` is the point that ends there.
    fn send(&mut self, node: AxisNode, ends: Option<AxisPoint>) -> Result<(), PostError> {
        self.planner.push(node)?;
        if let Some(sampler) = &mut self.sampler {
            sampler.node([self.piece, self.nodes], node);
        }
        if self.nodes > 0 {
            let interval = self.nodes - 1;
            self.closing.push_back(PendingInterval { piece: self.piece, interval, ends });
        }
        self.nodes += 1;
        Ok(())
    }

    /// Takes the steps that the planner has finished.
    fn planned(&mut self, out: &mut Vec<TimedPoint>) {
        while !self.planner.wants() {
            let Some(step) = self.planner.next() else { break };
            self.step(&step, out);
        }
    }

    fn step(&mut self, step: &StreamStep, out: &mut Vec<TimedPoint>) {
        self.close_before([step.piece, step.interval], out);
        if let Some(sampler) = &mut self.sampler {
            sampler.step(step);
        }
        self.seconds += step.duration;
    }

    /// Ends the intervals before `next`, and appends their points.
    fn close_before(&mut self, next: [usize; 2], out: &mut Vec<TimedPoint>) {
        while let Some(front) = self.closing.front()
            && [front.piece, front.interval] < next
        {
            if let Some(point) = front.ends {
                // Steps add up to the time of the point; never less than programmed, whatever the rounding.
                let seconds = self.seconds.max(point.least.unwrap_or(0.0));
                out.push(TimedPoint { point, seconds });
                self.seconds = 0.0;
            }
            self.closing.pop_front();
        }
    }
}

/// Returns the value and two derivatives.
fn jet(q: &[AxisVector; 4]) -> [AxisVector; 3] {
    [q[0], q[1], q[2]]
}
