//! Times of places: the axes along a smooth path that passes all of them, window by window.

use super::corner::Corner;
use super::leg::Place;
use super::{PostError, PostMethod, PostOptions};
use crate::feed::{AnyStream, Limits, ProgrammedSpeeds, StreamKind, StreamOptions, StreamStep};
use crate::machine::Kinematics;
use crate::math::quintic::Quintic;
use crate::types::{AxisNode, AxisVector, Motion};
use std::collections::VecDeque;

/// What a turn counts in the path parameter beside the way of the tip \[mm/rad\].
pub(super) const LEVER: f64 = 10.0;

/// Longest distance of two rows, so that speed can change on the way \[mm\].
const STEP: f64 = 5.0;

/// Nine decimals are the most that words have \[mm\].
pub(super) const LEAST: f64 = 1e-9;

/// Shortest run-up, over the length of its stretch.
const SHORTEST: f64 = 1e-4;

/// Where the programmed speed changes, it does so over this length of the quicker block \[mm\].
const CHANGE: f64 = 0.5;

/// Programmed speeds count as different from this ratio on.
const DIFFERENT: f64 = 1.05;

/// A place and when it is passed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Timed {
    pub(super) place: Place,
    /// Time from the place before \[s\].
    pub(super) seconds: f64,
}

/// A straight stretch between two places.
#[derive(Debug, Clone, Copy)]
struct Straight {
    place: Place,
    from: AxisVector,
    /// Axes by the path parameter.
    rate: AxisVector,
    length: f64,
    /// Programmed time, and way of the tip, by the path parameter.
    feed_rate: f64,
    tip_rate: f64,
    /// How far the start of it is bent; its length if all is.
    bent: f64,
    /// Way from rest to the programmed speed, at most.
    run_up: f64,
}

/// An interval between nodes that is being planned.
#[derive(Debug, Clone, Copy)]
struct Closing {
    piece: usize,
    interval: usize,
    ends: Option<Place>,
}

/// Takes in places, hands out their times.
#[derive(Debug)]
pub(super) struct Pace {
    kinematics: Kinematics,
    planner: AnyStream,
    /// Velocities and accelerations of the axes.
    limits: [AxisVector; 2],
    tolerance: [f64; 2],
    at: AxisVector,
    /// Kind of motion of the piece, index, nodes in it, path parameter.
    motion: Option<Motion>,
    piece: usize,
    nodes: usize,
    s: f64,
    /// The last node of the piece, and whether it is passed slowly.
    last: Option<(AxisNode, bool)>,
    held: Option<Straight>,
    closing: VecDeque<Closing>,
    seconds: f64,
}

impl Pace {
    pub(super) fn new(
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
            tolerance: options.tolerance,
            at,
            motion: None,
            piece: 0,
            nodes: 0,
            s: 0.0,
            last: None,
            held: None,
            closing: VecDeque::new(),
            seconds: 0.0,
        })
    }

    /// Takes in a place; those whose time is known are appended.
    pub(super) fn push(&mut self, place: &Place, out: &mut Vec<Timed>) -> Result<(), PostError> {
        let motion = if place.least.is_some() { Motion::Cut } else { Motion::Link };
        let travel = place.q - self.at;
        let turn = LEVER * travel.fixed_rows::<2>(3).norm();
        let length = place.tip.hypot(turn);
        if self.motion != Some(motion) {
            self.end_piece(out)?;
        }
        if length <= self.least_gap() {
            // Nothing moves that a word can say; what follows starts where the axes were.
            return Ok(());
        }
        let mut straight = Straight {
            place: *place,
            from: self.at,
            rate: travel / length,
            length,
            feed_rate: place.least.unwrap_or(0.0) / length,
            tip_rate: place.tip / length,
            bent: length,
            run_up: 0.0,
        };
        straight.run_up = self.run_up(&straight);
        self.at = place.q;
        match self.held.take() {
            None => {
                self.motion = Some(motion);
                self.planner.begin(motion);
                (self.nodes, self.s) = (0, 0.0);
                let q = [straight.from, straight.rate, AxisVector::zeros(), AxisVector::zeros()];
                self.last = None;
                self.node(q, &straight, (None, true))?;
                self.held = Some(straight);
            }
            Some(before) => self.corner(&before, straight)?,
        }
        self.planned(out);
        Ok(())
    }

    /// Ends the path; all places that are left are appended.
    pub(super) fn finish(mut self, out: &mut Vec<Timed>) -> Result<(), PostError> {
        self.end_piece(out)?;
        while let Some(step) = self.planner.next() {
            self.step(&step, out);
        }
        self.close_before([usize::MAX, 0], out);
        Ok(())
    }

    fn end_piece(&mut self, out: &mut Vec<Timed>) -> Result<(), PostError> {
        if let Some(last) = self.held.take() {
            self.inner(&last, last.length)?;
            let end = last.place.q;
            let q = [end, last.rate, AxisVector::zeros(), AxisVector::zeros()];
            self.node(q, &last, (Some(last.place), true))?;
            self.piece += 1;
        }
        self.motion = None;
        self.planned(out);
        Ok(())
    }

    /// The node between two straight stretches: the parabola through it and a place on either side, as far away as
    /// the path that is timed may leave them.
    fn corner(&mut self, before: &Straight, mut after: Straight) -> Result<(), PostError> {
        let change = after.rate - before.rate;
        let corner = Corner {
            q: before.place.q,
            rates: [before.rate, after.rate],
            length: before.length.max(after.length),
        };
        let reach = corner.reach(&self.kinematics, self.tolerance);
        let within = |length: f64| if reach >= length { length } else { reach.min(0.5 * length) };
        let [near, far] = [within(before.length), within(after.length)];
        let weight = 1.0 / (near + far);
        let rate = (before.rate * far + after.rate * near) * weight;
        let second = change * (2.0 * weight);
        let slower = |one: f64, other: f64| one > DIFFERENT * other;
        let brief = |bent: f64, length: f64| bent.min(0.5 * length).min(CHANGE);
        let end = if slower(after.feed_rate, before.feed_rate) {
            brief(near, before.length)
        } else {
            near
        };
        after.bent =
            if slower(before.feed_rate, after.feed_rate) { brief(far, after.length) } else { far };
        self.inner(before, end)?;
        let q = [before.place.q, rate, second, AxisVector::zeros()];
        let both = Straight {
            feed_rate: before.feed_rate.max(after.feed_rate),
            tip_rate: before.tip_rate.max(after.tip_rate),
            ..*before
        };
        self.node(q, &both, (Some(before.place), false))?;
        self.held = Some(after);
        Ok(())
    }

    /// Nodes where a stretch begins and ends to be straight; `end`: how far its end is bent.
    fn inner(&mut self, of: &Straight, end: f64) -> Result<(), PostError> {
        let start = self.s;
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
            self.node(q, of, (None, true))?;
        }
        self.s = start + of.length;
        Ok(())
    }

    /// Two rows nearer than this are one: less than the last digit of any word, and more than the rounding of the
    /// path parameter leaves \[mm\].
    fn least_gap(&self) -> f64 {
        LEAST + 16.0 * f64::EPSILON * self.s
    }

    /// `v² / 2a` along a stretch, by the programmed speed and the limits of the axes.
    fn run_up(&self, of: &Straight) -> f64 {
        let slowest = |limits: &AxisVector| of.rate.abs().component_div(limits).amax();
        let rate = slowest(&self.limits[0]).max(of.feed_rate);
        // Not so short that rounding shows; nothing is gained either.
        (0.5 * slowest(&self.limits[1]) / (rate * rate)).max(SHORTEST * of.length)
    }

    /// A node in a stretch, or at its end; `slow`: the path is passed slowly there, and speed changes beside it.
    fn node(
        &mut self,
        q: [AxisVector; 4],
        of: &Straight,
        (place, slow): (Option<Place>, bool),
    ) -> Result<(), PostError> {
        let node = AxisNode { s: self.s, q, tip_rate: of.tip_rate, feed_rate: of.feed_rate };
        if let Some((last, was_slow)) = self.last.replace((node, slow)) {
            let length = node.s - last.s;
            let run_up = of.run_up;
            let quintic = Quintic::new(length, jet(&last.q), jet(&node.q));
            let inside = [run_up, length - run_up];
            let fits = run_up < 0.45 * length && run_up > self.least_gap();
            let wanted = [was_slow && fits, slow && fits];
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
        self.send(node, place)
    }

    fn send(&mut self, node: AxisNode, ends: Option<Place>) -> Result<(), PostError> {
        self.planner.push(node)?;
        if self.nodes > 0 {
            let interval = self.nodes - 1;
            self.closing.push_back(Closing { piece: self.piece, interval, ends });
        }
        self.nodes += 1;
        Ok(())
    }

    fn planned(&mut self, out: &mut Vec<Timed>) {
        while !self.planner.wants() {
            let Some(step) = self.planner.next() else { break };
            self.step(&step, out);
        }
    }

    fn step(&mut self, step: &StreamStep, out: &mut Vec<Timed>) {
        self.close_before([step.piece, step.interval], out);
        self.seconds += step.duration;
    }

    /// Ends the intervals before one.
    fn close_before(&mut self, next: [usize; 2], out: &mut Vec<Timed>) {
        while let Some(front) = self.closing.front()
            && [front.piece, front.interval] < next
        {
            if let Some(place) = front.ends {
                let seconds = self.seconds.max(place.least.unwrap_or(0.0));
                out.push(Timed { place, seconds });
                self.seconds = 0.0;
            }
            self.closing.pop_front();
        }
    }
}

/// Value and two derivatives.
fn jet(q: &[AxisVector; 4]) -> [AxisVector; 3] {
    [q[0], q[1], q[2]]
}
