//! Checks of the input: path, schedule and options.

use super::error::BlocksError;
use super::options::BlockOptions;
use crate::types::{AxisPath, Schedule};

pub(super) fn validate(
    path: &AxisPath,
    schedule: &Schedule,
    options: &BlockOptions,
) -> Result<(), BlocksError> {
    let positive = [
        ("tolerance", options.tolerance),
        ("link_tolerance", options.link_tolerance),
        ("max_step", options.max_step),
        ("max_turn", options.max_turn),
        ("max_axis_turn", options.max_axis_turn),
        ("max_duration", options.max_duration),
    ];
    for (name, value) in positive {
        if value.is_nan() || value <= 0.0 {
            return Err(BlocksError::BadOption { name, value, must: "positive" });
        }
    }
    for (name, value) in [("lever", options.lever), ("min_duration", options.min_duration)] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(BlocksError::BadOption { name, value, must: "finite and not negative" });
        }
    }
    schedule.check_against(path)?;
    Ok(())
}
