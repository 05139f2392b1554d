//! One run of a program from rest to rest: blocks in, steps of its schedule out.

use super::block::{BlockCoordinates, BlockEnding, BlockKind, BlockStart, MotionBlock};
use super::corner::{CornerTolerance, largest_speed};
use super::joints::{WordJoints, WordsFault};
use super::leg::{Leg, LetterVector};
use super::pace::Pace;
use super::plan_limit::{self, PlanLimit};
use super::rounded_path::{PathNode, RoundedPath};
use crate::feed::{FeedError, JerkStream, Limits, ProgrammedSpeeds, StreamOptions, StreamStep};
use crate::inverse::PoseRefusal;
use crate::machine::{Machine, TravelExcess};
use crate::math::quintic::Quintic;
use crate::types::{AXES, AxisNode, Motion};
use std::collections::VecDeque;

/// Nodes that the plan looks ahead.
const WINDOW: usize = 256;

/// Legs that wait for nodes, and their length \[mm\]: beyond both no further block is of use.
const MANY_LEGS: usize = 600;
const LONG_PATH: f64 = 20.0;

/// Shares of the limits that are planned with. Joints are planned on quintics between nodes and run by the kinematics, and
/// steps are no polynomials of time: both differ in the third derivative most.
const SHARES: [f64; 3] = [0.9995, 0.995, 0.97];

/// Returns the limits that a program is planned with on a machine: a little below those of its axes.
pub fn planned_limits(machine: &Machine) -> Limits<AXES> {
    let [v, a, j] = SHARES;
    Limits::symmetric(
        machine.vector(|axis| axis.vel) * v,
        machine.vector(|axis| axis.acc) * a,
        machine.vector(|axis| axis.jerk) * j,
    )
}

/// Nodes with which a run begins, if more are still to come.
const ENOUGH: usize = 96;

/// Deviation of the tip where a path is to be exact \[mm\]: where it goes on in the same direction, and arcs begin.
const EXACT: f64 = 0.001;

/// Change of direction that an exact path goes through without a stop.
const SAME_DIRECTION: f64 = 1e-4;

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
pub struct ProgramRun {
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

impl ProgramRun {
    /// Begins a run with the kinematics of its blocks. `axis_tolerance` is the largest deviation of the rotaries at corners
    /// \[rad\].
    ///
    /// # Errors
    ///
    /// [`FeedError`] for limits that no plan keeps.
    pub fn new(
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

    /// Returns the stream that plans it.
    pub fn stream(&mut self) -> &mut JerkStream {
        &mut self.stream
    }

    /// True if no further block is of use before some of those at hand are planned.
    pub fn is_full(&self) -> bool {
        self.path.waiting() > MANY_LEGS && self.path.ahead() > LONG_PATH
    }

    /// True if the nodes of all of the path are handed to the plan, down to its end.
    pub fn is_finished(&self) -> bool {
        self.path.is_finished()
    }

    /// Ends the run where its last block ends.
    pub fn end(&mut self) {
        self.path.end();
    }

    /// Takes a block; returns false where the run has to end before it.
    ///
    /// # Errors
    ///
    /// [`WordsFault`] if the joints cannot follow the block.
    pub fn take(&mut self, block: &MotionBlock) -> Result<bool, WordsFault> {
        let suits = self.joints.suits(block.coordinates, block.tool_length);
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
        let mut pace = Pace::of(&[start, middle, end], &self.limits);
        let Some(last) = self.path.last() else { return pace };
        let Ok(before) = rates(last, last.length) else { return pace };
        let turn = leg.at(0.0)[1] - last.at(last.length)[1];
        pace.enters = largest_speed(&turn, &(start - before), &self.tolerance, &self.limits);
        pace
    }

    /// Tolerance at the end of a block.
    fn corner_tolerance(&self, block: &MotionBlock) -> CornerTolerance {
        let blends = block.ending == BlockEnding::Blend;
        let tip = if blends { block.tolerance } else { EXACT };
        let end = LetterVector::from(block.end);
        if block.coordinates == BlockCoordinates::Tip {
            return CornerTolerance { tip, axis: self.axis_tolerance };
        }
        // Plain axes: the rotaries move the tip as well, and half of the tolerance is theirs.
        let lever = self.joints.lever(&end);
        CornerTolerance { tip: 0.5 * tip, axis: self.axis_tolerance.min(0.5 * tip / lever) }
    }

    /// Hands nodes to the plan while it wants more. Returns true if it wants more and the path has none yet.
    ///
    /// # Errors
    ///
    /// [`RunFault`] where the kinematics have no answer.
    pub fn feed(&mut self) -> Result<bool, RunFault> {
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
    pub fn may_begin(&self) -> bool {
        self.nodes.len() >= ENOUGH
    }

    /// Returns the nodes before and behind a step.
    fn around(&self, step: &StreamStep) -> Option<[&RunNode; 2]> {
        let after = self.nodes.partition_point(|node| node.path.s <= step.s.low);
        let before = after.saturating_sub(1);
        Some([self.nodes.get(before)?, self.nodes.get(before + 1)?])
    }

    /// Returns the nodes of the path between which a step is, unless it is forgotten.
    pub fn nodes_of(&self, step: &StreamStep) -> Option<[&PathNode; 2]> {
        self.around(step).map(|nodes| nodes.map(|node| &node.path))
    }

    /// Returns the limit that a step is nearest to, with overrides of feed and rapid moves.
    pub fn binding(&self, step: &StreamStep, overrides: [f64; 2]) -> PlanLimit {
        let Some([from, to]) = self.around(step) else { return PlanLimit::None };
        let state = step.at(0.5 * step.duration);
        let rates = from.path.rates;
        let programmed = [rates[0] / overrides[0], rates[1] / overrides[1]];
        plan_limit::nearest(&between(from, to, state.s).axes, &state, &self.limits, programmed)
    }

    /// Returns the block where the committed plan ends.
    pub fn block(&self) -> u32 {
        self.nodes.front().map_or(0, |node| node.path.block)
    }

    /// Forgets nodes before `s`, but the last of them.
    pub fn forget(&mut self, s: f64) {
        while self.nodes.get(1).is_some_and(|next| next.path.s <= s) {
            self.nodes.pop_front();
        }
    }

    /// Plans anew from rest at `s`.
    ///
    /// # Errors
    ///
    /// [`FeedError`].
    pub fn restart(&mut self, s: f64) -> Result<(), FeedError> {
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
#[non_exhaustive]
pub struct RunFault {
    /// Number of the block.
    pub block: u32,
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

/// Checks that the joints reach every place of a block; of places outside travel the farthest counts.
fn check(joints: &WordJoints, block: &MotionBlock, leg: Option<&Leg>) -> Result<(), WordsFault> {
    joints.has_axes(&block.start.into(), &block.end.into())?;
    let Some(leg) = leg else { return Ok(()) };
    let count = (1..MOST_CHECKS).find(|&n| leg.length <= CHECK_STEP * f64::from(n));
    let count = count.unwrap_or(MOST_CHECKS);
    let mut farthest: Option<TravelExcess> = None;
    for k in 1..=count {
        let [at, ..] = leg.at(leg.length * f64::from(k) / f64::from(count));
        match joints.at(&at) {
            Err(WordsFault::Refused(PoseRefusal::OutOfTravel(here))) => {
                let is_farther = farthest.is_none_or(|other| here.excess > other.excess);
                farthest = if is_farther { Some(here) } else { farthest };
            }
            other => drop(other?),
        }
    }
    farthest.map_or(Ok(()), |excess| Err(WordsFault::Refused(PoseRefusal::OutOfTravel(excess))))
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
