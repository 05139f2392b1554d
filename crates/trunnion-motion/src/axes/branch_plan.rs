//! Branch, whole turns and retracts for the whole path, by dynamic programming.

use super::branch_run::{BranchRun, CellBlock, NodePosition, PathSegment, RunCell, SwitchPoint};
use super::error::AxesError;
use super::follower::{AxisTrack, PathFollower};
use super::retract::{RetractLegs, RetractPlanner};
use super::segments::LinkMove;
use super::travel::TravelLimits;
use crate::inverse::TRAVEL_TIE;
use crate::machine::{FIRST_ROTARY, RotaryPair};
use crate::math::angle::unwrap_near;
use crate::types::ToolPose;
use std::f64::consts::TAU;
use std::ops::Range;

/// Choice of branches, whole turns and retracts for a whole path.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BranchPlan {
    /// In order; at least one for each segment.
    pub(super) parts: Vec<PlannedRun>,
    /// Weighted rotary travel and the prices of retracts \[rad\].
    pub(super) cost: f64,
}

/// Cells of one branch, run without a break.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PlannedRun {
    /// Entry into this part.
    pub(super) entry: RunEntry,
    pub(super) segment: usize,
    pub(super) branch: usize,
    pub(super) cells: Range<usize>,
    /// Whole turns added to the rotaries \[rad\].
    pub(super) offset: [f64; 2],
}

/// Entry of the tool into a part of the path.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum RunEntry {
    /// The path starts.
    Start,
    /// Over the link before.
    Link(AxisTrack),
    /// Out of the part and back to the same point.
    Retract { switch: SwitchPoint, pose: ToolPose, rotaries: [[f64; 2]; 2], legs: RetractLegs },
}

/// Branch of the inverse with a number of whole turns of each rotary.
#[derive(Debug, Clone, Copy)]
struct BranchTurns {
    branch: usize,
    turns: [f64; 2],
}

/// State of the dynamic program: a branch with whole turns, and the cheapest sequence that leads to it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct BranchState {
    branch: usize,
    turns: [f64; 2],
    rank: PathRank,
    record: Option<usize>,
}

/// Entry into a state, with the entry before it; the chosen plan is read back along these.
#[derive(Debug, Clone, Copy, PartialEq)]
struct EntryRecord {
    segment: usize,
    cell: usize,
    branch: usize,
    turns: [f64; 2],
    back: Option<usize>,
}

/// Cost first; where it is equal, fewer axes on the side they do not prefer.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PathRank {
    cost: f64,
    unpreferred: usize,
}

impl PathRank {
    const NEVER: Self = Self { cost: f64::INFINITY, unpreferred: 0 };

    fn before(self, other: Self) -> bool {
        // Costs within `TRAVEL_TIE` are equal but for the rounding of their sums.
        self.cost < other.cost - TRAVEL_TIE
            || (self.cost <= other.cost + TRAVEL_TIE && self.unpreferred < other.unpreferred)
    }
}

/// Returns the cheapest choice for the whole path.
///
/// Dynamic programming over segments and their cells: a state is a branch with whole turns. What a
/// state costs from here on does not depend on how it was reached, so that the cheapest entry of each
/// state is enough (Bellman's principle of optimality).
pub(super) fn plan_branches(
    follower: &PathFollower<'_>,
    segments: &[PathSegment],
    links: &[LinkMove],
) -> Result<BranchPlan, AxesError> {
    let travel = TravelLimits { axes: &follower.inverse.kinematics().machine().axes };
    let retractor = follower.options.retract.as_ref();
    let retractor = retractor.map(|options| RetractPlanner { follower, travel, options });
    let mut planner = BranchPlanner { follower, travel, retractor, records: Vec::new() };
    let mut states: Vec<BranchState> = Vec::new();
    for (index, segment) in segments.iter().enumerate() {
        let mut entries = planner.entries(segment)?;
        let before = index.checked_sub(1).and_then(|before| segments.get(before));
        match (before, index.checked_sub(1).and_then(|link| links.get(link))) {
            (Some(from), Some(link)) => {
                planner.join(link, from, &states, segment, &mut entries)?;
            }
            _ => planner.begin(segment, &mut entries),
        }
        planner.enter(index, 0, &mut entries);
        states = planner.run(index, segment, entries)?;
    }
    let best = cheapest(&states);
    let cost = best.map_or(0.0, |state| state.rank.cost);
    let parts = planner.trace(segments, links, best.and_then(|state| state.record))?;
    Ok(BranchPlan { parts, cost })
}

struct BranchPlanner<'a> {
    follower: &'a PathFollower<'a>,
    travel: TravelLimits<'a>,
    retractor: Option<RetractPlanner<'a>>,
    records: Vec<EntryRecord>,
}

impl BranchPlanner<'_> {
    /// Returns every branch at every turn that keeps its first cell inside travel.
    fn entries(&self, segment: &PathSegment) -> Result<Vec<BranchState>, AxesError> {
        let first = segment.cells(0..1, self.follower.options);
        let states: Vec<BranchState> = self
            .fitting(&first, 0)
            .map(|BranchTurns { branch, turns }| BranchState {
                branch,
                turns,
                rank: PathRank::NEVER,
                record: None,
            })
            .collect();
        if states.is_empty() { Err(self.outside(segment)) } else { Ok(states) }
    }

    /// Returns the branches and turns that are inside travel on a cell; `cells` has those of each branch.
    fn fitting(&self, cells: &[Vec<RunCell>], cell: usize) -> impl Iterator<Item = BranchTurns> {
        let travel = self.travel;
        cells.iter().enumerate().flat_map(move |(branch, cells)| {
            let bounds = cells.get(cell).map(|cell| cell.bounds);
            let turns = bounds.into_iter().flat_map(move |bounds| travel.turns(&bounds));
            turns.map(move |turns| BranchTurns { branch, turns })
        })
    }

    fn outside(&self, segment: &PathSegment) -> AxesError {
        self.travel.outside(segment, self.follower.options)
    }

    /// Ranks the states of the first segment by the rotary travel from the position before the path.
    fn begin(&self, segment: &PathSegment, states: &mut [BranchState]) {
        let start = &self.follower.options.start;
        let from = [start[FIRST_ROTARY], start[FIRST_ROTARY + 1]];
        for state in states {
            let Some(branch) = segment.branches.get(state.branch) else { continue };
            let to = turned(branch.start(), state.turns);
            let cost = self.price(self.travel.moved(from, to));
            state.rank = PathRank { cost, unpreferred: self.travel.unpreferred(to) };
        }
    }

    /// Ranks the states at the start of a segment by the cheapest link from a state before it, and drops
    /// those that no link inside travel leads to.
    fn join(
        &self,
        link: &LinkMove,
        from: &PathSegment,
        before: &[BranchState],
        segment: &PathSegment,
        states: &mut Vec<BranchState>,
    ) -> Result<(), AxesError> {
        let mut fault = None;
        for state in states.iter_mut() {
            let Some(branch) = segment.branches.get(state.branch) else { continue };
            let to = turned(branch.start(), state.turns);
            for origin in before {
                let Some(last) = from.branches.get(origin.branch) else { continue };
                let end = turned(last.end, origin.turns);
                let moved = self.travel.moved(end, to);
                let rank = self.further(origin.rank, self.price(moved), to);
                // The link is followed only where it would be the cheapest so far: that takes most time.
                if !rank.before(state.rank) {
                    continue;
                }
                match self.link(link, [end, added(end, moved)]) {
                    Ok(_) => (state.rank, state.record) = (rank, origin.record),
                    Err(error) => fault = fault.or(Some(error)),
                }
            }
        }
        states.retain(|state| state.rank.cost.is_finite());
        let nothing = || self.outside(segment);
        if states.is_empty() { Err(fault.unwrap_or_else(nothing)) } else { Ok(()) }
    }

    /// Returns the rank after a move of a given price to the rotaries `to`.
    fn further(&self, from: PathRank, price: f64, to: [f64; 2]) -> PathRank {
        PathRank {
            cost: from.cost + price,
            unpreferred: from.unpreferred + self.travel.unpreferred(to),
        }
    }

    /// Records the entry of each state, for [`Self::trace`].
    fn enter(&mut self, segment: usize, cell: usize, states: &mut [BranchState]) {
        for state in states {
            let BranchState { branch, turns, record: back, .. } = *state;
            self.records.push(EntryRecord { segment, cell, branch, turns, back });
            state.record = Some(self.records.len() - 1);
        }
    }

    /// Runs the states over a segment: they go on while they are inside travel, and others are entered by
    /// a retract where that is cheaper. Blocks on which certainly neither happens are added up whole.
    fn run(
        &mut self,
        index: usize,
        segment: &PathSegment,
        mut states: Vec<BranchState>,
    ) -> Result<Vec<BranchState>, AxesError> {
        for (block, cells) in segment.blocks().enumerate() {
            // The set of states and their entries stay the same over the block: only travel is added.
            if !self.goes_on(segment, block, &states) {
                self.run_cells(index, segment, cells, &mut states)?;
                continue;
            }
            for state in &mut states {
                let of = segment.branches.get(state.branch).and_then(|of| of.blocks.get(block));
                state.rank.cost += of.map_or(0.0, |of| of.travel);
            }
        }
        Ok(states)
    }

    /// Returns `true` if certainly no state has to be left on a block, or is cheaper to enter anew.
    fn goes_on(&self, segment: &PathSegment, block: usize, states: &[BranchState]) -> bool {
        let mut known = 0;
        for (index, branch) in segment.branches.iter().enumerate() {
            let Some(of) = branch.blocks.get(block) else { return false };
            let all = || self.travel.turns(&of.bounds);
            // `bounds` is the hull of all cells, `least` their intersection. If as many turns fit the one as
            // the other, turns that fit on any cell fit on all of them, and must be states.
            let on = |turns: [f64; 2]| {
                states.iter().any(|state| state.branch == index && equal(state.turns, turns))
            };
            if of.jumps || all().count() != self.travel.turns(&of.least).count() || !all().all(on) {
                return false;
            }
            known += all().count();
        }
        known == states.len() && self.none_anew(segment, block, states)
    }

    /// Returns `true` if certainly no state on a block is cheaper to enter by a retract.
    fn none_anew(&self, segment: &PathSegment, block: usize, states: &[BranchState]) -> bool {
        let (Some(retractor), Some(best)) = (&self.retractor, cheapest(states)) else {
            return true;
        };
        // The cheapest retract that the block allows is a lower bound of the price of any.
        let mut blocks = segment.branches.iter().filter_map(|branch| branch.blocks.get(block));
        let inside = blocks.all(|block| block.inside);
        let options = retractor.options;
        let in_cut = options.price_in_cut;
        let price = if inside { in_cut } else { in_cut.min(options.price) };
        let of = |state: &BranchState| segment.branches.get(state.branch)?.blocks.get(block);
        states.iter().all(|state| {
            of(state).is_some_and(|to| {
                // Costs only grow along a block, so `most` bounds the state's cost anywhere on it, and
                // no entry is cheaper than the price on top of the cheapest state.
                let most = state.rank.cost + to.travel;
                let from_none = |origin: &BranchState| {
                    of(origin)
                        .is_some_and(|from| !self.may_be_before(origin, from, state, to, price))
                };
                most <= best.rank.cost + price || states.iter().all(from_none)
            })
        })
    }

    /// Returns `true` if a retract on a block may lead from one state to another where that is cheaper, or as
    /// cheap and preferred. The blocks are those of the two branches, the price that of the retract \[rad\].
    fn may_be_before(
        &self,
        from: &BranchState,
        from_block: &CellBlock,
        to: &BranchState,
        to_block: &CellBlock,
        price: f64,
    ) -> bool {
        let cost = from.rank.cost + price;
        if from.branch == to.branch {
            // On one branch both states have the same travel along the block, so that the difference of
            // their costs stays what it is, and the move between them is that of their turns.
            let moved = self.travel.moved(turned([0.0; 2], from.turns), turned([0.0; 2], to.turns));
            let unpreferred = self.travel.unpreferred_all_over(&to_block.bounds, to.turns);
            let rank = PathRank {
                cost: cost + self.price(moved),
                unpreferred: from.rank.unpreferred + unpreferred,
            };
            return rank.before(to.rank);
        }
        // Least cost at the start of the block and the least move from it, against the most that the
        // other state costs at the end of the block.
        let moved =
            self.travel.least_moved(&from_block.bounds, from.turns, &to_block.bounds, to.turns);
        cost + self.price(moved) <= to.rank.cost + to_block.travel + TRAVEL_TIE
    }

    /// Runs the states over a range of cells, cell by cell, as [`Self::run`].
    fn run_cells(
        &mut self,
        index: usize,
        segment: &PathSegment,
        range: Range<usize>,
        states: &mut Vec<BranchState>,
    ) -> Result<(), AxesError> {
        let cells = segment.cells(range.clone(), self.follower.options);
        for (inside, cell) in range.enumerate() {
            if let Some(switch) = segment.switch(cell) {
                let mut fault = None;
                let fitting: Vec<_> = self.fitting(&cells, inside).collect();
                let mut broken = self.breaks(segment, &switch, states, &fitting, &mut fault);
                // States that leave travel, or whose rotaries jump here, end; so do those that a retract
                // enters more cheaply than they go on.
                states.retain(|state| {
                    fitting.iter().any(|one| state.is(*one))
                        && !segment.jumps_at(state.branch, cell)
                        && !broken.iter().any(|other| other.same(state))
                });
                self.enter(index, cell, &mut broken);
                states.append(&mut broken);
                if states.is_empty() {
                    return Err(fault.unwrap_or_else(|| self.outside(segment)));
                }
            }
            for state in states.iter_mut() {
                let cell = cells.get(state.branch).and_then(|cells| cells.get(inside));
                state.rank.cost += cell.map_or(0.0, |cell| cell.travel);
            }
        }
        Ok(())
    }

    /// Returns the states among `fitting` that are best entered by a retract at a switch point; `fault`
    /// keeps the first reason why a retract is impossible.
    fn breaks(
        &self,
        segment: &PathSegment,
        switch: &SwitchPoint,
        states: &[BranchState],
        fitting: &[BranchTurns],
        fault: &mut Option<AxesError>,
    ) -> Vec<BranchState> {
        let cell = switch.cell;
        let (Some(retractor), Some(best)) = (&self.retractor, cheapest(states)) else {
            return Vec::new();
        };
        let options = retractor.options;
        let price = if switch.inside { options.price_in_cut } else { options.price };
        let mut found = Vec::new();
        for &BranchTurns { branch, turns } in fitting {
            let Some(of) = segment.branches.get(branch) else { continue };
            let goes_on = states
                .iter()
                .find(|state| state.is(BranchTurns { branch, turns }))
                .filter(|_| !of.jumps_at(cell));
            let mut entered = BranchState {
                branch,
                turns,
                rank: goes_on.map_or(PathRank::NEVER, |on| on.rank),
                record: None,
            };
            // Already as cheap as the cheapest retract from the cheapest state.
            if entered.rank.cost <= best.rank.cost + price {
                continue;
            }
            let to = turned(of.start_of(cell), turns);
            for origin in states {
                let Some(last) = segment.branches.get(origin.branch) else { continue };
                let from = turned(last.end_before(cell), origin.turns);
                let moved = self.travel.moved(from, to);
                let rank = self.further(origin.rank, price + self.price(moved), to);
                if !rank.before(entered.rank) {
                    continue;
                }
                let pose = self.pose(last, cell);
                match retractor.check(switch.piece, &pose, [from, added(from, moved)]) {
                    Ok(()) => (entered.rank, entered.record) = (rank, origin.record),
                    Err(error) => *fault = fault.take().or(Some(error)),
                }
            }
            if entered.record.is_some() {
                found.push(entered);
            }
        }
        found
    }

    /// Returns the pose at the start of a cell.
    fn pose(&self, branch: &BranchRun, cell: usize) -> ToolPose {
        self.follower.inverse.kinematics().forward(&branch.axes_at(cell))
    }

    /// Returns the cost of a move of both rotaries \[rad\].
    fn price(&self, moved: [f64; 2]) -> f64 {
        let RotaryPair { first, second } = self.follower.options.rotary_weights;
        first * moved[0].abs() + second * moved[1].abs()
    }

    /// Follows a link and checks that it stays inside travel.
    fn link(&self, link: &LinkMove, rotaries: [[f64; 2]; 2]) -> Result<AxisTrack, AxesError> {
        let track =
            self.follower.link(link.tips, rotaries).map_err(|trouble| trouble.of(link.piece))?;
        // The rotaries go straight between two positions inside travel.
        for (node, bounds) in track.bounds().enumerate() {
            if !self.travel.slides_inside(&bounds)
                && let Some(worst) = self.travel.worst(&bounds, [0.0; 2])
            {
                let u = track.nodes.get(node).map_or(0.0, |node| node.s);
                let at = NodePosition { piece: link.piece, node, u };
                return Err(self.travel.fault(at, &worst));
            }
        }
        Ok(track)
    }

    /// Reads the plan back from the last record, and returns its parts from first to last.
    fn trace(
        &self,
        segments: &[PathSegment],
        links: &[LinkMove],
        last: Option<usize>,
    ) -> Result<Vec<PlannedRun>, AxesError> {
        let mut records: Vec<EntryRecord> = Vec::new();
        let mut at = last;
        while let Some(record) = at.and_then(|at| self.records.get(at)) {
            records.push(*record);
            at = record.back;
        }
        records.reverse();
        let start = &self.follower.options.start;
        let mut end = [start[FIRST_ROTARY], start[FIRST_ROTARY + 1]];
        let mut parts: Vec<PlannedRun> = Vec::with_capacity(records.len());
        for (index, record) in records.iter().enumerate() {
            let Some(segment) = segments.get(record.segment) else { continue };
            let Some(branch) = segment.branches.get(record.branch) else { continue };
            let next = records.get(index + 1).filter(|next| next.segment == record.segment);
            let cells = record.cell..next.map_or(segment.count(), |next| next.cell);
            let own = branch.start_of(record.cell);
            // Where an axis has no ends of travel its turns are open: they follow from where it is.
            let begin = added(end, self.travel.moved(end, turned(own, record.turns)));
            let link = record.segment.checked_sub(1).and_then(|link| links.get(link));
            let entry = match (record.cell, link) {
                (0, Some(link)) => RunEntry::Link(self.link(link, [end, begin])?),
                (0, None) => RunEntry::Start,
                (cell, _) => self.retract(segment, cell, branch, [end, begin])?,
            };
            // Whole turns of 2π added to `own` exactly, so that parts and links meet to rounding.
            let offset = [0, 1].map(|axis| unwrap_near(own[axis], begin[axis]) - own[axis]);
            end = added(branch.end_before(cells.end), offset);
            let (segment, branch) = (record.segment, record.branch);
            parts.push(PlannedRun { entry, segment, branch, cells, offset });
        }
        Ok(parts)
    }

    /// Plans the retract at the start of a cell.
    fn retract(
        &self,
        segment: &PathSegment,
        cell: usize,
        branch: &BranchRun,
        rotaries: [[f64; 2]; 2],
    ) -> Result<RunEntry, AxesError> {
        let (Some(retractor), Some(at)) = (&self.retractor, segment.switch(cell)) else {
            return Ok(RunEntry::Start);
        };
        let pose = self.pose(branch, cell);
        let legs = retractor.legs(at.piece, &pose, rotaries)?;
        Ok(RunEntry::Retract { switch: at, pose, rotaries, legs })
    }
}

impl BranchState {
    fn same(&self, other: &Self) -> bool {
        self.is(BranchTurns { branch: other.branch, turns: other.turns })
    }

    fn is(&self, other: BranchTurns) -> bool {
        self.branch == other.branch && equal(self.turns, other.turns)
    }
}

/// Compares numbers of turns: whole, so that equal numbers have equal bits.
fn equal(a: [f64; 2], b: [f64; 2]) -> bool {
    a.map(f64::to_bits) == b.map(f64::to_bits)
}

/// Adds whole turns to rotary positions \[rad\].
fn turned(rotaries: [f64; 2], turns: [f64; 2]) -> [f64; 2] {
    added(rotaries, turns.map(|turns| TAU * turns))
}

fn added([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a + c, b + d]
}

/// Returns the first state that no other is better than.
fn cheapest(states: &[BranchState]) -> Option<BranchState> {
    states
        .iter()
        .copied()
        .reduce(|best, state| if state.rank.before(best.rank) { state } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_costs_are_decided_by_preference() {
        let a = PathRank { cost: 1.0, unpreferred: 1 };
        let b = PathRank { cost: 1.0 + 1e-12, unpreferred: 0 };
        assert!(b.before(a) && !a.before(b));
        assert!(PathRank { cost: 0.5, unpreferred: 2 }.before(b));
    }
}
