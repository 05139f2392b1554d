//! Tests of the kinematics for a servo cycle, by its Rust and its C interface.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test stops on surprise")]

mod allocation;
mod c_interface;
mod header;
mod kinematics;
mod linuxcnc_modules;
mod observer;
mod operation;
mod planner;
mod random_programs;
mod switched;
mod walk;
