//! Job and machine files: text to data with line, column and suggestion; no I/O.

mod document;
pub mod job;
mod places;
pub mod schema;
mod walk;

pub use places::{Place, Places};
