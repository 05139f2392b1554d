//! A polyline that arrives leg by leg becomes a smooth path, with its corners rounded within their tolerances.
//!
//! Every corner has a kernel (`kernel`) of its own half width. Where kernels overlap their roundings add up, so short
//! legs of a smooth curve become that curve again: the kernels reach over many of them.

use super::block::{BlockKind, BlockStart};
use super::kernel::{bending, rounding};
use super::leg::{Leg, LetterVector, triples};
use std::collections::VecDeque;

/// Largest half width of a kernel \[mm\]: a path must be known three times as far ahead.
pub(super) const WIDEST: f64 = 2.0;

/// Largest distance between two nodes \[mm\].
const LARGEST_STEP: f64 = 4.0;

/// Largest turn of the rotaries between two nodes \[rad\]: the axes move on curves there.
const LARGEST_TURN: f64 = 0.035;

/// Nodes over the half width of a kernel.
const NODES: f64 = 6.0;

/// Smallest distance between two nodes \[mm\]. Positions are rounded to 1e-13 of a metre, and over this distance a third
/// derivative by 0.1 1/mm2 then.
const SMALLEST_STEP: f64 = 1e-3;

/// A place that stands out gets a node unless another one is nearer than this share of a step.
const NEAR: f64 = 0.3;

/// A kernel is in a crowd where others ask for steps as fine as this multiple of its own.
const CROWD: f64 = 2.0;

/// A leg as long as this many steps begins at a node: the number of its block is in time.
const LONG: f64 = 4.0;

/// Share of a tolerance that roundings use; the rest is for the quintics between nodes.
pub(super) const USED: f64 = 0.95;

/// Change of direction that is none: rounding of positions.
const STRAIGHT: f64 = 1e-9;

/// Distance before a change of speed at which the old speed still holds \[mm\].
const SPEED_STEP: f64 = 0.02;

/// Largest value of the kernel of a bend: at 1/4.
const LARGEST_BEND: f64 = 27.0 / 3072.0;

/// Halvings of the range of a width.
const HALVINGS: u32 = 10;

/// Corners on either side that a kernel reaches at most.
const MANY: usize = 64;

/// Rounds in which widths are made smaller together.
const ROUNDS: u32 = 40;

/// Largest deviations at a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CornerTolerance {
    /// Of X Y Z, and of U V W \[mm\].
    pub(super) tip: f64,
    /// Of A B C \[rad\].
    pub(super) axis: f64,
}

impl CornerTolerance {
    /// Returns a deviation as a share of the tolerance.
    pub(super) fn share(&self, deviation: &LetterVector) -> f64 {
        let [xyz, abc, uvw] = triples(deviation).map(|triple| triple.norm());
        (xyz / self.tip).max(abc / self.axis).max(uvw / self.tip)
    }

    /// Returns the smaller tolerance of both.
    pub(super) fn min(self, other: Self) -> Self {
        Self { tip: self.tip.min(other.tip), axis: self.axis.min(other.axis) }
    }
}

#[derive(Debug, Clone)]
struct Corner {
    at: f64,
    /// Change of direction, and of curvature.
    turn: LetterVector,
    bend: LetterVector,
    tolerance: CornerTolerance,
    /// Half width of its kernel, once it was chosen.
    width: f64,
}

impl Corner {
    /// Returns the step that a kernel of half width `w` adds to the path at `s`, with derivatives.
    fn at(&self, s: f64, w: f64) -> [LetterVector; 4] {
        // At a corner the leg behind it counts, and so do the jumps behind it.
        let u =
            ((s - self.at) / w).abs().max(f64::MIN_POSITIVE) * if s < self.at { -1.0 } else { 1.0 };
        let [turn, bend] = [rounding(u), bending(u)];
        let mut scale = w;
        std::array::from_fn(|order| {
            let part = self.turn * (turn[order] * scale) + self.bend * (bend[order] * scale * w);
            scale /= w;
            part
        })
    }

    /// Returns that step without derivatives.
    fn deviation(&self, s: f64, w: f64) -> LetterVector {
        let u = (s - self.at) / w;
        self.turn * (rounding(u)[0] * w) + self.bend * (bending(u)[0] * w * w)
    }

    /// Bound on what it adds at `s`, as a share of a tolerance.
    fn share(&self, s: f64, w: f64, tolerance: &CornerTolerance) -> f64 {
        let u = (s - self.at) / w;
        if u.abs() >= 1.0 {
            return 0.0;
        }
        tolerance.share(&(self.turn * (rounding(u)[0] * w)))
            + tolerance.share(&(self.bend * (LARGEST_BEND * w * w)))
    }
}

/// A place of the smooth path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PathNode {
    pub(super) s: f64,
    /// Letters and their derivatives by `s`.
    pub(super) letters: [LetterVector; 4],
    /// Seconds per length of a feed and of a rapid move.
    pub(super) rates: [f64; 2],
    /// Block that begins or is run here.
    pub(super) block: u32,
}

#[derive(Debug, Clone)]
struct PlacedLeg {
    from: f64,
    leg: Leg,
    /// Speed at its start, and the largest one on it, where it has a time of its own.
    enters: f64,
    peak: f64,
}

impl PlacedLeg {
    fn end(&self) -> f64 {
        self.from + self.leg.length
    }

    /// Notes the speed at its end.
    fn leave(&mut self, speed: f64) {
        let Leg { length, pace, .. } = &self.leg;
        self.peak = pace.peak(*length, length * self.leg.rate(), [self.enters, speed]);
    }
}

/// Returns the speed where two legs meet, as their times have it: with the same acceleration on either side of the corner,
/// which the corner may not allow.
fn border_speed(before: &Leg, behind: &Leg) -> f64 {
    let [long, short] = [before, behind].map(|leg| leg.length * leg.rate());
    let speeds = [before, behind].map(|leg| 1.0 / leg.rate());
    let even = (speeds[0] * short + speeds[1] * long) / (long + short);
    even.min(behind.pace.enters)
}

/// Changes of direction and curvature from the end of a leg to the start of the next one.
fn turn_between(before: &Leg, behind: &Leg) -> [LetterVector; 2] {
    let [before, behind] = [before.at(before.length), behind.at(0.0)];
    [1, 2].map(|order: usize| behind[order] - before[order])
}

/// The leg, if it is a timed one.
fn timed(leg: Option<&PlacedLeg>) -> Option<&Leg> {
    leg.map(|placed| &placed.leg).filter(|leg| leg.kind == BlockKind::Timed)
}

/// Seconds per length at a place of a timed leg: linear from its middle to an end beside a faster leg.
fn timed_rate(leg: &Leg, beside: [Option<&Leg>; 2], share: f64) -> f64 {
    let own = leg.rates[0];
    let border = |other: &Leg| {
        (own * other.length + other.rates[0] * leg.length) / (leg.length + other.length)
    };
    let [start, end] = beside.map(|other| other.map_or(own, border).min(own));
    if share < 0.5 {
        start + (own - start) * 2.0 * share
    } else {
        own + (end - own) * (2.0 * share - 1.0)
    }
}

/// The smooth path of one run, from rest to rest.
#[derive(Debug, Clone, Default)]
pub(super) struct RoundedPath {
    legs: VecDeque<PlacedLeg>,
    corners: VecDeque<Corner>,
    /// Corners whose widths are tried, and those that are settled.
    chosen: usize,
    settled: usize,
    length: f64,
    ended: bool,
    /// Last node.
    node: Option<f64>,
    /// Largest half width of all kernels.
    reach: f64,
}

impl RoundedPath {
    /// Appends a leg; `tolerance` is that of the corner where it begins.
    pub(super) fn push(&mut self, leg: &Leg, tolerance: CornerTolerance) {
        if let Some(PlacedLeg { leg: last, .. }) = self.legs.back() {
            let [turn, bend] = turn_between(last, leg);
            if turn.amax() > STRAIGHT || bend.amax() > STRAIGHT {
                let at = self.length;
                self.corners.push_back(Corner { at, turn, bend, tolerance, width: 0.0 });
            }
        }
        let enters = self.legs.back().map_or(0.0, |last| border_speed(&last.leg, leg));
        if let Some(last) = self.legs.back_mut() {
            last.leave(enters);
        }
        let mut placed = PlacedLeg { from: self.length, leg: *leg, enters, peak: 0.0 };
        // Until it is known what follows it goes on as it is.
        placed.leave(f64::INFINITY);
        self.legs.push_back(placed);
        self.length += leg.length;
    }

    /// Ends the path where the last leg ends.
    pub(super) fn end(&mut self) {
        self.ended = true;
        if let Some(last) = self.legs.back_mut() {
            last.leave(0.0);
        }
    }

    pub(super) fn is_ended(&self) -> bool {
        self.ended
    }

    /// True if the last node was returned.
    pub(super) fn is_finished(&self) -> bool {
        let all = self.node.is_some_and(|node| node >= self.length);
        self.ended && (self.legs.is_empty() || all)
    }

    /// Returns the last leg.
    pub(super) fn last(&self) -> Option<&Leg> {
        self.legs.back().map(|last| &last.leg)
    }

    /// Returns the direction at the end of the last leg.
    pub(super) fn direction(&self) -> Option<LetterVector> {
        self.legs.back().map(|last| last.leg.at(last.leg.length)[1])
    }

    /// Returns the length that nodes have not passed.
    pub(super) fn ahead(&self) -> f64 {
        self.length - self.node.unwrap_or(0.0)
    }

    /// Returns the number of legs that nodes have not passed.
    pub(super) fn waiting(&self) -> usize {
        self.legs.len()
    }

    /// Returns the next node; `None` while the path ahead is not known well enough, and at the end.
    pub(super) fn next_node(&mut self) -> Option<PathNode> {
        self.settle();
        let s = self.next_place()?;
        let settled = self.settled_to();
        if s > settled {
            return None;
        }
        self.node = Some(s);
        let node = self.node_at(s)?;
        self.forget(s - 2.0 * WIDEST);
        Some(node)
    }

    /// Place up to which no corner will change any more.
    fn settled_to(&self) -> f64 {
        match self.corners.get(self.settled) {
            Some(corner) => corner.at - WIDEST,
            None if self.ended => self.length,
            None => self.length - WIDEST,
        }
    }

    /// Place up to which the path is known, as far as corners ask.
    fn known(&self) -> f64 {
        if self.ended { f64::INFINITY } else { self.length }
    }

    /// Chooses and settles the widths of corners that enough is known of.
    fn settle(&mut self) {
        let known = self.known();
        self.reach = self.corners.iter().map(|corner| corner.width).fold(0.0, f64::max);
        while let Some(corner) = self.corners.get(self.chosen) {
            if corner.at + WIDEST > known {
                break;
            }
            let width = self.widest(self.chosen);
            if let Some(corner) = self.corners.get_mut(self.chosen) {
                corner.width = width;
            }
            self.reach = self.reach.max(width);
            self.chosen += 1;
        }
        while self.settled < self.chosen {
            let Some(corner) = self.corners.get(self.settled) else { break };
            if corner.at + 2.0 * WIDEST > known {
                break;
            }
            let to = corner.at + corner.width;
            self.shrink(self.settled, to);
            self.settled += 1;
        }
    }

    /// Returns the largest half width of a corner's kernel, if all corners near it had the same.
    fn widest(&self, index: usize) -> f64 {
        let Some(corner) = self.corners.get(index) else { return 0.0 };
        let end = if self.ended { self.length - corner.at } else { f64::INFINITY };
        // A kernel over very many legs is no better than one over many.
        let neighbours = [index.checked_sub(MANY), index.checked_add(MANY)];
        let far = neighbours.into_iter().flatten().filter_map(|other| self.corners.get(other));
        let crowd = far.map(|other| (other.at - corner.at).abs()).fold(f64::INFINITY, f64::min);
        let most = WIDEST.min(corner.at).min(end).min(crowd);
        let share = |width: f64| {
            let near = self.near(corner.at, width);
            // Corners that cancel out would not, were one of them to become narrower.
            near.map(|other| other.share(corner.at, width, &corner.tolerance)).sum::<f64>()
        };
        if share(most) <= USED {
            return most;
        }
        let [mut low, mut high] = [0.0, most];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if share(middle) <= USED { low = middle } else { high = middle }
        }
        if low > 0.0 { low } else { high * (USED / share(high)).min(1.0) }
    }

    /// Makes kernels from `first` on smaller until the path keeps its tolerances at the corners and between them, up to
    /// `to`.
    fn shrink(&mut self, first: usize, to: f64) {
        let Some(from) = self.corners.get(first).map(|corner| corner.at - corner.width) else {
            return;
        };
        let places: Vec<(f64, CornerTolerance)> = self.places(from, to);
        for _ in 0..ROUNDS {
            let mut kept = true;
            for (s, tolerance) in &places {
                let share = tolerance.share(&self.deviation(*s));
                if share > USED {
                    kept = false;
                    self.scale(first, *s, 0.97 * (USED / share).max(0.25));
                }
            }
            if kept {
                return;
            }
        }
    }

    /// Corners in a stretch and places between them, with their tolerances.
    fn places(&self, from: f64, to: f64) -> Vec<(f64, CornerTolerance)> {
        let mut places = Vec::new();
        let mut last: Option<&Corner> = None;
        for corner in self.corners.iter().filter(|corner| (from..=to).contains(&corner.at)) {
            if let Some(last) = last {
                let tolerance = last.tolerance.min(corner.tolerance);
                let between =
                    [0.25, 0.5, 0.75].map(|share| last.at + share * (corner.at - last.at));
                places.extend(between.map(|s| (s, tolerance)));
            }
            places.push((corner.at, corner.tolerance));
            last = Some(corner);
        }
        places
    }

    /// Scales the widths of the kernels from `first` on that reach `s`.
    fn scale(&mut self, first: usize, s: f64, factor: f64) {
        for corner in self.corners.iter_mut().skip(first).take(self.chosen - first) {
            if (corner.at - s).abs() < corner.width {
                corner.width *= factor;
            }
        }
    }

    /// Corners within `width` of `s`.
    fn near(&self, s: f64, width: f64) -> impl Iterator<Item = &Corner> {
        let first = self.corners.partition_point(|corner| corner.at <= s - width);
        self.corners.range(first..).take_while(move |corner| corner.at < s + width)
    }

    /// Returns the deviation from the polyline at `s`.
    fn deviation(&self, s: f64) -> LetterVector {
        let near = self.near(s, self.reach).filter(|corner| corner.width > 0.0);
        near.fold(LetterVector::zeros(), |sum, corner| sum + corner.deviation(s, corner.width))
    }

    /// Returns the leg that begins at `s` or holds it.
    fn leg_at(&self, s: f64) -> usize {
        let after = self.legs.partition_point(|leg| leg.from <= s);
        after.saturating_sub(1)
    }

    /// Returns the place of the next node.
    fn next_place(&self) -> Option<f64> {
        let Some(last) = self.node else { return (!self.legs.is_empty()).then_some(0.0) };
        if last >= self.length {
            return None;
        }
        let mut step = LARGEST_STEP;
        let legs = self.legs.range(self.leg_at(last)..);
        if let Some(leg) = legs.clone().next() {
            let turn = triples(&leg.leg.at(0.0)[1])[1].norm();
            step = step.min(LARGEST_TURN / turn.max(f64::MIN_POSITIVE)).min(leg.leg.largest_step());
        }
        for corner in self.near(last, LARGEST_STEP + WIDEST).filter(|corner| corner.width > 0.0) {
            let begin = corner.at - corner.width;
            if begin >= last + step || corner.at + corner.width <= last {
                continue;
            }
            // Before a kernel that is narrow beside the step it begins with a node; in a crowd of kernels it need not.
            let own = (corner.width / NODES).max(SMALLEST_STEP);
            let alone = step > CROWD * own && begin > last + NEAR * own;
            step = if alone { begin - last } else { step.min(own) };
        }
        for leg in legs.skip(1) {
            if leg.from >= last + step {
                break;
            }
            step = self.step_to(last, step, leg);
        }
        let left = self.length - last;
        let s = if left <= step + SMALLEST_STEP {
            self.length
        } else if left < 2.0 * step {
            last + 0.5 * left
        } else {
            last + step
        };
        (s > last).then_some(s)
    }

    /// Returns the step to the beginning of a leg ahead, or the whole step where it needs no node.
    fn step_to(&self, last: f64, step: f64, leg: &PlacedLeg) -> f64 {
        let distance = leg.from - last;
        if distance < SMALLEST_STEP {
            return step;
        }
        let before = self.legs.get(self.leg_at(leg.from).saturating_sub(1));
        let timed = leg.leg.kind == BlockKind::Timed;
        let bits = |leg: &Leg| leg.rates.map(f64::to_bits);
        let changes = !timed && before.is_some_and(|before| bits(&before.leg) != bits(&leg.leg));
        // Of short legs the number of the block comes late by less than a step.
        let marked = leg.leg.begins == BlockStart::Marked || leg.leg.length > LONG * step;
        if changes && distance > 2.0 * SPEED_STEP {
            return step.min(distance - SPEED_STEP).max(SMALLEST_STEP);
        }
        if changes || marked { step.min(distance) } else { step }
    }

    /// Returns the path at `s`.
    fn node_at(&self, s: f64) -> Option<PathNode> {
        let index = self.leg_at(s);
        let PlacedLeg { from, leg, .. } = self.legs.get(index)?;
        let mut letters = leg.at(s - from);
        for corner in self.near(s, self.reach).filter(|corner| corner.width > 0.0) {
            for (letter, part) in letters.iter_mut().zip(corner.at(s, corner.width)) {
                *letter += part;
            }
        }
        let rates = self.rates_at(s, index)?;
        // A leg that begins so soon has no node of its own.
        let block = self.legs.get(self.leg_at(s + SMALLEST_STEP))?.leg.block;
        Some(PathNode { s, letters, rates, block })
    }

    /// Returns the seconds per length of a feed and of a rapid move at `s` in a leg.
    fn rates_at(&self, s: f64, index: usize) -> Option<[f64; 2]> {
        let PlacedLeg { from, leg, peak, .. } = self.legs.get(index)?;
        let before = index.checked_sub(1).and_then(|before| self.legs.get(before));
        if leg.kind == BlockKind::Timed {
            let share = (s - from) / leg.length;
            let beside = [before, self.legs.get(index + 1)].map(timed);
            return Some([timed_rate(leg, beside, share).min(1.0 / peak), 0.0]);
        }
        // Where the speed changes the lower one holds.
        let changes = before.filter(|before| s <= *from && before.leg.kind != BlockKind::Timed);
        Some(changes.map_or(leg.rates, |before| {
            [0, 1].map(|kind| leg.rates[kind].max(before.leg.rates[kind]))
        }))
    }

    /// Forgets legs and corners before `s`.
    fn forget(&mut self, s: f64) {
        while self.legs.len() > 1 && self.legs.front().is_some_and(|leg| leg.end() < s) {
            self.legs.pop_front();
        }
        while self.settled > 0 && self.corners.front().is_some_and(|corner| corner.at < s) {
            self.corners.pop_front();
            self.settled -= 1;
            self.chosen -= 1;
        }
    }
}
