//! Surfaces, cutters and the files they come from.
//!
//! [`surface`] evaluates B-spline faces with derivatives, bounds and closest points, [`cutter`]
//! describes a milling cutter as a profile of revolution, [`drop_cutter`] lowers one on triangles, and
//! [`import`] reads STEP, STL and surface JSON. Units everywhere: **mm, rad**.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod cutter;
pub mod drop_cutter;
pub mod import;
pub mod surface;

pub use nalgebra;
pub use trunnion_types::{math, types};
