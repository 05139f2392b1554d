//! Nodes along a course, so close that quintics between them follow it.

use super::course::{Across, Along, Course, Look};
use super::travel::TRAVEL_ROUNDING;
use super::{AxesError, AxesOptions, Deviation};
use crate::inverse::{Inverse, InverseError, Rates};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::angle_between;
use crate::math::quintic::Quintic;
use crate::types::{AXES, AxisNode, AxisVector, PoseCurve, ToolPose};
use nalgebra::Point3;

/// Share of the tolerance that deviations at checked points may use. The error of a quintic
/// between exact nodes is (t(1-t))³ to leading order; the checked points miss its top by less
/// than a tenth, and the rest is for what is not leading order.
const SHARE: f64 = 0.5;

/// Where an interval is checked, as shares of it.
const CHECKED: [f64; 5] = [0.15, 0.325, 0.5, 0.675, 0.85];

/// Intervals shorter than this share of the piece give up.
const SHORTEST: f64 = 1e-10;

/// Intervals shorter than this share of the piece may turn a rotary by any amount: on them only
/// the deviation counts. So a free axis can settle while the tool leaves the singular direction.
const SETTLING: f64 = 1e-4;

/// Halvings of an interval after which a way may go over to the other branch where both meet, at the rim
/// of reach: a thousandth of it cannot be followed on one.
const OVER: usize = 10;

/// Parts an interval is cut into to bound its extent.
const PARTS: u32 = 8;

/// Control points this far outside both ends of an interval \[mm or rad\] are taken as its bounds: a
/// tenth of what is on an end of travel.
const FLAT: f64 = 0.1 * TRAVEL_ROUNDING;

/// Share of the tolerance below which the error of an interval is not looked at any closer.
const SMALL: f64 = 0.01;

/// Ways at a place: both branches through a singular direction, and both beside it.
const WAYS: usize = 4;

/// A pose without an axis.
const NO_AXIS: InverseError = InverseError::NotFinite { what: "the tool axis" };

/// Follows courses with an inverse and tolerances.
#[derive(Debug, Clone, Copy)]
pub(super) struct Marcher<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) options: &'a AxesOptions,
}

/// Nodes along a course.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Marched {
    pub(super) nodes: Vec<AxisNode>,
    pub(super) deviation: Deviation,
}

/// Lowest and highest value of every axis on some part of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds(pub(super) [[f64; 2]; AXES]);

impl Bounds {
    pub(super) const NONE: Self = Self([[f64::INFINITY, f64::NEG_INFINITY]; AXES]);
    pub(super) const ALL: Self = Self([[f64::NEG_INFINITY, f64::INFINITY]; AXES]);

    pub(super) fn include(&mut self, q: &AxisVector) {
        for ([low, high], &value) in self.0.iter_mut().zip(q.iter()) {
            *low = low.min(value);
            *high = high.max(value);
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for ([low, high], [l, h]) in self.0.iter_mut().zip(other.0) {
            *low = low.min(l);
            *high = high.max(h);
        }
    }

    /// The highest low ends and the lowest high ends of both; where they do not overlap, the wrong way
    /// round.
    pub(super) fn meet(&mut self, other: &Self) {
        for ([low, high], [l, h]) in self.0.iter_mut().zip(other.0) {
            *low = low.max(l);
            *high = high.min(h);
        }
    }

    /// Bounds of the quintic between two nodes: it stays between the lowest and the highest of its
    /// control points. Where an axis turns back on the way, the control points of its parts.
    pub(super) fn between(from: &AxisNode, to: &AxisNode) -> Self {
        let mut ends = Self::NONE;
        ends.include(&from.q[0]);
        ends.include(&to.q[0]);
        let mut hull = ends;
        hull.include_controls(&from.q, to.s - from.s);
        hull.include_controls(&to.q, from.s - to.s);
        if hull.exceeds(&ends) <= FLAT {
            return hull;
        }
        let quintic = between(from, to);
        let part = (to.s - from.s) / f64::from(PARTS);
        for index in 0..PARTS {
            let x = part * f64::from(index);
            for (x, side) in [(x, part), (x + part, -part)] {
                let q = quintic.at(x);
                ends.include(&q[0]);
                ends.include_controls(&q, side);
            }
        }
        ends
    }

    /// Second and third control point of a quintic that goes on for `length` from here.
    fn include_controls(&mut self, [q, q1, q2, _]: &[AxisVector; 4], length: f64) {
        self.include(&(q + q1 * (length / 5.0)));
        self.include(&(q + q1 * (length * 0.4) + q2 * (length * length / 20.0)));
    }

    /// How far beyond other bounds \[mm or rad\].
    fn exceeds(&self, other: &Self) -> f64 {
        let pairs = self.0.iter().zip(&other.0);
        pairs.map(|(own, other)| (other[0] - own[0]).max(own[1] - other[1])).fold(0.0, f64::max)
    }
}

/// Why a course cannot be followed, with the parameter.
pub(super) enum Trouble {
    Inverse(f64, InverseError),
    NotFollowed(f64, Deviation),
}

impl Trouble {
    /// As the error of a piece.
    pub(super) fn of(self, piece: usize) -> AxesError {
        match self {
            Self::Inverse(u, source) => AxesError::Inverse { piece, u, source },
            Self::NotFollowed(u, Deviation { tip, axis }) => {
                AxesError::NotFollowed { piece, u, tip, axis }
            }
        }
    }
}

impl<'a> Marcher<'a> {
    /// Directions this close to the singular one may be taken to be on it \[rad\]: a share of the
    /// tolerance that leaves the rest to the quintics beside it.
    pub(super) fn pole(&self) -> f64 {
        0.1 * self.options.axis_tolerance
    }

    /// A curve as a course.
    pub(super) fn along(&self, curve: &'a PoseCurve) -> Along<'a> {
        let feed_at = self.options.feed_at;
        Along { inverse: self.inverse, curve, feed_at, pole: self.pole() }
    }

    /// Nodes along a curve, for each start from where its rotaries are nearest.
    pub(super) fn curve(
        &self,
        curve: &'a PoseCurve,
        starts: &[AxisVector],
    ) -> Vec<Result<Marched, Trouble>> {
        self.march(&self.along(curve), starts)
    }

    /// Nodes along a link; no node if nothing moves.
    pub(super) fn link(
        &self,
        tips: [Point3<f64>; 2],
        rotaries: [[f64; 2]; 2],
    ) -> Result<Marched, Trouble> {
        let [from, to] = rotaries;
        let distance = (tips[1] - tips[0]).norm();
        let turn = (to[0] - from[0]).hypot(to[1] - from[1]);
        let length = if distance > 0.0 { distance } else { turn };
        if length <= 0.0 {
            return Ok(Marched::nothing());
        }
        let course = Across { inverse: self.inverse, tips, rotaries, knots: [0.0, length] };
        self.march(&course, &[AxisVector::zeros()]).pop().unwrap_or(Ok(Marched::nothing()))
    }

    /// From every start along a course. The one that is behind takes the next step, so that what all
    /// of them need at a place is computed once.
    fn march(&self, course: &dyn Course, starts: &[AxisVector]) -> Vec<Result<Marched, Trouble>> {
        let mut sight = Sight { course, span: 0, look: Look::nowhere(), middle: None };
        let mut walkers: Vec<Result<Walker, Trouble>> =
            starts.iter().map(|start| self.set_out(&mut sight, start)).collect();
        loop {
            let under_way = walkers.iter_mut().filter_map(|slot| match slot {
                Ok(walker) if !walker.targets.is_empty() => Some((walker.at(), slot)),
                _ => None,
            });
            let Some((_, slot)) = under_way.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if let Ok(walker) = slot
                && let Err(trouble) = self.advance(&mut sight, walker)
            {
                *slot = Err(trouble);
            }
        }
        walkers.into_iter().map(|walker| walker.map(Walker::finish)).collect()
    }

    /// The start of a way: what is nearest to `start`.
    fn set_out(&self, sight: &mut Sight<'_>, start: &AxisVector) -> Result<Walker, Trouble> {
        let knots = sight.course.knots();
        let first = knots.first().copied().unwrap_or(0.0);
        sight.look_at((first, 0), start)?;
        let [nearest, ..] = self.by_turn(&sight.look, start);
        let (index, nearest) = nearest.ok_or(Trouble::Inverse(first, NO_AXIS))?;
        let mut marched = Marched::nothing();
        // A few more than knots, so that a node between some of them does not move all.
        marched.nodes.reserve(knots.len() + knots.len() / 64);
        let targets = knots.get(1).copied().into_iter().collect();
        let mut walker =
            Walker { span: 0, targets, marched, lost: Vec::new(), standing: Standing::default() };
        walker.arrive(&sight.look, (index, nearest), sight.look.node(nearest, start));
        Ok(walker)
    }

    /// One step on, or a nearer target.
    fn advance(&self, sight: &mut Sight<'_>, walker: &mut Walker) -> Result<(), Trouble> {
        let knots = sight.course.knots();
        let spans = knots.len().saturating_sub(1);
        let whole = match knots {
            [first, .., last] => last - first,
            _ => 0.0,
        };
        let Some(&to) = walker.targets.last() else { return Ok(()) };
        let span = walker.span;
        let next = if walker.targets.len() == 1 { (span + 1).min(spans - 1) } else { span };
        let start = walker.at();
        match self.step(sight, walker, (to, [span, next]), whole)? {
            None => {
                walker.targets.pop();
                if walker.targets.is_empty() {
                    walker.span += 1;
                    walker.targets.extend(knots.get(walker.span + 1));
                }
            }
            Some(worst) if to - start <= SHORTEST * whole => {
                return Err(Trouble::NotFollowed(start, worst));
            }
            Some(_) => walker.targets.push(start + 0.5 * (to - start)),
        }
        Ok(())
    }

    /// One step: to the node at `to` on the first way that stays within tolerance; if there is none,
    /// how far the best is off. Spans are those of the interval and of the node.
    fn step(
        &self,
        sight: &mut Sight<'_>,
        walker: &mut Walker,
        (to, [span, next]): (f64, [usize; 2]),
        whole: f64,
    ) -> Result<Option<Deviation>, Trouble> {
        let Some(from) = walker.marched.nodes.last() else {
            return Err(Trouble::Inverse(to, NO_AXIS));
        };
        let near = &from.q[0];
        sight.look_at((to, next), near)?;
        let Sight { course, look, middle, .. } = sight;
        let mut least = Deviation { tip: f64::INFINITY, axis: f64::INFINITY };
        let settling = to - from.s <= SETTLING * whole;
        for (index, way) in self.in_order((*course, span), look, walker).into_iter().flatten() {
            let node = look.node(way, near);
            let rotaries = (node.q[0] - near).fixed_rows::<2>(FIRST_ROTARY).amax();
            if rotaries > self.options.max_rotary_step && !settling {
                continue;
            }
            let known = !walker.standing.lost && way.lost == 0;
            let deviation = self.deviation((*course, span), middle, [from, &node], known);
            if self.small(deviation, SHARE) {
                walker.marched.deviation = walker.marched.deviation.max(deviation);
                walker.arrive(look, (index, way), node);
                return Ok(None);
            }
            if deviation.tip < least.tip {
                least = deviation;
            }
        }
        Ok(Some(least))
    }

    /// The ways at a place in the order they are tried: on the same branch. Where the singular direction
    /// lies between, what turns least from `near` first: straight through is on the other.
    fn in_order<'l>(
        &self,
        course: (&dyn Course, usize),
        look: &'l Look,
        walker: &Walker,
    ) -> [Option<(usize, &'l Rates)>; WAYS] {
        match (&look.both, walker.standing.branch) {
            (Some(both), Some(branch))
                if look.more.is_empty() && !self.passes(course, walker, look) =>
            {
                let [plus, minus] = both;
                let [plus, minus] = [Some((0, plus)), Some((1, minus))];
                let [own, other] = if branch == 0 { [plus, minus] } else { [minus, plus] };
                [own, other.filter(|_| walker.targets.len() > OVER), None, None]
            }
            _ => {
                let near = walker.marched.nodes.last().map(|node| node.q[0]).unwrap_or_default();
                self.by_turn(look, &near)
            }
        }
    }

    /// Whether the singular direction is passed so close on an interval that passing through it may be
    /// within tolerance: straight from end to end, and also by its middle.
    fn passes(&self, (course, span): (&dyn Course, usize), walker: &Walker, look: &Look) -> bool {
        let [from, to] = [walker.standing.across, look.across];
        let close = SHARE * self.options.axis_tolerance;
        if nearest(from, to) > close {
            return false;
        }
        let middle = course.pose(0.5 * (walker.at() + look.u), span);
        let middle = middle.map(|pose| self.inverse.across(&pose.axis));
        middle.is_none_or(|middle| nearest(from, middle).min(nearest(middle, to)) <= close)
    }

    /// The ways at a place with their indices, the one that turns least from `near` first.
    fn by_turn<'l>(&self, look: &'l Look, near: &AxisVector) -> [Option<(usize, &'l Rates)>; WAYS] {
        let mut order = [(f64::INFINITY, None); WAYS];
        for (slot, way) in order.iter_mut().zip(look.ways().enumerate()) {
            let turned = look.unwound(way.1, near);
            *slot = (turn(&turned, near, self.options), Some(way));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        order.map(|(_, way)| way)
    }

    /// Within a share of the tolerances.
    fn small(&self, deviation: Deviation, share: f64) -> bool {
        deviation.tip <= share * self.options.tip_tolerance
            && deviation.axis <= share * self.options.axis_tolerance
    }

    /// How far the quintic between two nodes is from the course, at the checked points: in the
    /// middle only, where that and what the third derivatives say, if they are `known`, is next to
    /// nothing. Infinite where there is no pose.
    fn deviation(
        &self,
        (course, span): (&dyn Course, usize),
        middle: &mut Option<(f64, Option<ToolPose>)>,
        [from, to]: [&AxisNode; 2],
        known: bool,
    ) -> Deviation {
        let quintic = between(from, to);
        let [start, length] = [from.s, to.s - from.s];
        let off = |share: f64, wanted: Option<ToolPose>| {
            let Some(wanted) = wanted else {
                return Deviation { tip: f64::INFINITY, axis: f64::INFINITY };
            };
            let ToolPose { tip, axis } =
                self.inverse.kinematics().forward(&quintic.value(share * length));
            let distance = (tip - wanted.tip).norm();
            // `max` ignores NaN; a position that is not a number is not within any tolerance.
            let distance = if distance.is_nan() { f64::INFINITY } else { distance };
            Deviation { tip: distance, axis: angle_between(&axis, &wanted.axis) }
        };
        let [first @ .., centre, next, last] = CHECKED;
        let u = start + centre * length;
        let seen = middle.filter(|(at, _)| at.to_bits() == u.to_bits()).map(|(_, pose)| pose);
        let wanted = seen.unwrap_or_else(|| course.pose(u, span));
        *middle = Some((u, wanted));
        let worst = off(centre, wanted);
        if known && self.small(worst, SMALL) && self.smooth(&quintic, [from, to], wanted) {
            return worst;
        }
        let others = first.into_iter().chain([next, last]);
        others.fold(worst, |worst, share| {
            worst.max(off(share, course.pose(start + share * length, span)))
        })
    }

    /// Whether the third derivatives of a quintic are so close to the exact ones that its error is
    /// next to nothing.
    ///
    /// The error `k (x (l - x))³` has third derivatives `6 k l³` and `-6 k l³` at the ends and its
    /// top `k (l/2)⁶` in the middle: 1/384 of `l³` times the third derivative. An error of a rotary
    /// moves the tip by no more than the longest lever.
    fn smooth(
        &self,
        quintic: &Quintic<AXES>,
        [from, to]: [&AxisNode; 2],
        wanted: Option<ToolPose>,
    ) -> bool {
        let length = to.s - from.s;
        let [start, end] = quintic.thirds();
        let off = (start - from.q[3]).sup(&(from.q[3] - start));
        let off = off.sup(&(end - to.q[3])).sup(&(to.q[3] - end));
        let top = off * (length.powi(3) / 384.0);
        let slides = top.fixed_rows::<FIRST_ROTARY>(0).sum();
        let turn = top[FIRST_ROTARY] + top[SECOND_ROTARY];
        let chain = self.inverse.kinematics().chain();
        let [first, second] = &chain.rotary;
        let at = wanted.map_or(f64::INFINITY, |pose| (pose.tip.coords - first.point).norm());
        let lever = at + (second.point - first.point).norm() + (chain.tip - second.point).norm();
        let lever = lever + to.q[0].fixed_rows::<FIRST_ROTARY>(0).norm();
        self.small(Deviation { tip: slides + lever * turn, axis: turn }, SMALL)
    }
}

/// What a place on the way has for all that come along.
struct Sight<'a> {
    course: &'a dyn Course,
    /// The last place looked at, and from which span.
    span: usize,
    look: Look,
    /// The pose in the middle of the last interval, and its parameter.
    middle: Option<(f64, Option<ToolPose>)>,
}

impl Sight<'_> {
    /// Looks at a place, unless that is known.
    fn look_at(&mut self, (u, span): (f64, usize), near: &AxisVector) -> Result<(), Trouble> {
        let known = self.span == span && self.look.u.to_bits() == u.to_bits() && !self.look.held;
        if known {
            return Ok(());
        }
        self.span = span;
        let looked = self.course.look(u, span, near, &mut self.look);
        looked.map_err(|error| {
            self.look = Look::nowhere();
            Trouble::Inverse(u, error)
        })
    }
}

/// One way along a course, as far as it has come.
struct Walker {
    span: usize,
    /// Where to, the nearest last.
    targets: Vec<f64>,
    marched: Marched,
    /// Nodes whose highest derivatives are not known.
    lost: Vec<usize>,
    standing: Standing,
}

/// How a way stands at its last node.
#[derive(Debug, Clone, Copy, Default)]
struct Standing {
    /// Which branch it is on, if any.
    branch: Option<usize>,
    /// Part of the tool axis square to the singular direction.
    across: [f64; 2],
    /// Whether the highest derivatives are not known.
    lost: bool,
}

impl Walker {
    /// Parameter of the last node.
    fn at(&self) -> f64 {
        self.marched.nodes.last().map_or(f64::INFINITY, |node| node.s)
    }

    fn arrive(&mut self, look: &Look, (index, way): (usize, &Rates), node: AxisNode) {
        let lost = way.lost > 0;
        if lost {
            self.lost.push(self.marched.nodes.len());
        }
        let branch = look.both.is_some().then_some(index).filter(|index| *index < 2);
        self.standing = Standing { branch, across: look.across, lost };
        self.marched.nodes.push(node);
    }

    fn finish(mut self) -> Marched {
        self.marched.complete(&self.lost);
        self.marched
    }
}

/// Distance from the origin of the straight line between two points.
fn nearest(from: [f64; 2], to: [f64; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (along, square) = (-dot(from, way), dot(way, way));
    let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    let point = [from[0] + share * way[0], from[1] + share * way[1]];
    dot(point, point).sqrt()
}

/// Weighted rotary travel between two positions \[rad\].
pub(super) fn turn(to: &AxisVector, from: &AxisVector, options: &AxesOptions) -> f64 {
    let [first, second] = options.rotary_weights;
    first * (to[FIRST_ROTARY] - from[FIRST_ROTARY]).abs()
        + second * (to[SECOND_ROTARY] - from[SECOND_ROTARY]).abs()
}

/// The axis path between two nodes.
fn between(from: &AxisNode, to: &AxisNode) -> Quintic<AXES> {
    let jet = |q: &[AxisVector; 4]| [q[0], q[1], q[2]];
    Quintic::new(to.s - from.s, jet(&from.q), jet(&to.q))
}

impl Marched {
    pub(super) fn nothing() -> Self {
        Self { nodes: Vec::new(), deviation: Deviation::default() }
    }

    /// Two nodes between which every axis moves in proportion, over the way of the slides \[mm\] or
    /// the turn of the rotaries \[rad\]; no node if nothing moves.
    ///
    /// The speed of the tip counts as that of the slides: while rotaries swing a tool that is far
    /// from the part, their own limits hold.
    pub(super) fn proportional(from: &AxisVector, to: &AxisVector) -> Self {
        let way = to - from;
        let [slides, turn] =
            [way.fixed_rows::<3>(0).norm(), way.fixed_rows::<2>(FIRST_ROTARY).norm()];
        let length = if slides > 0.0 { slides } else { turn };
        if length <= 0.0 {
            return Self::nothing();
        }
        let rate = slides / length;
        let zero = AxisVector::zeros();
        let node = |s: f64, q: &AxisVector| AxisNode {
            s,
            q: [*q, way / length, zero, zero],
            tip_rate: rate,
            feed_rate: rate,
        };
        let nodes = vec![node(0.0, from), node(length, to)];
        Self { nodes, deviation: Deviation::default() }
    }

    /// How far the axes go from each node to the next.
    pub(super) fn bounds(&self) -> impl Iterator<Item = Bounds> {
        self.nodes.windows(2).map(|pair| Bounds::between(&pair[0], &pair[1]))
    }

    /// The nodes of a piece, if it moves at all.
    pub(super) fn into_nodes(self) -> Option<Vec<AxisNode>> {
        (self.nodes.len() > 1).then_some(self.nodes)
    }

    /// Third derivatives that are not known exactly are those of the quintic beside the node.
    fn complete(&mut self, lost: &[usize]) {
        let count = self.nodes.len();
        for &index in lost {
            let from = index.min(count.saturating_sub(2));
            if let (Some(&a), Some(&b)) = (self.nodes.get(from), self.nodes.get(from + 1)) {
                let [_, _, _, third] =
                    between(&a, &b).at(if index == from { 0.0 } else { b.s - a.s });
                if let Some(node) = self.nodes.get_mut(index) {
                    node.q[3] = third;
                }
            }
        }
    }
}
