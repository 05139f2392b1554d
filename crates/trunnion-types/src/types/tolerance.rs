//! Tolerances and deviations of a cutter location.

/// Largest deviation of a cutter location: of its tip, and of its tool axis.
///
/// # Example
///
/// ```
/// use trunnion_types::types::PoseTolerance;
///
/// // 5 um at the tip; 1 mrad moves a point 100 mm above the tip by 0.1 mm.
/// let tolerance = PoseTolerance { tip: 0.005, axis: 0.001 };
/// assert_eq!(PoseTolerance::from([0.005, 0.001]), tolerance);
/// assert_eq!(<[f64; 2]>::from(tolerance), [0.005, 0.001]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseTolerance {
    /// Largest distance between tips \[mm\].
    pub tip: f64,
    /// Largest angle between tool axes \[rad\].
    pub axis: f64,
}

impl PoseTolerance {
    /// Creates the tolerance of `tip` \[mm\] and `axis` \[rad\].
    pub const fn new(tip: f64, axis: f64) -> Self {
        Self { tip, axis }
    }

    /// Returns this share of the tolerance.
    #[must_use]
    pub const fn scaled(&self, share: f64) -> Self {
        Self { tip: share * self.tip, axis: share * self.axis }
    }
}

impl From<[f64; 2]> for PoseTolerance {
    /// Takes `[tip, axis]` \[mm, rad\].
    fn from([tip, axis]: [f64; 2]) -> Self {
        Self { tip, axis }
    }
}

impl From<PoseTolerance> for [f64; 2] {
    /// Returns `[tip, axis]` \[mm, rad\].
    fn from(tolerance: PoseTolerance) -> Self {
        [tolerance.tip, tolerance.axis]
    }
}

/// Deviation of a cutter location: of its tip, and of its tool axis.
///
/// # Example
///
/// ```
/// use trunnion_types::types::PoseDeviation;
///
/// let worst = PoseDeviation { tip: 0.002, axis: 1e-4 }.max(PoseDeviation { tip: 0.001, axis: 3e-4 });
/// assert_eq!(worst, PoseDeviation { tip: 0.002, axis: 3e-4 });
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PoseDeviation {
    /// Distance between tips \[mm\].
    pub tip: f64,
    /// Angle between tool axes \[rad\].
    pub axis: f64,
}

impl PoseDeviation {
    /// Returns the larger of both distances, and the larger of both angles.
    #[must_use]
    pub const fn max(self, other: Self) -> Self {
        Self { tip: self.tip.max(other.tip), axis: self.axis.max(other.axis) }
    }
}

impl From<[f64; 2]> for PoseDeviation {
    /// Takes `[tip, axis]` \[mm, rad\].
    fn from([tip, axis]: [f64; 2]) -> Self {
        Self { tip, axis }
    }
}
