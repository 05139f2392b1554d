//! APT/CL and G-code: [`words`] shared by both sides, [`read`], [`write`](mod@write), and the
//! [`control`] that runs a program.
//!
//! # Meaning of X, Y, Z in a program
//!
//! * **TCP on** (`program.linuxcnc.ngc`): the tool tip in the *table frame*: fixed to the workpiece,
//!   origin at the workpiece origin, axes parallel to the machine's while all axes stand at zero.
//!   That is the workpiece frame turned by the setup rotation (`tip_table = rotation * tip`), because
//!   a control's TCP knows pivots and tool length but no setup rotation.
//! * **TCP off** (`program.g93.nc`): axis positions, less the work offset and less the tool length
//!   along Z while `G43` is on: `axis = word + offset + length`.
//! * Both take the same work offset: the axis positions at which, rotaries at zero and no tool, the
//!   gauge point stands on the workpiece origin. `setup.txt` has the numbers.
//! * Rotary words are axis values in degrees, unwound, reversed where the control turns the other way.
//!
//! Motion inside a block is linear in the words: tip and rotaries with TCP, all axes without.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod control;
pub mod read;
pub mod words;
#[cfg(feature = "write")]
pub mod write;

pub use nalgebra;

use trunnion_motion::machine;
use trunnion_types::{math, types};
