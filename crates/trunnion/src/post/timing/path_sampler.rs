//! Setpoints along the smooth path that times the points.

use crate::feed::{StepSampler, StreamStep};
use crate::types::{AxisNode, Setpoint};
use std::collections::VecDeque;

/// Two nodes that follow each other in a piece.
#[derive(Debug, Clone, Copy)]
struct NodeInterval {
    /// Piece, and interval in it.
    at: [usize; 2],
    ends: [AxisNode; 2],
}

/// Sampler of the steps of a planner, which keeps the nodes until their steps are planned.
#[derive(Debug)]
pub(crate) struct PathSampler {
    sampler: StepSampler,
    last: Option<AxisNode>,
    waiting: VecDeque<NodeInterval>,
    setpoints: Vec<Setpoint>,
}

impl PathSampler {
    /// Starts at time 0, with the period of the servo \[s\].
    pub(crate) fn new(period: f64) -> Self {
        Self {
            sampler: StepSampler::new(period),
            last: None,
            waiting: VecDeque::new(),
            setpoints: Vec::new(),
        }
    }

    /// Takes in a node of a piece, by its index.
    pub(super) fn node(&mut self, [piece, index]: [usize; 2], node: AxisNode) {
        let before = self.last.replace(node).filter(|_| index > 0);
        if let Some(before) = before {
            self.waiting.push_back(NodeInterval { at: [piece, index - 1], ends: [before, node] });
        }
    }

    /// Samples a step; the intervals before its own are done.
    pub(super) fn step(&mut self, step: &StreamStep) {
        let own = [step.piece, step.interval];
        while self.waiting.front().is_some_and(|interval| interval.at < own) {
            self.waiting.pop_front();
        }
        if let Some(interval) = self.waiting.front() {
            self.sampler.take(step, &interval.ends, &mut self.setpoints);
        }
    }

    /// Goes on along another path, from rest.
    pub(crate) fn restart(&mut self) {
        self.sampler.restart();
        (self.last, self.waiting) = (None, VecDeque::new());
    }

    /// Returns the setpoints since the last call.
    pub(crate) fn take(&mut self) -> Vec<Setpoint> {
        std::mem::take(&mut self.setpoints)
    }

    /// Returns the remaining setpoints with the one at the end.
    pub(crate) fn finish(mut self) -> Vec<Setpoint> {
        self.sampler.finish(&mut self.setpoints);
        self.setpoints
    }
}
