//! Job and machine files: text to data with line, column and suggestion; no I/O.

pub mod job;
mod places;

pub use places::{Place, Places};
