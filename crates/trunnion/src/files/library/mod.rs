//! Libraries of cutters, holders and machines, from which jobs are made (`trunnion-library/1`).

pub(super) mod raw;
mod read;

pub use raw::{LAYOUT, LibraryHolder, LibraryMachine};
pub use read::{LibraryCutter, LibraryFile, parse, standard};
