//! Options of a plan.

/// Speeds that the user asks for, besides the limits of the axes. `None` is as fast as the axes can.
///
/// The default asks for nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ProgrammedSpeeds {
    /// Speed of the programmed point on everything but links \[mm/s\].
    pub feed: Option<f64>,
    /// Speed of the programmed point on links \[mm/s\].
    pub link_feed: Option<f64>,
    /// Speed of the tool tip in the workpiece frame, on every motion \[mm/s\].
    pub tip: Option<f64>,
}

impl ProgrammedSpeeds {
    /// As fast as the axes can.
    pub const FASTEST: Self = Self { feed: None, link_feed: None, tip: None };
}

/// Multiples of the programmed speeds; the axes keep theirs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedOverrides {
    /// Of the programmed feed.
    pub feed: f64,
    /// Of the largest tip speed.
    pub tip: f64,
}

/// A value at the start of the first piece of a path, and one at the end of the last.
///
/// # Example
///
/// ```
/// use trunnion_motion::feed::{FeedOptions, PathEnds};
///
/// // The path begins at 20 mm/s and ends at rest.
/// let options = FeedOptions { end_speeds: PathEnds { start: 20.0, end: 0.0 }, ..FeedOptions::fastest() };
/// assert_eq!(FeedOptions::fastest().end_speeds, PathEnds::REST);
/// assert_eq!(options.end_speeds.end, 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathEnds {
    /// Value at the start of the path.
    pub start: f64,
    /// Value at its end.
    pub end: f64,
}

impl PathEnds {
    /// No motion at either end.
    pub const REST: Self = Self { start: 0.0, end: 0.0 };
}

impl From<[f64; 2]> for PathEnds {
    fn from([start, end]: [f64; 2]) -> Self {
        Self { start, end }
    }
}

/// Options of the planners. Begin with [`FeedOptions::fastest`] and change what matters by struct update:
///
/// ```
/// use trunnion_motion::feed::FeedOptions;
///
/// let options = FeedOptions { time_tolerance: 1e-4, ..FeedOptions::fastest().with_feed(50.0) };
/// assert_eq!(options.speeds.feed, Some(50.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedOptions {
    /// Programmed feed, feed on links and largest tip speed.
    pub speeds: ProgrammedSpeeds,
    /// Fraction of a piece's time that is not worth more work. [`optimal()`](crate::feed::optimal()) inserts rows until
    /// the time still to gain is estimated below it; [`jerk()`](crate::feed::jerk()) goes on until a sweep gains
    /// less. Limits hold whatever the value; 1e-3 is fine, 1 stops at the first schedule.
    pub time_tolerance: f64,
    /// `ds/dt` at the ends of the path; pieces rest where they meet.
    pub end_speeds: PathEnds,
    /// `true` keeps the limits everywhere in [`optimal()`](crate::feed::optimal()). `false` keeps them at rows alone
    /// (TOPP-RA's interpolation scheme on the path's nodes), for comparison: limits may break in
    /// between, and [`super::FeedPlan::bounds`] reports by how much. [`jerk()`](crate::feed::jerk()) always keeps
    /// them everywhere.
    pub guarantee: bool,
}

impl FeedOptions {
    /// Plans as fast as the axes can, from rest to rest, to 0.1 % of the time, with guaranteed limits.
    #[must_use]
    pub const fn fastest() -> Self {
        Self {
            speeds: ProgrammedSpeeds::FASTEST,
            time_tolerance: 1e-3,
            end_speeds: PathEnds::REST,
            guarantee: true,
        }
    }

    /// Sets the programmed feed \[mm/s\] on everything but links.
    #[must_use]
    pub const fn with_feed(mut self, feed: f64) -> Self {
        self.speeds.feed = Some(feed);
        self
    }
}
