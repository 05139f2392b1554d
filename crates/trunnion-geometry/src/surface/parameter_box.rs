//! Rectangle of parameters.

use crate::types::Interval;

/// Ranges of u and v.
pub(super) type ParameterBox = [Interval; 2];
