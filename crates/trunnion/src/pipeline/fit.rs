//! Fit of the cutters into concave faces, checked before passes are placed.

use super::error::PipelineError;
use super::job::Job;
use super::reach::samples;
use super::too_concave::TooConcave;
use crate::files::job::JobArea;
use crate::surface::{FaceIndex, FaceSample};
use crate::types::Uv;
use nalgebra::Point3;

/// Share of a face that may be too concave without a warning: seams and corners are reported where they stay uncut.
const SHARE: f64 = 0.02;

/// Relative rounding of a curvature: a cutter of the radius of a fillet fits it.
const ROUNDING: f64 = 1e-6;

/// Checks by the curvature of the faces that the cutters fit into their hollows.
///
/// It takes a fraction of a second; [`run`](super::run()) begins with it. Returns a warning for every face of which
/// some part is too concave, and for every face that two operations cut whole. A flat end mill has no corner radius: it is not judged.
///
/// # Errors
///
/// [`PipelineError::TooConcave`] for the first face that is too concave everywhere.
pub fn fit(job: &Job) -> Result<Vec<String>, PipelineError> {
    let mut warnings = cut_twice(job);
    for face in job.cut_faces() {
        let number = face.face().number;
        let cuts = |one: &&Job| one.faces.iter().any(|other| other.face().number == number);
        let corners = job.operations().filter(cuts).map(|one| one.cutter.minor());
        let corner = corners.fold(f64::INFINITY, f64::min);
        let samples = samples(face);
        let tight = |sample: &FaceSample| {
            let radius = concave_radius(face, sample.uv)?;
            (radius < corner * (1.0 - ROUNDING)).then_some((radius, sample.point))
        };
        let found: Vec<(f64, Point3<f64>)> = samples.iter().filter_map(tight).collect();
        let Some(&(radius, point)) = found.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        let share = found.len() as f64 / samples.len().max(1) as f64;
        let tight = TooConcave { face: number, share, radius, point, corner };
        if found.len() == samples.len() {
            return Err(PipelineError::TooConcave(Box::new(tight)));
        }
        if share > SHARE {
            warnings.push(format!("{tight}; it stays unfinished"));
        }
    }
    Ok(warnings)
}

/// Warns of faces that two operations cut whole: the second takes its time and changes little.
fn cut_twice(job: &Job) -> Vec<String> {
    let whole: Vec<&Job> =
        job.operations().filter(|one| one.file.strategy.area == JobArea::Whole).collect();
    let mut warnings = Vec::new();
    for face in job.cut_faces().into_iter().map(|face| face.face().number) {
        let cuts = |one: &&&Job| one.faces.iter().any(|other| other.face().number == face);
        let names: Vec<&str> = whole.iter().filter(cuts).map(|one| one.name.as_str()).collect();
        if names.len() > 1 {
            warnings.push(format!(
                "face {face} is cut whole by {}: write method = \"rest\" in the later one to cut only what is left",
                names.join(" and by ")
            ));
        }
    }
    warnings
}

/// Returns the smallest radius with which a face bends towards the cutter \[mm\]; `None` where it does not.
fn concave_radius(face: &FaceIndex, Uv { u, v }: Uv) -> Option<f64> {
    let curvature = face.face().surface.jet2(u, v).curvature()?;
    // Positive: towards S_u x S_v, which is away from the cutter on a flipped face.
    let most = if face.face().flip { -curvature.min } else { curvature.max };
    (most > 0.0).then(|| most.recip())
}
