//! Local optimum of the strip width.

use crate::positioning::solve::conditions::ProblemState;

/// The end of a climb.
#[derive(Debug, Clone)]
pub(crate) struct LocalOptimum {
    pub(crate) state: ProblemState,
    /// Multiplier of each condition, in the order of `state.conditions` \[mm width per mm\].
    pub(crate) multipliers: Vec<f64>,
    pub(crate) at_range_end: bool,
}
