//! Search for the ends of blocks, the longest block first.

use super::deviation::{ControlledPath, PathPoint};
use super::options::BlockOptions;
use super::smooth_piece::SmoothPiece;
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::angle_between;
use crate::types::{Motion, SchedulePiece};
use nalgebra::Point3;

/// Halvings between an allowed and a refused length: right to 1/128 of the block.
const HALVINGS: u32 = 7;

/// Allowance for the bisection, which ends up to 1/128 short of the longest block.
const ROUNDED_UP: f64 = 1.0 + 1.0 / 64.0;

/// Largest deviation of a hop, over the distance from its ends: hops are planned so that the tool is clear by as much.
const CLEAR: f64 = 0.1;

/// Block that exceeds the tolerance however short it is.
pub(super) struct ToleranceFault {
    pub(super) s: f64,
    pub(super) deviation: f64,
    pub(super) tolerance: f64,
}

/// Finds the path parameters of the block ends of a piece. The first one is where it starts.
pub(super) fn ends(
    controlled: &ControlledPath<'_, SmoothPiece<'_>>,
    rows: &SchedulePiece,
    options: &BlockOptions,
) -> Result<Vec<f64>, ToleranceFault> {
    let (Some(first), Some(last)) =
        (controlled.poses.piece.nodes.first(), controlled.poses.piece.nodes.last())
    else {
        return Ok(Vec::new());
    };
    let mut from = controlled.at(first.s);
    let tips = [from.pose.tip, controlled.at(last.s).pose.tip];
    let search = EndSearch { controlled, rows, options, end: last.s, tips };
    let mut ends = vec![first.s];
    let mut guess = last.s - first.s;
    while from.s < last.s {
        let to = search.longest(&from, guess)?;
        guess = to.s - from.s;
        ends.push(to.s);
        from = to;
    }
    search.balance(&mut ends);
    Ok(ends)
}

struct EndSearch<'a> {
    controlled: &'a ControlledPath<'a, SmoothPiece<'a>>,
    rows: &'a SchedulePiece,
    options: &'a BlockOptions,
    end: f64,
    /// Tips at the start and the end of the piece \[mm\].
    tips: [Point3<f64>; 2],
}

impl EndSearch<'_> {
    /// Finds the end of the longest allowed block from a point: the length is doubled or halved from a
    /// guess until both an allowed and a refused length are known, then bisected between them.
    fn longest(&self, from: &PathPoint, guess: f64) -> Result<PathPoint, ToleranceFault> {
        let mut best: Option<PathPoint> = None;
        let mut refused = f64::INFINITY;
        let mut length = guess;
        // Lengths below this share of s are lost in its rounding.
        let shortest = from.s.abs().max(self.end.abs()) * f64::EPSILON * 1024.0;
        // Bracket the longest block: doubling while allowed, halving while refused.
        while best.is_none() || refused.is_infinite() {
            let to = self.controlled.at(self.end.min(from.s + length));
            if self.allowed(from, &to) {
                best = Some(to);
                if to.s >= self.end {
                    return Ok(to);
                }
                length *= 2.0;
            } else {
                refused = to.s;
                length = 0.5 * (to.s - from.s);
                if length <= shortest {
                    return Err(self.fault(from, &to));
                }
            }
        }
        let mut best = best.unwrap_or(*from);
        for _ in 0..HALVINGS {
            let to = self.controlled.at(0.5 * (best.s + refused));
            // Part of an allowed block is allowed, so one bracket is enough.
            if self.allowed(from, &to) { best = to } else { refused = to.s }
        }
        Ok(best)
    }

    fn allowed(&self, from: &PathPoint, to: &PathPoint) -> bool {
        self.fine(from, to) && self.keeps_tolerance(from, to)
    }

    fn keeps_tolerance(&self, from: &PathPoint, to: &PathPoint) -> bool {
        let tolerance = self.tolerance([from, to]);
        self.controlled.deviation(from, to, tolerance) <= tolerance
    }

    /// Returns `true` if step, turns and duration are allowed.
    fn fine(&self, from: &PathPoint, to: &PathPoint) -> bool {
        if self.controlled.poses.piece.motion.is_free() {
            return true;
        }
        let duration = self.rows.time_at(to.s) - self.rows.time_at(from.s);
        if duration <= self.options.min_duration * ROUNDED_UP {
            return true;
        }
        let step = (to.pose.tip - from.pose.tip).norm();
        let turn = |axis: usize| (to.q[axis] - from.q[axis]).abs();
        let axis = angle_between(&from.pose.axis, &to.pose.axis);
        step <= self.options.max_step
            && axis <= self.options.max_axis_turn
            && turn(FIRST_ROTARY).max(turn(SECOND_ROTARY)) <= self.options.max_turn
            && duration <= self.options.max_duration
    }

    fn tolerance(&self, block: [&PathPoint; 2]) -> f64 {
        let BlockOptions { tolerance, link_tolerance, .. } = *self.options;
        match self.controlled.poses.piece.motion {
            Motion::Link => link_tolerance,
            // A hop leaves the part along the tool axis: a share of its distance from both ends is
            // free.
            Motion::Hop => (tolerance + CLEAR * self.ends_away(block)).min(link_tolerance),
            _ => tolerance,
        }
    }

    /// Returns the least distance of the tip, at either end of a block, from the tips at the ends of the piece \[mm\].
    fn ends_away(&self, block: [&PathPoint; 2]) -> f64 {
        let distance = |tip: &Point3<f64>| {
            block.iter().map(|point| (point.pose.tip - tip).norm()).fold(f64::INFINITY, f64::min)
        };
        self.tips.iter().map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Balances the last two blocks. A last block that is too short shares its time evenly with the one
    /// before; if that leaves both too short they become one. Both only if the tolerance allows it.
    fn balance(&self, ends: &mut Vec<f64>) {
        let &[.., before, middle, last] = ends.as_slice() else { return };
        let [start, via, end] = [before, middle, last].map(|s| self.rows.time_at(s));
        let least = self.options.min_duration;
        if end - via >= least {
            return;
        }
        let index = ends.len() - 2;
        let [from, to] = [before, last].map(|s| self.controlled.at(s));
        // Both blocks together are too short for two: one block, if the deviation allows it.
        if end - start < 2.0 * least {
            if self.keeps_tolerance(&from, &to) {
                ends.remove(index);
            }
            return;
        }
        // Equal times instead, if the schedule has a point there and both halves stay within
        // tolerance.
        let Some(moment) = self.rows.at_time(0.5 * (start + end)) else { return };
        let via = self.controlled.at(moment.s);
        if via.s > before && via.s < last && self.allowed(&from, &via) && self.allowed(&via, &to) {
            ends[index] = via.s;
        }
    }

    fn fault(&self, from: &PathPoint, to: &PathPoint) -> ToleranceFault {
        let deviation = self.controlled.deviation(from, to, f64::INFINITY);
        ToleranceFault { s: from.s, deviation, tolerance: self.tolerance([from, to]) }
    }
}
