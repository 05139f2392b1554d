//! Distances of the machine's bodies from stock, as it is cut so far.
//!
//! Stock only shrinks, so the stock before a move holds what is there during that move and all moves behind it. The search goes
//! forward with one state of the stock. Where a move comes too near, the program is cut up to that move, and the move
//! is judged again.

use super::linked::{LinkedBody, WORKPIECE, placed};
use super::pair::BodyPair;
use super::search::{self, PairApproach, PairGoal};
use super::spans::MoveSpans;
use crate::machine::Machine;
use crate::verify::error::VerifyError;
use crate::verify::replay::controls::Controls;
use crate::verify::replay::segment::Segment;
use crate::verify::stock::partly_cut::PartlyCutStock;
use nalgebra::Isometry3;
use std::ops::Range;

/// Moves that are searched at once where some come too near.
const CHUNK: usize = 128;

/// States that are exact at their move; so many more are twice as far apart, and so on, so that their number stays small.
const EXACT_STATES: u32 = 64;

/// Moves of a batch, with the place of each in the program: rapids run in two ways.
pub(super) struct PlacedMoves {
    pub(super) segments: Vec<Segment>,
    pub(super) places: Vec<usize>,
}

/// Approach of a body of the machine to the stock.
pub(super) struct StockApproach<'a> {
    pub(super) body: &'a LinkedBody,
    pub(super) approach: PairApproach,
}

/// Stock between the bodies of a machine.
pub(super) struct StockWatch<'a> {
    machine: &'a Machine,
    bodies: Vec<&'a LinkedBody>,
    uncut: &'a LinkedBody,
    place: Isometry3<f64>,
    material: PartlyCutStock<'a>,
    /// State that bodies are compared with.
    state: StockState,
    /// Number of states so far.
    states: u32,
}

enum StockState {
    Uncut,
    Cut(LinkedBody),
    /// Nothing is left.
    Gone,
}

/// Stock on the workpiece, and the bodies that may meet it.
pub(super) struct StockScene<'a> {
    pub(super) machine: &'a Machine,
    pub(super) bodies: Vec<&'a LinkedBody>,
    /// All of the stock, on the workpiece.
    pub(super) uncut: &'a LinkedBody,
    /// Place of the workpiece in the machine frame.
    pub(super) place: Isometry3<f64>,
}

impl<'a> StockWatch<'a> {
    pub(super) fn new(scene: StockScene<'a>, material: PartlyCutStock<'a>) -> Self {
        let StockScene { machine, bodies, uncut, place } = scene;
        Self { machine, bodies, uncut, place, material, state: StockState::Uncut, states: 0 }
    }

    /// Returns all pairs with the uncut stock.
    pub(super) fn pairs(&self) -> impl Iterator<Item = BodyPair<'a>> {
        self.bodies.iter().map(|body| BodyPair::new(self.machine, [self.uncut, body]))
    }

    /// Finds approaches below the goal in a batch: each below the reported distance is one to the stock before its move.
    pub(super) fn search(
        &mut self,
        controls: &Controls,
        moves: &PlacedMoves,
        goal: PairGoal,
    ) -> Result<Vec<StockApproach<'a>>, VerifyError> {
        let part = |range: Range<usize>| {
            let segments = moves.segments.get(range).unwrap_or_default().to_vec();
            MoveSpans::new(controls, segments)
        };
        let is_near = |one: &&StockApproach<'_>| one.approach.distance < goal.reported;
        let count = moves.segments.len();
        let all = self.approaches(&part(0..count), goal)?;
        if !all.iter().any(|one| is_near(&one)) {
            return Ok(all);
        }
        let (mut found, mut from) = (Vec::new(), 0);
        while from < count {
            let to = (from + CHUNK).min(count);
            let near = self.approaches(&part(from..to), goal)?;
            let first = near.iter().filter(is_near).map(|one| from + one.approach.first).min();
            let Some(first) = first else {
                found.extend(near);
                from = to;
                continue;
            };
            found.extend(self.approaches(&part(from..first), goal)?);
            let spans = part(first..first + 1);
            let mut exact = self.bounded(&spans, goal)?;
            if exact.iter().any(|one| is_near(&one))
                && let Some(place) = moves.places.get(first)
                && self.cut_up_to(*place)?
            {
                exact = self.bounded(&spans, goal)?;
            }
            found.extend(exact);
            from = first + 1;
        }
        Ok(found)
    }

    /// Finds approaches to the present state.
    fn approaches(
        &self,
        spans: &MoveSpans<'_>,
        goal: PairGoal,
    ) -> Result<Vec<StockApproach<'a>>, VerifyError> {
        let stock = match &self.state {
            StockState::Uncut => self.uncut,
            StockState::Cut(body) => body,
            StockState::Gone => return Ok(Vec::new()),
        };
        let mut found = Vec::new();
        for body in &self.bodies {
            let pair = BodyPair::new(self.machine, [stock, body]);
            let near = search::nearest(&pair, spans, goal)?;
            found.extend(near.into_iter().map(|approach| StockApproach { body, approach }));
        }
        Ok(found)
    }

    /// Finds approaches to the present state on one move. What is left of the stock is within the uncut stock, whose surface
    /// is known exactly: both distances are bounds.
    fn bounded(
        &self,
        spans: &MoveSpans<'_>,
        goal: PairGoal,
    ) -> Result<Vec<StockApproach<'a>>, VerifyError> {
        let mut found = self.approaches(spans, goal)?;
        if matches!(self.state, StockState::Uncut) {
            return Ok(found);
        }
        for body in &self.bodies {
            let mut own: Vec<&mut PairApproach> = found
                .iter_mut()
                .filter(|one| std::ptr::eq(one.body, *body))
                .map(|one| &mut one.approach)
                .collect();
            if own.is_empty() {
                continue;
            }
            let pair = BodyPair::new(self.machine, [self.uncut, body]);
            if spans.samples(1).any(|q| pair.is_inside(q)) {
                continue;
            }
            // Without an approach below the goal the body stays off by that.
            let least = goal.reported.max(goal.least);
            let outside = search::nearest(&pair, spans, goal)?;
            let outside = outside.iter().map(|one| one.distance).fold(least, f64::min);
            for one in &mut own {
                one.distance = one.distance.max(outside);
            }
        }
        Ok(found)
    }

    /// Cuts with all moves before one; `false` if the present state stays.
    fn cut_up_to(&mut self, place: usize) -> Result<bool, VerifyError> {
        let doublings = self.states / EXACT_STATES;
        let apart = 1_usize.checked_shl(doublings).unwrap_or(usize::MAX);
        if place < self.material.done().saturating_add(apart) {
            return Ok(false);
        }
        self.material.cut_up_to(place)?;
        self.states += 1;
        let surface = self.material.surface();
        let mesh = placed(&surface.mesh, &self.place);
        let name = self.uncut.name.clone();
        let body = LinkedBody::new(name, WORKPIECE, mesh, surface.allowance);
        self.state = body.map_or(StockState::Gone, StockState::Cut);
        Ok(true)
    }
}
