//! Tuning of the cutter-location smoother, shared by `run`, `path` and `post`.

use crate::types::PoseTolerance;

/// Turn of the path from which a cutter location is a corner \[rad\].
pub const CORNER: f64 = 20.0 * DEGREE;

/// Largest turn of the path that is rounded \[rad\].
pub const LARGEST_BLEND: f64 = 120.0 * DEGREE;

/// Ratio of neighbouring steps from which a cutter location is a corner.
pub const STEP_RATIO: f64 = 8.0;

/// Cutter locations in memory at a time.
pub const WINDOW_STATIONS: usize = 1024;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// Splits a smoothing share \[mm\]: one half moves the tip, the other half turns the tool axis at the lever \[mm\].
///
/// # Example
///
/// ```
/// let tolerance = trunnion::post::smoothing_tolerance(0.02, 10.0);
/// assert_eq!((tolerance.tip, tolerance.axis), (0.01, 0.001));
/// ```
pub fn smoothing_tolerance(share: f64, lever: f64) -> PoseTolerance {
    PoseTolerance { tip: 0.5 * share, axis: 0.5 * share / lever }
}
