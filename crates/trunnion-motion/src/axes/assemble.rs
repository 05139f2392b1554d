//! The axis path of a branch plan.

use super::branch_plan::{BranchPlan, RunEntry};
use super::branch_run::PathSegment;
use super::result::{FollowedPath, PathDeviation, RetractMove};
use super::segments::LinkMove;
use crate::machine::RotaryPair;
use crate::types::{AxisPath, AxisPiece};

/// Puts segments, links and retracts together in order.
pub(super) fn assemble(
    chosen: BranchPlan,
    links: &[LinkMove],
    mut segments: Vec<PathSegment>,
) -> FollowedPath {
    let mut pieces: Vec<AxisPiece> = Vec::new();
    let mut deviation = PathDeviation::default();
    let mut retracts = Vec::new();
    for part in chosen.parts {
        match part.entry {
            RunEntry::Start => {}
            RunEntry::Link(track) => {
                deviation = deviation.max(track.deviation);
                let link = part.segment.checked_sub(1).and_then(|link| links.get(link));
                // A link that moves nothing gives no piece.
                if let (Some(link), Some(nodes)) = (link, track.into_nodes()) {
                    pieces.push(AxisPiece { motion: link.motion, source: link.piece, nodes });
                }
            }
            RunEntry::Retract { switch, pose, rotaries, legs } => {
                let source = switch.piece;
                let first = pieces.len();
                for (motion, track) in legs {
                    deviation = deviation.max(track.deviation);
                    pieces.push(AxisPiece { motion, source, nodes: track.nodes });
                }
                let (u, in_cut, pieces) = (switch.u, switch.inside, first..pieces.len());
                let [before, after] = rotaries.map(RotaryPair::from);
                retracts.push(RetractMove { source, u, in_cut, pose, before, after, pieces });
            }
        }
        let segment = segments.get_mut(part.segment);
        if let Some(branch) = segment.and_then(|of| of.branches.get_mut(part.branch)) {
            deviation = branch.runs().fold(deviation, |all, run| all.max(run.track.deviation));
            pieces.extend(branch.pieces(part.cells, part.offset));
        }
    }
    let (path, passages) = (AxisPath { pieces }, Vec::new());
    FollowedPath { path, deviation, rotary_travel: chosen.cost, retracts, passages }
}
