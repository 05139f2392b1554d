//! A library of cutters, holders and machines as data for the fields of a page.

use serde::Serialize;
use trunnion::files::library::{LibraryCutter, LibraryFile, LibraryHolder, LibraryMachine};

/// Library as the fields of a page show it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LibraryModel {
    /// Name.
    pub name: String,
    /// Cutters.
    pub cutters: Vec<CutterModel>,
    /// Holders.
    pub holders: Vec<HolderModel>,
    /// Machines beside the built-in ones.
    pub machines: Vec<MachineChoice>,
}

/// Cutter of a library.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct CutterModel {
    /// Name.
    pub name: String,
    /// Keys of the tool of a job, with their values in TOML.
    pub keys: Vec<[String; 2]>,
}

/// Holder of a library.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HolderModel {
    /// Name.
    pub name: String,
    /// Pairs of height above the lower end and radius \[mm\]; the upper end is at the gauge point.
    pub profile: Vec<[f64; 2]>,
}

/// Machine of a library.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct MachineChoice {
    /// Name.
    pub name: String,
    /// File, or name of a built-in machine.
    pub file: String,
}

impl LibraryModel {
    pub(crate) fn of(file: &LibraryFile) -> Self {
        let cutter =
            |one: &LibraryCutter| CutterModel { name: one.name.clone(), keys: one.keys.clone() };
        let holder = |one: &LibraryHolder| HolderModel {
            name: one.name.clone(),
            profile: one.profile.clone(),
        };
        let machine =
            |one: &LibraryMachine| MachineChoice { name: one.name.clone(), file: one.file.clone() };
        Self {
            name: file.name.clone(),
            cutters: file.cutters.iter().map(cutter).collect(),
            holders: file.holders.iter().map(holder).collect(),
            machines: file.machines.iter().map(machine).collect(),
        }
    }
}
