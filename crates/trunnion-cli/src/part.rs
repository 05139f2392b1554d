//! Reads a part: surface JSON or STEP, distinguished by content.

use crate::outcome::Failure;
use crate::text;
use std::path::Path;
use trunnion::import;
use trunnion::import::step::StepReader;
use trunnion::import::{ImportError, Part, Reader, surface_json};
use trunnion::surface::Face;
use trunnion::types::{Diagnostic, Progress};

/// STEP reader. Its chord tolerance is far below the run-out of a cutter; its distance of equal points
/// is that of neighbouring edge ends in common CAD systems.
pub(crate) const STEP: StepReader = StepReader { chord: 0.001, same: 0.01 };

/// Reads the faces of a part.
pub(crate) fn read(path: &Path, progress: &dyn Progress) -> Result<Part, Failure> {
    read_bytes(path, &text::read_bytes(path)?, progress)
}

/// Reads the faces of a part from the bytes of a file.
pub(crate) fn read_bytes(
    path: &Path,
    bytes: &[u8],
    progress: &dyn Progress,
) -> Result<Part, Failure> {
    if is_json(path, bytes) {
        return surface_json::read(bytes)
            .and_then(|surface| {
                Face::new(1, surface, Vec::new())
                    .map_err(|error| Diagnostic::whole(error.to_string()).into())
            })
            .map(|face| Part { faces: vec![face], warnings: Vec::new() })
            .map_err(|faults| Failure::faults(path, &faults));
    }
    STEP.read(bytes, progress).map_err(|error| match error {
        ImportError::Cancelled(_) => Failure::Stopped,
        ImportError::WrongFormat { .. } => {
            let help = "a part is a STEP file with its faces, or a surface JSON file";
            Failure::input(format!("{}: {error}\n  help: {help}", path.display()))
        }
        error => Failure::input(format!("{}: {error}", path.display())),
    })
}

/// Returns true for JSON: by its first brace, or by the file name, so that the JSON reader explains
/// what is wrong.
fn is_json(path: &Path, bytes: &[u8]) -> bool {
    let name = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let first = import::without_mark(bytes).iter().find(|byte| !byte.is_ascii_whitespace());
    name || first == Some(&b'{')
}
