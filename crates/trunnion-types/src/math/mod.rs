//! Jets (truncated Taylor), B-spline basis, roots, angles; nothing of machining.

pub mod angle;
pub mod bspline;
pub mod jet;
pub mod quintic;
pub mod spline;
