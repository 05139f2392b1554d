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
    pub holders: Vec<LibraryHolder>,
    /// Machines beside the built-in ones.
    pub machines: Vec<LibraryMachine>,
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

impl LibraryModel {
    pub(crate) fn of(file: &LibraryFile) -> Self {
        let cutter =
            |one: &LibraryCutter| CutterModel { name: one.name.clone(), keys: one.keys.clone() };
        Self {
            name: file.name.clone(),
            cutters: file.cutters.iter().map(cutter).collect(),
            holders: file.holders.clone(),
            machines: file.machines.clone(),
        }
    }
}
