//! Depth of a body that must not touch material, over all points and times: branch and bound.
//!
//! Material is what no earlier body held of the stock. In a box, the part of the body deeper than a given depth is behind
//! support planes of the body. Together with the faces of the uncut stock they bound a polytope. None of it is material if
//! one earlier body held all of it. Proof: the distance from a convex body that moves straight is convex in point and time,
//! except for the turn of its frame. What the body holds at the corners, each at its own time, it holds in between.
//! Undecided boxes are subdivided.
//!
//! Where a tool leaves a surface it has just cut, both surfaces coincide, and boxes along them would have to be tiny. There
//! a point outside the earlier body is in front of one of its support planes. If that plane recedes, or advances by less
//! than the given depth, the point is no deeper in the body now.

use super::boxes::EarlierBody;
use super::polytope::{Polytope, mean};
use crate::math;
use crate::verify::stock::clip::closest_approach::{BodyMotion, RayLine, TimeGuess};
use crate::verify::swept::bvh::BoundingBox;
use crate::verify::swept::distance;
use crate::verify::swept::mesh::{BoxContent, ClosedMesh};
use crate::verify::swept::relative::RelativeMotion;
use crate::verify::swept::tool::BodyPose;
use nalgebra::{Point3, Vector3};
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::rc::Rc;

/// Scales of a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SearchScale {
    /// Depth up to which a body need not be reported \[mm\].
    pub(crate) least: f64,
    /// Accuracy of the depth \[mm\].
    pub(crate) depth: f64,
    /// Accuracy of times, as a distance \[mm\].
    pub(crate) tolerance: f64,
}

/// Deepest point found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DeepestPoint {
    pub(crate) depth: f64,
    pub(crate) point: Point3<f64>,
}

/// Result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SearchOutcome {
    pub(crate) deepest: Option<DeepestPoint>,
    /// Depth that remains possible if the search met its limit and found nothing.
    pub(crate) open: Option<f64>,
}

/// Most boxes until something is found in material.
const MOST_CELLS: u32 = 20_000;
/// Most boxes to refine the depth of what was found.
const REFINING: u32 = 1000;
/// Most earlier bodies tested for holding all of a box: those that held its middle deepest.
const ASKED: usize = 3;
/// Number of bodies above which the last ones are tested first.
const MANY: usize = 64;
/// Number of last bodies tested first.
const LAST: usize = 8;
/// Thickness below which a polytope is due to rounding alone \[mm\].
const THIN: f64 = 1e-6;
/// Size of a box, as a share of the least depth, below which it is not subdivided.
const FINEST: f64 = 0.25;

/// Box over an interval of time, with a bound on the depth of the body in it.
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
    /// Orders by depth, so that a heap returns the deepest first.
    fn cmp(&self, other: &Self) -> Ordering {
        self.depth.total_cmp(&other.depth)
    }
}

/// Search in progress.
pub(crate) struct DepthSearch<'a> {
    shell: &'a ClosedMesh,
    motion: RelativeMotion<'a>,
    scale: SearchScale,
    /// Pose in which the same body ended last, with the error of the bodies \[mm\].
    last: Option<(BodyPose, f64)>,
    found: Option<DeepestPoint>,
    open: BinaryHeap<SearchCell<'a>>,
}

/// Part of a box that the body may hold.
struct HeldBox {
    corners: Vec<Point3<f64>>,
    /// Bound on its depth.
    depth: f64,
    /// The bound is limited by the length of the interval of time rather than by the size of the box.
    in_time: bool,
}

impl<'a> DepthSearch<'a> {
    pub(crate) fn new(
        shell: &'a ClosedMesh,
        motion: RelativeMotion<'a>,
        scale: SearchScale,
    ) -> Self {
        Self { shell, motion, scale, last: None, found: None, open: BinaryHeap::new() }
    }

    /// Finds the deepest point in a box that no earlier body held, if it is deeper than `known`.
    pub(crate) fn run(
        mut self,
        bounds: &BoundingBox,
        before: Rc<[&'a EarlierBody]>,
        known: f64,
    ) -> SearchOutcome {
        let goal = known.max(self.scale.least);
        let (depth, time) = (f64::INFINITY, [-1.0, 1.0]);
        // The same body one piece earlier has usually cut the surface that is left now.
        let same = before.iter().rev().find(|before| before.body == self.motion.body);
        self.last =
            same.map(|before| (before.bounded.piece.instant(1.0).pose, before.bounded.bend));
        self.open.push(SearchCell { depth, bounds: *bounds, time, before });
        let mut cells = 0;
        while let Some(cell) = self.open.pop() {
            let goal = self.goal(goal);
            if cell.depth <= goal {
                break;
            }
            cells += 1;
            let is_reported = self.found.is_some() || known > 0.0;
            if cells > if is_reported { REFINING } else { MOST_CELLS } {
                let open = Some(cell.depth).filter(|_| !is_reported);
                return SearchOutcome { deepest: self.found, open };
            }
            self.part(&cell, goal);
        }
        SearchOutcome { deepest: self.found, open: None }
    }

    /// Returns the depth up to which nothing more is sought.
    fn goal(&self, least: f64) -> f64 {
        self.found.map_or(least, |found| found.depth + self.scale.depth.max(DEPTH * found.depth))
    }

    /// Decides a box, or subdivides it in space or time.
    fn part(&mut self, cell: &SearchCell<'a>, goal: f64) {
        // Step 1: drop the box if the body only leaves the surface that it cut before.
        if self.leaves(&cell.bounds, cell.time, goal) {
            return;
        }
        // Step 2: bound the part of the stock that the body may hold deeper than the goal.
        let Some(held) = self.held(&cell.bounds, cell.time, goal) else { return };
        let bounds = around(&held.corners);
        if (bounds.high - bounds.low).min() < THIN {
            return;
        }
        let middle = nalgebra::center(&bounds.low, &bounds.high);
        let far = 0.5 * (bounds.high - bounds.low).norm();
        let most = |all: &[f64]| all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // Step 3: drop the box if one earlier body held all of that part. One of the last bodies often did.
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
        // Step 4: test the middle exactly, which may raise the goal.
        let point = mean(&held.corners);
        self.try_at(&point, cell.time, &before);
        if far <= FINEST * self.scale.least {
            return;
        }
        // Step 5: subdivide what limits the bound, time or space.
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

    /// Bounds the part of a box that is in the uncut stock and may be deeper in the body than `goal` at some time.
    fn held(&self, bounds: &BoundingBox, time: [f64; 2], goal: f64) -> Option<HeldBox> {
        let RelativeMotion { body, piece, .. } = self.motion;
        let middle = nalgebra::center(&bounds.low, &bounds.high);
        // Step 1: take the planes of the body at the time at which it is nearest to the middle of the box.
        let u = self.motion.nearest_time(&middle, time);
        let pose = piece.instant(u).pose;
        let (_, gradient) = distance::distance(body, &pose, &middle);
        let mut polytope = Polytope::cuboid(bounds);
        let mut planes = Vec::new();
        let mut in_time = false;
        for direction in [gradient].into_iter().chain(distance::sides(body, &pose, &middle)) {
            // `long` is what the reach gains over the interval of time, `wide` the extent of the box along
            // the plane normal.
            let reach = self.motion.reach(&direction, time);
            let long =
                reach - pose.tip.coords.dot(&direction) - body.extent(&pose.axis, &direction);
            let wide =
                (0..3).map(|k| (direction[k] * (bounds.high[k] - bounds.low[k])).abs()).sum();
            in_time |= planes.is_empty() && long > f64::max(wide, FINEST * self.scale.least);
            // A point deeper than the goal is behind every support plane by more than the goal.
            polytope.keep(&direction, reach - goal);
            planes.push((direction, reach));
            if polytope.is_empty() {
                return None;
            }
        }
        // Step 2: clip by the faces of the uncut stock around the box.
        match self.shell.within(bounds) {
            BoxContent::Nothing => return None,
            BoxContent::Behind(faces) => {
                for (direction, most) in &faces {
                    polytope.keep(direction, *most);
                }
            }
        }
        let corners = polytope.corners();
        if corners.is_empty() {
            return None;
        }
        // Step 3: the least depth below any one plane, at the worst corner, bounds the depth in the polytope.
        let under = |(direction, reach): &(Vector3<f64>, f64)| {
            corners
                .iter()
                .map(|p| reach - direction.dot(&p.coords))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let depth = planes.iter().map(under).fold(f64::INFINITY, f64::min);
        Some(HeldBox { corners, depth, in_time })
    }

    /// Tests if nothing in a box is deeper in the body than `goal` unless the body held it where it ended last.
    ///
    /// That holds if no point of the body's surface, as seen from the box, has advanced by more than the goal since.
    fn leaves(&self, bounds: &BoundingBox, time: [f64; 2], goal: f64) -> bool {
        let RelativeMotion { body, piece, sag } = self.motion;
        let (Some((was, off)), Some(top)) = (self.last, body.end_top()) else {
            return false;
        };
        let half = 0.5 * (bounds.high - bounds.low).norm();
        let from_tip = nalgebra::center(&bounds.low, &bounds.high) - was.tip;
        let height = was.axis.dot(&from_tip);
        if height + half > top {
            return false;
        }
        let aside = from_tip - was.axis * height;
        // Below its top the body faces across its axis and back along it; across, within the angle that the box subtends.
        let round = math::asin((half / aside.norm()).min(1.0));
        time.into_iter().all(|u| {
            let now = piece.instant(u).pose;
            let by = now.tip - was.tip;
            let along = was.axis.dot(&by);
            let apart = by - was.axis * along;
            // Advance of the nearest surface: the translation resolved into the directions that face the box.
            let angle = if half < aside.norm() {
                math::angle_of_vectors(&aside, &apart) - round
            } else {
                0.0
            };
            let [out, back] = [apart.norm() * math::cos(angle.max(0.0)), -along];
            let on = if out > 0.0 && back > 0.0 { math::hypot(out, back) } else { out.max(back) };
            // The turn of the axis moves points by at most angle times reach; the sag and the error of the
            // bodies add to it.
            on + (now.axis - was.axis).norm() * math::hypot(top, body.radius()) + sag + off <= goal
        })
    }

    /// Returns the earlier bodies that come within `far` of a point, in order, and those that held it deepest.
    fn near(
        &self,
        before: &[&'a EarlierBody],
        point: &Point3<f64>,
        far: f64,
    ) -> (Rc<[&'a EarlierBody]>, Vec<&'a EarlierBody>) {
        let mut deepest: Vec<(f64, &'a EarlierBody)> = Vec::with_capacity(ASKED + 1);
        let mut close = |before: &&'a EarlierBody| {
            let EarlierBody { body, bounded, .. } = *before;
            // In a short move the middle decides.
            let (mut distance, motion) = bounded.piece.at_middle(*body, point);
            // By the speed of its points, the body stays farther off than the box reaches.
            if distance - motion > far {
                return false;
            }
            if motion > far {
                let (nearest, bound, _) = self.away(before, point);
                if bound > far {
                    return false;
                }
                distance = nearest;
            }
            let at = deepest.partition_point(|(other, _)| *other <= distance);
            deepest.insert(at, (distance, *before));
            deepest.truncate(ASKED);
            true
        };
        let near = before.iter().filter(|before| close(before)).copied().collect();
        (near, deepest.into_iter().map(|(_, before)| before).collect())
    }

    /// Returns the distance of a point from a body at the nearest time, its lower bound at all times, and that time.
    fn away(&self, before: &EarlierBody, point: &Point3<f64>) -> (f64, f64, f64) {
        let EarlierBody { body, bounded, .. } = before;
        // The nearest time to a point needs no direction; any line through it serves.
        let line = RayLine { from: *point, direction: Vector3::z() };
        let moving = BodyMotion::new(bounded, *body, self.scale.tolerance);
        let near = moving.nearest(&line, 0.0, TimeGuess::at(0.0));
        (near.distance, near.bound - 0.5 * bounded.bend, near.u)
    }

    /// Returns the distances of corners outside a body, each at its own time. If none is positive, the body holds the whole
    /// convex hull.
    fn outside(&self, before: &EarlierBody, corners: &[Point3<f64>]) -> Vec<f64> {
        let BoundingBox { low, high } = around(corners);
        let all: Vec<(f64, f64, f64)> = corners.iter().map(|p| self.away(before, p)).collect();
        // Each corner is held at its own time; over the range of these times the frame turns.
        let time = all.iter().map(|(_, _, u)| *u);
        let [first, last] = time
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], u| [low.min(u), high.max(u)]);
        let bounded = &before.bounded;
        // Turn of the frame times extent of the corners: a mean of products differs from the product of the means by at
        // most a quarter of both ranges. And the convexity by the bend costs half of the bend.
        let turned = 0.25 * bounded.piece.shear(last - first) * (high - low).norm();
        let loss = turned + 0.5 * bounded.bend;
        all.into_iter().map(|(distance, ..)| distance + loss).collect()
    }

    /// Records a point if it is material and deeper in the body than what was found.
    fn try_at(&mut self, point: &Point3<f64>, time: [f64; 2], before: &[&EarlierBody]) {
        let RelativeMotion { body, piece, .. } = self.motion;
        let u = self.motion.nearest_time(point, time);
        let depth = -distance::distance(body, &piece.instant(u).pose, point).0;
        let known = self.found.map_or(self.scale.least, |found| found.depth);
        // Cheap tests first: deeper than known, and inside the uncut stock.
        if depth <= known || !self.shell.holds(point) {
            return;
        }
        // Material is what no earlier body held, not even by the error of its distance.
        if before.iter().all(|before| self.away(before, point).0 > 0.5 * before.bounded.bend) {
            self.found = Some(DeepestPoint { depth, point: *point });
        }
    }
}

/// Accuracy of a depth as a share of itself.
const DEPTH: f64 = 0.05;

/// Returns the smallest box around points.
fn around(points: &[Point3<f64>]) -> BoundingBox {
    let join = |all: BoundingBox, p: &Point3<f64>| all.join(&BoundingBox { low: *p, high: *p });
    points.iter().fold(BoundingBox::empty(), join)
}

/// Chooses the axis across which a box is halved: the longest of those where one half may then be dropped, by the
/// distances of its corners outside a body, or else the longest.
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
