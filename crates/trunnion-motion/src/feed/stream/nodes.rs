//! The nodes a stream knows: those of the plan that is run, and those after it.

use crate::types::{AxisNode, AxisPiece, Motion};
use std::collections::{VecDeque, vec_deque};
use std::iter::Peekable;

/// A node, where it belongs, and how its piece is run.
#[derive(Debug, Clone)]
pub(super) struct NodeEntry<const N: usize> {
    pub(super) piece: usize,
    /// Of the node in its piece; of the one after it for a place between nodes.
    pub(super) index: usize,
    pub(super) motion: Motion,
    pub(super) node: AxisNode<N>,
}

/// Nodes around and ahead of the end of the committed schedule.
#[derive(Debug, Clone)]
pub(super) struct NodeQueue<const N: usize> {
    /// Start of the interval that is run.
    from: Option<NodeEntry<N>>,
    /// Ends of the intervals of the plan that are not run yet.
    planned: VecDeque<NodeEntry<N>>,
    /// Nodes that are not planned yet; the first is where the plan ends.
    queue: VecDeque<NodeEntry<N>>,
}

impl<const N: usize> NodeQueue<N> {
    pub(super) fn new() -> Self {
        Self { from: None, planned: VecDeque::new(), queue: VecDeque::new() }
    }

    pub(super) fn push(&mut self, entry: NodeEntry<N>) {
        self.queue.push_back(entry);
    }

    /// Returns the number of intervals ahead.
    pub(super) fn ahead(&self) -> usize {
        self.planned.len() + self.waiting()
    }

    /// Returns the number of intervals that are not planned.
    pub(super) fn waiting(&self) -> usize {
        self.queue.len().saturating_sub(1)
    }

    /// Returns `true` if all that was planned was run.
    pub(super) fn is_run(&self) -> bool {
        self.planned.is_empty()
    }

    /// Returns the piece of the first node that is not run.
    pub(super) fn piece(&self) -> Option<usize> {
        self.queue.front().map(|entry| entry.piece)
    }

    /// Returns the kind of motion of the planned path.
    pub(super) fn planned_motion(&self) -> Option<Motion> {
        self.planned.front().map(|entry| entry.motion)
    }

    /// Returns the number of nodes at the front of the queue that belong to one piece.
    pub(super) fn of_a_piece(&self) -> usize {
        let first = self.piece();
        self.queue.iter().take_while(|entry| Some(entry.piece) == first).count()
    }

    /// Returns `true` if another piece has begun after that of the first node in the queue.
    pub(super) fn has_another_piece(&self) -> bool {
        self.of_a_piece() < self.queue.len()
    }

    /// Drops nodes that nothing follows in their piece.
    pub(super) fn drop_ends(&mut self) {
        while self.of_a_piece() == 1 && self.queue.len() > 1 {
            self.queue.pop_front();
        }
    }

    /// Takes the nodes known of a piece but the last `kept`; the last one taken stays, as the first of what
    /// follows.
    pub(super) fn take(&mut self, kept: usize) -> Option<AxisPiece<N>> {
        let count = self.of_a_piece();
        let count = if count >= 2 + kept { count - kept } else { count };
        let first = self.queue.front()?;
        // Without a plan the first node taken is where the motion starts.
        if self.planned.is_empty() {
            self.from = Some(first.clone());
        }
        let motion = first.motion;
        let nodes = self.queue.iter().take(count).map(|entry| entry.node).collect();
        self.planned.extend(self.queue.iter().take(count).skip(1).cloned());
        self.queue.drain(..count - 1);
        Some(AxisPiece { motion, source: 0, nodes })
    }

    /// Returns the interval between nodes in which the schedule runs, and notes that it was run up
    /// to `s`.
    pub(super) fn run_to(&mut self, s: f64) -> Option<usize> {
        let end = self.planned.front()?;
        // Entries have the index of the node at the end of their interval.
        let interval = end.index - 1;
        if s >= end.node.s {
            self.from = self.planned.pop_front();
        }
        Some(interval)
    }

    /// Finds the intervals of the plan in order.
    pub(super) fn intervals(&self) -> PlannedIntervals<'_, N> {
        PlannedIntervals { rest: self.planned.iter().peekable() }
    }

    /// Returns the planned path from `s` on, which lies in the interval that is run.
    pub(super) fn planned_from(&self, s: f64) -> Option<AxisPiece<N>> {
        let here = between(self.from.as_ref()?, self.planned.front()?, s)?;
        let mut nodes = vec![here.node];
        nodes.extend(self.planned.iter().map(|entry| entry.node));
        Some(AxisPiece { motion: here.motion, source: 0, nodes })
    }

    /// Ends the plan at `s`: what comes after is not planned any more.
    pub(super) fn end_at(&mut self, s: f64) {
        // The node at the end of the plan is in both lists.
        let mut after = self.planned.pop_back();
        while let Some(last) = self.planned.back() {
            if last.node.s < s {
                break;
            }
            if let Some(entry) = after {
                self.give_back(entry);
            }
            after = self.planned.pop_back();
        }
        // `after` is the first node at or beyond s, and the interval before it holds s.
        let Some(after) = after else { return };
        let before = self.planned.back().or(self.from.as_ref());
        let Some(end) = before.and_then(|before| between(before, &after, s)) else { return };
        self.give_back(after);
        let starts = self.from.as_ref().is_some_and(|from| s <= from.node.s);
        if self.queue.front().is_none_or(|first| first.node.s > s) {
            self.queue.push_front(end.clone());
        }
        if !starts {
            self.planned.push_back(end);
        }
    }

    /// Puts a node in front of the queue, unless it is there already.
    fn give_back(&mut self, entry: NodeEntry<N>) {
        let stands =
            |first: &NodeEntry<N>| first.piece == entry.piece && first.node.s <= entry.node.s;
        if !self.queue.front().is_some_and(stands) {
            self.queue.push_front(entry);
        }
    }
}

/// Intervals of the plan that are not run, in order.
#[derive(Debug)]
pub(super) struct PlannedIntervals<'a, const N: usize> {
    rest: Peekable<vec_deque::Iter<'a, NodeEntry<N>>>,
}

impl<const N: usize> PlannedIntervals<'_, N> {
    /// Returns the interval in which a cell ends at `s`; cells are asked for in order.
    pub(super) fn of(&mut self, s: f64) -> Option<usize> {
        while self.rest.next_if(|end| end.node.s < s).is_some() {}
        // Entries have the index of the node at the end of their interval.
        self.rest.peek().map(|end| end.index - 1)
    }
}

/// Returns the point `s` between two nodes as a node: both halves of the quintic are the quintic.
fn between<const N: usize>(from: &NodeEntry<N>, to: &NodeEntry<N>, s: f64) -> Option<NodeEntry<N>> {
    if s <= from.node.s {
        return Some(from.clone());
    }
    if s >= to.node.s {
        return Some(to.clone());
    }
    // Feed and tip rates are linear between nodes.
    let piece = AxisPiece { motion: to.motion, source: 0, nodes: vec![from.node, to.node] };
    let share = (s - from.node.s) / (to.node.s - from.node.s);
    let mean = |from: f64, to: f64| from + share * (to - from);
    let node = AxisNode {
        s,
        q: piece.axes_at(s)?,
        tip_rate: mean(from.node.tip_rate, to.node.tip_rate),
        feed_rate: mean(from.node.feed_rate, to.node.feed_rate),
    };
    Some(NodeEntry { node, ..to.clone() })
}
