//! Job and machine files: text to data with line, column and suggestion; no I/O.

mod fault;
pub mod job;

pub use fault::{Fault, Place, Places};
