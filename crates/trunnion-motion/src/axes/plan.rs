//! Branch, whole turns and retracts for the whole path, by dynamic programming.

use super::AxesError;
use super::march::{Marched, Marcher};
use super::retract::{Legs, Retractor};
use super::stops::Link;
use super::strand::{Block, Cell, Joint, Strand, Stretch};
use super::travel::Travel;
use crate::inverse::TRAVEL_TIE;
use crate::machine::FIRST_ROTARY;
use crate::math::angle::unwrap_near;
use crate::types::ToolPose;
use std::f64::consts::TAU;
use std::ops::Range;

/// What was chosen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chosen {
    /// In order; at least one for each stretch.
    pub(super) parts: Vec<Part>,
    /// Weighted rotary travel and the prices of retracts \[rad\].
    pub(super) cost: f64,
}

/// Cells of one strand, run without a break.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    /// How it is come to.
    pub(super) way: Way,
    pub(super) stretch: usize,
    pub(super) strand: usize,
    pub(super) cells: Range<usize>,
    /// Added to the rotaries \[rad\].
    pub(super) offset: [f64; 2],
}

/// How the tool comes to a part of the path.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Way {
    /// The path starts.
    Start,
    /// Over the link before.
    Link(Marched),
    /// Out of the part and back to the same place.
    Retract { joint: Joint, pose: ToolPose, rotaries: [[f64; 2]; 2], legs: Legs },
}

/// A strand with whole turns, and the cheapest way to where the tool is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    strand: usize,
    turns: [f64; 2],
    rank: Rank,
    record: Option<usize>,
}

/// Where a state was entered, and from which.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Record {
    stretch: usize,
    cell: usize,
    strand: usize,
    turns: [f64; 2],
    back: Option<usize>,
}

/// Cost first; where it is equal, fewer axes on the side they do not prefer.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Rank {
    cost: f64,
    disliked: usize,
}

impl Rank {
    const NEVER: Self = Self { cost: f64::INFINITY, disliked: 0 };

    fn before(self, other: Self) -> bool {
        self.cost < other.cost - TRAVEL_TIE
            || (self.cost <= other.cost + TRAVEL_TIE && self.disliked < other.disliked)
    }
}

/// The cheapest choice for the whole path.
pub(super) fn choose(
    marcher: &Marcher<'_>,
    stretches: &[Stretch],
    links: &[Link],
) -> Result<Chosen, AxesError> {
    let travel = Travel { axes: &marcher.inverse.kinematics().machine().axes };
    let retractor = marcher.options.retract.as_ref();
    let retractor = retractor.map(|options| Retractor { marcher, travel, options });
    let mut planner = Planner { marcher, travel, retractor, records: Vec::new() };
    let mut states: Vec<State> = Vec::new();
    for (index, stretch) in stretches.iter().enumerate() {
        let mut entries = planner.entries(stretch)?;
        let before = index.checked_sub(1).and_then(|before| stretches.get(before));
        match (before, index.checked_sub(1).and_then(|link| links.get(link))) {
            (Some(from), Some(link)) => {
                planner.join(link, (from, &states), (stretch, &mut entries))?;
            }
            _ => planner.begin(stretch, &mut entries),
        }
        planner.enter(index, 0, &mut entries);
        states = planner.run(index, stretch, entries)?;
    }
    let best = cheapest(&states);
    let cost = best.map_or(0.0, |state| state.rank.cost);
    let parts = planner.trace(stretches, links, best.and_then(|state| state.record))?;
    Ok(Chosen { parts, cost })
}

struct Planner<'a> {
    marcher: &'a Marcher<'a>,
    travel: Travel<'a>,
    retractor: Option<Retractor<'a>>,
    records: Vec<Record>,
}

impl Planner<'_> {
    /// Every strand at every turn that keeps its first cell inside travel (the whole of it, where
    /// it cannot be left).
    fn entries(&self, stretch: &Stretch) -> Result<Vec<State>, AxesError> {
        let first = stretch.cells(0..1, self.marcher.options);
        let states: Vec<State> = self
            .fitting(&first, 0)
            .map(|(strand, turns)| State { strand, turns, rank: Rank::NEVER, record: None })
            .collect();
        if states.is_empty() { Err(self.outside(stretch)) } else { Ok(states) }
    }

    /// Strands and turns inside travel on a cell, of the cells of each strand.
    fn fitting(&self, cells: &[Vec<Cell>], cell: usize) -> impl Iterator<Item = (usize, [f64; 2])> {
        let travel = self.travel;
        cells.iter().enumerate().flat_map(move |(strand, cells)| {
            let bounds = cells.get(cell).map(|cell| cell.bounds);
            let turns = bounds.into_iter().flat_map(move |bounds| travel.turns(&bounds));
            turns.map(move |turns| (strand, turns))
        })
    }

    fn outside(&self, stretch: &Stretch) -> AxesError {
        self.travel.outside(stretch, self.marcher.options)
    }

    /// The first stretch, from where the rotaries stand before the path.
    fn begin(&self, stretch: &Stretch, states: &mut [State]) {
        let start = &self.marcher.options.start;
        let from = [start[FIRST_ROTARY], start[FIRST_ROTARY + 1]];
        for state in states {
            let Some(strand) = stretch.strands.get(state.strand) else { continue };
            let to = turned(strand.start(), state.turns);
            let cost = self.price(self.travel.moved(from, to));
            state.rank = Rank { cost, disliked: self.travel.disliked(to) };
        }
    }

    /// The next stretch, over a link.
    fn join(
        &self,
        link: &Link,
        (from, before): (&Stretch, &[State]),
        (stretch, states): (&Stretch, &mut Vec<State>),
    ) -> Result<(), AxesError> {
        let mut fault = None;
        for state in states.iter_mut() {
            let Some(strand) = stretch.strands.get(state.strand) else { continue };
            let to = turned(strand.start(), state.turns);
            for origin in before {
                let Some(last) = from.strands.get(origin.strand) else { continue };
                let end = turned(last.end, origin.turns);
                let moved = self.travel.moved(end, to);
                let rank = self.further(origin.rank, self.price(moved), to);
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
        let nothing = || self.outside(stretch);
        if states.is_empty() { Err(fault.unwrap_or_else(nothing)) } else { Ok(()) }
    }

    fn further(&self, from: Rank, price: f64, to: [f64; 2]) -> Rank {
        Rank { cost: from.cost + price, disliked: from.disliked + self.travel.disliked(to) }
    }

    /// Notes where states were entered.
    fn enter(&mut self, stretch: usize, cell: usize, states: &mut [State]) {
        for state in states {
            let State { strand, turns, record: back, .. } = *state;
            self.records.push(Record { stretch, cell, strand, turns, back });
            state.record = Some(self.records.len() - 1);
        }
    }

    /// Along a stretch: states go on while they fit, others are come to by a retract where that is
    /// cheaper. By the block where nothing of that happens, else cell by cell.
    fn run(
        &mut self,
        index: usize,
        stretch: &Stretch,
        mut states: Vec<State>,
    ) -> Result<Vec<State>, AxesError> {
        for (block, cells) in stretch.blocks().enumerate() {
            if !self.goes_on(stretch, block, &states) {
                self.run_cells(index, stretch, cells, &mut states)?;
                continue;
            }
            for state in &mut states {
                let of = stretch.strands.get(state.strand).and_then(|of| of.blocks.get(block));
                state.rank.cost += of.map_or(0.0, |of| of.travel);
            }
        }
        Ok(states)
    }

    /// Whether it is certain that on a block no state has to be left, or is better come to anew.
    fn goes_on(&self, stretch: &Stretch, block: usize, states: &[State]) -> bool {
        let mut known = 0;
        for (index, strand) in stretch.strands.iter().enumerate() {
            let Some(of) = strand.blocks.get(block) else { return false };
            let all = || self.travel.turns(&of.bounds);
            // What is inside on any cell is inside on all of them, and is a state.
            let on = |turns: [f64; 2]| {
                states.iter().any(|state| state.strand == index && equal(state.turns, turns))
            };
            if of.torn || all().count() != self.travel.turns(&of.least).count() || !all().all(on) {
                return false;
            }
            known += all().count();
        }
        known == states.len() && self.none_anew(stretch, block, states)
    }

    /// Whether it is certain that no state on a block is better come to by a retract.
    fn none_anew(&self, stretch: &Stretch, block: usize, states: &[State]) -> bool {
        let (Some(retractor), Some(best)) = (&self.retractor, cheapest(states)) else {
            return true;
        };
        let mut blocks = stretch.strands.iter().filter_map(|strand| strand.blocks.get(block));
        let inside = blocks.all(|block| block.inside);
        let [price, between] = [true, false].map(|inside| retractor.options.price(inside));
        let price = if inside { price } else { price.min(between) };
        let of = |state: &State| stretch.strands.get(state.strand)?.blocks.get(block);
        states.iter().all(|state| {
            of(state).is_some_and(|to| {
                let most = state.rank.cost + to.travel;
                let from_none = |origin: &State| {
                    of(origin).is_some_and(|from| {
                        !self.may_be_before([(origin, from), (state, to)], price)
                    })
                };
                most <= best.rank.cost + price || states.iter().all(from_none)
            })
        })
    }

    /// Whether one state may lead to another anew on a block, at a place where that is cheaper, or as
    /// cheap and preferred.
    fn may_be_before(&self, [(from, on), (to, block)]: [(&State, &Block); 2], price: f64) -> bool {
        let cost = from.rank.cost + price;
        if from.strand == to.strand {
            // Both come along the same way, so that the difference stays what it is.
            let moved = self.travel.moved(turned([0.0; 2], from.turns), turned([0.0; 2], to.turns));
            let disliked = self.travel.disliked_all_over(&block.bounds, to.turns);
            let rank =
                Rank { cost: cost + self.price(moved), disliked: from.rank.disliked + disliked };
            return rank.before(to.rank);
        }
        let moved = self.travel.least_moved([(&on.bounds, from.turns), (&block.bounds, to.turns)]);
        cost + self.price(moved) <= to.rank.cost + block.travel + TRAVEL_TIE
    }

    /// The same, cell by cell.
    fn run_cells(
        &mut self,
        index: usize,
        stretch: &Stretch,
        range: Range<usize>,
        states: &mut Vec<State>,
    ) -> Result<(), AxesError> {
        let cells = stretch.cells(range.clone(), self.marcher.options);
        for (inside, cell) in range.enumerate() {
            if let Some(joint) = stretch.joint(cell) {
                let mut fault = None;
                let fitting: Vec<_> = self.fitting(&cells, inside).collect();
                let mut broken =
                    self.breaks(stretch, (cell, &joint), (states, &fitting), &mut fault);
                states.retain(|state| {
                    let on = |(strand, turns): &(usize, [f64; 2])| {
                        *strand == state.strand && equal(*turns, state.turns)
                    };
                    fitting.iter().any(on)
                        && !stretch.is_torn(state.strand, cell)
                        && !broken.iter().any(|other| other.same(state))
                });
                self.enter(index, cell, &mut broken);
                states.append(&mut broken);
                if states.is_empty() {
                    return Err(fault.unwrap_or_else(|| self.outside(stretch)));
                }
            }
            for state in states.iter_mut() {
                let cell = cells.get(state.strand).and_then(|cells| cells.get(inside));
                state.rank.cost += cell.map_or(0.0, |cell| cell.travel);
            }
        }
        Ok(())
    }

    /// States that are best come to by a retract at a joint.
    fn breaks(
        &self,
        stretch: &Stretch,
        (cell, joint): (usize, &Joint),
        (states, fitting): (&[State], &[(usize, [f64; 2])]),
        fault: &mut Option<AxesError>,
    ) -> Vec<State> {
        let (Some(retractor), Some(best)) = (&self.retractor, cheapest(states)) else {
            return Vec::new();
        };
        let price = retractor.options.price(joint.inside);
        let mut found = Vec::new();
        for &(strand, turns) in fitting {
            let Some(of) = stretch.strands.get(strand) else { continue };
            let goes_on = states
                .iter()
                .find(|state| state.strand == strand && equal(state.turns, turns))
                .filter(|_| !of.is_torn(cell));
            let mut entered = State {
                strand,
                turns,
                rank: goes_on.map_or(Rank::NEVER, |on| on.rank),
                record: None,
            };
            if entered.rank.cost <= best.rank.cost + price {
                continue;
            }
            let to = turned(of.start_of(cell), turns);
            for origin in states {
                let Some(last) = stretch.strands.get(origin.strand) else { continue };
                let from = turned(last.end_before(cell), origin.turns);
                let moved = self.travel.moved(from, to);
                let rank = self.further(origin.rank, price + self.price(moved), to);
                if !rank.before(entered.rank) {
                    continue;
                }
                let pose = self.pose(last, cell);
                match retractor.check(joint.piece, &pose, [from, added(from, moved)]) {
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

    /// The pose at the start of a cell.
    fn pose(&self, strand: &Strand, cell: usize) -> ToolPose {
        self.marcher.inverse.kinematics().forward(&strand.axes_at(cell))
    }

    /// Weighted \[rad\].
    fn price(&self, moved: [f64; 2]) -> f64 {
        let [first, second] = self.marcher.options.rotary_weights;
        first * moved[0].abs() + second * moved[1].abs()
    }

    /// A link, if it stays inside travel.
    fn link(&self, link: &Link, rotaries: [[f64; 2]; 2]) -> Result<Marched, AxesError> {
        let marched =
            self.marcher.link(link.tips, rotaries).map_err(|trouble| trouble.of(link.piece))?;
        // The rotaries go straight between two positions inside travel.
        for (node, bounds) in marched.bounds().enumerate() {
            if !self.travel.slides_inside(&bounds)
                && let Some(worst) = self.travel.worst(&bounds, [0.0; 2])
            {
                let u = marched.nodes.get(node).map_or(0.0, |node| node.s);
                return Err(self.travel.fault((link.piece, node, u), &worst));
            }
        }
        Ok(marched)
    }

    /// Parts from first to last, with the ways to them.
    fn trace(
        &self,
        stretches: &[Stretch],
        links: &[Link],
        last: Option<usize>,
    ) -> Result<Vec<Part>, AxesError> {
        let mut records: Vec<Record> = Vec::new();
        let mut at = last;
        while let Some(record) = at.and_then(|at| self.records.get(at)) {
            records.push(*record);
            at = record.back;
        }
        records.reverse();
        let start = &self.marcher.options.start;
        let mut end = [start[FIRST_ROTARY], start[FIRST_ROTARY + 1]];
        let mut parts: Vec<Part> = Vec::with_capacity(records.len());
        for (index, record) in records.iter().enumerate() {
            let Some(stretch) = stretches.get(record.stretch) else { continue };
            let Some(strand) = stretch.strands.get(record.strand) else { continue };
            let next = records.get(index + 1).filter(|next| next.stretch == record.stretch);
            let cells = record.cell..next.map_or(stretch.count(), |next| next.cell);
            let own = strand.start_of(record.cell);
            let begin = added(end, self.travel.moved(end, turned(own, record.turns)));
            let link = record.stretch.checked_sub(1).and_then(|link| links.get(link));
            let way = match (record.cell, link) {
                (0, Some(link)) => Way::Link(self.link(link, [end, begin])?),
                (0, None) => Way::Start,
                (cell, _) => self.retract(stretch, cell, strand, [end, begin])?,
            };
            // Whole turns exactly, so that parts and links meet to the last bit of rounding.
            let offset = [0, 1].map(|axis| unwrap_near(own[axis], begin[axis]) - own[axis]);
            end = added(strand.end_before(cells.end), offset);
            let (stretch, strand) = (record.stretch, record.strand);
            parts.push(Part { way, stretch, strand, cells, offset });
        }
        Ok(parts)
    }

    fn retract(
        &self,
        stretch: &Stretch,
        cell: usize,
        strand: &Strand,
        rotaries: [[f64; 2]; 2],
    ) -> Result<Way, AxesError> {
        let (Some(retractor), Some(at)) = (&self.retractor, stretch.joint(cell)) else {
            return Ok(Way::Start);
        };
        let pose = self.pose(strand, cell);
        let legs = retractor.legs(at.piece, &pose, rotaries)?;
        Ok(Way::Retract { joint: at, pose, rotaries, legs })
    }
}

impl State {
    fn same(&self, other: &Self) -> bool {
        self.strand == other.strand && equal(self.turns, other.turns)
    }
}

/// Turns are whole numbers.
fn equal(a: [f64; 2], b: [f64; 2]) -> bool {
    a.map(f64::to_bits) == b.map(f64::to_bits)
}

/// Rotaries with whole turns added.
fn turned(rotaries: [f64; 2], turns: [f64; 2]) -> [f64; 2] {
    added(rotaries, turns.map(|turns| TAU * turns))
}

fn added([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a + c, b + d]
}

/// The first state that none is before.
fn cheapest(states: &[State]) -> Option<State> {
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
        let a = Rank { cost: 1.0, disliked: 1 };
        let b = Rank { cost: 1.0 + 1e-12, disliked: 0 };
        assert!(b.before(a) && !a.before(b));
        assert!(Rank { cost: 0.5, disliked: 2 }.before(b));
    }
}
