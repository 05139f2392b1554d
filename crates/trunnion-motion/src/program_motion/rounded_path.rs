//! A polyline that arrives leg by leg becomes a smooth path, with its corners rounded within their tolerances.
//!
//! Every corner has a kernel (`kernel`) of its own half width. Where kernels overlap their roundings add up, so short
//! legs of a smooth curve become that curve again: the kernels reach over many of them.

use super::block::{BlockKind, BlockStart};
use super::corner::{Corner, CornerTolerance, USED, WIDEST};
use super::leg::{Leg, LetterVector, triples};
use super::leg_speeds::{border_speed, is_same, timed, timed_rate};
use std::collections::VecDeque;

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

/// Change of direction that is none: rounding of positions.
const STRAIGHT: f64 = 1e-9;

/// Distance before a change of speed at which the old speed still holds \[mm\].
const SPEED_STEP: f64 = 0.02;

/// Halvings of the range of a width.
const HALVINGS: u32 = 10;

/// Corners on either side that a kernel reaches at most.
const MANY: usize = 64;

/// Rounds in which widths are made smaller together.
const ROUNDS: u32 = 40;

/// Place whose deviation from the polyline is watched: a corner, or one between two.
#[derive(Debug, Clone, Copy)]
struct CheckedPlace {
    at: f64,
    tolerance: CornerTolerance,
    /// Sum over the kernels whose widths are chosen.
    deviation: LetterVector,
}

/// A place of the smooth path.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PathNode {
    /// Path parameter: length along the program \[mm\], with 10 mm for a radian.
    pub s: f64,
    /// Letters \[mm or rad\] and their derivatives by `s`.
    pub letters: [LetterVector; 4],
    /// Seconds per length of a feed and of a rapid move.
    pub(super) rates: [f64; 2],
    /// Block that begins or is run here.
    pub block: u32,
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

/// Changes of direction and curvature from the end of a leg to the start of the next one.
fn turn_between(before: &Leg, behind: &Leg) -> [LetterVector; 2] {
    let [before, behind] = [before.at(before.length), behind.at(0.0)];
    [1, 2].map(|order: usize| behind[order] - before[order])
}

/// The larger of two times per length, of both kinds.
fn slower(one: [f64; 2], other: [f64; 2]) -> [f64; 2] {
    [one[0].max(other[0]), one[1].max(other[1])]
}

/// The smooth path of one run, from rest to rest.
#[derive(Debug, Clone, Default)]
pub(super) struct RoundedPath {
    legs: VecDeque<PlacedLeg>,
    corners: VecDeque<Corner>,
    places: VecDeque<CheckedPlace>,
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
                self.push_corner(Corner { at, turn, bend, tolerance, width: 0.0 });
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

    /// Appends a corner, and the places between it and the last one.
    fn push_corner(&mut self, corner: Corner) {
        if let Some(last) = self.corners.back() {
            let tolerance = last.tolerance.min(corner.tolerance);
            let [from, to] = [last.at, corner.at];
            for share in [0.25, 0.5, 0.75] {
                self.push_place(from + share * (to - from), tolerance);
            }
        }
        self.push_place(corner.at, corner.tolerance);
        self.corners.push_back(corner);
    }

    fn push_place(&mut self, at: f64, tolerance: CornerTolerance) {
        let deviation = self.deviation(at);
        self.places.push_back(CheckedPlace { at, tolerance, deviation });
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
        let last = self.node.replace(s);
        let node = self.node_at(s, last)?;
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
            self.reach = self.reach.max(width);
            self.resize(self.chosen, width);
            self.chosen += 1;
        }
        while self.settled < self.chosen {
            let Some(corner) = self.corners.get(self.settled) else { break };
            if corner.at + 2.0 * WIDEST > known {
                break;
            }
            let ends = [corner.at - corner.width, corner.at + corner.width];
            self.shrink(self.settled, ends);
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

    /// Makes kernels from `first` on smaller until the path keeps its tolerances at the corners and between them, between
    /// two ends.
    fn shrink(&mut self, first: usize, [from, to]: [f64; 2]) {
        for _ in 0..ROUNDS {
            let mut kept = true;
            for index in self.places_within(from, to) {
                let Some(CheckedPlace { at, tolerance, deviation }) = self.places.get(index) else {
                    break;
                };
                let (at, share) = (*at, tolerance.share(deviation));
                if share > USED {
                    kept = false;
                    self.scale(first, at, 0.97 * (USED / share).max(0.25));
                }
            }
            if kept {
                return;
            }
        }
    }

    /// Indices of the places from one to another.
    fn places_within(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let index = |s: f64| self.places.partition_point(|place| place.at < s);
        index(from)..self.places.partition_point(|place| place.at <= to).max(index(from))
    }

    /// Scales the widths of the kernels from `first` on that reach `s`.
    fn scale(&mut self, first: usize, s: f64, factor: f64) {
        for index in first..self.chosen {
            let reaches = |corner: &&Corner| (corner.at - s).abs() < corner.width;
            if let Some(corner) = self.corners.get(index).filter(reaches) {
                self.resize(index, factor * corner.width);
            }
        }
    }

    /// Gives a corner another half width, and the places that its kernel reaches their deviations.
    fn resize(&mut self, index: usize, width: f64) {
        let Some(corner) = self.corners.get_mut(index) else { return };
        let before = std::mem::replace(&mut corner.width, width);
        let corner = corner.clone();
        let reach = before.max(width);
        let near = self.places_within(corner.at - reach, corner.at + reach);
        for place in self.places.range_mut(near) {
            for (width, sign) in [(before, -1.0), (width, 1.0)] {
                if width > 0.0 {
                    place.deviation += corner.deviation(place.at, width) * sign;
                }
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
        // Beginning of a kernel that the step must not pass, though it be close to the end.
        let mut bends = f64::INFINITY;
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
            bends = if alone { begin } else { bends };
        }
        for leg in legs.skip(1) {
            if leg.from >= last + step {
                break;
            }
            step = self.step_to(last, step, leg);
        }
        let left = self.length - last;
        let straight = self.length <= bends.max(last + SMALLEST_STEP);
        let s = if left <= step + SMALLEST_STEP && straight {
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
        let here = self.legs.get(self.leg_at(last)).map(|here| &here.leg);
        let timed = leg.leg.kind == BlockKind::Timed;
        let changes = !timed && here.is_some_and(|here| !is_same(here, &leg.leg));
        // Of short legs the number of the block comes late by less than a step.
        let marked = leg.leg.begins == BlockStart::Marked || leg.leg.length > LONG * step;
        if changes && distance > 2.0 * SPEED_STEP {
            return step.min(distance - SPEED_STEP).max(SMALLEST_STEP);
        }
        if changes || marked { step.min(distance) } else { step }
    }

    /// Returns the path at `s`, behind a node at `last`.
    fn node_at(&self, s: f64, last: Option<f64>) -> Option<PathNode> {
        let index = self.leg_at(s);
        let PlacedLeg { from, leg, .. } = self.legs.get(index)?;
        let mut letters = leg.at(s - from);
        for corner in self.near(s, self.reach).filter(|corner| corner.width > 0.0) {
            for (letter, part) in letters.iter_mut().zip(corner.at(s, corner.width)) {
                *letter += part;
            }
        }
        let rates = self.rates_at(s, index, last)?;
        // A leg that begins so soon has no node of its own.
        let block = self.legs.get(self.leg_at(s + SMALLEST_STEP))?.leg.block;
        Some(PathNode { s, letters, rates, block })
    }

    /// Returns the seconds per length of a feed and of a rapid move at `s` in a leg, behind a node at `last`.
    fn rates_at(&self, s: f64, index: usize, last: Option<f64>) -> Option<[f64; 2]> {
        let PlacedLeg { from, leg, peak, .. } = self.legs.get(index)?;
        let before = index.checked_sub(1).and_then(|before| self.legs.get(before));
        if leg.kind == BlockKind::Timed {
            let share = (s - from) / leg.length;
            let beside = [before, self.legs.get(index + 1)];
            let beside = beside.map(|other| timed(other.map(|placed| &placed.leg)));
            return Some([timed_rate(leg, beside, share).min(1.0 / peak), 0.0]);
        }
        // Where the speed changes the lower one holds, and so it does among legs without a node between them.
        let changes = before.filter(|before| s <= *from && before.leg.kind != BlockKind::Timed);
        let start = changes.map_or(leg.rates, |before| slower(leg.rates, before.leg.rates));
        let same = |other: &&PlacedLeg| is_same(leg, &other.leg);
        let back = self.legs.range(..index).rev().take_while(same);
        let back = back.take_while(|other| last.is_some_and(|last| other.end() > last));
        let onward = self.legs.range(index + 1..).take_while(same);
        let onward = onward.take_while(|other| other.from < s + LARGEST_STEP);
        Some(back.chain(onward).fold(start, |rates, other| slower(rates, other.leg.rates)))
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
        while self.places.front().is_some_and(|place| place.at < s) {
            self.places.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::quintic::Quintic;
    use crate::program_motion::block::{
        BlockCoordinates, BlockEnding, BlockShape, LETTERS, MotionBlock,
    };

    /// Number between 0 and 1, by xorshift.
    fn unit(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn leg(start: [f64; 3], end: [f64; 3]) -> Option<Leg> {
        let letters = |at: [f64; 3]| {
            let mut letters = [0.0; LETTERS];
            letters[..3].copy_from_slice(&at);
            letters
        };
        Leg::of(&MotionBlock {
            number: 1,
            start: letters(start),
            end: letters(end),
            shape: BlockShape::Line,
            kind: BlockKind::Feed,
            speed: 10.0,
            begins: BlockStart::Flow,
            ending: BlockEnding::Blend,
            tolerance: 0.01,
            coordinates: BlockCoordinates::Axes,
            tool_length: 0.0,
        })
    }

    /// Distance of a place from the polyline.
    fn miss(points: &[[f64; 3]], at: &LetterVector) -> f64 {
        let at = triples(at)[0];
        let distance = |two: &[[f64; 3]]| {
            let [from, to] = [two[0], two[1]].map(nalgebra::Vector3::from);
            let along = to - from;
            let u = (at - from).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
            (at - from - along * u.clamp(0.0, 1.0)).norm()
        };
        points.windows(2).map(distance).fold(f64::INFINITY, f64::min)
    }

    /// Between its nodes as well, the path stays within the tolerance of legs of any lengths, from a millionth of a
    /// millimetre to a millimetre.
    #[test]
    fn tiny_legs_keep_the_tolerance() {
        let mut state = 77;
        for case in 0..60 {
            let tip = 10.0_f64.powf(-2.5 + 2.0 * unit(&mut state));
            let tolerance = CornerTolerance { tip, axis: 1e-3 };
            let mut points = vec![[0.0; 3]];
            let mut path = RoundedPath::default();
            for _ in 0..80 {
                let size = 10.0_f64.powf(-6.0 + 6.0 * unit(&mut state));
                let from = points[points.len() - 1];
                let to = from.map(|value| value + size * (2.0 * unit(&mut state) - 1.0));
                if let Some(leg) = leg(from, to) {
                    path.push(&leg, tolerance);
                    points.push(to);
                }
            }
            path.end();
            let mut before: Option<PathNode> = None;
            let mut worst = 0.0_f64;
            while let Some(node) = path.next_node() {
                if let Some(last) = before.replace(node) {
                    let jet = |of: &PathNode| [of.letters[0], of.letters[1], of.letters[2]];
                    let length = node.s - last.s;
                    let curve = Quintic::new(length, jet(&last), jet(&node));
                    for k in 0..=8 {
                        let [at, ..] = curve.at(length * f64::from(k) / 8.0);
                        let share = miss(&points, &at) / tip;
                        worst = worst.max(share);
                    }
                }
            }
            assert!(path.is_finished() && worst <= 1.0, "case {case}: {worst}");
        }
    }
}
