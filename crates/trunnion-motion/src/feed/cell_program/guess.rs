//! A guess of the constraints that bind.

/// Constraints that bound the cell before. On smooth paths they bind the next cell too, which is
/// quickly checked. This only saves time: answers do not depend on it but for rounding.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct WarmStart {
    /// Coefficient and axis of the strip, where the end is as fast as what follows allows.
    pub(super) one: Option<[usize; 2]>,
    /// The two sides of strips whose corner it is.
    pub(super) corner: Option<[ActiveSide; 2]>,
    /// `true` if the answer was at the corner.
    pub(super) at_corner: bool,
}

/// `sign (a x + b y) = limit` for the strip of a coefficient and an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct ActiveSide {
    pub(super) place: [usize; 2],
    pub(super) sign: f64,
}
