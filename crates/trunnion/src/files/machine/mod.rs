//! The machine file (`trunnion-machine/1`): the kinematic chain, its limits, its control.

mod raw;
mod read;

pub(super) use raw::RawMachine;
pub use read::{MachineFile, parse};

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-machine/1";
