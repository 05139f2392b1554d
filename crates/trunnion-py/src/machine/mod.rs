//! `trunnion.Machine`.
//!
//! ```text
//! angle_unit   radians or degrees
//! poses        tips and tool axes of an argument pair, and poses without an answer
//! class        the class: setup, figures of the axes, files
//! maps         forward map, inverse, derivatives
//! answers      imports and calibrations
//! ```

mod angle_unit;
mod answers;
mod class;
mod maps;
mod poses;

pub(crate) use angle_unit::AngleUnit;
pub(crate) use answers::{calibrate_machine, import_machine};
pub(crate) use class::{Machine, built_in};
pub(crate) use poses::{PoseArrays, Poses};
