//! Constants that several files of this module share.

/// Faults after which a reader gives up.
pub const MOST_FAULTS: usize = 20;

/// Length that one radian of rotary travel counts for beside the travel of the tip \[mm/rad\].
pub(super) const LEVER: f64 = 10.0;

/// Smallest length that words can express: they have nine decimals at most \[mm\].
pub(super) const SMALLEST_LENGTH: f64 = 1e-9;
