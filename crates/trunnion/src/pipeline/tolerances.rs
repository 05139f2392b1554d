//! Shares and tolerances that several stages use.

/// Share of the linearisation tolerance that the quintic axis path takes from the blocks, for tip and axis each.
pub(super) const QUINTIC_SHARE: f64 = 0.1;

/// Tolerance of links, far from the part \[mm\].
pub(super) const LINK_TOLERANCE: f64 = 1.0;
