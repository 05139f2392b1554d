//! Name of the machine file's layout.

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-machine/1";
