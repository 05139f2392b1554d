//! The machine file (`trunnion-machine/1`): the kinematic chain, its limits, its control.

mod body;
mod built_in;
mod layout;
pub(super) mod raw;
mod read;
mod write;

pub use built_in::{BUILT_IN, built_in};
pub use layout::LAYOUT;
pub use read::{MachineFile, parse};
pub use write::write;
