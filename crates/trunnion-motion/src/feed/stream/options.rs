//! Options of a stream.

use crate::feed::error::FeedError;
use crate::feed::limits::Limits;
use crate::feed::options::FeedOptions;
use crate::feed::validate::{validate_limits, validate_options};

/// Largest override: twice the programmed feed.
pub(super) const MOST_OVERRIDE: f64 = 2.0;

/// How a [`FeedStream`] looks ahead. No `Default`: the caller knows the part and its memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamOptions {
    /// Speed of the programmed point on everything but links \[mm/s\]; `None` for as fast as the axes can.
    pub feed: Option<f64>,
    /// Speed of the programmed point on links \[mm/s\]; `None` for as fast as the axes can.
    pub link_feed: Option<f64>,
    /// Speed of the tool tip in the workpiece frame, on every motion \[mm/s\]; `None` for no limit.
    pub tip: Option<f64>,
    /// Rows to look ahead, at least 4: [`FeedStream::wants`] asks for so many. Where the distance to stop
    /// from full speed is shorter than three quarters of the window, nothing is lost against planning
    /// the whole path on the same rows.
    pub window: usize,
    /// Largest distance of two rows in `s`; longer stretches between nodes are cut.
    pub step: f64,
}

impl StreamOptions {
    /// The options as those of a plan, if they and the limits make sense.
    pub(super) fn validated<const N: usize>(
        &self,
        limits: &Limits<N>,
    ) -> Result<FeedOptions, FeedError> {
        validate_limits(limits)?;
        let feeds = FeedOptions {
            feed: self.feed,
            link_feed: self.link_feed,
            tip: self.tip,
            time_tolerance: 1.0,
            ends: [0.0; 2],
            guarantee: true,
        };
        validate_options(&feeds)?;
        let Self { window, step, .. } = *self;
        if window < 4 || !(step > 0.0 && step.is_finite()) {
            return Err(FeedError::BadWindow { window, step });
        }
        Ok(feeds)
    }

    /// How many parts a stretch between nodes is cut into: no more than fill a window.
    pub(super) fn parts(&self, length: f64) -> usize {
        let most = self.window;
        (1..most).find(|&parts| length <= self.step * parts as f64).unwrap_or(most)
    }
}
