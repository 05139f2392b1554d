//! A stream that keeps jerk limits.

use super::{Step, StreamOptions};
use crate::feed::jerk::{Ahead, Course};
use crate::feed::{FeedError, Limits, Reciprocals, error};
use crate::types::{AXES, AxisNode, AxisPiece, Motion, Stretch};
use std::collections::VecDeque;

/// Plans a path that arrives node by node, within velocity, acceleration and jerk limits.
///
/// As [`super::Stream`]: nodes go in with [`JerkStream::begin`] and [`JerkStream::push`], stretches of
/// committed schedule come out of [`JerkStream::next`], which can always be followed by a stop inside
/// what is known of the path. A quarter of the window is run before the next quarter is planned, so a
/// node costs a constant time on average, and memory is that of the window.
///
/// There is no override yet: the path is run as programmed.
///
/// # Source
///
/// `docs/sources.md#001`: jerk-limited schedules, window by window.
#[derive(Debug, Clone)]
pub struct JerkStream<const N: usize = AXES> {
    options: StreamOptions,
    /// On cuts and on links.
    limits: [Reciprocals<N>; 2],
    /// Nodes that are not planned yet; the first is where the plan ends, and counts as planned.
    queue: VecDeque<Entry<N>>,
    course: Option<Course<N>>,
    /// `s` of the nodes that end the intervals of the plan, and how many are waiting to be run.
    ends: VecDeque<(f64, usize)>,
    pushed: [usize; 2],
    last: Option<f64>,
    motion: Motion,
    /// Piece that is run.
    piece: usize,
    time: f64,
    speed: f64,
}

/// A node, where it belongs, and whether it begins a piece.
#[derive(Debug, Clone)]
struct Entry<const N: usize> {
    piece: usize,
    index: usize,
    motion: Motion,
    node: AxisNode<N>,
}

impl<const N: usize> JerkStream<N> {
    /// A stream without nodes, at rest. `options.step` does not count: rest is resolved by itself.
    ///
    /// # Errors
    ///
    /// As [`super::Stream::new`], and [`FeedError::NoJerkLimit`].
    pub fn new(limits: Limits<N>, options: StreamOptions) -> Result<Self, FeedError> {
        let feeds = options.validated(&limits)?;
        if limits.jerk.is_none() {
            return Err(FeedError::NoJerkLimit);
        }
        Ok(Self {
            options,
            limits: [Motion::Cut, Motion::Link]
                .map(|motion| Reciprocals::new(motion, &limits, &feeds)),
            queue: VecDeque::new(),
            course: None,
            ends: VecDeque::new(),
            pushed: [0; 2],
            last: None,
            motion: Motion::Cut,
            piece: 0,
            time: 0.0,
            speed: 0.0,
        })
    }

    /// Begins a piece: the next node is its first, at rest.
    pub fn begin(&mut self, motion: Motion) {
        self.pushed[0] += usize::from(self.pushed[1] > 0);
        (self.motion, self.last, self.pushed[1]) = (motion, None, 0);
    }

    /// Takes the next node of the piece.
    ///
    /// # Errors
    ///
    /// [`FeedError`] names piece, node and axis of what is wrong with the node; it is not taken then.
    pub fn push(&mut self, node: AxisNode<N>) -> Result<(), FeedError> {
        let [piece, index] = self.pushed;
        error::validate_next([piece, index], &node, self.last.unwrap_or(f64::NEG_INFINITY))?;
        self.queue.push_back(Entry { piece, index, motion: self.motion, node });
        (self.last, self.pushed[1]) = (Some(node.s), index + 1);
        Ok(())
    }

    /// Whether more nodes are of use before the next stretch is taken.
    pub fn wants(&self) -> bool {
        self.ends.len() + self.queue.len().saturating_sub(1) < self.options.window
    }

    /// Time at the end of what was handed out \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Speed `ds/dt` there.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Nodes at the front of the queue that belong to one piece.
    fn known(&self) -> usize {
        let first = self.queue.front().map(|entry| entry.piece);
        self.queue.iter().take_while(|entry| Some(entry.piece) == first).count()
    }

    /// Whether the piece goes on after what is known: not where another has begun, or nodes run out.
    fn ahead(&self) -> Ahead {
        if self.wants() || self.known() < self.queue.len() { Ahead::Nothing } else { Ahead::More }
    }

    /// Takes the nodes known of a piece; the last stays, as the first of what follows.
    fn take(&mut self) -> Option<AxisPiece<N>> {
        let count = self.known();
        let motion = self.queue.front()?.motion;
        let mut nodes = Vec::with_capacity(count);
        for entry in self.queue.iter().take(count) {
            nodes.push(entry.node);
        }
        self.ends.extend(
            self.queue.iter().take(count).skip(1).map(|entry| (entry.node.s, entry.index - 1)),
        );
        self.queue.drain(..count - 1);
        Some(AxisPiece { motion, source: 0, nodes })
    }

    /// Plans what is known where it is time to.
    fn plan(&mut self) -> Option<()> {
        if self.ends.is_empty() {
            self.course = None;
        }
        if let Some(mut course) = self.course.take() {
            let more = self.queue.front().map(|entry| entry.piece) == Some(self.piece);
            let known = if more { self.known() } else { 0 };
            // With less than a quarter only where no more is at hand.
            if known >= 2 && (known > self.options.window / 4 || self.wants()) {
                let ahead = self.ahead();
                let before = (self.queue.clone(), self.ends.clone());
                let piece = self.take()?;
                let limits = &self.limits[usize::from(piece.motion.is_free())];
                if !course.lead_on(&piece, limits, ahead) {
                    (self.queue, self.ends) = before;
                }
            }
            self.course = Some(course);
            return Some(());
        }
        // A node that nothing follows in its piece is done with.
        while self.known() == 1 && self.queue.len() > 1 {
            self.queue.pop_front();
        }
        if self.known() < 2 {
            return None;
        }
        self.piece = self.queue.front()?.piece;
        let ahead = self.ahead();
        let piece = self.take()?;
        let limits = &self.limits[usize::from(piece.motion.is_free())];
        self.course = Some(Course::new(&piece, limits, ahead));
        Some(())
    }
}

/// The next stretch of committed schedule. `None` while the axes rest at the end of what was pushed.
impl<const N: usize> Iterator for JerkStream<N> {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        self.plan()?;
        let [s, speed, acceleration] = self.course.as_mut()?.run()?;
        let (end, interval) = *self.ends.front()?;
        let duration = Stretch { length: s[1] - s[0], speed, acceleration }.time();
        let step = Step {
            piece: self.piece,
            interval,
            s,
            t: self.time,
            duration,
            speed,
            acceleration: acceleration[0],
            end_acceleration: acceleration[1],
        };
        if s[1] >= end {
            self.ends.pop_front();
        }
        self.time += duration;
        self.speed = speed[1];
        Some(step)
    }
}
