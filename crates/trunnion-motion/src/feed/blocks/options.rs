//! Options of the classical planner.

use crate::feed::error::FeedError;

/// Options of the classical planner. Begin with [`LookAheadOptions::whole`] and change the rest by struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LookAheadOptions {
    /// Servo period \[s\]: axis velocities may step at a junction by acceleration times period.
    pub period: f64,
    /// Look-ahead.
    pub ahead: LookAhead,
    /// Blocks that are passed through in runs, if any.
    pub tiny: Option<TinyBlocks>,
}

impl LookAheadOptions {
    /// Looks ahead over the whole path, with a servo period \[s\] and no joining of tiny blocks.
    #[must_use]
    pub const fn whole(period: f64) -> Self {
        Self { period, ahead: LookAhead::Whole, tiny: None }
    }
}

/// Number of blocks that the planner considers before one is run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LookAhead {
    /// No look-ahead: the motion stops at every junction.
    Stops,
    /// A fixed number.
    Blocks(usize),
    /// `blocks` at first, and on until they last `periods` servo periods at their feed.
    Dynamic {
        /// Least number of blocks; the paper has 5.
        blocks: usize,
        /// Least time in servo periods; the paper has 1000.
        periods: f64,
    },
    /// All.
    Whole,
}

/// Limits of tiny blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TinyBlocks {
    /// Blocks shorter than this are tiny: `L_ref`, in the measure of the path.
    pub length: f64,
    /// Runs of more tiny blocks than this are passed through like one block: `N_ref`.
    pub count: usize,
}

/// Checks that periods and lengths are positive.
pub(super) fn validate(options: &LookAheadOptions) -> Result<(), FeedError> {
    let positive = |name: &'static str, value: f64| {
        let good = value > 0.0 && value.is_finite();
        if good { Ok(()) } else { Err(FeedError::BadBlockOption { name, value }) }
    };
    positive("servo period", options.period)?;
    if let Some(tiny) = options.tiny {
        positive("length of a tiny block", tiny.length)?;
    }
    match options.ahead {
        LookAhead::Dynamic { periods, .. } => positive("window in servo periods", periods),
        _ => Ok(()),
    }
}
