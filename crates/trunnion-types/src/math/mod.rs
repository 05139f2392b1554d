//! Intervals, jets (truncated Taylor), B-spline basis, angles; nothing of machining.

pub mod angle;
pub mod bspline;
mod interval;
pub mod jet;
pub mod quintic;
pub mod spline;

pub use interval::Interval;
