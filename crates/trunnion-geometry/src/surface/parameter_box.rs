//! Rectangle of parameters.

/// Ranges of u and v.
pub(super) type ParameterBox = [[f64; 2]; 2];
