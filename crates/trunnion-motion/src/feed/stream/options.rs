//! Options of a stream.

use crate::feed::error::FeedError;
use crate::feed::limits::Limits;
use crate::feed::options::{FeedOptions, ProgrammedSpeeds};
use crate::feed::validate::{validate_limits, validate_options};

/// Largest override: twice the programmed feed.
pub(super) const MOST_OVERRIDE: f64 = 2.0;

/// Look-ahead of a [`FeedStream`](super::FeedStream) or a [`JerkStream`](super::JerkStream).
///
/// Begin with [`StreamOptions::fastest`] and change the rest by struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamOptions {
    /// Programmed feed, feed on links and largest tip speed.
    pub speeds: ProgrammedSpeeds,
    /// Rows to look ahead, at least 4: [`FeedStream::wants`](crate::feed::FeedStream::wants) asks for so many. Where the distance to stop
    /// from full speed is shorter than three quarters of the window, nothing is lost against planning
    /// the whole path on the same rows.
    pub window: usize,
    /// Largest distance of two rows in `s`; longer stretches between nodes are cut.
    pub step: f64,
}

impl StreamOptions {
    /// Plans as fast as the axes can, with a window of so many rows at most `step` apart in `s`.
    #[must_use]
    pub const fn fastest(window: usize, step: f64) -> Self {
        Self { speeds: ProgrammedSpeeds::FASTEST, window, step }
    }

    /// Sets the programmed feed \[mm/s\] on everything but links.
    #[must_use]
    pub const fn with_feed(mut self, feed: f64) -> Self {
        self.speeds.feed = Some(feed);
        self
    }

    /// Checks options and limits, and returns the options as those of a plan.
    pub(super) fn validated<const N: usize>(
        &self,
        limits: &Limits<N>,
    ) -> Result<FeedOptions, FeedError> {
        validate_limits(limits)?;
        let feeds = FeedOptions { speeds: self.speeds, ..FeedOptions::fastest() };
        validate_options(&feeds)?;
        let Self { window, step, .. } = *self;
        if window < 4 || !(step > 0.0 && step.is_finite()) {
            return Err(FeedError::BadWindow { window, step });
        }
        Ok(feeds)
    }

    /// Returns the number of parts that a stretch between nodes is cut into: no more than fill a
    /// window.
    pub(super) fn parts(&self, length: f64) -> usize {
        // The smallest number of equal parts that are short enough.
        let most = self.window;
        (1..most).find(|&parts| length <= self.step * parts as f64).unwrap_or(most)
    }
}
