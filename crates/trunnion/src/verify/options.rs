//! Resolution, tolerances and bounds of a check.

use super::error::VerifyError;

/// Tolerance of the finished part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviationTolerance {
    /// Largest excess \[mm\].
    pub excess: f64,
    /// Deepest gouge \[mm\].
    pub gouge: f64,
}

/// Resolution and tolerances of a check. Begin with [`CheckOptions::of_tolerance`] and change the rest by struct
/// update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckOptions {
    /// Largest distance of grid points \[mm\].
    pub grid: f64,
    /// Search range for the tool along the normal, both ways \[mm\]: material higher than that is uncut.
    pub reach: f64,
    /// Accuracy of heights \[mm\]: no tool smaller by a fifth of this gets lower by more than this. (A tenth
    /// each covers motion inside a block and touches that only graze.)
    pub ray_tolerance: f64,
    /// Largest excess \[mm\].
    pub total: f64,
    /// Deepest gouge \[mm\].
    pub gouge: f64,
    /// Largest number of grid points on one face.
    pub most_points: usize,
    /// Bounds to prove between the grid points, if any.
    pub bounds: Option<BoundOptions>,
}

/// Material higher than this counts as uncut, unless a tolerance is not far below it \[mm\].
const REACH: f64 = 1.0;
/// Shares of the tolerances of excess and of gouges by which a ray may miss the swept cutter: a gouge is judged with
/// it against it.
const RAY_SHARES: [f64; 2] = [0.005, 0.05];
/// Smallest gouge that counts \[mm\]: rounded words take the tool of a program that touches a face into it. Words of
/// X Y Z with four decimals, the most that controls take in mm, are off by `sqrt(3) * 0.00005` together.
pub const LEAST_GOUGE: f64 = 1e-4;
/// Shares of the same by which a bound may lie beyond the worst measured point.
const MARGIN_SHARES: [f64; 2] = [0.05, 0.5];
/// Largest number of grid points on one face.
const MOST_POINTS: usize = 20_000_000;

impl CheckOptions {
    /// Returns the options that suit a tolerance, with points at most `grid` \[mm\] apart. A gouge may be
    /// [`LEAST_GOUGE`] deep in any case.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::verify::{CheckOptions, DeviationTolerance};
    ///
    /// let options = CheckOptions::of_tolerance(DeviationTolerance { excess: 0.02, gouge: 0.002 }, 0.2);
    /// assert_eq!((options.total, options.gouge), (0.02, 0.002));
    /// assert!(options.ray_tolerance <= 0.05 * options.gouge);
    /// ```
    #[must_use]
    pub const fn of_tolerance(tolerance: DeviationTolerance, grid: f64) -> Self {
        let DeviationTolerance { excess: total, gouge } = tolerance;
        // Words rounded to the last decimal take the tool into the face by up to this much.
        let gouge = gouge.max(LEAST_GOUGE);
        // Both tolerances must hold, so the finer share counts.
        let ray_tolerance = (RAY_SHARES[1] * gouge).min(RAY_SHARES[0] * total);
        let finer_margin = (MARGIN_SHARES[1] * gouge).min(MARGIN_SHARES[0] * total);
        let margin = BoundMargins { gouge: finer_margin, excess: MARGIN_SHARES[0] * total };
        Self {
            grid,
            reach: REACH.max(2.0 * total).max(2.0 * gouge),
            ray_tolerance,
            total,
            gouge,
            most_points: MOST_POINTS,
            bounds: Some(BoundOptions::within(margin)),
        }
    }
}

/// Largest distances of bounds from the worst that is measured; smaller where the tolerance is kept by less.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundMargins {
    /// Distance from the worst gouge \[mm\].
    pub gouge: f64,
    /// Distance from the worst excess \[mm\].
    pub excess: f64,
}

impl BoundMargins {
    /// Creates margins of the same distance \[mm\].
    #[must_use]
    pub const fn both(distance: f64) -> Self {
        Self { gouge: distance, excess: distance }
    }
}

/// Bounds that hold all over the faces. Begin with [`BoundOptions::within`] and change the rest by struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundOptions {
    /// Largest distances of the bounds from the worst gouge and the worst excess.
    pub margin: BoundMargins,
    /// Bounds excess as well: not for faces that are to be left alone.
    pub excess: bool,
}

impl BoundOptions {
    /// Bounds gouges and excess within these distances of the worst of each.
    #[must_use]
    pub const fn within(margin: BoundMargins) -> Self {
        Self { margin, excess: true }
    }
}

/// Share of the ray tolerance by which the chords of an arc may be off.
pub(super) const CHORD_SHARE: f64 = 0.1;

impl CheckOptions {
    /// Refuses options that are not usable numbers.
    pub(super) fn validated(&self) -> Result<(), VerifyError> {
        let options = self;
        let positive = [
            ("grid", options.grid),
            ("reach", options.reach),
            ("ray_tolerance", options.ray_tolerance),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(VerifyError::Option { name, value, must: "a length above 0" });
            }
        }
        for (name, value) in [("total", options.total), ("gouge", options.gouge)] {
            if !(value >= 0.0 && value < options.reach) {
                return Err(VerifyError::Option { name, value, must: "from 0 to below the reach" });
            }
        }
        Ok(())
    }
}
