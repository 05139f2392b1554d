//! Nodes along a motion, so close that quintics between them follow it.

use super::axis_bounds::{AxisBounds, quintic_between, rotary_cost};
use super::error::AxesError;
use super::options::AxesOptions;
use super::path_motion::{CurveMotion, Evaluation, LinkMotion, PathMotion};
use super::result::PathDeviation;
use crate::inverse::{AxisJets, Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math::angle::angle_between;
use crate::math::quintic::Quintic;
use crate::types::{AXES, AxisNode, AxisVector, PoseCurve, ToolPose};
use nalgebra::Point3;

/// Share of the tolerance that deviations at checked points may use. The error of a quintic
/// between exact nodes is (t(1-t))³ to leading order; the checked points miss its top by less
/// than a tenth, and the rest is for what is not leading order.
const SHARE: f64 = 0.5;

/// Check points of an interval, as shares of it.
const CHECKED: [f64; 5] = [0.15, 0.325, 0.5, 0.675, 0.85];

/// Intervals shorter than this share of the piece give up.
const SHORTEST: f64 = 1e-10;

/// Intervals shorter than this share of the piece may turn a rotary by any amount: on them only
/// the deviation counts. So a free axis can settle while the tool leaves the singular direction.
const SETTLING: f64 = 1e-4;

/// Halvings of an interval after which a track may change to the other branch where both meet, at the rim
/// of reach: a thousandth of it cannot be followed on one.
const OVER: usize = 10;

/// Share of the tolerance below which the error of an interval is not checked further.
const SMALL: f64 = 0.01;

/// Solutions at one parameter: both branches through a singular direction, and both beside it.
const WAYS: usize = 4;

/// A pose without an axis.
const NO_AXIS: InverseError = InverseError::NotFinite { what: "the tool axis" };

/// Follower of motions with an inverse and tolerances.
#[derive(Debug, Clone, Copy)]
pub(super) struct PathFollower<'a> {
    pub(super) inverse: &'a Inverse,
    pub(super) options: &'a AxesOptions,
}

/// Nodes along a motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct AxisTrack {
    pub(super) nodes: Vec<AxisNode>,
    pub(super) deviation: PathDeviation,
}

/// Reason why a motion cannot be followed, with the parameter.
pub(super) enum FollowError {
    Inverse(f64, InverseError),
    NotFollowed(f64, PathDeviation),
}

impl FollowError {
    /// Converts to the error of a piece.
    pub(super) fn of(self, piece: usize) -> AxesError {
        match self {
            Self::Inverse(u, source) => AxesError::Inverse { piece, u, source },
            Self::NotFollowed(u, PathDeviation { tip, axis }) => {
                AxesError::NotFollowed { piece, u, tip, axis }
            }
        }
    }
}

impl<'a> PathFollower<'a> {
    /// Directions this close to the singular one may be taken to be on it \[rad\]: a share of the
    /// tolerance that leaves the rest to the quintics beside it.
    pub(super) fn pole(&self) -> f64 {
        0.1 * self.options.axis_tolerance
    }

    /// Returns a curve as a motion.
    pub(super) fn along(&self, curve: &'a PoseCurve) -> CurveMotion<'a> {
        let feed_at = self.options.feed_at;
        CurveMotion { inverse: self.inverse, curve, feed_at, pole: self.pole() }
    }

    /// Returns nodes along a curve, one track for each start, from the solution with the nearest rotaries.
    pub(super) fn curve(
        &self,
        curve: &'a PoseCurve,
        starts: &[AxisVector],
    ) -> Vec<Result<AxisTrack, FollowError>> {
        self.march(&self.along(curve), starts)
    }

    /// Returns nodes along a link; none if nothing moves.
    pub(super) fn link(
        &self,
        tips: [Point3<f64>; 2],
        rotaries: [[f64; 2]; 2],
    ) -> Result<AxisTrack, FollowError> {
        let [from, to] = rotaries;
        let distance = (tips[1] - tips[0]).norm();
        let turn = (to[0] - from[0]).hypot(to[1] - from[1]);
        let length = if distance > 0.0 { distance } else { turn };
        if length <= 0.0 {
            return Ok(AxisTrack::nothing());
        }
        let motion = LinkMotion { inverse: self.inverse, tips, rotaries, knots: [0.0, length] };
        self.march(&motion, &[AxisVector::zeros()]).pop().unwrap_or(Ok(AxisTrack::nothing()))
    }

    /// Follows a motion from every start. The track that is furthest behind takes the next step, so
    /// that the kinematics at one parameter are computed once for all.
    fn march(
        &self,
        motion: &dyn PathMotion,
        starts: &[AxisVector],
    ) -> Vec<Result<AxisTrack, FollowError>> {
        let mut cache =
            EvaluationCache { motion, span: 0, evaluation: Evaluation::unset(), middle: None };
        let mut trackers: Vec<Result<BranchTracker, FollowError>> =
            starts.iter().map(|start| self.set_out(&mut cache, start)).collect();
        loop {
            let under_way = trackers.iter_mut().filter_map(|slot| match slot {
                Ok(tracker) if !tracker.targets.is_empty() => Some((tracker.at(), slot)),
                _ => None,
            });
            let Some((_, slot)) = under_way.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            if let Ok(tracker) = slot
                && let Err(trouble) = self.advance(&mut cache, tracker)
            {
                *slot = Err(trouble);
            }
        }
        trackers.into_iter().map(|tracker| tracker.map(BranchTracker::finish)).collect()
    }

    /// Starts a track at the solution nearest to `start`.
    fn set_out(
        &self,
        cache: &mut EvaluationCache<'_>,
        start: &AxisVector,
    ) -> Result<BranchTracker, FollowError> {
        let knots = cache.motion.knots();
        let first = knots.first().copied().unwrap_or(0.0);
        cache.evaluate_at((first, 0), start)?;
        let [nearest, ..] = self.by_turn(&cache.evaluation, start);
        let (index, nearest) = nearest.ok_or(FollowError::Inverse(first, NO_AXIS))?;
        let mut track = AxisTrack::nothing();
        // A few more than knots, so that a node between some of them does not move all.
        track.nodes.reserve(knots.len() + knots.len() / 64);
        let targets = knots.get(1).copied().into_iter().collect();
        let mut tracker = BranchTracker {
            span: 0,
            targets,
            track,
            lost: Vec::new(),
            state: TrackerState::default(),
        };
        tracker.arrive(&cache.evaluation, (index, nearest), cache.evaluation.node(nearest, start));
        Ok(tracker)
    }

    /// Takes one step, or sets a nearer target.
    fn advance(
        &self,
        cache: &mut EvaluationCache<'_>,
        tracker: &mut BranchTracker,
    ) -> Result<(), FollowError> {
        let knots = cache.motion.knots();
        let spans = knots.len().saturating_sub(1);
        let whole = match knots {
            [first, .., last] => last - first,
            _ => 0.0,
        };
        let Some(&to) = tracker.targets.last() else { return Ok(()) };
        let span = tracker.span;
        // The last target is the knot at the end of the span, where the next span begins.
        let next = if tracker.targets.len() == 1 { (span + 1).min(spans - 1) } else { span };
        let start = tracker.at();
        match self.step(cache, tracker, (to, [span, next]), whole)? {
            None => {
                tracker.targets.pop();
                if tracker.targets.is_empty() {
                    tracker.span += 1;
                    tracker.targets.extend(knots.get(tracker.span + 1));
                }
            }
            Some(worst) if to - start <= SHORTEST * whole => {
                return Err(FollowError::NotFollowed(start, worst));
            }
            // Too far for one quintic: halve the interval.
            Some(_) => tracker.targets.push(start + 0.5 * (to - start)),
        }
        Ok(())
    }

    /// Takes one step to the node at `to`, on the first solution that stays within tolerance; if none
    /// does, returns the least deviation. Spans are those of the interval and of the node.
    fn step(
        &self,
        cache: &mut EvaluationCache<'_>,
        tracker: &mut BranchTracker,
        (to, [span, next]): (f64, [usize; 2]),
        whole: f64,
    ) -> Result<Option<PathDeviation>, FollowError> {
        let Some(from) = tracker.track.nodes.last() else {
            return Err(FollowError::Inverse(to, NO_AXIS));
        };
        let near = &from.q[0];
        cache.evaluate_at((to, next), near)?;
        let EvaluationCache { motion, evaluation, middle, .. } = cache;
        let mut least = PathDeviation { tip: f64::INFINITY, axis: f64::INFINITY };
        let settling = to - from.s <= SETTLING * whole;
        for (index, way) in
            self.in_order((*motion, span), evaluation, tracker).into_iter().flatten()
        {
            let node = evaluation.node(way, near);
            let rotaries = (node.q[0] - near).fixed_rows::<2>(FIRST_ROTARY).amax();
            if rotaries > self.options.max_rotary_step && !settling {
                continue;
            }
            let known = !tracker.state.lost && way.lost == 0;
            let deviation = self.deviation((*motion, span), middle, [from, &node], known);
            if self.small(deviation, SHARE) {
                tracker.track.deviation = tracker.track.deviation.max(deviation);
                tracker.arrive(evaluation, (index, way), node);
                return Ok(None);
            }
            if deviation.tip < least.tip {
                least = deviation;
            }
        }
        Ok(Some(least))
    }

    /// Returns the solutions at a parameter in the order they are tried: the same branch first. Where the
    /// singular direction lies between, the least turn comes first: straight through is the other branch.
    fn in_order<'l>(
        &self,
        motion: (&dyn PathMotion, usize),
        evaluation: &'l Evaluation,
        tracker: &BranchTracker,
    ) -> [Option<(usize, &'l AxisJets)>; WAYS] {
        match (&evaluation.both, tracker.state.branch) {
            (Some(both), Some(branch))
                if evaluation.more.is_empty() && !self.passes(motion, tracker, evaluation) =>
            {
                let [plus, minus] = both;
                let [plus, minus] = [Some((0, plus)), Some((1, minus))];
                let [own, other] = if branch == 0 { [plus, minus] } else { [minus, plus] };
                [own, other.filter(|_| tracker.targets.len() > OVER), None, None]
            }
            _ => {
                let near = tracker.track.nodes.last().map(|node| node.q[0]).unwrap_or_default();
                self.by_turn(evaluation, &near)
            }
        }
    }

    /// Returns `true` if an interval passes the singular direction so close that passing through it may be
    /// within tolerance: straight from end to end, and also by its middle.
    fn passes(
        &self,
        (motion, span): (&dyn PathMotion, usize),
        tracker: &BranchTracker,
        evaluation: &Evaluation,
    ) -> bool {
        let [from, to] = [tracker.state.across, evaluation.across];
        let close = SHARE * self.options.axis_tolerance;
        if nearest(from, to) > close {
            return false;
        }
        let middle = motion.pose(0.5 * (tracker.at() + evaluation.u), span);
        let middle = middle.map(|pose| self.inverse.across(&pose.axis));
        middle.is_none_or(|middle| nearest(from, middle).min(nearest(middle, to)) <= close)
    }

    /// Returns the solutions at a parameter with their indices, the least turn from `near` first.
    fn by_turn<'l>(
        &self,
        evaluation: &'l Evaluation,
        near: &AxisVector,
    ) -> [Option<(usize, &'l AxisJets)>; WAYS] {
        let mut order = [(f64::INFINITY, None); WAYS];
        for (slot, way) in order.iter_mut().zip(evaluation.ways().enumerate()) {
            let turned = evaluation.unwound(way.1, near);
            *slot = (rotary_cost(&turned, near, self.options), Some(way));
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        order.map(|(_, way)| way)
    }

    /// Returns `true` if a deviation is within a share of the tolerances.
    fn small(&self, deviation: PathDeviation, share: f64) -> bool {
        deviation.tip <= share * self.options.tip_tolerance
            && deviation.axis <= share * self.options.axis_tolerance
    }

    /// Returns the deviation of the quintic between two nodes from the motion, at the check points: in the
    /// middle only, where that and the error by the third derivatives, if they are `known`, is next to
    /// nothing. Infinite where there is no pose.
    fn deviation(
        &self,
        (motion, span): (&dyn PathMotion, usize),
        middle: &mut Option<(f64, Option<ToolPose>)>,
        [from, to]: [&AxisNode; 2],
        known: bool,
    ) -> PathDeviation {
        let quintic = quintic_between(from, to);
        let [start, length] = [from.s, to.s - from.s];
        let off = |share: f64, wanted: Option<ToolPose>| {
            let Some(wanted) = wanted else {
                return PathDeviation { tip: f64::INFINITY, axis: f64::INFINITY };
            };
            let ToolPose { tip, axis } =
                self.inverse.kinematics().forward(&quintic.value(share * length));
            let distance = (tip - wanted.tip).norm();
            // `max` ignores NaN; a position that is not a number is not within any tolerance.
            let distance = if distance.is_nan() { f64::INFINITY } else { distance };
            PathDeviation { tip: distance, axis: angle_between(&axis, &wanted.axis) }
        };
        let [first @ .., centre, next, last] = CHECKED;
        let u = start + centre * length;
        let seen = middle.filter(|(at, _)| at.to_bits() == u.to_bits()).map(|(_, pose)| pose);
        let wanted = seen.unwrap_or_else(|| motion.pose(u, span));
        *middle = Some((u, wanted));
        let worst = off(centre, wanted);
        if known && self.small(worst, SMALL) && self.smooth(&quintic, [from, to], wanted) {
            return worst;
        }
        let others = first.into_iter().chain([next, last]);
        others.fold(worst, |worst, share| {
            worst.max(off(share, motion.pose(start + share * length, span)))
        })
    }

    /// Returns `true` if the third derivatives of a quintic are so close to the exact ones that its error is
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
        // Largest absolute error of the third derivatives at both ends, axis by axis.
        let off = (start - from.q[3]).sup(&(from.q[3] - start));
        let off = off.sup(&(end - to.q[3])).sup(&(to.q[3] - end));
        let top = off * (length.powi(3) / 384.0);
        let slides = top.fixed_rows::<FIRST_ROTARY>(0).sum();
        let turn = top[FIRST_ROTARY] + top[SECOND_ROTARY];
        let chain = self.inverse.kinematics().chain();
        let [first, second] = &chain.rotary;
        // Longest lever: tip to first rotary, first to second, second to tool, and the linear axes.
        let at = wanted.map_or(f64::INFINITY, |pose| (pose.tip.coords - first.point).norm());
        let lever = at + (second.point - first.point).norm() + (chain.tip - second.point).norm();
        let lever = lever + to.q[0].fixed_rows::<FIRST_ROTARY>(0).norm();
        self.small(PathDeviation { tip: slides + lever * turn, axis: turn }, SMALL)
    }
}

/// Exact kinematics at one path parameter, shared by all branches being followed.
struct EvaluationCache<'a> {
    motion: &'a dyn PathMotion,
    /// Span of the last evaluation.
    span: usize,
    evaluation: Evaluation,
    /// The pose in the middle of the last interval, and its parameter.
    middle: Option<(f64, Option<ToolPose>)>,
}

impl EvaluationCache<'_> {
    /// Evaluates the motion at a parameter, unless that is known.
    fn evaluate_at(
        &mut self,
        (u, span): (f64, usize),
        near: &AxisVector,
    ) -> Result<(), FollowError> {
        let known = self.span == span
            && self.evaluation.u.to_bits() == u.to_bits()
            && !self.evaluation.held;
        if known {
            return Ok(());
        }
        self.span = span;
        let looked = self.motion.evaluate(u, span, near, &mut self.evaluation);
        looked.map_err(|error| {
            self.evaluation = Evaluation::unset();
            FollowError::Inverse(u, error)
        })
    }
}

/// One branch along a motion, up to the last node.
struct BranchTracker {
    span: usize,
    /// Parameters still to reach, the nearest last.
    targets: Vec<f64>,
    track: AxisTrack,
    /// Nodes whose highest derivatives are not known.
    lost: Vec<usize>,
    state: TrackerState,
}

/// State of a branch at its last node.
#[derive(Debug, Clone, Copy, Default)]
struct TrackerState {
    /// Branch of the inverse, if determined.
    branch: Option<usize>,
    /// Part of the tool axis square to the singular direction.
    across: [f64; 2],
    /// `true` if the highest derivatives are unknown.
    lost: bool,
}

impl BranchTracker {
    /// Parameter of the last node.
    fn at(&self) -> f64 {
        self.track.nodes.last().map_or(f64::INFINITY, |node| node.s)
    }

    fn arrive(
        &mut self,
        evaluation: &Evaluation,
        (index, way): (usize, &AxisJets),
        node: AxisNode,
    ) {
        let lost = way.lost > 0;
        if lost {
            self.lost.push(self.track.nodes.len());
        }
        let branch = evaluation.both.is_some().then_some(index).filter(|index| *index < 2);
        self.state = TrackerState { branch, across: evaluation.across, lost };
        self.track.nodes.push(node);
    }

    fn finish(mut self) -> AxisTrack {
        self.track.complete(&self.lost);
        self.track
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

impl AxisTrack {
    pub(super) fn nothing() -> Self {
        Self { nodes: Vec::new(), deviation: PathDeviation::default() }
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
        Self { nodes, deviation: PathDeviation::default() }
    }

    /// Returns the extent of the axes from each node to the next.
    pub(super) fn bounds(&self) -> impl Iterator<Item = AxisBounds> {
        self.nodes.windows(2).map(|pair| AxisBounds::between(&pair[0], &pair[1]))
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
                    quintic_between(&a, &b).at(if index == from { 0.0 } else { b.s - a.s });
                if let Some(node) = self.nodes.get_mut(index) {
                    node.q[3] = third;
                }
            }
        }
    }
}
