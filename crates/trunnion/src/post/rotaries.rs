//! Rotary solutions, chosen ahead so that a cut stays inside travel.
//!
//! Where no solution keeps a cut inside travel, the tool retracts and the rotaries unwind off the part.

use super::options::{PostMove, PostPace};
use crate::inverse::{Inverse, InverseSolutions};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::unwrap_near;
use crate::types::{AxisVector, ToolPose};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Look-ahead \[moves\].
const WINDOW: usize = 1 << 16;

/// Length of the return to the part that runs at the feed of the cut \[mm\].
const APPROACH: f64 = 1.0;

/// Most lines of retracts that are reported.
const MOST_REPORTED: usize = 1000;

/// Move with the axes chosen for its end.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlannedMove {
    pub(super) one: PostMove,
    /// Axes at its end; `None` takes the solution near the axes before.
    pub(super) axes: Option<AxisVector>,
    /// Phase of a retract; `None` for a move of the input.
    pub(super) phase: Option<RetractPhase>,
}

/// Phases of a retract.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RetractPhase {
    /// The tool leaves the part along its axis.
    Out,
    /// The tip stands still, the rotaries turn.
    Turn,
    /// The tool returns.
    Back,
}

/// Planner that holds moves back until the rotary solutions for a whole cut are known.
#[derive(Debug, Clone)]
pub(super) struct RotaryPlanner {
    /// `None`: moves are passed on unchanged.
    inverse: Option<Inverse>,
    /// Retract along the tool axis \[mm\]; `None` forbids retracts.
    unwind: Option<f64>,
    /// Rapid moves, followed by those of a cut.
    pending: VecDeque<PostMove>,
    /// Axes at the end of the planned moves.
    at: Option<AxisVector>,
    /// Lines of the input before which the tool retracts.
    pub(super) unwound: Vec<u32>,
}

impl RotaryPlanner {
    /// Creates a planner; `inverse` is that of the target, if its rotaries are chosen here.
    pub(super) fn new(inverse: Option<Inverse>, unwind: Option<f64>) -> Self {
        Self { inverse, unwind, pending: VecDeque::new(), at: None, unwound: Vec::new() }
    }

    /// Takes in a move, and appends the moves that are planned.
    pub(super) fn push(&mut self, one: &PostMove, out: &mut Vec<PlannedMove>) {
        if self.inverse.is_none() {
            return out.push(plain(*one));
        }
        let cutting = self.pending.back().is_some_and(|last| last.pace != PostPace::Rapid);
        // A cut ends where the next rapid move begins.
        let begins = one.pace == PostPace::Rapid && cutting;
        if begins || self.pending.len() >= WINDOW {
            self.finish(out);
        }
        self.pending.push_back(*one);
    }

    /// Plans all moves that are held back.
    pub(super) fn finish(&mut self, out: &mut Vec<PlannedMove>) {
        let moves: Vec<PostMove> = self.pending.drain(..).collect();
        let Some(inverse) = self.inverse.take() else { return };
        let planned = out.len();
        if self.plan(&inverse, &moves, out).is_none() {
            // A pose is out of reach: the subdivision reports which.
            out.truncate(planned);
            out.extend(moves.into_iter().map(plain));
        }
        self.inverse = Some(inverse);
    }

    /// Plans rapid moves and the cut behind them; `None` if a pose is out of reach.
    fn plan(
        &mut self,
        inverse: &Inverse,
        moves: &[PostMove],
        out: &mut Vec<PlannedMove>,
    ) -> Option<()> {
        let home = inverse.kinematics().machine().home();
        let rapid = |one: &&PostMove| one.pace == PostPace::Rapid;
        // Step 1: separate the rapid moves from the cut. The very first move sets the starting position.
        let least = usize::from(self.at.is_none());
        let rapids = moves.iter().take_while(rapid).count().max(least).min(moves.len());
        let (air, cut) = moves.split_at(rapids);
        // Step 2: follow the rapid moves; at the last, choose the solution that leads farthest along the cut.
        let mut near = self.at.unwrap_or(home);
        let mut reach = None;
        for (index, one) in air.iter().enumerate() {
            let last = index + 1 == air.len();
            let (q, followed) = if last && !cut.is_empty() {
                choose(inverse, &one.pose, &near, cut)?
            } else {
                (inverse.near_inside(&one.pose, &near).ok()?, 0)
            };
            reach = Some(followed);
            near = q;
            out.push(PlannedMove { axes: Some(q), ..plain(*one) });
        }
        // Step 3: plan the cut, with a retract wherever travel ends.
        let reach = reach.unwrap_or_else(|| follow(inverse, near, cut).0);
        self.at = Some(self.cut(inverse, near, CutAhead { moves: cut, reach }, out)?);
        Some(())
    }

    /// Plans a cut that starts at the axes `q`; returns the axes at its end.
    fn cut(
        &mut self,
        inverse: &Inverse,
        mut q: AxisVector,
        ahead: CutAhead<'_>,
        out: &mut Vec<PlannedMove>,
    ) -> Option<AxisVector> {
        let CutAhead { moves: mut rest, mut reach } = ahead;
        loop {
            // Follow the cut as far as travel allows.
            let (fits, left) = rest.split_at(reach.min(rest.len()));
            q = follow(inverse, q, fits).1;
            out.extend(fits.iter().map(|one| plain(*one)));
            let Some(next) = left.first() else { return Some(q) };
            // Beyond, only a retract helps: choose again the rotaries that lead farthest.
            let length = self.unwind?;
            let pose = inverse.kinematics().forward(&q);
            let (to, further) = choose(inverse, &pose, &q, left)?;
            // No solution leads on, so that a retract would not help either.
            if further == 0 {
                return None;
            }
            out.extend(retract(inverse, next, &pose, length, to)?);
            if self.unwound.len() < MOST_REPORTED {
                self.unwound.push(next.line);
            }
            (q, rest, reach) = (to, left, further);
        }
    }
}

/// Cut that is still to be planned.
#[derive(Clone, Copy)]
struct CutAhead<'a> {
    moves: &'a [PostMove],
    /// Number of moves that can be followed inside travel.
    reach: usize,
}

fn plain(one: PostMove) -> PlannedMove {
    PlannedMove { one, axes: None, phase: None }
}

/// Returns the moves of a retract: out along the tool axis, rotaries to `to`, and back to the same pose.
fn retract(
    inverse: &Inverse,
    next: &PostMove,
    pose: &ToolPose,
    length: f64,
    to: AxisVector,
) -> Option<[PlannedMove; 4]> {
    let up = |by: f64| ToolPose { tip: pose.tip + pose.axis.scale(by), ..*pose };
    let far = up(length);
    // The rotaries turn with the tip away from the part; the linear axes follow the tip.
    let turned = inverse.near_inside(&far, &to).ok()?;
    let rapid = |pose: ToolPose| PostMove { pose, q: None, pace: PostPace::Rapid, ..*next };
    let planned = |one: PostMove, axes, phase| PlannedMove { one, axes, phase: Some(phase) };
    Some([
        planned(rapid(far), None, RetractPhase::Out),
        planned(rapid(far), Some(turned), RetractPhase::Turn),
        planned(rapid(up(APPROACH.min(length))), None, RetractPhase::Back),
        planned(PostMove { pose: *pose, q: None, ..*next }, Some(to), RetractPhase::Back),
    ])
}

/// Returns the number of moves that can be followed inside travel, and the axes at their end.
fn follow(inverse: &Inverse, from: AxisVector, moves: &[PostMove]) -> (usize, AxisVector) {
    let machine = inverse.kinematics().machine();
    let mut q = from;
    for (count, one) in moves.iter().enumerate() {
        match inverse.near(&one.pose, &q) {
            Ok(next) if machine.out_of_travel(&next).is_none() => q = next,
            _ => return (count, q),
        }
    }
    (moves.len(), q)
}

/// Returns the axes at a pose from which most moves can be followed, and the number of these moves.
///
/// Of several that lead equally far it takes those nearest to the axes before.
fn choose(
    inverse: &Inverse,
    pose: &ToolPose,
    near: &AxisVector,
    moves: &[PostMove],
) -> Option<(AxisVector, usize)> {
    let first = inverse.near_inside(pose, near).ok()?;
    let mut best = (first, follow(inverse, first, moves).0);
    // The nearest solution leads through the whole cut.
    if best.1 == moves.len() {
        return Some(best);
    }
    let away = |q: &AxisVector| (q - near).fixed_rows::<2>(FIRST_ROTARY).abs().sum();
    for q in solutions(inverse, pose, near) {
        let reach = follow(inverse, q, moves).0;
        if reach > best.1 || (reach == best.1 && away(&q) < away(&best.0)) {
            best = (q, reach);
        }
    }
    Some(best)
}

/// Returns all axis positions inside travel at a pose; of endless axes only the turn nearest to `near`.
fn solutions(inverse: &Inverse, pose: &ToolPose, near: &AxisVector) -> Vec<AxisVector> {
    let machine = inverse.kinematics().machine();
    let turns = |value: f64, axis: usize| -> Vec<f64> {
        let [low, high] = machine.axes.get(axis).map_or([0.0; 2], |axis| axis.limits.ends());
        if !(low.is_finite() && high.is_finite()) {
            return vec![unwrap_near(value, near[axis])];
        }
        // All turns inside the travel, from the lowest on.
        let first = value + TAU * ((low - value) / TAU).ceil();
        let next = std::iter::successors(Some(first), |turn| Some(turn + TAU));
        next.take_while(|turn| *turn <= high).collect()
    };
    let found = match inverse.solutions(pose) {
        Ok(InverseSolutions::Regular(both)) => both.to_vec(),
        Ok(InverseSolutions::Singular(one)) => vec![one],
        Err(_) => Vec::new(),
    };
    let mut all = Vec::new();
    for q in found {
        for first in turns(q[FIRST_ROTARY], FIRST_ROTARY) {
            for second in turns(q[SECOND_ROTARY], SECOND_ROTARY) {
                let mut q = q;
                [q[FIRST_ROTARY], q[SECOND_ROTARY]] = [first, second];
                all.push(q);
            }
        }
    }
    all.retain(|q| machine.out_of_travel(q).is_none());
    all
}
