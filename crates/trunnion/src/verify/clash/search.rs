//! Least distance of a pair over a batch of moves: best-first search over boxes of positions.

use super::pair::BodyPair;
use super::spans::{MoveSpans, SpanNode};
use crate::verify::error::VerifyError;
use nalgebra::Point3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Approach of a pair on one line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairApproach {
    pub(crate) line: u32,
    /// Lower bound of the distance \[mm\], within the tolerance.
    pub(crate) distance: f64,
    /// Point between the bodies, in the frame of the first.
    pub(crate) point: Point3<f64>,
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
    node: SpanNode,
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

/// Share of the tolerance by which a distance between meshes may be too large, where that saves work.
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
    open.extend(spans.root().map(|node| OpenSpan { low: f64::NEG_INFINITY, node }));
    while let Some(OpenSpan { low, node }) = open.pop() {
        // From here on nothing improves the least distance, and nothing is to be reported.
        let most = goal.reported.max(least - goal.accuracy(least));
        if low >= most {
            break;
        }
        let area = spans.area(&node)?;
        let spread = pair.spread(&area);
        let slack = SLACK * goal.tolerance;
        let Some(gap) = pair.gap(&area.middle, [most + spread, slack]) else { continue };
        // Where the triangles cross, the depth is not known: it counts as touching.
        let low = if gap.distance > 0.0 {
            let planes = pair.between_planes(&area, &gap);
            (gap.distance - slack - spread).max(planes)
        } else {
            -spread.max(goal.tolerance)
        };
        let short = matches!(node, SpanNode::Part { time, .. } if time[1] - time[0] < SHORTEST);
        let sharp = gap.distance - low <= goal.accuracy(gap.distance) || short;
        // Of many lines that are reported each has its own distance.
        if sharp && (low >= goal.reported || spans.is_one_line(&node)) {
            found.push(PairApproach {
                line: spans.line(&node),
                distance: low,
                point: gap.middle(),
            });
            least = least.min(low);
            continue;
        }
        open.extend(node.halves().map(|node| OpenSpan { low, node }));
    }
    Ok(found)
}
