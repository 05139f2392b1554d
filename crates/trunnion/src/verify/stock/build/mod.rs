//! Builds stock from solids.

pub(crate) mod solid;
pub(crate) mod triangles;
