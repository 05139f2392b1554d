//! Reads a part: surface JSON or STEP, distinguished by content.

use crate::outcome::Failure;
use crate::text;
use std::path::Path;
use trunnion::import;
use trunnion::import::step::StepReader;
use trunnion::import::{ImportError, Part, Reader, surface_json};
use trunnion::surface::Face;
use trunnion::types::{Diagnostic, Progress};

/// How trim loops are read: far below what the run-out of a cutter could notice, and as near as
/// common CAD systems let the ends of neighbouring edges lie.
pub(crate) const STEP: StepReader = StepReader { chord: 0.001, same: 0.01 };

/// Reads the faces of a part.
pub(crate) fn read(path: &Path, progress: &dyn Progress) -> Result<Part, Failure> {
    let bytes = text::read_bytes(path)?;
    if is_json(path, &bytes) {
        return surface_json::read(&bytes)
            .and_then(|surface| {
                Face::new(1, surface, Vec::new())
                    .map_err(|error| Diagnostic::whole(error.to_string()).into())
            })
            .map(|face| Part { faces: vec![face], warnings: Vec::new() })
            .map_err(|faults| Failure::faults(path, &faults));
    }
    STEP.read(&bytes, progress).map_err(|error| match error {
        ImportError::Cancelled(_) => Failure::Stopped,
        error => Failure::input(format!("{}: {error}", path.display())),
    })
}

/// JSON starts with a brace; a name that promises JSON is believed, so that its reader can say what
/// is wrong.
fn is_json(path: &Path, bytes: &[u8]) -> bool {
    let name = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let first = import::without_mark(bytes).iter().find(|byte| !byte.is_ascii_whitespace());
    name || first == Some(&b'{')
}
