//! Branch and whole turns for the whole path, by dynamic programming.

use super::AxesError;
use super::march::{Extent, Marched, Marcher};
use super::stops::{Candidate, Link};
use crate::inverse::TRAVEL_TIE;
use crate::machine::{Axis, FIRST_ROTARY, Prefer, SECOND_ROTARY};
use crate::math::angle::{unwrap_near, wrap};
use crate::types::AXES;
use std::f64::consts::TAU;
use std::iter::successors;

/// Axis positions come from lengths up to 10^5 mm, so that they are rounded by up to 10^-11 mm a
/// step; what is beyond travel by less than this \[mm or rad\] is on its end.
const TRAVEL_ROUNDING: f64 = 1e-9;

/// What was chosen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chosen {
    /// One for each stop.
    pub(super) steps: Vec<Step>,
    /// One for each link.
    pub(super) links: Vec<Marched>,
    /// Weighted rotary travel \[rad\].
    pub(super) cost: f64,
}

/// A candidate and the whole turns added to its rotaries \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    pub(super) candidate: usize,
    pub(super) offset: [f64; 2],
}

/// A candidate with whole turns, and the cheapest way to it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct State {
    step: Step,
    rank: Rank,
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
    stops: &[Vec<Candidate>],
    links: &[Link],
) -> Result<Chosen, AxesError> {
    let planner = Planner { marcher, axes: &marcher.inverse.kinematics().machine().axes };
    let mut columns: Vec<Vec<State>> = Vec::with_capacity(stops.len());
    for (index, candidates) in stops.iter().enumerate() {
        let mut states = planner.states(candidates)?;
        match (columns.last(), index.checked_sub(1).and_then(|link| links.get(link))) {
            (Some(before), Some(link)) => {
                let from = stops.get(index - 1).map_or(&[][..], Vec::as_slice);
                planner.join(link, (from, before), (candidates, &mut states))?;
            }
            _ => planner.begin(candidates, &mut states),
        }
        columns.push(states);
    }
    planner.trace(stops, links, &columns)
}

struct Planner<'a> {
    marcher: &'a Marcher<'a>,
    axes: &'a [Axis; AXES],
}

impl Planner<'_> {
    /// Every candidate at every turn inside travel.
    fn states(&self, candidates: &[Candidate]) -> Result<Vec<State>, AxesError> {
        let mut states = Vec::new();
        for (index, candidate) in candidates.iter().enumerate() {
            let extent = whole(candidate);
            let linear_inside = (0..FIRST_ROTARY)
                .all(|axis| self.beyond(axis, &extent[axis], 0.0) <= TRAVEL_ROUNDING);
            if !linear_inside {
                continue;
            }
            let turns = [FIRST_ROTARY, SECOND_ROTARY].map(|axis| self.turns(axis, &extent[axis]));
            let [first, second] = &turns;
            for &first in first {
                for &second in second {
                    let step = Step { candidate: index, offset: [first, second] };
                    states.push(State { step, rank: Rank::NEVER, back: None });
                }
            }
        }
        if states.is_empty() { Err(self.outside(candidates)) } else { Ok(states) }
    }

    /// Whole turns that keep a rotary inside travel \[rad\]; one for an axis without ends, whose
    /// turn follows from where it comes from.
    fn turns(&self, axis: usize, extent: &Extent) -> Vec<f64> {
        let [low, high] = self.limits(axis);
        if !(low.is_finite() && high.is_finite()) {
            return vec![0.0];
        }
        let last = ((high + TRAVEL_ROUNDING - extent.high) / TAU).floor();
        let until = |turn: f64| (turn <= last).then_some(turn);
        let first = until(((low - TRAVEL_ROUNDING - extent.low) / TAU).ceil());
        successors(first, |turn| until(turn + 1.0)).map(|turn| turn * TAU).collect()
    }

    fn limits(&self, axis: usize) -> [f64; 2] {
        self.axes.get(axis).map_or([0.0; 2], |axis| axis.limits)
    }

    /// How far an axis is beyond its travel; not positive inside.
    fn beyond(&self, axis: usize, extent: &Extent, offset: f64) -> f64 {
        let [low, high] = self.limits(axis);
        (low - extent.low - offset).max(extent.high + offset - high)
    }

    /// The first stop, from where the rotaries stand before the path.
    fn begin(&self, candidates: &[Candidate], states: &mut [State]) {
        let start = &self.marcher.options.start;
        let from = [start[FIRST_ROTARY], start[SECOND_ROTARY]];
        for state in states {
            let Some(candidate) = candidates.get(state.step.candidate) else { continue };
            let cost = self.price(self.move_to(from, candidate, state.step));
            state.rank = self.rank(0.0, cost, candidate, state.step);
        }
    }

    /// The next stop, over a link.
    fn join(
        &self,
        link: &Link,
        (from, before): (&[Candidate], &[State]),
        (candidates, states): (&[Candidate], &mut Vec<State>),
    ) -> Result<(), AxesError> {
        let mut fault = None;
        for state in states.iter_mut() {
            let Some(candidate) = candidates.get(state.step.candidate) else { continue };
            for (back, origin) in before.iter().enumerate() {
                let Some(last) = from.get(origin.step.candidate) else { continue };
                let end = added(last.end, origin.step.offset);
                let moved = self.move_to(end, candidate, state.step);
                let cost = self.price(moved);
                let mut rank = self.rank(origin.rank.cost, cost, candidate, state.step);
                rank.disliked += origin.rank.disliked;
                if !rank.before(state.rank) {
                    continue;
                }
                match self.link(link, [end, added(end, moved)]) {
                    Ok(_) => (state.rank, state.back) = (rank, Some(back)),
                    Err(error) => fault = fault.or(Some(error)),
                }
            }
        }
        states.retain(|state| state.rank.cost.is_finite());
        let nothing = || self.outside(candidates);
        if states.is_empty() { Err(fault.unwrap_or_else(nothing)) } else { Ok(()) }
    }

    /// Rotary moves from `from` to the start of a candidate \[rad\].
    fn move_to(&self, from: [f64; 2], candidate: &Candidate, step: Step) -> [f64; 2] {
        let to = added(candidate.start, step.offset);
        [0, 1].map(|axis| {
            let turn = to[axis] - from[axis];
            let [low, high] = self.limits(FIRST_ROTARY + axis);
            if low.is_finite() && high.is_finite() { turn } else { wrap(turn) }
        })
    }

    /// Weighted \[rad\].
    fn price(&self, moved: [f64; 2]) -> f64 {
        let [first, second] = self.marcher.options.rotary_weights;
        first * moved[0].abs() + second * moved[1].abs()
    }

    fn rank(&self, before: f64, link: f64, candidate: &Candidate, step: Step) -> Rank {
        let at = added(candidate.start, step.offset);
        let wrong = |(axis, value): (&Axis, f64)| match axis.prefer {
            Some(Prefer::Positive) => value < 0.0,
            Some(Prefer::Negative) => value >= 0.0,
            None => false,
        };
        let disliked =
            self.axes.iter().skip(FIRST_ROTARY).zip(at).filter(|pair| wrong(*pair)).count();
        Rank { cost: before + link + candidate.travel, disliked }
    }

    /// A link, if it stays inside travel.
    fn link(&self, link: &Link, rotaries: [[f64; 2]; 2]) -> Result<Marched, AxesError> {
        let marched =
            self.marcher.link(link.tips, rotaries).map_err(|trouble| trouble.of(link.piece))?;
        // The rotaries go straight between two positions inside travel.
        let worst = self.worst(&marched.extent, [0.0; 2]).filter(|worst| worst.axis < FIRST_ROTARY);
        match worst {
            Some(worst) => {
                let u = marched.nodes.get(worst.node).map_or(0.0, |node| node.s);
                Err(self.fault(link.piece, u, &worst))
            }
            None => Ok(marched),
        }
    }

    /// Offsets from first to last stop, and the links between.
    fn trace(
        &self,
        stops: &[Vec<Candidate>],
        links: &[Link],
        columns: &[Vec<State>],
    ) -> Result<Chosen, AxesError> {
        let mut at = columns.last().and_then(|states| cheapest(states));
        let cost = at.and_then(|at| columns.last()?.get(at)).map_or(0.0, |state| state.rank.cost);
        let mut steps = Vec::with_capacity(columns.len());
        for states in columns.iter().rev() {
            let Some(state) = at.and_then(|at| states.get(at)) else { break };
            steps.push(state.step);
            at = state.back;
        }
        steps.reverse();
        let start = &self.marcher.options.start;
        let mut end = [start[FIRST_ROTARY], start[SECOND_ROTARY]];
        let mut marched = Vec::with_capacity(links.len());
        for (index, (step, candidates)) in steps.iter_mut().zip(stops).enumerate() {
            let Some(candidate) = candidates.get(step.candidate) else { continue };
            let begin = added(end, self.move_to(end, candidate, *step));
            if let Some(link) = index.checked_sub(1).and_then(|before| links.get(before)) {
                marched.push(self.link(link, [end, begin])?);
            }
            // Whole turns exactly, so that pieces and links meet to the last bit of rounding.
            step.offset = [0, 1].map(|axis| {
                unwrap_near(candidate.start[axis], begin[axis]) - candidate.start[axis]
            });
            end = added(candidate.end, step.offset);
        }
        Ok(Chosen { steps, links: marched, cost })
    }

    /// The way out of travel that is least bad.
    fn outside(&self, candidates: &[Candidate]) -> AxesError {
        let mut best: Option<(usize, f64, Beyond)> = None;
        for candidate in candidates {
            let extent = whole(candidate);
            let offset =
                [FIRST_ROTARY, SECOND_ROTARY].map(|axis| self.least_turn(axis, &extent[axis]));
            let worst =
                candidate.extents.iter().enumerate().filter_map(|(index, (piece, extent))| {
                    let worst = self.worst(extent, offset)?;
                    let nodes = candidate.pieces.get(index).map_or(&[][..], |piece| &piece.nodes);
                    Some((*piece, nodes.get(worst.node).map_or(0.0, |node| node.s), worst))
                });
            let worst = worst.max_by(|a, b| a.2.excess.total_cmp(&b.2.excess));
            if let Some(worst) = worst
                && best.as_ref().is_none_or(|best| worst.2.excess < best.2.excess)
            {
                best = Some(worst);
            }
        }
        let (piece, u, beyond) = best.unwrap_or_default();
        self.fault(piece, u, &beyond)
    }

    /// The whole turns that leave a rotary least outside.
    fn least_turn(&self, axis: usize, extent: &Extent) -> f64 {
        let [low, high] = self.limits(axis);
        if !(low.is_finite() && high.is_finite()) {
            return 0.0;
        }
        let middle = 0.5 * (extent.low + extent.high);
        unwrap_near(middle, 0.5 * (low + high)) - middle
    }

    /// The axis farthest beyond its travel.
    fn worst(&self, extents: &[Extent; AXES], offset: [f64; 2]) -> Option<Beyond> {
        let all = extents.iter().enumerate().map(|(axis, extent)| {
            let offset = axis.checked_sub(FIRST_ROTARY).and_then(|at| offset.get(at)).copied();
            let offset = offset.unwrap_or(0.0);
            let [low, high] = self.limits(axis);
            let [below, above] = [low - extent.low - offset, extent.high + offset - high];
            if below > above {
                let value = extent.low + offset;
                Beyond { axis, value, limit: low, excess: below, node: extent.low_at }
            } else {
                let value = extent.high + offset;
                Beyond { axis, value, limit: high, excess: above, node: extent.high_at }
            }
        });
        all.filter(|one| one.excess > TRAVEL_ROUNDING).max_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    fn fault(&self, piece: usize, u: f64, beyond: &Beyond) -> AxesError {
        let Beyond { axis, value, limit, excess, node } = *beyond;
        let name = self.axes.get(axis).map_or_else(String::new, |axis| axis.name.clone());
        let remedy = if axis < FIRST_ROTARY {
            let way = if value > limit { "down" } else { "up" };
            format!(
                "move the workpiece origin so that {name} comes {way} by {excess:.3} mm, or turn the setup"
            )
        } else {
            format!("turn the setup, or split the path so that {name} can unwind on a link")
        };
        AxesError::OutOfTravel { piece, node, u, axis: name, value, limit, excess, remedy }
    }
}

/// An axis beyond its travel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Beyond {
    axis: usize,
    value: f64,
    limit: f64,
    excess: f64,
    node: usize,
}

/// How far the axes go on all pieces together.
fn whole(candidate: &Candidate) -> [Extent; AXES] {
    let mut all = [Extent::NONE; AXES];
    for (_, extents) in &candidate.extents {
        for (all, extent) in all.iter_mut().zip(extents) {
            all.include(extent.low, extent.low_at);
            all.include(extent.high, extent.high_at);
        }
    }
    all
}

fn added([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a + c, b + d]
}

/// The first state that none is before.
fn cheapest(states: &[State]) -> Option<usize> {
    let mut best: Option<(usize, Rank)> = None;
    for (index, state) in states.iter().enumerate() {
        if best.is_none_or(|(_, rank)| state.rank.before(rank)) {
            best = Some((index, state.rank));
        }
    }
    best.map(|(index, _)| index)
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
