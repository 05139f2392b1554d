//! Turns stock into a triangle mesh.

pub(crate) mod merge;
pub(crate) mod surface_nets;
