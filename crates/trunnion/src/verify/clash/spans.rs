//! Moves as boxes of axis positions, in a tree.

use super::pair::JointBox;
use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use crate::verify::replay::controls::Controls;
use crate::verify::replay::segment::{Course, Segment};

/// Box of axis positions by its ends.
#[derive(Debug, Clone, Copy)]
struct JointHull {
    low: AxisVector,
    high: AxisVector,
}

impl JointHull {
    fn around(ends: &[AxisVector; 2], bow: &AxisVector) -> Self {
        let [a, b] = ends;
        Self { low: a.inf(b) - bow, high: a.sup(b) + bow }
    }

    fn join(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn joint_box(&self) -> JointBox {
        JointBox { middle: (self.low + self.high) * 0.5, half: (self.high - self.low) * 0.5 }
    }
}

/// Part of a batch of moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum SpanNode {
    /// Moves from a first one on, with the node of the tree.
    Moves { node: usize, first: usize, count: usize },
    /// Interval of the time of one move, within 0..=1.
    Part { index: usize, time: [f64; 2] },
}

impl SpanNode {
    /// Divides a part in two.
    pub(crate) fn halves(&self) -> [Self; 2] {
        match *self {
            Self::Moves { first, count: 1, .. } => {
                [[0.0, 0.5], [0.5, 1.0]].map(|time| Self::Part { index: first, time })
            }
            Self::Moves { node, first, count } => {
                let half = count / 2;
                [
                    Self::Moves { node: node + 1, first, count: half },
                    Self::Moves { node: node + 2 * half, first: first + half, count: count - half },
                ]
            }
            Self::Part { index, time: [from, to] } => {
                let middle = 0.5 * (from + to);
                [[from, middle], [middle, to]].map(|time| Self::Part { index, time })
            }
        }
    }
}

/// Batch of moves with one tool, as a tree of boxes.
pub(crate) struct MoveSpans<'a> {
    controls: &'a Controls,
    segments: Vec<Segment>,
    /// Hulls of both halves follow their own: with `n` moves in the first half, it is at the next place, and the second
    /// one `2 n` places on.
    tree: Vec<JointHull>,
}

impl<'a> MoveSpans<'a> {
    /// Builds the tree of moves whose positions are known.
    pub(crate) fn new(controls: &'a Controls, segments: Vec<Segment>) -> Self {
        let mut spans = Self { controls, segments, tree: Vec::new() };
        if !spans.segments.is_empty() {
            spans.build(0, spans.segments.len());
        }
        spans
    }

    fn build(&mut self, first: usize, count: usize) -> Option<JointHull> {
        let at = self.tree.len();
        if count == 1 {
            let segment = self.segments.get(first)?;
            let hull = JointHull::around(&segment.joints, &self.bow(segment, 1.0));
            self.tree.push(hull);
            return Some(hull);
        }
        let half = count / 2;
        // Entered before its children, and mended after them.
        let start = self.segments.get(first)?.joints;
        self.tree.push(JointHull::around(&start, &AxisVector::zeros()));
        let low = self.build(first, half)?;
        let high = self.build(first + half, count - half)?;
        let hull = low.join(&high);
        if let Some(entered) = self.tree.get_mut(at) {
            *entered = hull;
        }
        Some(hull)
    }

    /// Bounds how far the axes leave the straight line between both ends of a part of a move, `share` of its duration.
    ///
    /// With the tip straight and the rotaries linear in time, a linear axis has a second derivative of at most
    /// `a^2 r + 2 a v`: `a` the sum of both turns, `r` the distance of the tip from what turns it, `v` the travel. It leaves
    /// its chord by an eighth of that, which falls with the square of the duration.
    ///
    /// On a great circle between tool vectors the bound is a heuristic. Of orthogonal rotary axes one turns monotonously, and
    /// the other leaves its ends by at most half of the arc, which is no longer than both turns: that holds. Axes that are not
    /// orthogonal, and linear axes near a singular direction, where a rotary axis runs ahead, may leave more.
    fn bow(&self, segment: &Segment, share: f64) -> AxisVector {
        if matches!(segment.course, Course::Joints | Course::Rest) {
            return AxisVector::zeros();
        }
        let change = segment.joints[1] - segment.joints[0];
        let turn = change[3].abs() + change[4].abs();
        let travel = change.fixed_rows::<3>(0).norm();
        let lever = self.controls.of(segment.tool).lever(segment) + travel;
        let linear = (turn * turn * lever + 2.0 * turn * (travel + turn * lever)) / 8.0;
        let linear = linear * share.powi(2);
        let is_circle = matches!(segment.course, Course::Circle { .. });
        let rotary = if is_circle { 0.5 * turn * share } else { 0.0 };
        AxisVector::from([linear, linear, linear, rotary, rotary])
    }

    /// Returns positions at the ends of moves, spread over all of them.
    pub(crate) fn samples(&self, most: usize) -> impl Iterator<Item = &AxisVector> {
        let step = self.segments.len().div_ceil(most.max(1)).max(1);
        let ends = self.segments.iter().step_by(step).map(|segment| &segment.joints[0]);
        ends.chain(self.segments.last().map(|segment| &segment.joints[1]))
    }

    pub(crate) fn root(&self) -> Option<SpanNode> {
        let count = self.segments.len();
        (count > 0).then_some(SpanNode::Moves { node: 0, first: 0, count })
    }

    /// Returns the line of the program at which a part begins.
    pub(crate) fn line(&self, node: &SpanNode) -> u32 {
        self.segments.get(Self::first(node)).map_or(0, |segment| segment.line)
    }

    /// Returns the index of the first move of a part.
    pub(crate) fn first(node: &SpanNode) -> usize {
        match *node {
            SpanNode::Moves { first, .. } => first,
            SpanNode::Part { index, .. } => index,
        }
    }

    /// Returns the number of lines of a part, or a little more.
    pub(crate) fn is_one_line(&self, node: &SpanNode) -> bool {
        match *node {
            SpanNode::Moves { first, count, .. } => {
                let line = |index: usize| self.segments.get(index).map(|segment| segment.line);
                line(first) == line(first + count - 1)
            }
            SpanNode::Part { .. } => true,
        }
    }

    /// Returns the box of the positions in a part.
    pub(crate) fn area(&self, node: &SpanNode) -> Result<JointBox, VerifyError> {
        match *node {
            SpanNode::Moves { node, .. } => {
                let hull = self.tree.get(node).map(JointHull::joint_box);
                hull.ok_or(VerifyError::NoMotion)
            }
            SpanNode::Part { index, time: [from, to] } => {
                let segment = self.segments.get(index).ok_or(VerifyError::NoMotion)?;
                let control = self.controls.of(segment.tool);
                let ends = [control.joints(segment, from)?, control.joints(segment, to)?];
                let bow = self.bow(segment, to - from);
                Ok(JointHull::around(&ends, &bow).joint_box())
            }
        }
    }
}
