//! The machine file (`trunnion-machine/1`): the kinematic chain, its limits, its control.

mod built_in;
mod raw;
mod read;

pub use built_in::{BUILT_IN, built_in};
pub(super) use raw::RawMachine;
pub use read::{MachineFile, parse};

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-machine/1";
