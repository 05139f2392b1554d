//! Five-axis machining, from a surface to a verified program.
//!
//! Stages, in order; every arrow is a plain function from data to data:
//!
//! ```text
//! import ─▶ surface ─▶ positioning ─▶ cover ─▶ toolpath ─▶ axes ─▶ feed ─▶ setpoint ─▶ (servo)
//!             cutter ──┘                        machine ──┘          └─▶ blocks ─▶ nc ─▶ (program)
//!                                                                                  │
//!                              verify ◀── surface, cutter, machine, nc::read ◀─────┘
//! ```
//!
//! Read [`types`] first: it is the vocabulary that stages hand on. Units everywhere: **mm, rad, s**.
//! This crate does no I/O, reads no clock, holds no global state and never panics on user data;
//! the same input gives the same bytes on any number of threads.
//! Which module may use which is written down, and checked, in `tests/it/layers.rs`.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod blocks;
pub mod cover;
pub mod files;
pub mod pipeline;
pub mod positioning;
pub mod post;
#[cfg(test)]
mod sample_machine;
pub mod toolpath;
pub mod verify;

pub use nalgebra;
pub use trunnion_geometry::{cutter, drop_cutter, import, surface};
pub use trunnion_motion::{axes, calibrate, feed, inverse, machine, program_motion, setpoint};
pub use trunnion_nc as nc;
pub use trunnion_types::{math, types};

/// The README's Rust lines compile.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
mod readme {}
