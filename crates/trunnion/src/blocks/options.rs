//! Interpolation by the control, and options of blocks.

/// Motion of a control from one block end to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockInterpolation {
    /// All five axes linearly; the tip bows (no RTCP).
    Axes,
    /// The tip straight in the workpiece frame, the rotary axes linearly.
    RotaryLinear,
    /// The tip straight in the workpiece frame, the tool axis on a great circle.
    GreatCircle,
}

/// Tolerances and sizes of blocks. Begin with [`BlockOptions::within`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct BlockOptions {
    /// Motion of the control between block ends.
    pub control: BlockInterpolation,
    /// Largest deviation while cutting, leading in and out \[mm\]: tip distance, plus angle of the
    /// tool axis times `lever`.
    pub tolerance: f64,
    /// The same on links, and the most on hops: there the deviation may grow with the distance from their ends \[mm\].
    pub link_tolerance: f64,
    /// Distance from the tip to the point whose position matters, for instance the contact \[mm\].
    pub lever: f64,
    /// Longest tip travel of a block; links and hops are exempt \[mm\].
    pub max_step: f64,
    /// Largest travel of a rotary axis in a block; links and hops are exempt \[rad\].
    pub max_turn: f64,
    /// Largest turn of the tool axis in a block; links and hops are exempt \[rad\]. Paper 003 controls the
    /// error by it.
    pub max_axis_turn: f64,
    /// Longest block; links and hops are exempt \[s\]. A block runs at its mean speed, so this decides how
    /// closely a program follows the speeds of the schedule.
    pub max_duration: f64,
    /// Shortest block \[s\]: wins over the four above, and yields to the tolerances. 0 for none.
    pub min_duration: f64,
}

impl BlockOptions {
    /// Allows blocks of any length and duration within a tolerance \[mm\] of the tip, on links as well.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::blocks::{BlockInterpolation, BlockOptions};
    ///
    /// let mut options = BlockOptions::within(BlockInterpolation::RotaryLinear, 0.01);
    /// options.lever = 6.0;
    /// options.max_duration = 0.02;
    /// assert_eq!(options.link_tolerance, 0.01);
    /// ```
    #[must_use]
    pub const fn within(control: BlockInterpolation, tolerance: f64) -> Self {
        Self {
            control,
            tolerance,
            link_tolerance: tolerance,
            lever: 0.0,
            max_step: f64::INFINITY,
            max_turn: f64::INFINITY,
            max_axis_turn: f64::INFINITY,
            max_duration: f64::INFINITY,
            min_duration: 0.0,
        }
    }
}
