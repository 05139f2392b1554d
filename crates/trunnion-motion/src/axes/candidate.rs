//! Branches of the inverse followed over a segment, before the ends of travel are checked.

use super::error::AxesError;
use super::follower::AxisTrack;
use super::options::AxesOptions;
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::types::{AxisVector, Motion};

/// Candidate motion along a shape: a branch, followed by continuity.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CandidateRun {
    /// Index of the tool-path piece it starts with.
    pub(super) piece: usize,
    /// Its curves in order; none for a point.
    pub(super) runs: Vec<CurveRun>,
    /// Axes at a point.
    pub(super) point_axes: Option<AxisVector>,
    /// Rotaries at both ends \[rad\].
    pub(super) start: [f64; 2],
    pub(super) end: [f64; 2],
}

/// One curve, followed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CurveRun {
    /// Index of the tool-path piece.
    pub(super) piece: usize,
    pub(super) motion: Motion,
    pub(super) track: AxisTrack,
    /// `true` if the rotaries jump before it, which takes a retract.
    pub(super) jumps: bool,
}

impl CandidateRun {
    /// Appends a curve. `near` holds the axes at its start, and afterwards those at its end.
    pub(super) fn extend(
        &mut self,
        mut run: CurveRun,
        near: &mut AxisVector,
        options: &AxesOptions,
    ) -> Result<(), AxesError> {
        let (Some(first), Some(last)) = (run.track.nodes.first(), run.track.nodes.last()) else {
            return Ok(());
        };
        let [from, to] = [first, last].map(|node| rotaries(&node.q[0]));
        *near = last.q[0];
        if self.runs.is_empty() {
            (self.piece, self.start, self.end) = (run.piece, from, from);
        }
        // Curves meet in one pose: the rotaries can differ there only in the singular direction.
        let turn = (from[0] - self.end[0]).abs().max((from[1] - self.end[1]).abs());
        run.jumps = turn > options.tolerance.axis;
        if run.jumps && options.retract.is_none() {
            let piece = run.piece;
            return Err(AxesError::TurnAtRest { piece, before: piece.saturating_sub(1), turn });
        }
        self.end = to;
        self.runs.push(run);
        Ok(())
    }
}

/// Returns the rotaries of an axis position \[rad\].
pub(super) fn rotaries(q: &AxisVector) -> [f64; 2] {
    [q[FIRST_ROTARY], q[SECOND_ROTARY]]
}
