//! Machines, parts and meshes from files.

use crate::outcome::Failure;
use crate::{library as libraries, machine as machines, material, part as parts};
use std::path::Path;
use trunnion::files::library::LibraryFile;
use trunnion::files::machine::MachineFile;
use trunnion::import::Part;
use trunnion::types::{Mesh, Progress};

/// Reads a machine file, or the built-in machine of that name if there is no such file.
///
/// # Errors
///
/// Every fault of the file, with line and column.
pub fn machine(name: &str) -> Result<MachineFile, Failure> {
    machines::load(name)
}

/// Returns the text of a machine file or built-in machine.
///
/// # Errors
///
/// A file that cannot be read, or a name that no built-in machine has.
pub fn machine_text(name: &str) -> Result<String, Failure> {
    machines::source(name)
}

/// Reads a library of cutters, holders and machines.
///
/// # Errors
///
/// Every fault of the file, with line and column.
pub fn library(path: &Path) -> Result<LibraryFile, Failure> {
    libraries::read(path)
}

/// Reads the faces of a part, surface JSON or STEP.
///
/// # Errors
///
/// Every fault of the file.
pub fn part(path: &Path, progress: &dyn Progress) -> Result<Part, Failure> {
    parts::read(path, progress)
}

/// Reads the faces of a part from the bytes of a surface JSON or STEP file; `name` stands in messages.
///
/// # Errors
///
/// Every fault of the file.
pub fn part_of_bytes(name: &Path, bytes: &[u8], progress: &dyn Progress) -> Result<Part, Failure> {
    parts::read_bytes(name, bytes, progress)
}

/// Reads the triangles of an STL file, or of a STEP solid within `chord` \[mm\].
///
/// # Errors
///
/// The fault of the file.
pub fn mesh(path: &Path, chord: Option<f64>) -> Result<Mesh, Failure> {
    material::mesh_of(path, chord)
        .map_err(|what| Failure::input(format!("{}: {what}", path.display())))
}
