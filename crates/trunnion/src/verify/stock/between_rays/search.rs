//! How deep a body that must not touch material gets into it, between all places and times.
//!
//! Material is what of the stock no body before held. In a box, what the body holds deeper than a given depth is
//! behind planes at its surface, so with the faces of the uncut stock it is in a polytope. None of that is material
//! if a body before it held all of the polytope: the distance from a convex body that moves straight is convex in
//! place and time, but for how its frame turns, so what it holds at the corners, each at its own time, it holds in
//! between. Boxes of which that is not known are parted.
//!
//! Where a tool leaves what it cut, both surfaces are the same, and boxes along them would have to be small. There a
//! place outside of the body before is in front of a plane at its surface; if that plane moves back, or on by less
//! than the given depth, the place is not deeper in the body now.

use super::EarlierBody;
use super::polytope::{Polytope, mean};
use crate::verify::stock::clip::closest_approach::{BodyMotion, RayLine, TimeGuess};
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::distance;
use crate::verify::swept::mesh::{BoxContent, ClosedMesh};
use crate::verify::swept::relative::RelativeMotion;
use crate::verify::swept::tool::{BodyPose, ConvexBody};
use nalgebra::{Point3, Vector3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::rc::Rc;

/// What is asked for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchScale {
    /// How deep a body may be without being told \[mm\].
    pub(crate) least: f64,
    /// To what the depth is found \[mm\].
    pub(crate) depth: f64,
    /// How exactly times are found \[mm\].
    pub(crate) tolerance: f64,
}

/// The deepest place that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DeepestPoint {
    pub(crate) depth: f64,
    pub(crate) point: Point3<f64>,
}

/// What a search gave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SearchOutcome {
    pub(crate) deepest: Option<DeepestPoint>,
    /// It met its limit and found nothing: it may be as deep as this.
    pub(crate) open: Option<f64>,
}

/// Boxes looked at, at most, to find that something is in material, and how deep.
const MOST_CELLS: u32 = 20_000;
const REFINING: u32 = 1000;
/// Bodies of which it is asked whether they held all of a box: those that held its middle the deepest.
const ASKED: usize = 3;
/// Of more bodies than this the last ones are asked first.
const MANY: usize = 64;
const LAST: usize = 8;
/// What is thinner than this is of rounding alone \[mm\].
const THIN: f64 = 1e-6;
/// A box in which depths differ by less than this share of the least depth is parted no further.
const FINEST: f64 = 0.25;

/// A box over a stretch of time, and how deep the body may be in it.
struct SearchCell<'a> {
    depth: f64,
    bounds: BoundingBox,
    time: [f64; 2],
    before: Rc<[&'a EarlierBody]>,
}

impl PartialEq for SearchCell<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for SearchCell<'_> {}

impl PartialOrd for SearchCell<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for SearchCell<'_> {
    /// The deepest is the greatest: a heap gives it first.
    fn cmp(&self, other: &Self) -> Ordering {
        self.depth.total_cmp(&other.depth)
    }
}

/// A search under way.
pub(crate) struct DepthSearch<'a> {
    shell: &'a ClosedMesh,
    passing: RelativeMotion<'a>,
    scale: SearchScale,
    /// Where the same body ended last, and how much the bodies are off \[mm\].
    last: Option<(BodyPose, f64)>,
    found: Option<DeepestPoint>,
    open: BinaryHeap<SearchCell<'a>>,
}

/// What the body holds of a box.
struct HeldBox {
    corners: Vec<Point3<f64>>,
    /// How deep at most.
    depth: f64,
    /// Time rather than place keeps that from being known better.
    in_time: bool,
}

impl<'a> DepthSearch<'a> {
    pub(crate) fn new(
        shell: &'a ClosedMesh,
        passing: RelativeMotion<'a>,
        scale: SearchScale,
    ) -> Self {
        Self { shell, passing, scale, last: None, found: None, open: BinaryHeap::new() }
    }

    /// The deepest place in a box that none of the parts before held, if deeper than `known`.
    pub(crate) fn run(
        mut self,
        bounds: &BoundingBox,
        before: Rc<[&'a EarlierBody]>,
        known: f64,
    ) -> SearchOutcome {
        let goal = known.max(self.scale.least);
        let (depth, time) = (f64::INFINITY, [-1.0, 1.0]);
        let same = before.iter().rev().find(|before| before.body == self.passing.body);
        self.last =
            same.map(|before| (before.stretch.piece.instant(1.0).stand, before.stretch.bend));
        self.open.push(SearchCell { depth, bounds: *bounds, time, before });
        let mut cells = 0;
        while let Some(cell) = self.open.pop() {
            let goal = self.goal(goal);
            if cell.depth <= goal {
                break;
            }
            cells += 1;
            let told = self.found.is_some() || known > 0.0;
            if cells > if told { REFINING } else { MOST_CELLS } {
                let open = Some(cell.depth).filter(|_| !told);
                return SearchOutcome { deepest: self.found, open };
            }
            self.part(&cell, goal);
        }
        SearchOutcome { deepest: self.found, open: None }
    }

    /// What is no deeper than this is not looked for.
    fn goal(&self, least: f64) -> f64 {
        self.found.map_or(least, |found| found.depth + self.scale.depth.max(DEPTH * found.depth))
    }

    fn part(&mut self, cell: &SearchCell<'a>, goal: f64) {
        if self.leaves(&cell.bounds, cell.time, goal) {
            return;
        }
        let Some(held) = self.held(&cell.bounds, cell.time, goal) else { return };
        let bounds = around(&held.corners);
        if (bounds.high - bounds.low).min() < THIN {
            return;
        }
        let middle = nalgebra::center(&bounds.low, &bounds.high);
        let far = 0.5 * (bounds.high - bounds.low).norm();
        let most = |all: &[f64]| all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // One of the last ones often held it all, which spares a look at the others.
        let last = cell.before.iter().rev().take(LAST).filter(|_| cell.before.len() > MANY);
        if last.into_iter().any(|before| most(&self.outside(before, &held.corners)) <= 0.0) {
            return;
        }
        let (before, deepest) = self.near(&cell.before, &middle, far);
        let mut over: Option<Vec<f64>> = None;
        for before in deepest {
            let outside = self.outside(before, &held.corners);
            if most(&outside) <= 0.0 {
                return;
            }
            if over.as_ref().is_none_or(|best| most(&outside) < most(best)) {
                over = Some(outside);
            }
        }
        let place = mean(&held.corners);
        self.try_at(&place, cell.time, &before);
        if far <= FINEST * self.scale.least {
            return;
        }
        let depth = held.depth.min(cell.depth);
        let [from, to] = cell.time;
        if held.in_time {
            let middle = 0.5 * (from + to);
            for time in [[from, middle], [middle, to]] {
                self.open.push(SearchCell { depth, bounds, time, before: Rc::clone(&before) });
            }
            return;
        }
        let axis = across(&bounds, &held.corners, over.as_deref());
        let [mut low, mut high] = [bounds; 2];
        (low.high[axis], high.low[axis]) = (middle[axis], middle[axis]);
        for bounds in [low, high] {
            self.open.push(SearchCell {
                depth,
                bounds,
                time: cell.time,
                before: Rc::clone(&before),
            });
        }
    }

    /// What of a box is in the stock as it was and may be deeper in the body than `goal` at some time.
    fn held(&self, bounds: &BoundingBox, time: [f64; 2], goal: f64) -> Option<HeldBox> {
        let RelativeMotion { body, piece, .. } = self.passing;
        let middle = nalgebra::center(&bounds.low, &bounds.high);
        let u = self.passing.nearest_time(&middle, time);
        let stand = piece.instant(u).stand;
        let (_, gradient) = distance::distance(body, &stand, &middle);
        let mut polytope = Polytope::cuboid(bounds);
        let mut planes = Vec::new();
        let mut in_time = false;
        for way in [gradient].into_iter().chain(distance::sides(body, &stand, &middle)) {
            let reach = self.passing.reach(&way, time);
            let long = reach - stand.tip.coords.dot(&way) - body.extent(&stand.axis, &way);
            let wide = (0..3).map(|k| (way[k] * (bounds.high[k] - bounds.low[k])).abs()).sum();
            in_time |= planes.is_empty() && long > f64::max(wide, FINEST * self.scale.least);
            polytope.keep(&way, reach - goal);
            planes.push((way, reach));
            if polytope.is_empty() {
                return None;
            }
        }
        match self.shell.within(bounds) {
            BoxContent::Nothing => return None,
            BoxContent::Behind(faces) => {
                for (way, most) in &faces {
                    polytope.keep(way, *most);
                }
            }
        }
        let corners = polytope.corners();
        if corners.is_empty() {
            return None;
        }
        let under = |(way, reach): &(Vector3<f64>, f64)| {
            corners.iter().map(|p| reach - way.dot(&p.coords)).fold(f64::NEG_INFINITY, f64::max)
        };
        let depth = planes.iter().map(under).fold(f64::INFINITY, f64::min);
        Some(HeldBox { corners, depth, in_time })
    }

    /// Whether nothing of a box that the same body did not hold where it ended last is deeper in it now than `goal`: at no
    /// place of its surface there, as seen from the box, has it moved on by more.
    fn leaves(&self, bounds: &BoundingBox, time: [f64; 2], goal: f64) -> bool {
        let RelativeMotion { body, piece, sag } = self.passing;
        let (Some((was, off)), ConvexBody::Nose { top, .. }) = (self.last, body) else {
            return false;
        };
        let half = 0.5 * (bounds.high - bounds.low).norm();
        let from_tip = nalgebra::center(&bounds.low, &bounds.high) - was.tip;
        let height = was.axis.dot(&from_tip);
        if height + half > top {
            return false;
        }
        let aside = from_tip - was.axis * height;
        // Below its top it faces across its axis and back along it; across, no farther round than the box lies.
        let round = (half / aside.norm()).min(1.0).asin();
        time.into_iter().all(|u| {
            let now = piece.instant(u).stand;
            let by = now.tip - was.tip;
            let along = was.axis.dot(&by);
            let apart = by - was.axis * along;
            let angle = if half < aside.norm() { aside.angle(&apart) - round } else { 0.0 };
            let [out, back] = [apart.norm() * angle.max(0.0).cos(), -along];
            let on = if out > 0.0 && back > 0.0 { out.hypot(back) } else { out.max(back) };
            on + (now.axis - was.axis).norm() * top.hypot(body.radius()) + sag + off <= goal
        })
    }

    /// Bodies before that come within `far` of a place, in order, and those that held it the deepest.
    fn near(
        &self,
        before: &[&'a EarlierBody],
        place: &Point3<f64>,
        far: f64,
    ) -> (Rc<[&'a EarlierBody]>, Vec<&'a EarlierBody>) {
        let mut deepest: Vec<(f64, &'a EarlierBody)> = Vec::with_capacity(ASKED + 1);
        let mut close = |before: &&'a EarlierBody| {
            let EarlierBody { body, stretch, .. } = *before;
            // In a short move the middle tells enough.
            let (mut distance, motion) = stretch.piece.at_middle(*body, place);
            if distance - motion > far {
                return false;
            }
            if motion > far {
                let (nearest, bound, _) = self.away(before, place);
                if bound > far {
                    return false;
                }
                distance = nearest;
            }
            let place = deepest.partition_point(|(other, _)| *other <= distance);
            deepest.insert(place, (distance, *before));
            deepest.truncate(ASKED);
            true
        };
        let near = before.iter().filter(|before| close(before)).copied().collect();
        (near, deepest.into_iter().map(|(_, before)| before).collect())
    }

    /// Distance of a point from a body at the nearest time, what it is at least at all times, and that time.
    fn away(&self, before: &EarlierBody, point: &Point3<f64>) -> (f64, f64, f64) {
        let EarlierBody { body, stretch, .. } = before;
        let line = RayLine { from: *point, way: Vector3::z() };
        let moving = BodyMotion::new(stretch, *body, self.scale.tolerance);
        let near = moving.nearest(&line, 0.0, TimeGuess::at(0.0));
        (near.distance, near.bound - 0.5 * stretch.bend, near.u)
    }

    /// By how much corners are outside a body, each at its own time; if none is, then nothing in between is.
    fn outside(&self, before: &EarlierBody, corners: &[Point3<f64>]) -> Vec<f64> {
        let BoundingBox { low, high } = around(corners);
        let all: Vec<(f64, f64, f64)> = corners.iter().map(|p| self.away(before, p)).collect();
        let time = all.iter().map(|(_, _, u)| *u);
        let [first, last] = time
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], u| [low.min(u), high.max(u)]);
        let stretch = &before.stretch;
        // What the frame turns, times what the corners are apart: a mean of products is off the product of the means
        // by a quarter of both ranges. And what is convex only with the bend is off by half of it.
        let turned = 0.25 * stretch.piece.shear(last - first) * (high - low).norm();
        let loss = turned + 0.5 * stretch.bend;
        all.into_iter().map(|(distance, ..)| distance + loss).collect()
    }

    /// Takes a place if it is material and deeper in the body than what was found.
    fn try_at(&mut self, place: &Point3<f64>, time: [f64; 2], before: &[&EarlierBody]) {
        let RelativeMotion { body, piece, .. } = self.passing;
        let u = self.passing.nearest_time(place, time);
        let depth = -distance::distance(body, &piece.instant(u).stand, place).0;
        let known = self.found.map_or(self.scale.least, |found| found.depth);
        if depth <= known || !self.shell.holds(place) {
            return;
        }
        if before.iter().all(|before| self.away(before, place).0 > 0.5 * before.stretch.bend) {
            self.found = Some(DeepestPoint { depth, point: *place });
        }
    }
}

/// Share of a depth to which it is found.
const DEPTH: f64 = 0.05;

/// The smallest box around points.
fn around(points: &[Point3<f64>]) -> BoundingBox {
    let join = |all: BoundingBox, p: &Point3<f64>| all.join(&BoundingBox { low: *p, high: *p });
    points.iter().fold(BoundingBox::empty(), join)
}

/// Across which axis to part a box: the longest of those where one half may be done with, by how far its corners are
/// outside a body, or else the longest.
fn across(bounds: &BoundingBox, corners: &[Point3<f64>], over: Option<&[f64]>) -> usize {
    let size = bounds.high - bounds.low;
    let useful = |axis: usize| {
        let middle = 0.5 * (bounds.low[axis] + bounds.high[axis]);
        let clear = |upper: bool| {
            let half = corners.iter().zip(over.unwrap_or_default());
            half.filter(|(p, _)| (p[axis] > middle) == upper).all(|(_, over)| *over <= 0.0)
        };
        over.is_some() && (clear(false) || clear(true))
    };
    let longest =
        |axes: &[usize]| axes.iter().copied().max_by(|a, b| size[*a].total_cmp(&size[*b]));
    let some: Vec<usize> = (0..3).filter(|axis| useful(*axis)).collect();
    longest(&some).unwrap_or_else(|| size.imax())
}
