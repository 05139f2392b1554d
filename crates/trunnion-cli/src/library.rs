//! Libraries of cutters, holders and machines, from files.

use crate::outcome::Failure;
use crate::text;
use std::path::Path;
use trunnion::files::library::{LibraryFile, parse};

/// Reads a library.
pub(crate) fn read(path: &Path) -> Result<LibraryFile, Failure> {
    parse(&text::read(path)?).map_err(|faults| Failure::faults(path, &faults))
}
