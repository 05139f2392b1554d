//! Which way round the rotaries go: looked at ahead, so that a cut stays inside travel; where none does, the rotaries
//! go round off the part.

use super::{PostMove, PostPace};
use crate::inverse::{Inverse, Solutions};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::unwrap_near;
use crate::types::{AxisVector, ToolPose};
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Most moves that are looked at ahead.
const WINDOW: usize = 1 << 16;

/// Last way back to the part, at the feed of the cut \[mm\].
const APPROACH: f64 = 1.0;

/// Most lines of retracts that are told.
const MOST_TOLD: usize = 1000;

/// A move and how it is to be run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planned {
    pub(super) one: PostMove,
    /// Axes at its end; without it those near the ones before.
    pub(super) stand: Option<AxisVector>,
    /// Part of a retract.
    pub(super) part: Option<Part>,
}

/// Parts of a retract.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Out,
    /// The tip stands, the rotaries turn.
    Turn,
    Back,
}

/// Holds moves back until it is known how far the ways to run them lead.
#[derive(Debug, Clone)]
pub(super) struct Ahead {
    /// `None`: moves are run as they come.
    inverse: Option<Inverse>,
    /// How far the tool retracts along its axis \[mm\].
    unwind: Option<f64>,
    /// Rapid moves, then those of a cut.
    pending: VecDeque<PostMove>,
    /// Axes at the end of what was planned.
    at: Option<AxisVector>,
    /// Lines of the input before which it retracted.
    pub(super) unwound: Vec<u32>,
}

impl Ahead {
    /// `inverse`: of the target, if its rotaries are chosen here.
    pub(super) fn new(inverse: Option<Inverse>, unwind: Option<f64>) -> Self {
        Self { inverse, unwind, pending: VecDeque::new(), at: None, unwound: Vec::new() }
    }

    /// Takes in a move; those that are planned are appended.
    pub(super) fn push(&mut self, one: &PostMove, out: &mut Vec<Planned>) {
        if self.inverse.is_none() {
            return out.push(plain(*one));
        }
        let cutting = self.pending.back().is_some_and(|last| last.pace != PostPace::Rapid);
        let begins = one.pace == PostPace::Rapid && cutting;
        if begins || self.pending.len() >= WINDOW {
            self.finish(out);
        }
        self.pending.push_back(*one);
    }

    /// Plans all that was held back.
    pub(super) fn finish(&mut self, out: &mut Vec<Planned>) {
        let moves: Vec<PostMove> = self.pending.drain(..).collect();
        let Some(inverse) = self.inverse.take() else { return };
        let planned = out.len();
        if self.plan(&inverse, &moves, out).is_none() {
            // Something is out of reach: whoever runs the moves says what.
            out.truncate(planned);
            out.extend(moves.into_iter().map(plain));
        }
        self.inverse = Some(inverse);
    }

    fn plan(
        &mut self,
        inverse: &Inverse,
        moves: &[PostMove],
        out: &mut Vec<Planned>,
    ) -> Option<()> {
        let home = inverse.kinematics().machine().home();
        let rapid = |one: &&PostMove| one.pace == PostPace::Rapid;
        // The first move of all says where the program starts.
        let least = usize::from(self.at.is_none());
        let rapids = moves.iter().take_while(rapid).count().max(least).min(moves.len());
        let (way, cut) = moves.split_at(rapids);
        let mut near = self.at.unwrap_or(home);
        let mut reach = None;
        for (index, one) in way.iter().enumerate() {
            let last = index + 1 == way.len();
            let (q, followed) = if last && !cut.is_empty() {
                choose(inverse, &one.pose, &near, cut)?
            } else {
                (inverse.near_inside(&one.pose, &near).ok()?, 0)
            };
            reach = Some(followed);
            near = q;
            out.push(Planned { stand: Some(q), ..plain(*one) });
        }
        let reach = reach.unwrap_or_else(|| follow(inverse, near, cut).0);
        self.at = Some(self.cut(inverse, near, (cut, reach), out)?);
        Some(())
    }

    /// A cut from axes on, which lead so many moves far; axes at its end.
    fn cut(
        &mut self,
        inverse: &Inverse,
        mut q: AxisVector,
        (mut rest, mut reach): (&[PostMove], usize),
        out: &mut Vec<Planned>,
    ) -> Option<AxisVector> {
        loop {
            let (fits, left) = rest.split_at(reach.min(rest.len()));
            q = follow(inverse, q, fits).1;
            out.extend(fits.iter().map(|one| plain(*one)));
            let Some(next) = left.first() else { return Some(q) };
            let length = self.unwind?;
            let pose = inverse.kinematics().forward(&q);
            let (to, further) = choose(inverse, &pose, &q, left)?;
            if further == 0 {
                return None;
            }
            retract(inverse, (next, &pose, length), to, out)?;
            if self.unwound.len() < MOST_TOLD {
                self.unwound.push(next.line);
            }
            (q, rest, reach) = (to, left, further);
        }
    }
}

fn plain(one: PostMove) -> Planned {
    Planned { one, stand: None, part: None }
}

/// Out along the tool axis, rotaries round, and back to the same place.
fn retract(
    inverse: &Inverse,
    (next, pose, length): (&PostMove, &ToolPose, f64),
    to: AxisVector,
    out: &mut Vec<Planned>,
) -> Option<()> {
    let up = |by: f64| ToolPose { tip: pose.tip + pose.axis.scale(by), ..*pose };
    let far = up(length);
    let turned = inverse.near_inside(&far, &to).ok()?;
    let rapid = |pose: ToolPose| PostMove { pose, q: None, pace: PostPace::Rapid, ..*next };
    let part = |one: PostMove, stand, part| Planned { one, stand, part: Some(part) };
    out.push(part(rapid(far), None, Part::Out));
    out.push(part(rapid(far), Some(turned), Part::Turn));
    out.push(part(rapid(up(APPROACH.min(length))), None, Part::Back));
    out.push(part(PostMove { pose: *pose, q: None, ..*next }, Some(to), Part::Back));
    Some(())
}

/// How many moves can be followed inside travel from axes on, and the axes at the end of them.
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

/// Axes at a pose from which most moves can be followed; where several lead as far, those nearest to the ones before.
fn choose(
    inverse: &Inverse,
    pose: &ToolPose,
    near: &AxisVector,
    moves: &[PostMove],
) -> Option<(AxisVector, usize)> {
    let first = inverse.near_inside(pose, near).ok()?;
    let mut best = (first, follow(inverse, first, moves).0);
    if best.1 == moves.len() {
        return Some(best);
    }
    let away = |q: &AxisVector| (q - near).fixed_rows::<2>(FIRST_ROTARY).abs().sum();
    for q in stands(inverse, pose, near) {
        let reach = follow(inverse, q, moves).0;
        if reach > best.1 || (reach == best.1 && away(&q) < away(&best.0)) {
            best = (q, reach);
        }
    }
    Some(best)
}

/// All axis positions at a pose inside travel; of endless axes the turn near those before.
fn stands(inverse: &Inverse, pose: &ToolPose, near: &AxisVector) -> Vec<AxisVector> {
    let machine = inverse.kinematics().machine();
    let turns = |value: f64, axis: usize| -> Vec<f64> {
        let [low, high] = machine.axes.get(axis).map_or([0.0; 2], |axis| axis.limits);
        if !(low.is_finite() && high.is_finite()) {
            return vec![unwrap_near(value, near[axis])];
        }
        let first = value + TAU * ((low - value) / TAU).ceil();
        let next = std::iter::successors(Some(first), |turn| Some(turn + TAU));
        next.take_while(|turn| *turn <= high).collect()
    };
    let found = match inverse.solutions(pose) {
        Ok(Solutions::Regular(both)) => both.to_vec(),
        Ok(Solutions::Singular(one)) => vec![one],
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
