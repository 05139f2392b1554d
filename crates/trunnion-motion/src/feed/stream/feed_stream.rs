//! A stream within velocity and acceleration limits.

use super::options::{MOST_OVERRIDE, StreamOptions};
use super::step::StreamStep;
use super::window::{RowWindow, WindowRow, pieces, still};
use crate::feed::accelerations::CellAccelerations;
use crate::feed::cell::FeedCell;
use crate::feed::cell_program::{CellConstraints, WarmStart, forward, least};
use crate::feed::error::FeedError;
use crate::feed::limits::Limits;
use crate::feed::reciprocal::ReciprocalLimits;
use crate::feed::validate;
use crate::types::{AXES, AxisNode, Interval, Motion};

/// Parts of a stretch that would be run from rest to rest without a row in between, on which nothing
/// would ever move.
const PARTS: usize = 8;

/// Plans a path that arrives node by node, fastest within velocity and acceleration limits.
///
/// [`FeedStream::begin`] and [`FeedStream::push`] take nodes; [`FeedStream::next`] returns the committed
/// schedule, one step at a time. After every step the axes can still stop on the path known so far,
/// whatever is pushed later. Limits hold everywhere, between nodes as well, as in
/// [`optimal()`](crate::feed::optimal()). The schedule starts at rest, and stops where nodes run out.
///
/// [`FeedStream::set_override`] scales the feed from the next step on; 0 is a feed hold. Above the new
/// feed the axes brake as hard as their limits allow, and no harder.
///
/// Memory is that of the rows ahead: bounded, if nodes are pushed only while [`FeedStream::wants`] asks
/// for them. Every node costs a constant time on average.
///
/// # Source
///
/// `docs/sources.md#001`: look-ahead by reachability; the window's backward pass ends at rest and
/// stops where it meets the one before.
///
/// # Example
///
/// A control: nodes from a queue, setpoints every millisecond.
///
/// ```
/// use nalgebra::Vector1;
/// use trunnion_motion::feed::{Limits, FeedStream, StreamOptions};
/// use trunnion_motion::types::{AxisNode, Motion};
///
/// let [velocity, acceleration, jerk] = [50.0, 400.0, 1e4].map(Vector1::new);
/// let limits = Limits::symmetric(velocity, acceleration, jerk).without_jerk();
/// let options = StreamOptions::fastest(512, 0.5).with_feed(40.0);
/// let mut stream = FeedStream::new(limits, options)?;
///
/// let mut queue = (0..=100_u32).map(|k| {
///     let (s, zero) = (f64::from(k), Vector1::zeros());
///     let q = [Vector1::new(s), Vector1::new(1.0), zero, zero];
///     AxisNode { s, q, tip_rate: 1.0, feed_rate: 1.0 }
/// });
/// stream.begin(Motion::Cut);
/// let (mut now, mut setpoints) = (0.0, Vec::new());
/// loop {
///     while stream.wants() {
///         let Some(node) = queue.next() else { break };
///         stream.push(node)?;
///     }
///     // Here the operator's override would be read: stream.set_override(0.5)?;
///     let Some(step) = stream.next() else { break };
///     while now < step.t + step.duration {
///         setpoints.push(step.at(now - step.t).s);
///         now += 0.001;
///     }
/// }
/// // 100 mm at 40 mm/s, and 0.1 s to speed up and as much to slow down, each half as far.
/// assert!((stream.time() - (2.5 + 0.1)).abs() < 1e-9);
/// assert!(setpoints.len() >= 2600 && setpoints.is_sorted());
/// # Ok::<(), trunnion_motion::feed::FeedError>(())
/// ```
#[derive(Debug, Clone)]
pub struct FeedStream<const N: usize = AXES> {
    /// Of cuts and leads, and of links; the override is not in them.
    limits: [ReciprocalLimits<N>; 2],
    options: StreamOptions,
    window: RowWindow<N>,
    /// Motion, index and last node of the piece that is being pushed, and its nodes so far.
    motion: Motion,
    pieces: usize,
    last: Option<AxisNode<N>>,
    nodes: usize,
    /// Squared speed and time at the first row of the window.
    x: f64,
    time: f64,
    guess: WarmStart,
}

impl<const N: usize> FeedStream<N> {
    /// Starts a stream at rest.
    ///
    /// # Errors
    ///
    /// [`FeedError::BadLimit`], [`FeedError::BadFeed`], [`FeedError::BadWindow`].
    pub fn new(limits: Limits<N>, options: StreamOptions) -> Result<Self, FeedError> {
        let feeds = options.validated(&limits)?;
        Ok(Self {
            limits: [Motion::Cut, Motion::Link]
                .map(|motion| ReciprocalLimits::new(motion, &limits, &feeds)),
            options,
            window: RowWindow::new(),
            motion: Motion::Cut,
            pieces: 0,
            last: None,
            nodes: 0,
            x: 0.0,
            time: 0.0,
            guess: WarmStart::default(),
        })
    }

    /// Begins a piece: the next node is its first, at rest. Needed before the first piece, and
    /// wherever the path is not smooth or the kind of motion changes.
    pub fn begin(&mut self, motion: Motion) {
        self.pieces += usize::from(self.nodes > 0);
        (self.motion, self.last, self.nodes) = (motion, None, 0);
    }

    /// Takes the next node of the piece.
    ///
    /// # Errors
    ///
    /// [`FeedError`] names piece, node and axis of the defect; the node is not taken then.
    pub fn push(&mut self, node: AxisNode<N>) -> Result<(), FeedError> {
        let before = self.last.as_ref().map_or(f64::NEG_INFINITY, |last| last.s);
        validate::validate_next([self.pieces, self.nodes], &node, before)?;
        let (piece, motion) = (self.pieces, self.motion);
        match &self.last {
            None => self.window.rest(WindowRow::at([piece, 0], node.s, motion)),
            Some(last) => {
                // Long intervals are cut so that the window resolves the way down to a stop.
                let limits = &self.limits[usize::from(motion.is_free())];
                let row = |s| WindowRow::at([piece, self.nodes - 1], s, motion);
                let whole = FeedCell::between(last, &node);
                let parts = self.options.parts(whole.h);
                if parts == 1 {
                    self.window.push(whole, row(node.s), limits);
                } else {
                    let (start, h) = (last.s, whole.h);
                    for (cell, share) in pieces(whole, parts) {
                        let s = if share < 1.0 { start + share * h } else { node.s };
                        self.window.push(cell, row(s), limits);
                    }
                }
            }
        }
        self.last = Some(node);
        self.nodes += 1;
        Ok(())
    }

    /// Returns `true` if more nodes are of use before the next step is taken.
    pub fn wants(&self) -> bool {
        self.window.ahead() < self.options.window
    }

    /// Sets the override: feed and speeds at most this multiple of the programmed ones, from the next
    /// step on. 0 holds; above 1 the feed is raised, speeds of the axes are not.
    ///
    /// # Errors
    ///
    /// [`FeedError::BadOverride`] unless it is in 0..=2.
    pub fn set_override(&mut self, value: f64) -> Result<(), FeedError> {
        if !(0.0..=MOST_OVERRIDE).contains(&value) {
            return Err(FeedError::BadOverride { value });
        }
        self.window.set_override(value);
        Ok(())
    }

    /// Returns the time at the end of the committed schedule, without the time it was held \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the speed `ds/dt` there.
    pub fn speed(&self) -> f64 {
        self.x.sqrt()
    }

    /// Returns `true` if the axes rest because the override is 0, with path left to run.
    pub fn held(&self) -> bool {
        self.window.ahead() > 0 && self.window.holds() && self.x <= 0.0
    }
}

/// Returns the squared speed at the end of a cell from that at its start: the one wanted if that
/// is possible, and no more than what the window can follow.
fn onward<const N: usize>(
    cell: &CellAccelerations<N>,
    x: f64,
    [wanted, most]: [f64; 2],
    guess: &mut WarmStart,
) -> f64 {
    let (fastest, _) = forward::<N, 5>(cell, x, most, guess);
    if fastest <= wanted {
        return fastest;
    }
    // Only while braking: no less than the axes can do, which is what the window can follow.
    least(&CellConstraints::<N, 5>::of(cell), x).max(wanted).min(fastest)
}

/// The next step of the committed schedule. `None` while the axes rest: at the end of what was pushed,
/// or held; more may come after it.
impl<const N: usize> Iterator for FeedStream<N> {
    type Item = StreamStep;

    fn next(&mut self) -> Option<StreamStep> {
        loop {
            self.window.plan(self.x, &self.limits[0]);
            let reach = self.window.next_reach();
            let (row, Some(cell)) = self.window.first()? else {
                // From piece to piece, at rest.
                self.window.commit();
                continue;
            };
            let y = onward(&cell.accelerations(&self.limits[0]), self.x, reach, &mut self.guess);
            let limits = &self.limits[usize::from(row.motion.is_free())];
            if self.x <= 0.0 && y <= 0.0 && !still(cell, limits) {
                if self.window.holds() {
                    return None;
                }
                // Nothing would move from rest to rest: rows in between.
                self.window.cut(PARTS, limits)?;
                continue;
            }
            let (row, h) = (*row, cell.h);
            return self.step(&row, h, y);
        }
    }
}

impl<const N: usize> FeedStream<N> {
    /// Commits the first cell.
    fn step(&mut self, row: &WindowRow, h: f64, y: f64) -> Option<StreamStep> {
        let speed = [self.x.sqrt(), y.sqrt()];
        // Constant u over the cell: time 2 h / (v0 + v1), u = (y - x) / 2h.
        let sum = speed[0] + speed[1];
        let duration = if sum > 0.0 { 2.0 * h / sum } else { 0.0 };
        let end = self.window.commit()?;
        let step = StreamStep {
            piece: row.piece,
            interval: end.interval,
            s: Interval::new(row.s, end.s),
            t: self.time,
            duration,
            speed: speed.into(),
            acceleration: 0.5 * (y - self.x) / h,
            end_acceleration: 0.5 * (y - self.x) / h,
        };
        self.x = y;
        self.time += duration;
        Some(step)
    }
}
