//! Path following with step control: nodes so close that quintics between them follow the motion.

use super::axis_bounds::{AxisBounds, quintic_between, rotary_cost};
use super::error::AxesError;
use super::options::AxesOptions;
use super::path_motion::{CurveMotion, Evaluation, LinkMotion, PathMotion};
use super::result::PathDeviation;
use crate::inverse::{AxisJets, Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, SECOND_ROTARY};
use crate::math;
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

/// Intervals that would be shorter than this share of the piece are an error instead.
const SHORTEST: f64 = 1e-10;

/// Intervals shorter than this share of the piece may turn a rotary by any amount: on them only
/// the deviation counts. So a free axis can settle while the tool leaves the singular direction.
const SETTLING: f64 = 1e-4;

/// Halvings of an interval after which a track may change to the other branch where both meet, at the rim
/// of reach: a thousandth of it cannot be followed on one.
const OVER: usize = 10;

/// Share of the tolerance below which the error of an interval is not checked further.
const SMALL: f64 = 0.01;

/// Solutions at one parameter at most: both branches through a singular direction, and both beside it.
const SOLUTIONS: usize = 4;

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

/// One solution of the inverse at a parameter, with its index among all of them.
#[derive(Clone, Copy)]
struct Solution<'l> {
    /// 0 and 1 are the branches plus and minus where both are determined.
    index: usize,
    jets: &'l AxisJets,
}

/// A motion within one of its spans, on which it is smooth.
#[derive(Clone, Copy)]
struct MotionSpan<'a> {
    motion: &'a dyn PathMotion,
    span: usize,
}

impl MotionSpan<'_> {
    fn pose(&self, u: f64) -> Option<ToolPose> {
        self.motion.pose(u, self.span)
    }
}

/// Node that the next step is to reach.
#[derive(Clone, Copy)]
struct StepTarget {
    /// Its parameter.
    u: f64,
    /// Span of the interval up to it.
    span: usize,
    /// Span of the node itself, which is the next one at the end of a span.
    node_span: usize,
}

/// Pose in the middle of an interval, kept because halving the interval asks for it again.
#[derive(Clone, Copy)]
struct MiddlePose {
    u: f64,
    pose: Option<ToolPose>,
}

/// Exactness of the third derivatives at both ends of an interval.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ThirdDerivatives {
    Exact,
    Unknown,
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
    /// Returns the angle to the singular direction up to which a tool axis may be taken to be on it
    /// \[rad\]: a share of the tolerance that leaves the rest to the quintics beside it.
    pub(super) fn pole(&self) -> f64 {
        0.1 * self.options.tolerance.axis
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
        self.follow(&self.along(curve), starts)
    }

    /// Returns nodes along a link; none if nothing moves.
    pub(super) fn link(
        &self,
        tips: [Point3<f64>; 2],
        rotaries: [[f64; 2]; 2],
    ) -> Result<AxisTrack, FollowError> {
        let [from, to] = rotaries;
        let distance = (tips[1] - tips[0]).norm();
        let turn = math::hypot(to[0] - from[0], to[1] - from[1]);
        let length = if distance > 0.0 { distance } else { turn };
        if length <= 0.0 {
            return Ok(AxisTrack::nothing());
        }
        // A link has one solution: its rotaries are prescribed, so that the start does not matter.
        let motion = LinkMotion { inverse: self.inverse, tips, rotaries, knots: [0.0, length] };
        self.follow(&motion, &[AxisVector::zeros()]).pop().unwrap_or(Ok(AxisTrack::nothing()))
    }

    /// Follows a motion from every start. The track that is furthest behind takes the next step, so
    /// that the kinematics at one parameter are computed once for all.
    fn follow(
        &self,
        motion: &dyn PathMotion,
        starts: &[AxisVector],
    ) -> Vec<Result<AxisTrack, FollowError>> {
        let mut cache =
            EvaluationCache { motion, span: 0, evaluation: Evaluation::unset(), middle: None };
        let mut trackers: Vec<Result<BranchTracker, FollowError>> =
            starts.iter().map(|start| self.set_out(&mut cache, start)).collect();
        loop {
            let unfinished = trackers.iter_mut().filter_map(|slot| match slot {
                Ok(tracker) if !tracker.targets.is_empty() => Some((tracker.at(), slot)),
                _ => None,
            });
            let Some((_, slot)) = unfinished.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
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
        cache.evaluate_at(first, 0, start)?;
        let [nearest, ..] = self.by_turn(&cache.evaluation, start);
        let nearest = nearest.ok_or(FollowError::Inverse(first, NO_AXIS))?;
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
        tracker.arrive(&cache.evaluation, nearest, cache.evaluation.node(nearest.jets, start));
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
        let node_span = if tracker.targets.len() == 1 { (span + 1).min(spans - 1) } else { span };
        let start = tracker.at();
        match self.step(cache, tracker, StepTarget { u: to, span, node_span }, whole)? {
            None => {
                // A target that was set by halving leaves the ones beyond it on the stack.
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

    /// Takes one step to a target, on the first solution that stays within tolerance; if none does, returns
    /// the least deviation. `whole` is the length of the motion.
    fn step(
        &self,
        cache: &mut EvaluationCache<'_>,
        tracker: &mut BranchTracker,
        target: StepTarget,
        whole: f64,
    ) -> Result<Option<PathDeviation>, FollowError> {
        let StepTarget { u: to, span, node_span } = target;
        let Some(from) = tracker.track.nodes.last() else {
            return Err(FollowError::Inverse(to, NO_AXIS));
        };
        let near = &from.q[0];
        cache.evaluate_at(to, node_span, near)?;
        let EvaluationCache { motion, evaluation, middle, .. } = cache;
        let interval = MotionSpan { motion: *motion, span };
        let mut least = PathDeviation { tip: f64::INFINITY, axis: f64::INFINITY };
        let settling = to - from.s <= SETTLING * whole;
        for solution in self.in_order(interval, evaluation, tracker).into_iter().flatten() {
            let node = evaluation.node(solution.jets, near);
            // A jump to another branch shows as a large rotary step, and so does a pole passed beside.
            let rotaries = (node.q[0] - near).fixed_rows::<2>(FIRST_ROTARY).amax();
            if rotaries > self.options.max_rotary_step && !settling {
                continue;
            }
            let thirds = if tracker.state.lost || solution.jets.lost > 0 {
                ThirdDerivatives::Unknown
            } else {
                ThirdDerivatives::Exact
            };
            let deviation = self.deviation(interval, middle, [from, &node], thirds);
            if self.small(deviation, SHARE) {
                tracker.track.deviation = tracker.track.deviation.max(deviation);
                tracker.arrive(evaluation, solution, node);
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
        interval: MotionSpan<'_>,
        evaluation: &'l Evaluation,
        tracker: &BranchTracker,
    ) -> [Option<Solution<'l>>; SOLUTIONS] {
        match (&evaluation.both, tracker.state.branch) {
            (Some(both), Some(branch))
                if evaluation.more.is_empty() && !self.passes(interval, tracker, evaluation) =>
            {
                let [plus, minus] = both;
                let [plus, minus] =
                    [(0, plus), (1, minus)].map(|(index, jets)| Some(Solution { index, jets }));
                let [own, other] = if branch == 0 { [plus, minus] } else { [minus, plus] };
                // Away from the singular direction branches meet only at the rim of reach.
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
        interval: MotionSpan<'_>,
        tracker: &BranchTracker,
        evaluation: &Evaluation,
    ) -> bool {
        // `across` is the tool axis projected along the singular direction: a point of the plane whose
        // distance from the origin is the sine of the angle to that direction.
        let [from, to] = [tracker.state.across, evaluation.across];
        let close = SHARE * self.options.tolerance.axis;
        if nearest(from, to) > close {
            return false;
        }
        // A curved motion may pass farther off than its chord: the chords of both halves decide.
        let middle = interval.pose(0.5 * (tracker.at() + evaluation.u));
        let middle = middle.map(|pose| self.inverse.across(&pose.axis));
        middle.is_none_or(|middle| nearest(from, middle).min(nearest(middle, to)) <= close)
    }

    /// Returns the solutions at a parameter with their indices, the least turn from `near` first.
    fn by_turn<'l>(
        &self,
        evaluation: &'l Evaluation,
        near: &AxisVector,
    ) -> [Option<Solution<'l>>; SOLUTIONS] {
        let mut order = [(f64::INFINITY, None); SOLUTIONS];
        for (slot, (index, jets)) in order.iter_mut().zip(evaluation.solutions().enumerate()) {
            let turned = evaluation.unwound(jets, near);
            *slot = (rotary_cost(&turned, near, self.options), Some(Solution { index, jets }));
        }
        // Stable, so that of equal turns the branch plus comes first.
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        order.map(|(_, solution)| solution)
    }

    /// Returns `true` if a deviation is within a share of the tolerances.
    fn small(&self, deviation: PathDeviation, share: f64) -> bool {
        deviation.tip <= share * self.options.tolerance.tip
            && deviation.axis <= share * self.options.tolerance.axis
    }

    /// Returns the largest deviation of the quintic between two nodes from the motion at the check points.
    ///
    /// The middle alone is checked where the deviation there, and the error that the third derivatives
    /// show, are far below the tolerances. Infinite where there is no pose.
    fn deviation(
        &self,
        interval: MotionSpan<'_>,
        middle: &mut Option<MiddlePose>,
        [from, to]: [&AxisNode; 2],
        thirds: ThirdDerivatives,
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
        // The other solutions of the same interval are checked at the same middle.
        let known = middle.filter(|known| known.u.to_bits() == u.to_bits());
        let wanted = known.map_or_else(|| interval.pose(u), |known| known.pose);
        *middle = Some(MiddlePose { u, pose: wanted });
        let worst = off(centre, wanted);
        let exact = thirds == ThirdDerivatives::Exact;
        if exact && self.small(worst, SMALL) && self.smooth(&quintic, [from, to], wanted) {
            return worst;
        }
        let others = first.into_iter().chain([next, last]);
        others.fold(worst, |worst, share| {
            worst.max(off(share, interval.pose(start + share * length)))
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
        // Top of the error: k (l/2)⁶ with third derivative 6 k l³, so l³ / 384 of it.
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
    /// The middle of the last interval.
    middle: Option<MiddlePose>,
}

impl EvaluationCache<'_> {
    /// Evaluates the motion at a parameter of a span, unless that is known.
    fn evaluate_at(&mut self, u: f64, span: usize, near: &AxisVector) -> Result<(), FollowError> {
        // A held rotary stays where each track has it, so that its evaluation cannot be shared.
        let known = self.span == span
            && self.evaluation.u.to_bits() == u.to_bits()
            && !self.evaluation.held;
        if known {
            return Ok(());
        }
        self.span = span;
        let evaluated = self.motion.evaluate(u, span, near, &mut self.evaluation);
        evaluated.map_err(|error| {
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
    /// Returns the parameter of the last node.
    fn at(&self) -> f64 {
        self.track.nodes.last().map_or(f64::INFINITY, |node| node.s)
    }

    /// Appends a node that was reached with a solution.
    fn arrive(&mut self, evaluation: &Evaluation, solution: Solution<'_>, node: AxisNode) {
        let Solution { index, jets } = solution;
        let lost = jets.lost > 0;
        if lost {
            self.lost.push(self.track.nodes.len());
        }
        // Further solutions, and a held rotary, belong to no branch.
        let branch = evaluation.both.is_some().then_some(index).filter(|index| *index < 2);
        self.state = TrackerState { branch, across: evaluation.across, lost };
        self.track.nodes.push(node);
    }

    fn finish(mut self) -> AxisTrack {
        self.track.complete(&self.lost);
        self.track
    }
}

/// Returns the distance of the segment between two points from the origin.
fn nearest(from: [f64; 2], to: [f64; 2]) -> f64 {
    let chord = [to[0] - from[0], to[1] - from[1]];
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (along, square) = (-dot(from, chord), dot(chord, chord));
    // Foot of the perpendicular, kept on the segment.
    let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    let point = [from[0] + share * chord[0], from[1] + share * chord[1]];
    dot(point, point).sqrt()
}

impl AxisTrack {
    /// Creates a track without nodes.
    pub(super) fn nothing() -> Self {
        Self { nodes: Vec::new(), deviation: PathDeviation::default() }
    }

    /// Creates two nodes between which every axis moves in proportion, over the travel of the linear axes
    /// \[mm\] or the turn of the rotaries \[rad\]; no node if nothing moves.
    ///
    /// The speed of the tip counts as that of the slides: while rotaries swing a tool that is far
    /// from the part, their own limits hold.
    pub(super) fn proportional(from: &AxisVector, to: &AxisVector) -> Self {
        let travel = to - from;
        let [slides, turn] =
            [travel.fixed_rows::<3>(0).norm(), travel.fixed_rows::<2>(FIRST_ROTARY).norm()];
        let length = if slides > 0.0 { slides } else { turn };
        if length <= 0.0 {
            return Self::nothing();
        }
        let rate = slides / length;
        let zero = AxisVector::zeros();
        let node = |s: f64, q: &AxisVector| AxisNode {
            s,
            q: [*q, travel / length, zero, zero],
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

    /// Returns the nodes of a piece, if it moves at all.
    pub(super) fn into_nodes(self) -> Option<Vec<AxisNode>> {
        (self.nodes.len() > 1).then_some(self.nodes)
    }

    /// Fills in third derivatives that are not known exactly: those of the quintic beside the node.
    fn complete(&mut self, lost: &[usize]) {
        let count = self.nodes.len();
        for &index in lost {
            // The quintic after the node, or before it if it is the last one.
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
