//! Layout of a library as it is written.

use super::super::job::raw::RawTool;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-library/1";

/// Library of trunnion: cutters, holders and machines from which jobs are made.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read section by section; the whole describes the layout")]
pub(in super::super) struct RawLibrary {
    /// Layout of this file, with its version.
    #[schemars(extend("const" = LAYOUT))]
    schema: String,
    /// Name of the library.
    #[schemars(length(min = 1))]
    name: String,
    /// Cutters, one table each: the keys of [tool] in a job, with a name.
    #[serde(default)]
    cutter: Vec<RawTool>,
    /// Holders, one table each.
    #[serde(default)]
    holder: Vec<LibraryHolder>,
    /// Machines beside the built-in ones, one table each.
    #[serde(default)]
    machine: Vec<LibraryMachine>,
}

/// Holder of a library.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[non_exhaustive]
pub struct LibraryHolder {
    /// Name of the holder.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Profile: pairs [height above the lower end, radius] in mm, from below up; the upper end is at the gauge point.
    #[schemars(length(min = 1))]
    pub profile: Vec<[f64; 2]>,
}

/// Machine of a library.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[non_exhaustive]
pub struct LibraryMachine {
    /// Name of the machine.
    #[schemars(length(min = 1))]
    pub name: String,
    /// Machine file, or name of a built-in machine, as the table `machine` of a job has it.
    #[schemars(length(min = 1))]
    pub file: String,
}
