//! A path that arrives bit by bit, planned through a window that can always stop at its end.
//!
//! ```text
//! window   rows ahead, and the backward pass over them
//! jerk     the same with jerk limits, plan by plan
//! known    the nodes of those plans, and the ones after them
//! any      a stream of either kind
//! whole    a path that is known as a whole
//! ```

mod any;
mod jerk;
mod known;
mod whole;
mod window;

pub use any::AnyStream;
pub use jerk::JerkStream;
pub use whole::jerk_through_window;

use super::cell::{Accelerations, Cell};
use super::{FeedError, FeedOptions, Limits, Reciprocals, error, strip};
use crate::types::{AXES, AxisNode, Moment, Motion, Stretch};
use window::{Row, Window, pieces, still};

/// Largest override: twice the programmed feed.
const MOST_OVERRIDE: f64 = 2.0;

/// Parts of a stretch that would be run from rest to rest without a row in between, on which nothing
/// would ever move.
const PARTS: usize = 8;

/// How a [`Stream`] looks ahead. No `Default`: the caller knows the part and its memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamOptions {
    /// Speed of the programmed point on everything but links \[mm/s\]; `None` for as fast as the axes can.
    pub feed: Option<f64>,
    /// Speed of the programmed point on links \[mm/s\]; `None` for as fast as the axes can.
    pub link_feed: Option<f64>,
    /// Speed of the tool tip in the workpiece frame, on every motion \[mm/s\]; `None` for no limit.
    pub tip: Option<f64>,
    /// Rows to look ahead, at least 4: [`Stream::wants`] asks for so many. Where the distance to stop
    /// from full speed is shorter than three quarters of the window, nothing is lost against planning
    /// the whole path on the same rows.
    pub window: usize,
    /// Largest distance of two rows in `s`; longer stretches between nodes are cut.
    pub step: f64,
}

impl StreamOptions {
    /// The options as those of a plan, if they and the limits make sense.
    fn validated<const N: usize>(&self, limits: &Limits<N>) -> Result<FeedOptions, FeedError> {
        error::validate_limits(limits)?;
        let feeds = FeedOptions {
            feed: self.feed,
            link_feed: self.link_feed,
            tip: self.tip,
            time_tolerance: 1.0,
            ends: [0.0; 2],
            guarantee: true,
        };
        error::validate_options(&feeds)?;
        let Self { window, step, .. } = *self;
        if window < 4 || !(step > 0.0 && step.is_finite()) {
            return Err(FeedError::BadWindow { window, step });
        }
        Ok(feeds)
    }

    /// How many parts a stretch between nodes is cut into: no more than fill a window.
    fn parts(&self, length: f64) -> usize {
        let most = self.window;
        (1..most).find(|&parts| length <= self.step * parts as f64).unwrap_or(most)
    }
}

/// A stretch of committed schedule: `d²s/dt²` is linear in `s` from its start to its end, and without jerk
/// limits constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Piece of the path, counted from 0.
    pub piece: usize,
    /// Interval between nodes of the piece, counted from 0.
    pub interval: usize,
    /// Path parameter at both ends.
    pub s: [f64; 2],
    /// Time at the start, since the stream began and without the time it was held \[s\].
    pub t: f64,
    /// Time it takes \[s\].
    pub duration: f64,
    /// `ds/dt` at both ends.
    pub speed: [f64; 2],
    /// `d²s/dt²` at the start.
    pub acceleration: f64,
    /// `d²s/dt²` at the end.
    pub end_acceleration: f64,
}

impl Step {
    /// Place and speed a time after the start, clamped to the step.
    pub fn at(&self, dt: f64) -> Moment {
        let dt = dt.clamp(0.0, self.duration);
        let accelerations = [self.acceleration, self.end_acceleration];
        if accelerations[0].to_bits() != accelerations[1].to_bits() {
            let length = self.s[1] - self.s[0];
            let stretch = Stretch { length, speed: self.speed, acceleration: accelerations };
            let [advance, speed, acceleration, jerk] = stretch.at(dt);
            let s = (self.s[0] + advance).clamp(self.s[0], self.s[1]);
            return Moment { s, speed: speed.max(0.0), acceleration, jerk };
        }
        let s = self.s[0] + dt * (self.speed[0] + 0.5 * self.acceleration * dt);
        let speed = (self.speed[0] + self.acceleration * dt).max(0.0);
        let s = s.clamp(self.s[0], self.s[1]);
        Moment { s, speed, acceleration: self.acceleration, jerk: 0.0 }
    }
}

/// Plans a path that arrives node by node, fastest within velocity and acceleration limits.
///
/// Nodes go in with [`Stream::begin`] and [`Stream::push`], committed schedule comes out of
/// [`Stream::next`], one stretch at a time. Whatever is pushed or not pushed later: what was handed
/// out can be followed by a stop inside what is known of the path, and limits hold everywhere, between
/// nodes as well, as in [`super::optimal`]. The schedule starts at rest; where nodes run out it stops.
///
/// [`Stream::set_override`] scales the feed from the next stretch on; 0 is a feed hold. Above the new
/// feed the axes brake as hard as their limits allow, and no harder.
///
/// Memory is that of the rows ahead: bounded, if nodes are pushed only while [`Stream::wants`] asks
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
/// use trunnion::feed::{Limits, Stream, StreamOptions};
/// use trunnion::types::{AxisNode, Motion};
///
/// let [velocity, acceleration] = [Vector1::new(50.0), Vector1::new(400.0)];
/// let limits = Limits { velocity, rapid: velocity, acceleration, jerk: None, minus: None };
/// let options =
///     StreamOptions { feed: Some(40.0), link_feed: None, tip: None, window: 512, step: 0.5 };
/// let mut stream = Stream::new(limits, options)?;
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
/// # Ok::<(), trunnion::feed::FeedError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Stream<const N: usize = AXES> {
    /// Of cuts and leads, and of links; the override is not in them.
    limits: [Reciprocals<N>; 2],
    options: StreamOptions,
    window: Window<N>,
    /// Motion, index and last node of the piece that is being pushed, and its nodes so far.
    motion: Motion,
    pieces: usize,
    last: Option<AxisNode<N>>,
    nodes: usize,
    /// Squared speed and time at the first row of the window.
    x: f64,
    time: f64,
    guess: strip::Guess,
}

impl<const N: usize> Stream<N> {
    /// A stream at rest.
    ///
    /// # Errors
    ///
    /// [`FeedError::BadLimit`], [`FeedError::BadFeed`], [`FeedError::BadWindow`].
    pub fn new(limits: Limits<N>, options: StreamOptions) -> Result<Self, FeedError> {
        let feeds = options.validated(&limits)?;
        Ok(Self {
            limits: [Motion::Cut, Motion::Link]
                .map(|motion| Reciprocals::new(motion, &limits, &feeds)),
            options,
            window: Window::new(),
            motion: Motion::Cut,
            pieces: 0,
            last: None,
            nodes: 0,
            x: 0.0,
            time: 0.0,
            guess: strip::Guess::default(),
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
    /// [`FeedError`] names piece, node and axis of what is wrong with the node; it is not taken then.
    pub fn push(&mut self, node: AxisNode<N>) -> Result<(), FeedError> {
        let before = self.last.as_ref().map_or(f64::NEG_INFINITY, |last| last.s);
        error::validate_next([self.pieces, self.nodes], &node, before)?;
        let (piece, link) = (self.pieces, self.motion.is_free());
        match &self.last {
            None => self.window.rest(Row::at([piece, 0], node.s, link)),
            Some(last) => {
                let limits = &self.limits[usize::from(link)];
                let row = |s| Row::at([piece, self.nodes - 1], s, link);
                let whole = Cell::between(last, &node);
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

    /// Whether more nodes are of use before the next stretch is taken.
    pub fn wants(&self) -> bool {
        self.window.ahead() < self.options.window
    }

    /// Sets the override: feed and speeds at most this multiple of the programmed ones, from the next
    /// stretch on. 0 holds; above 1 the feed is raised, speeds of the axes are not.
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

    /// Time at the end of what was handed out, without the time it was held \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Speed `ds/dt` there.
    pub fn speed(&self) -> f64 {
        self.x.sqrt()
    }

    /// Whether the axes rest because the override is 0, with path left to run.
    pub fn held(&self) -> bool {
        self.window.ahead() > 0 && self.window.holds() && self.x <= 0.0
    }
}

/// Squared speed at the end of a cell, from that at its start: the one wanted if it can be had, and no
/// more than what the window can follow.
fn onward<const N: usize>(
    cell: &Accelerations<N>,
    x: f64,
    [wanted, most]: [f64; 2],
    guess: &mut strip::Guess,
) -> f64 {
    let (fastest, _) = strip::forward::<N, 5>(cell, x, most, guess);
    if fastest <= wanted {
        return fastest;
    }
    // Only while braking: no less than the axes can do, which is what the window can follow.
    strip::least(&cell.strips::<5>(), x).max(wanted).min(fastest)
}

/// The next stretch of committed schedule. `None` while the axes rest: at the end of what was pushed,
/// or held; more may come after it.
impl<const N: usize> Iterator for Stream<N> {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        loop {
            self.window.plan(self.x, &self.limits[0]);
            let reach = self.window.next_reach();
            let (row, Some(cell)) = self.window.first()? else {
                // From piece to piece, at rest.
                self.window.commit();
                continue;
            };
            let y = onward(&cell.accelerations(&self.limits[0]), self.x, reach, &mut self.guess);
            let limits = &self.limits[usize::from(row.link)];
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

impl<const N: usize> Stream<N> {
    /// Commits the first cell.
    fn step(&mut self, row: &Row, h: f64, y: f64) -> Option<Step> {
        let speed = [self.x.sqrt(), y.sqrt()];
        let sum = speed[0] + speed[1];
        let duration = if sum > 0.0 { 2.0 * h / sum } else { 0.0 };
        let end = self.window.commit()?;
        let step = Step {
            piece: row.piece,
            interval: end.interval,
            s: [row.s, end.s],
            t: self.time,
            duration,
            speed,
            acceleration: 0.5 * (y - self.x) / h,
            end_acceleration: 0.5 * (y - self.x) / h,
        };
        self.x = y;
        self.time += duration;
        Some(step)
    }
}
