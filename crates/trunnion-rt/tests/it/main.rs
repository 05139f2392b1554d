//! Tests of the kinematics for a servo cycle, by its Rust and its C interface.

mod allocation;
mod c_interface;
mod header;
mod kinematics;
mod linuxcnc_modules;
mod motion;
mod switched;
mod walk;
