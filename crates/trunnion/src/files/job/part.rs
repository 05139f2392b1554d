//! The job's `[part]`, and selections of its faces.

use super::super::document::Document;
use super::data::{FaceSelection, JobPart};
use super::raw::{RawFaces, RawPart};

/// Reads the part.
pub(super) fn part(raw: RawPart, doc: &mut Document<'_>) -> Option<JobPart> {
    let faces = faces(raw.faces, "part.faces", doc);
    let avoid = faces_of(raw.avoid, "part.avoid", doc);
    let angles = raw.rotation.map(f64::to_radians);
    Some(JobPart { file: raw.file, angles, faces: faces?, flip: raw.flip, avoid: avoid? })
}

/// Reads a selection of at least one face.
pub(super) fn faces(raw: RawFaces, path: &str, doc: &mut Document<'_>) -> Option<FaceSelection> {
    if matches!(&raw, RawFaces::Numbers(numbers) if numbers.is_empty()) {
        let help = "write `faces = \"all\"`, or numbers from `trunnion inspect`";
        doc.fault(path, "no face is named", help);
        return None;
    }
    faces_of(raw, path, doc)
}

fn faces_of(raw: RawFaces, path: &str, doc: &mut Document<'_>) -> Option<FaceSelection> {
    let RawFaces::Numbers(numbers) = raw else { return Some(FaceSelection::All) };
    for (at, number) in numbers.iter().enumerate() {
        if numbers.iter().take(at).any(|other| other == number) {
            let path = format!("{path}.{at}");
            // A face listed twice would be machined and measured twice.
            doc.fault(&path, format!("face {number} is named twice"), "name it once");
            return None;
        }
    }
    Some(FaceSelection::Numbers(numbers))
}
