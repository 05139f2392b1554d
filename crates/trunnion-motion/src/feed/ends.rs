//! Speeds at the ends of a piece.

use super::options::{FeedOptions, PathEnds};

/// Squared speeds at the ends of a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct EndSquares {
    pub(super) start: f64,
    pub(super) end: f64,
}

impl EndSquares {
    /// Returns the end speeds of piece `index` of `count`: inner ends rest.
    pub(super) fn of(index: usize, count: usize, options: &FeedOptions) -> Self {
        let PathEnds { start, end } = options.end_speeds;
        let at = |here: bool, speed: f64| if here { speed * speed } else { 0.0 };
        Self { start: at(index == 0, start), end: at(index + 1 == count, end) }
    }
}
