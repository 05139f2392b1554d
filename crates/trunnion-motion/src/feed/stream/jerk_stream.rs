//! A stream that keeps jerk limits.

use super::nodes::{NodeEntry, NodeQueue};
use super::options::{MOST_OVERRIDE, StreamOptions};
use super::step::StreamStep;
use crate::feed::error::FeedError;
use crate::feed::jerk::{CellMotion, PathAhead, RollingPlan, stop};
use crate::feed::limits::Limits;
use crate::feed::options::SpeedOverrides;
use crate::feed::plan::LimitRatios;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::feed::validate;
use crate::types::{AXES, AxisNode, LinearSegment, Motion};

/// The window grows to this many times its rows where the distance to stop is longer. That goes with the square of
/// the speed, or its power 3/2 where jerk alone limits: eight windows let it be 2.8 to 4 times what one can stop,
/// for 4 MB at 512 rows of five axes.
const WIDEST: usize = 8;

/// Fewest nodes that a plan is extended by while more are to come, as a share of a quarter of the window: a search over all
/// of the plan for each few of them would cost more than it brings.
const FEWEST_SHARE: usize = 4;

/// Plans a path that arrives node by node, within velocity, acceleration and jerk limits.
///
/// Works as [`FeedStream`](crate::feed::FeedStream): [`JerkStream::begin`] and [`JerkStream::push`] take nodes,
/// [`JerkStream::next`] returns the committed schedule step by step. After every step the axes can still
/// stop on the path known so far. A quarter of the window is run before the next quarter is planned, so a
/// node costs a constant time on average. Where the way down to the stop begins in the next quarter, more
/// nodes are wanted, up to eight windows: memory is that of as many at most.
///
/// [`JerkStream::set_override`] plans anew from the motion that is under way: braking as hard as the limits
/// allow where the new feed is lower, to the shortest stop that is found where it is 0.
///
/// # Source
///
/// `docs/sources.md#001`: jerk-limited schedules, window by window.
///
/// # Example
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::feed::{JerkStream, Limits, StreamOptions};
/// use trunnion_motion::types::{AxisNode, Motion};
///
/// let [velocity, acceleration, jerk] = [50.0, 400.0, 1e4].map(Vector1::new);
/// let limits = Limits::symmetric(velocity, acceleration, jerk);
/// let mut stream = JerkStream::new(limits, StreamOptions::fastest(64, 1.0))?;
/// stream.begin(Motion::Cut);
/// for k in 0..=100_u32 {
///     let (s, zero) = (f64::from(k), Vector1::zeros());
///     let q = [Vector1::new(s), Vector1::new(1.0), zero, zero];
///     stream.push(AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 })?;
/// }
/// let steps: Vec<_> = stream.by_ref().collect();
/// assert_eq!(steps.last().map(|step| (step.s.high, step.speed.end)), Some((100.0, 0.0)));
/// // 2 s at 50 mm/s, and the time to speed up and to slow down.
/// assert!(stream.time() > 2.0 && stream.bounds().velocity <= 1.0);
/// # Ok::<(), trunnion_motion::feed::FeedError>(())
/// ```
#[derive(Debug, Clone)]
pub struct JerkStream<const N: usize = AXES> {
    options: StreamOptions,
    /// On cuts and on links: as given, and at the override.
    given: [ReciprocalLimits<N>; 2],
    limits: [ReciprocalLimits<N>; 2],
    factor: f64,
    /// The plan was made for other limits.
    outdated: bool,
    known: NodeQueue<N>,
    plan: Option<RollingPlan<N>>,
    pushed: [usize; 2],
    last: Option<f64>,
    motion: Motion,
    /// Path that comes behind the nodes of the last piece.
    behind: PathAhead,
    /// Number of known nodes by which the plan could not be extended; 0 for none.
    refused: usize,
    /// Piece that is run.
    piece: usize,
    time: f64,
    speed: f64,
    bounds: LimitRatios,
}

impl<const N: usize> JerkStream<N> {
    /// Starts a stream without nodes, at rest. `options.step` does not count: rest is resolved by itself.
    ///
    /// # Errors
    ///
    /// As [`FeedStream::new`](crate::feed::FeedStream::new), and [`FeedError::NoJerkLimit`].
    pub fn new(limits: Limits<N>, options: StreamOptions) -> Result<Self, FeedError> {
        let feeds = options.validated(&limits)?;
        let limits = limits.smaller();
        if limits.jerk.is_none() {
            return Err(FeedError::NoJerkLimit);
        }
        let given = [Motion::Cut, Motion::Link]
            .map(|motion| ReciprocalLimits::new(motion, &limits, &feeds));
        Ok(Self {
            options,
            given,
            limits: given,
            factor: 1.0,
            outdated: false,
            known: NodeQueue::new(),
            plan: None,
            pushed: [0; 2],
            last: None,
            motion: Motion::Cut,
            behind: PathAhead::Nothing,
            refused: 0,
            piece: 0,
            time: 0.0,
            speed: 0.0,
            bounds: LimitRatios::default(),
        })
    }

    /// Begins a piece: the next node is its first, at rest.
    pub fn begin(&mut self, motion: Motion) {
        self.pushed[0] += usize::from(self.pushed[1] > 0);
        (self.motion, self.last, self.pushed[1]) = (motion, None, 0);
        self.behind = PathAhead::Nothing;
    }

    /// Takes the next node of the piece.
    ///
    /// # Errors
    ///
    /// [`FeedError`] names piece, node and axis of the defect; the node is not taken then.
    pub fn push(&mut self, node: AxisNode<N>) -> Result<(), FeedError> {
        let [piece, index] = self.pushed;
        validate::validate_next([piece, index], &node, self.last.unwrap_or(f64::NEG_INFINITY))?;
        self.known.push(NodeEntry { piece, index, motion: self.motion, node });
        (self.last, self.pushed[1]) = (Some(node.s), index + 1);
        Ok(())
    }

    /// Says that nodes of this piece are still to come, however few are known: it goes on until [`JerkStream::complete`]
    /// or the next [`JerkStream::begin`]. Without this word the path ends where nodes run out.
    pub fn go_on(&mut self) {
        self.behind = PathAhead::More;
    }

    /// Says that the piece ends with the last node.
    pub fn complete(&mut self) {
        self.behind = PathAhead::Nothing;
    }

    /// Returns `true` if more nodes are of use before the next step is taken.
    pub fn wants(&self) -> bool {
        let quarter = self.options.window / 4;
        let stops = || self.plan.as_ref().is_some_and(|plan| plan.stops_within(quarter));
        let most = WIDEST.saturating_mul(self.options.window);
        self.is_short() || (self.known.ahead() < most && self.known.waiting() <= quarter && stops())
    }

    /// Sets the override: feed and speeds at most this multiple of the programmed ones, from the next
    /// stretch on, as soon as the limits allow. 0 holds; above 1 the feed is raised, speeds of the axes
    /// are not.
    ///
    /// # Errors
    ///
    /// [`FeedError::BadOverride`] unless it is in 0..=2.
    pub fn set_override(&mut self, value: f64) -> Result<(), FeedError> {
        if !(0.0..=MOST_OVERRIDE).contains(&value) {
            return Err(FeedError::BadOverride { value });
        }
        self.outdated |= value.to_bits() != self.factor.to_bits();
        self.factor = value;
        if value > 0.0 {
            self.limits = self.given.map(|limits| limits.at_override(value));
        }
        Ok(())
    }

    /// Sets an override for the feed and one for the tip speed, from the next stretch on, as soon as the limits allow. The
    /// speeds of the axes stay as they are, unlike under [`JerkStream::set_override`], which this replaces.
    ///
    /// # Errors
    ///
    /// [`FeedError::BadOverride`] unless the feed's is above 0 and at most 2, and the tip's above 0 and at most 1.
    pub fn set_speed_overrides(&mut self, overrides: SpeedOverrides) -> Result<(), FeedError> {
        for (value, most) in [(overrides.feed, MOST_OVERRIDE), (overrides.tip, 1.0)] {
            if !(value > 0.0 && value <= most) {
                return Err(FeedError::BadOverride { value });
            }
        }
        let limits = self.given.map(|limits| limits.at_speed_overrides(overrides));
        let same = |(a, b): (&ReciprocalLimits<N>, &ReciprocalLimits<N>)| {
            a.feed.to_bits() == b.feed.to_bits() && a.tip.to_bits() == b.tip.to_bits()
        };
        self.outdated |= self.factor <= 0.0 || !limits.iter().zip(&self.limits).all(same);
        (self.factor, self.limits) = (1.0, limits);
        Ok(())
    }

    /// Returns `true` if [`JerkStream::plan_ahead`] has something to do: more of the path, or another override.
    pub fn is_due(&self) -> bool {
        let begins = self.factor > 0.0 && self.known.of_a_piece() >= 2;
        match &self.plan {
            _ if self.outdated => true,
            Some(plan) if !self.known.is_run() => {
                let ends = self.known_of_plan() < 2 && self.ahead() == PathAhead::Nothing;
                self.factor > 0.0 && (self.extends(plan) || (ends && plan.is_open()))
            }
            _ => begins,
        }
    }

    /// Plans what is known, from the end of the committed schedule on. [`JerkStream::next`] does so as well.
    pub fn plan_ahead(&mut self) {
        self.plan();
    }

    /// Commits the next step as it is planned, without planning any more.
    pub fn next_planned(&mut self) -> Option<StreamStep> {
        let plan = self.plan.as_mut()?;
        let cell = plan.take_cell()?;
        self.bounds = self.bounds.max(plan.bounds);
        let interval = self.known.run_to(cell[0][1])?;
        let step = step_of(self.piece, interval, self.time, cell);
        self.time += step.duration;
        self.speed = step.speed.end;
        Some(step)
    }

    /// Returns the steps that follow the committed schedule if neither nodes nor overrides come: down to rest, as the
    /// plan has them now.
    pub fn uncommitted(&self) -> Vec<StreamStep> {
        let Some(plan) = &self.plan else { return Vec::new() };
        let mut intervals = self.known.intervals();
        let mut t = self.time;
        let mut steps = Vec::new();
        for cell in plan.cells() {
            let [[_, high], ..] = cell;
            let Some(interval) = intervals.of(high) else { break };
            let step = step_of(self.piece, interval, t, cell);
            t += step.duration;
            steps.push(step);
        }
        steps
    }

    /// Returns guaranteed upper bounds of the ratios over the committed schedule. Where the feed was above a new
    /// override, velocities are compared with the limits of the axes.
    pub fn bounds(&self) -> LimitRatios {
        self.bounds
    }

    /// Returns `true` if the axes rest because the override is 0, with path left to run.
    pub fn held(&self) -> bool {
        self.factor <= 0.0 && self.speed <= 0.0 && self.known.ahead() > 0
    }

    /// Returns the time at the end of the committed schedule, without the time it was held \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the speed `ds/dt` there.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Returns the path expected after the known nodes: nothing where another piece has begun, or
    /// nodes run out.
    fn ahead(&self) -> PathAhead {
        if self.known.has_another_piece() {
            PathAhead::Nothing
        } else if self.is_short() {
            self.behind
        } else {
            PathAhead::More
        }
    }

    /// Returns `true` if fewer intervals than a window are ahead.
    fn is_short(&self) -> bool {
        self.known.ahead() < self.options.window
    }

    /// Nodes that are left for the next plan: a last stretch of a row or two would leave little way to get up
    /// speed again where the plan before it stops.
    fn kept(&self, ahead: PathAhead) -> usize {
        if ahead == PathAhead::More { self.options.window / 16 } else { 0 }
    }

    /// Returns the limits of the axes, whatever the feed.
    fn axes_on(&self, motion: Motion) -> ReciprocalLimits<N> {
        ReciprocalLimits { feed: 0.0, ..self.given[usize::from(motion.is_free())] }
    }

    /// Returns the limits on a kind of motion, at the override.
    fn limits_on(&self, motion: Motion) -> ReciprocalLimits<N> {
        self.limits[usize::from(motion.is_free())]
    }

    /// Plans the known nodes where it is time to.
    fn plan(&mut self) -> Option<()> {
        // Another override: from the motion under way, before anything else.
        if std::mem::take(&mut self.outdated) {
            self.plan_anew();
        }
        if self.known.is_run() {
            self.plan = None;
        }
        if self.factor <= 0.0 {
            return self.plan.as_ref().map(|_| ());
        }
        if let Some(plan) = self.plan.take() {
            self.plan = Some(self.extended(plan)?);
            return Some(());
        }
        // At rest: a piece starts once two of its nodes are known.
        self.known.drop_ends();
        if self.known.of_a_piece() < 2 {
            return None;
        }
        self.piece = self.known.piece()?;
        let ahead = self.ahead();
        let piece = self.known.take(self.kept(ahead))?;
        // A piece without room for rows has no plan: the stream ends before it.
        self.plan = RollingPlan::new(&piece, &self.limits_on(piece.motion), ahead);
        self.plan.is_some().then_some(())
    }

    /// Number of nodes that are known behind the plan, the one at its end among them.
    fn known_of_plan(&self) -> usize {
        let more = self.known.piece() == Some(self.piece);
        if more { self.known.of_a_piece() } else { 0 }
    }

    /// True if it is time to extend a plan.
    fn extends(&self, plan: &RollingPlan<N>) -> bool {
        let known = self.known_of_plan();
        // With less than a quarter only where no more is at hand. Every quarter is searched four times so; later, with
        // 40 to 110 us a node instead of 80 to 140, searches are not done with it: up to 2 % of the time is lost.
        let quarter = self.options.window / 4;
        let ends = self.is_short() && self.ahead() == PathAhead::Nothing;
        let fewest = if self.behind == PathAhead::More { quarter / FEWEST_SHARE } else { 2 };
        let due = known > quarter || ends || (known >= fewest && plan.stops_within(quarter));
        known >= 2 && due && known != self.refused
    }

    /// Returns the plan, extended where it is time to.
    fn extended(&mut self, mut plan: RollingPlan<N>) -> Option<RollingPlan<N>> {
        let known = self.known_of_plan();
        if self.extends(&plan) {
            let ahead = self.ahead();
            // A plan that cannot be extended stays as it is, and so do the nodes.
            let before = self.known.clone();
            let piece = self.known.take(self.kept(ahead))?;
            let limits = [self.limits_on(piece.motion), self.axes_on(piece.motion)];
            self.refused = 0;
            if !plan.extend(&piece, limits.each_ref(), ahead) {
                (self.known, self.refused) = (before, known);
            }
        } else if known < 2 && self.ahead() == PathAhead::Nothing {
            // The stop at the end is meant: its reserve for an extension can go.
            let motion = self.known.planned_motion()?;
            plan.end_here([&self.limits_on(motion), &self.axes_on(motion)]);
        }
        Some(plan)
    }

    /// Changes to another override from the motion under way.
    fn plan_anew(&mut self) {
        let Some(mut plan) = self.plan.take() else { return };
        let Some([s, speed, acceleration]) = plan.here() else { return };
        if speed <= 0.0 {
            // Planned from rest when it goes on.
            self.known.end_at(s);
            return;
        }
        let Some(rest) = self.known.planned_from(s) else { return };
        let axes = self.axes_on(rest.motion);
        if self.factor > 0.0 {
            plan.change_limits([&self.limits_on(rest.motion), &axes]);
        } else if let Some(halt) = stop(&rest, [speed * speed, acceleration], &axes)
            && let Some(end) = halt.end()
        {
            self.known.end_at(end);
            plan = halt;
        }
        self.plan = Some(plan);
    }
}

/// The next step of the committed schedule. `None` while the axes rest: at the end of what was pushed,
/// or held; more may come after it.
impl<const N: usize> Iterator for JerkStream<N> {
    type Item = StreamStep;

    fn next(&mut self) -> Option<StreamStep> {
        self.plan()?;
        self.next_planned()
    }
}

/// Returns the step over a cell of the plan, from time `t` on.
fn step_of(
    piece: usize,
    interval: usize,
    t: f64,
    [s, speed, acceleration]: CellMotion,
) -> StreamStep {
    StreamStep {
        piece,
        interval,
        s: s.into(),
        t,
        duration: LinearSegment { length: s[1] - s[0], speed, acceleration }.time(),
        speed: speed.into(),
        acceleration: acceleration[0],
        end_acceleration: acceleration[1],
    }
}
