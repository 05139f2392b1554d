//! Bytes to surfaces: STEP (feature `step`), surface JSON.

pub mod surface_json;
