//! Name of the job file's layout.

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-job/1";
