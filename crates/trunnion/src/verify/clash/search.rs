//! Least distance of a pair over a batch of moves: best-first search over boxes of positions.

use super::pair::{BodyPair, JointBox};
use super::spans::{MoveSpans, SpanNode};
use crate::types::AxisVector;
use crate::verify::error::VerifyError;
use crate::verify::swept::triangles::{GapGoal, SweptGap};
use nalgebra::Point3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Approach of a pair on one line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairApproach {
    pub(crate) line: u32,
    /// Index of the first of its moves.
    pub(crate) first: usize,
    /// Lower bound of the distance \[mm\], within the tolerance.
    pub(crate) distance: f64,
    /// Point between the bodies, in the frame of the first.
    pub(crate) point: Point3<f64>,
    /// Positions of the axes.
    pub(crate) axes: AxisVector,
}

/// Distances that a search is after.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairGoal {
    /// Every line below this is reported \[mm\].
    pub(crate) reported: f64,
    /// Least distance found so far \[mm\].
    pub(crate) least: f64,
    /// Accuracy \[mm\].
    pub(crate) tolerance: f64,
}

impl PairGoal {
    /// Returns the accuracy of a distance \[mm\]: of one that is not reported, a share of it.
    fn accuracy(&self, distance: f64) -> f64 {
        self.tolerance.max(SHARE * (distance - self.reported))
    }
}

/// Part of the motion with a lower bound on its distance.
struct OpenSpan {
    low: f64,
    /// Distance in the middle of the part that this one is of: of equal bounds the nearest is looked at first.
    near: f64,
    node: SpanNode,
    /// Triangles that were nearest in the part that this one is of.
    hint: Option<[u32; 2]>,
}

impl PartialEq for OpenSpan {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for OpenSpan {}

impl PartialOrd for OpenSpan {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for OpenSpan {
    /// Orders by distance, so that a heap returns the nearest first; of equal ones the one that is earlier in the program.
    fn cmp(&self, other: &Self) -> Ordering {
        other
            .low
            .total_cmp(&self.low)
            .then(other.near.total_cmp(&self.near))
            .then_with(|| place(&other.node).total_cmp(&place(&self.node)))
    }
}

fn place(node: &SpanNode) -> f64 {
    match node {
        SpanNode::Moves { first, .. } => *first as f64,
        SpanNode::Part { index, time } => *index as f64 + time[0],
    }
}

/// Accuracy of distances beyond those that are reported, as a share of what they are beyond.
pub(crate) const SHARE: f64 = 0.01;

/// Share of the accuracy by which a distance between meshes may be too large, where that saves work.
const SLACK: f64 = 0.1;

/// Shortest part of a move, as a share: beyond, a bound that does not shrink is taken as it is.
const SHORTEST: f64 = 1e-9;

/// Finds the least distance below the goal's, and all lines below the reported distance.
pub(crate) fn nearest(
    pair: &BodyPair<'_>,
    spans: &MoveSpans<'_>,
    goal: PairGoal,
) -> Result<Vec<PairApproach>, VerifyError> {
    let mut found = Vec::new();
    let mut least = goal.least;
    let mut open = BinaryHeap::new();
    if let Some(node) = spans.root() {
        let low = pair.between_axis_planes(&spans.area(&node)?);
        open.push(OpenSpan { low, near: low, node, hint: None });
    }
    while let Some(OpenSpan { low, near, node, hint }) = open.pop() {
        // From here on nothing is nearer than the least distance, and nothing is to be reported.
        let most = goal.reported.max(least);
        if low >= most {
            break;
        }
        let area = spans.area(&node)?;
        // As accurate as the distance near by asks for: the least one so far may be far above it.
        let sharp = goal.accuracy(near.min(most));
        let wanted = GapGoal { hint, sharp, ..GapGoal::below(most, SLACK * sharp) };
        let Some(SweptGap { gap, low: bound }) = pair.swept(&area, wanted) else { continue };
        // Where the triangles cross, the depth is not known: it counts as touching.
        let bound = if gap.distance > 0.0 {
            bound.unwrap_or(f64::NEG_INFINITY).max(pair.between_planes(&area, &gap))
        } else {
            -pair.spread(&area).max(goal.tolerance)
        };
        let low = low.max(bound);
        let short = matches!(node, SpanNode::Part { time, .. } if time[1] - time[0] < SHORTEST);
        let sharp = gap.distance - low <= goal.accuracy(gap.distance) || short;
        // Of many lines that are reported each has its own distance.
        if sharp && (low >= goal.reported || spans.is_one_line(&node)) {
            found.push(PairApproach {
                line: spans.line(&node),
                first: MoveSpans::first(&node),
                distance: low,
                point: gap.middle(),
                axes: area.middle,
            });
            least = least.min(low);
            continue;
        }
        let (near, hint) = (gap.distance, Some(gap.triangles));
        open.extend(node.halves().map(|node| OpenSpan { low, near, node, hint }));
    }
    Ok(found)
}

/// Most joints between bodies of which all positions in a box are looked at.
const FEW_JOINTS: usize = 2;

/// Most boxes of positions that are looked at.
const MOST_BOXES: usize = 4000;

/// Proves that a pair with few joints between it stays off each other wherever its axes are in the box around a batch.
///
/// A table that turns to and fro passes the same positions again and again: they are looked at once. `false` says nothing.
pub(crate) fn is_clear(
    pair: &BodyPair<'_>,
    spans: &MoveSpans<'_>,
    goal: PairGoal,
) -> Result<bool, VerifyError> {
    let Some(root) = spans.root().filter(|_| pair.axes().count() <= FEW_JOINTS) else {
        return Ok(false);
    };
    let most = goal.reported.max(goal.least);
    let sharp = goal.accuracy(most);
    let mut open: Vec<(JointBox, Option<[u32; 2]>)> = vec![(spans.area(&root)?, None)];
    for _ in 0..MOST_BOXES {
        let Some((area, hint)) = open.pop() else { return Ok(true) };
        let wanted = GapGoal { hint, sharp, ..GapGoal::below(most, SLACK * sharp) };
        let Some(SweptGap { gap, low }) = pair.swept(&area, wanted) else { continue };
        if gap.distance < most || low.is_some() {
            return Ok(false);
        }
        if pair.between_planes(&area, &gap) < most {
            open.extend(pair.halves(&area).map(|half| (half, Some(gap.triangles))));
        }
    }
    Ok(false)
}
