//! A stream of either kind.

use super::feed_stream::FeedStream;
use super::jerk_stream::JerkStream;
use super::options::StreamOptions;
use super::step::StreamStep;
use crate::feed::error::FeedError;
use crate::feed::limits::Limits;
use crate::feed::plan::LimitRatios;
use crate::types::{AXES, AxisNode, Motion};

/// Limits that a stream keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamKind {
    /// Velocity and acceleration limits.
    Optimal,
    /// Jerk limits as well.
    Jerk,
}

/// A stream that keeps jerk limits or not, as the user chooses.
#[derive(Debug, Clone)]
pub enum AnyStream<const N: usize = AXES> {
    /// Velocity and acceleration limits.
    Optimal(Box<FeedStream<N>>),
    /// Jerk limits as well.
    Jerk(Box<JerkStream<N>>),
}

impl<const N: usize> AnyStream<N> {
    /// Starts a stream without nodes, at rest.
    ///
    /// # Errors
    ///
    /// As [`FeedStream::new`] and [`JerkStream::new`].
    pub fn new(
        kind: StreamKind,
        limits: Limits<N>,
        options: StreamOptions,
    ) -> Result<Self, FeedError> {
        Ok(match kind {
            StreamKind::Optimal => Self::Optimal(Box::new(FeedStream::new(limits, options)?)),
            StreamKind::Jerk => Self::Jerk(Box::new(JerkStream::new(limits, options)?)),
        })
    }

    /// Begins a piece: the next node is its first, at rest.
    pub fn begin(&mut self, motion: Motion) {
        match self {
            Self::Optimal(stream) => stream.begin(motion),
            Self::Jerk(stream) => stream.begin(motion),
        }
    }

    /// Takes the next node of the piece.
    ///
    /// # Errors
    ///
    /// As [`FeedStream::push`].
    pub fn push(&mut self, node: AxisNode<N>) -> Result<(), FeedError> {
        match self {
            Self::Optimal(stream) => stream.push(node),
            Self::Jerk(stream) => stream.push(node),
        }
    }

    /// Returns `true` if more nodes are of use before the next step is taken.
    pub fn wants(&self) -> bool {
        match self {
            Self::Optimal(stream) => stream.wants(),
            Self::Jerk(stream) => stream.wants(),
        }
    }

    /// Returns the time at the end of the committed schedule, without the time it was held \[s\].
    pub fn time(&self) -> f64 {
        match self {
            Self::Optimal(stream) => stream.time(),
            Self::Jerk(stream) => stream.time(),
        }
    }

    /// Returns guaranteed upper bounds of the ratios over the committed schedule; `None` without
    /// jerk limits, where the method of planning keeps them.
    pub fn bounds(&self) -> Option<LimitRatios> {
        match self {
            // Every step is a feasible point of its cell's linear program.
            Self::Optimal(_) => None,
            Self::Jerk(stream) => Some(stream.bounds()),
        }
    }
}

impl<const N: usize> Iterator for AnyStream<N> {
    type Item = StreamStep;

    fn next(&mut self) -> Option<StreamStep> {
        match self {
            Self::Optimal(stream) => stream.next(),
            Self::Jerk(stream) => stream.next(),
        }
    }
}
