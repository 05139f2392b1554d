//! Builds stock from solids.

pub(crate) mod fill;
pub(crate) mod solid;
pub(crate) mod triangles;
