//! Job, machine and limits files, tables: text to data with line, column and suggestion; no I/O.

mod document;
pub mod foreign;
pub mod job;
pub mod library;
pub mod limits;
pub mod machine;
pub mod measurements;
mod path;
mod places;
pub mod schema;
pub mod setups;
pub mod summary;
pub mod table;
mod walk;

pub use places::{KeyPositions, TextPosition};
