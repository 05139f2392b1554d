//! Job and machine files: text to data with line, column and suggestion; no I/O.

mod document;
pub mod job;
pub mod machine;
mod places;
pub mod schema;
pub mod summary;
mod walk;

pub use places::{Place, Places};
