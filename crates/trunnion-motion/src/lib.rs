//! Motion of five-axis machines: kinematics, axis paths and feed planning.
//!
//! [`machine`] is the kinematic chain and its forward map, [`inverse`] maps tool poses to axes in
//! closed form, [`axes`] turns a tool path into an axis path, [`feed`] plans the speed along it as
//! fast as the axes allow, and [`setpoint`] samples the plan at the servo period. [`program_motion`]
//! plans a program inside a control, block by block. No stage needs a file format. Units everywhere: **mm, rad, s**.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod axes;
pub mod calibrate;
pub mod feed;
pub mod inverse;
pub mod machine;
pub mod program_motion;
pub mod setpoint;

pub use nalgebra;
pub use trunnion_types::{math, types};
