//! Signed distance of the cutting circle and the flat disc from the surface, and its bounds.

pub(crate) mod circle;
pub(crate) mod curve;
pub(crate) mod disc;
pub(crate) mod gaps;
pub(crate) mod probe;
pub(crate) mod ring;
pub(crate) mod width;
