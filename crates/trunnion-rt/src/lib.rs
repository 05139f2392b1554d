//! Five-axis kinematics inside a control's servo cycle.
//!
//! A machine file is read once, at load. From then on [`MachineKinematics`] maps between joints, the words of
//! a program and tool poses, and [`SwitchedKinematics`] adds the switch between tool-centre-point control and
//! plain axes. After the load no function allocates, locks, calls the system or panics; the tests prove it.
//!
//! `linuxcnc/trunnion_rt.h` is the C interface, made from [`interface`]. Units everywhere: **mm, rad, s**.
//!
//! # Words of a program
//!
//! With tool-centre-point control a control counts X, Y and Z in the table frame, which is the machine frame
//! with all axes at zero, and adds the tool length along Z:
//!
//! ```text
//! tip in the table frame = gauge point + (X, Y, Z) - length * z
//! ```
//!
//! The rotary words are the rotary joints, so with the rotaries at zero words and joints agree on a machine
//! whose linear axes are parallel to the machine frame. Joints and words are in the order X, Y, Z, then the
//! rotary axes in chain order, workpiece side first.
//!
//! # Example
//!
//! ```
//! use trunnion_rt::machine_named;
//!
//! let kinematics = machine_named("bc-trunnion")?;
//! // The table tilted by 30 degrees, a tool of 120 mm.
//! let words = [-300.0, -250.0, -380.0, 0.0, 30_f64.to_radians()].into();
//! let reached = kinematics.joints(120.0, &words)?;
//! let again = kinematics.words(120.0, &reached.joints);
//! assert!((again - words).amax() < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod ini;
pub mod interface;
mod kinematics;
mod load;
pub mod planner;
mod refusal;
mod switched;

pub use ini::{IniDifference, ini_differences};
pub use kinematics::{MachineKinematics, ReachedJoints};
pub use load::{LoadError, machine_from_text, machine_named};
pub use refusal::{Refusal, RefusalCode};
pub use switched::{KinematicsMode, SwitchedKinematics};
