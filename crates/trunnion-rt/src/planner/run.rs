//! One run from rest to rest: blocks in, steps of its schedule out.

use super::block::{BlockEnding, BlockKind, BlockStart, MotionBlock};
use super::joints::{WordJoints, WordsFault};
use super::leg::{Leg, LetterVector};
use super::pace::Pace;
use super::piece::MotionPiece;
use super::pieces;
use super::rounded_path::{CornerTolerance, PathNode, RoundedPath};
use super::shared::PlanLimit;
use std::collections::VecDeque;
use trunnion::feed::{FeedError, JerkStream, Limits, ProgrammedSpeeds, StreamOptions, StreamStep};
use trunnion::math::quintic::Quintic;
use trunnion::types::{AXES, AxisNode, AxisVector, Motion};

/// Nodes that the plan looks ahead.
const WINDOW: usize = 256;

/// Nodes with which a run begins, if more are still to come.
const ENOUGH: usize = 96;

/// Deviation of the tip where a path is to be exact \[mm\]: where it goes on in the same direction, and arcs begin.
const EXACT: f64 = 0.001;

/// Change of direction that an exact path goes through without a stop.
const SAME_DIRECTION: f64 = 1e-4;

/// Share of a limit from which it counts as what limits the speed.
const BINDS: f64 = 0.9;

/// Distance between places where a block is checked \[mm\], and the most places.
const CHECK_STEP: f64 = 2.0;
const MOST_CHECKS: u32 = 500;

/// A node of the path, with joints.
#[derive(Debug, Clone, Copy)]
struct RunNode {
    path: PathNode,
    axes: AxisNode,
}

/// A run that is under way.
#[derive(Debug, Clone)]
pub(super) struct Run {
    path: RoundedPath,
    joints: WordJoints,
    limits: Limits<AXES>,
    stream: JerkStream,
    /// Nodes from the last committed step on.
    nodes: VecDeque<RunNode>,
    /// Largest deviation of the rotaries at corners \[rad\].
    axis_tolerance: f64,
    /// Ending of the last block, and the tolerance there.
    ending: BlockEnding,
    tolerance: CornerTolerance,
}

impl Run {
    /// Begins a run with the kinematics of its blocks.
    pub(super) fn new(
        joints: WordJoints,
        limits: &Limits<AXES>,
        axis_tolerance: f64,
    ) -> Result<Self, FeedError> {
        let stream = stream(limits)?;
        let tolerance = CornerTolerance { tip: EXACT, axis: axis_tolerance };
        Ok(Self {
            path: RoundedPath::default(),
            joints,
            limits: *limits,
            stream,
            nodes: VecDeque::new(),
            axis_tolerance,
            ending: BlockEnding::Blend,
            tolerance,
        })
    }

    pub(super) fn stream(&mut self) -> &mut JerkStream {
        &mut self.stream
    }

    pub(super) fn path(&self) -> &RoundedPath {
        &self.path
    }

    /// Ends the run where its last block ends.
    pub(super) fn end(&mut self) {
        self.path.end();
    }

    /// Takes a block; returns false where the run has to end before it.
    pub(super) fn take(&mut self, block: &MotionBlock) -> Result<bool, WordsFault> {
        let suits = self.joints.suits(block.mode, block.tool_length);
        let begins = self.path.direction().is_none();
        if self.path.is_ended() || !suits || (!begins && block.begins == BlockStart::Rest) {
            return Ok(false);
        }
        let tolerance = self.corner_tolerance(block);
        let leg = Leg::of(block);
        if let (false, Some(leg)) = (begins, &leg)
            && !self.goes_on(leg)
        {
            return Ok(false);
        }
        check(&self.joints, block, leg.as_ref())?;
        if let Some(mut leg) = leg {
            leg.pace = self.pace(&leg);
            self.path.push(&leg, self.tolerance);
            (self.ending, self.tolerance) = (block.ending, tolerance);
        }
        Ok(true)
    }

    /// True if the last block goes over into a leg without a stop.
    fn goes_on(&self, leg: &Leg) -> bool {
        match self.ending {
            BlockEnding::Stop => false,
            BlockEnding::Blend => true,
            BlockEnding::Exact => self
                .path
                .direction()
                .is_some_and(|direction| (leg.at(0.0)[1] - direction).amax() < SAME_DIRECTION),
        }
    }

    /// Returns the limits to a change of speed along a leg behind the last one, where one of the two has a time of its own.
    fn pace(&self, leg: &Leg) -> Pace {
        let is_timed = |leg: &Leg| leg.kind == BlockKind::Timed;
        if !(is_timed(leg) || self.path.last().is_some_and(is_timed)) {
            return Pace::FREE;
        }
        let rates = |leg: &Leg, at: f64| self.joints.jets(&leg.at(at)).map(|[_, rate, ..]| rate);
        let places = [0.0, 0.5 * leg.length, leg.length].map(|at| rates(leg, at));
        let [Ok(start), Ok(middle), Ok(end)] = places else { return Pace::FREE };
        let pace = Pace::of(&[start, middle, end], &self.limits);
        let Some(last) = self.path.last() else { return pace };
        let Ok(before) = rates(last, last.length) else { return pace };
        let turn = leg.at(0.0)[1] - last.at(last.length)[1];
        pace.with_corner(&turn, &(start - before), &self.tolerance, &self.limits)
    }

    /// Tolerance at the end of a block.
    fn corner_tolerance(&self, block: &MotionBlock) -> CornerTolerance {
        let blends = block.ending == BlockEnding::Blend;
        let tip = if blends { block.tolerance } else { EXACT };
        let end = LetterVector::from(block.end);
        if block.mode == crate::switched::KinematicsMode::ToolCenterPoint {
            return CornerTolerance { tip, axis: self.axis_tolerance };
        }
        // Plain axes: the rotaries move the tip as well, and half of the tolerance is theirs.
        let lever = self.joints.lever(&end);
        CornerTolerance { tip: 0.5 * tip, axis: self.axis_tolerance.min(0.5 * tip / lever) }
    }

    /// Hands nodes to the plan while it wants more. Returns true if it wants more and the path has none yet.
    pub(super) fn feed(&mut self) -> Result<bool, RunFault> {
        while self.stream.wants() {
            let Some(node) = self.path.next_node() else {
                let more = !self.path.is_finished();
                if !more {
                    self.stream.complete();
                }
                return Ok(more);
            };
            let q = self.joints.jets(&node.letters).map_err(|_| RunFault { block: node.block })?;
            let [feed_rate, tip_rate] = node.rates;
            let axes = AxisNode { s: node.s, q, tip_rate, feed_rate };
            self.stream.push(axes).map_err(|_| RunFault { block: node.block })?;
            self.nodes.push_back(RunNode { path: node, axes });
        }
        Ok(false)
    }

    /// True if enough of the path is known to begin with.
    pub(super) fn may_begin(&self) -> bool {
        self.nodes.len() >= ENOUGH
    }

    /// Appends the pieces of a step, at most `most` of them.
    pub(super) fn pieces(&self, step: &StreamStep, most: usize, out: &mut Vec<MotionPiece>) {
        let after = self.nodes.partition_point(|node| node.path.s <= step.s.low);
        let before = after.saturating_sub(1);
        if let (Some(from), Some(to)) = (self.nodes.get(before), self.nodes.get(before + 1)) {
            pieces::append(step, [&from.path, &to.path], most, out);
        }
    }

    /// Returns the limit that a step is nearest to, with overrides of feed and rapid moves.
    pub(super) fn binding(&self, step: &StreamStep, overrides: [f64; 2]) -> PlanLimit {
        let after = self.nodes.partition_point(|node| node.path.s <= step.s.low);
        let before = after.saturating_sub(1);
        let (Some(from), Some(to)) = (self.nodes.get(before), self.nodes.get(before + 1)) else {
            return PlanLimit::None;
        };
        let state = step.at(0.5 * step.duration);
        let middle = between(from, to, state.s);
        let [_, rate, bend, change] = middle.axes.q;
        let (v, a, j) = (state.speed, state.acceleration, state.jerk);
        let jerk = rate * j + bend * (3.0 * v * a) + change * v.powi(3);
        let orders = [
            (rate * v).component_div(&self.limits.velocity),
            (rate * a + bend * (v * v)).component_div(&self.limits.acceleration),
            self.limits.jerk.map_or_else(AxisVector::zeros, |limit| jerk.component_div(&limit)),
        ];
        let of_axis = |axis: usize| orders.map(|order| order[axis].abs());
        let axes = (0..AXES).flat_map(|axis| {
            let kinds = [PlanLimit::Velocity, PlanLimit::Acceleration, PlanLimit::Jerk];
            of_axis(axis).into_iter().zip(kinds).map(move |(share, kind)| (share, kind(axis)))
        });
        let [feed, rapid] = [from.path.rates[0] / overrides[0], from.path.rates[1] / overrides[1]];
        let speeds = [(feed * v, PlanLimit::Feed), (rapid * v, PlanLimit::Rapid)];
        let nearest = axes.chain(speeds).max_by(|one, other| one.0.total_cmp(&other.0));
        nearest.filter(|(share, _)| *share >= BINDS).map_or(PlanLimit::None, |(_, limit)| limit)
    }

    /// Returns the block where the committed plan ends.
    pub(super) fn block(&self) -> u32 {
        self.nodes.front().map_or(0, |node| node.path.block)
    }

    /// Forgets nodes before `s`, but the last of them.
    pub(super) fn forget(&mut self, s: f64) {
        while self.nodes.get(1).is_some_and(|next| next.path.s <= s) {
            self.nodes.pop_front();
        }
    }

    /// Plans anew from rest at `s`.
    pub(super) fn restart(&mut self, s: f64) -> Result<(), FeedError> {
        self.forget(s);
        self.stream = stream(&self.limits)?;
        let halfway = match (self.nodes.front(), self.nodes.get(1)) {
            (Some(from), Some(to)) if from.path.s < s => Some(between(from, to, s)),
            _ => None,
        };
        if let (Some(front), Some(node)) = (self.nodes.front_mut(), halfway) {
            *front = node;
        }
        for node in &self.nodes {
            self.stream.push(node.axes)?;
        }
        Ok(())
    }
}

/// Reason why a run cannot go on: the kinematics or the plan has no answer at this block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RunFault {
    pub(super) block: u32,
}

fn stream(limits: &Limits<AXES>) -> Result<JerkStream, FeedError> {
    // Nodes have seconds per length: the programmed speed is one.
    let speeds = ProgrammedSpeeds { feed: Some(1.0), link_feed: None, tip: Some(1.0) };
    let options = StreamOptions { speeds, ..StreamOptions::fastest(WINDOW, f64::MAX) };
    let mut stream = JerkStream::new(*limits, options)?;
    stream.begin(Motion::Cut);
    stream.go_on();
    Ok(stream)
}

/// Checks that the joints reach every place of a block.
fn check(joints: &WordJoints, block: &MotionBlock, leg: Option<&Leg>) -> Result<(), WordsFault> {
    joints.has_axes(&block.start.into(), &block.end.into())?;
    let Some(leg) = leg else { return Ok(()) };
    let count = (1..MOST_CHECKS).find(|&n| leg.length <= CHECK_STEP * f64::from(n));
    let count = count.unwrap_or(MOST_CHECKS);
    for k in 1..=count {
        let [at, ..] = leg.at(leg.length * f64::from(k) / f64::from(count));
        joints.at(&at)?;
    }
    Ok(())
}

/// The place `s` between two nodes.
fn between(from: &RunNode, to: &RunNode, s: f64) -> RunNode {
    let length = to.path.s - from.path.s;
    let jet = |node: &RunNode| [node.path.letters[0], node.path.letters[1], node.path.letters[2]];
    let letters = Quintic::new(length, jet(from), jet(to)).at(s - from.path.s);
    let jet = |node: &RunNode| [node.axes.q[0], node.axes.q[1], node.axes.q[2]];
    let q = Quintic::new(length, jet(from), jet(to)).at(s - from.path.s);
    RunNode { path: PathNode { s, letters, ..from.path }, axes: AxisNode { s, q, ..from.axes } }
}
