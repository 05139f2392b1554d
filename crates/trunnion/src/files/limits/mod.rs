//! The limits file (`trunnion-limits/1`): velocity, acceleration and jerk limits of the axes of a path table.

pub(super) mod raw;
mod read;

pub use raw::{AxisLimits, LAYOUT, PathLimits};
pub use read::{LimitsFile, parse};
