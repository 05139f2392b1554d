//! Elementary functions, intervals, jets (truncated Taylor), B-spline basis, angles and rotations; nothing of machining.

pub mod angle;
pub mod bspline;
mod elementary;
mod interval;
pub mod jet;
pub mod quintic;
mod rotation;
pub mod spline;

pub use elementary::{
    acos, asin, atan, atan2, cbrt, cos, cosh, exp, hypot, ln, log10, powf, sin, sin_cos, sinh, tan,
};
pub use interval::Interval;
pub use rotation::{
    angle_apart, angle_of, angle_of_vectors, exact_rotation_of_xyz, quaternion_about,
    quaternion_between, rotation_about, rotation_of_xyz, xyz_of_rotation,
};
