//! Vocabulary and mathematics of the five-axis machining engine `trunnion`.
//!
//! [`types`] is the plain data that stages hand on: cutter locations, passes, axis paths, schedules,
//! meshes, progress. [`math`] is what they are computed with: truncated Taylor series, B-splines,
//! quintics, angles. Units everywhere: **mm, rad, s**.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod math;
pub mod types;

pub use nalgebra;
