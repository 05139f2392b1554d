//! Fit of the cutters into concave faces, checked before passes are placed.

use super::error::PipelineError;
use super::job::Job;
use super::reach::samples;
use super::too_concave::TooConcave;
use crate::cover::{CoverOptions, FinishTolerance, flank_fits};
use crate::cutter::Cutter;
use crate::files::job::{JobArea, JobPrismatic};
use crate::positioning::ToleranceBand;
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
/// [`PipelineError::TooConcave`] for the first face that is too concave everywhere, [`PipelineError::NoFlank`] with all
/// faces that the flank is asked to cut and cannot.
pub fn fit(job: &Job) -> Result<Vec<String>, PipelineError> {
    flanks(job)?;
    let mut warnings = cut_twice(job);
    for face in job.cut_faces() {
        let number = face.face().number;
        let cuts = |one: &&Job| one.faces.iter().any(|other| other.face().number == number);
        let cutters: Vec<&Cutter> = job.operations().filter(cuts).map(|one| &one.cutter).collect();
        let samples = samples(face);
        let tight = |sample: &FaceSample| {
            let curvatures = curvatures(face, sample.uv)?;
            // The cutter that comes nearest to fitting names the miss.
            let mut nearest: Option<Miss> = None;
            for cutter in &cutters {
                let miss = miss(cutter, curvatures)?;
                if nearest.as_ref().is_none_or(|known| miss.ratio() > known.ratio()) {
                    nearest = Some(miss);
                }
            }
            nearest.map(|miss| (miss, sample.point))
        };
        let found: Vec<(Miss, Point3<f64>)> = samples.iter().filter_map(tight).collect();
        let least = |a: &&(Miss, Point3<f64>), b: &&(Miss, Point3<f64>)| {
            a.0.concave.total_cmp(&b.0.concave)
        };
        let Some((Miss { concave, radius, arc }, point)) = found.iter().min_by(least).copied()
        else {
            continue;
        };
        let share = found.len() as f64 / samples.len().max(1) as f64;
        let tight = TooConcave { face: number, share, radius: concave, point, corner: radius, arc };
        if found.len() == samples.len() {
            return Err(PipelineError::TooConcave(Box::new(tight)));
        }
        if share > SHARE {
            warnings.push(format!("{tight}; it stays unfinished"));
        }
    }
    Ok(warnings)
}

/// Checks that the flank can lie along the faces of the operations that ask for it.
fn flanks(job: &Job) -> Result<(), PipelineError> {
    let asked = job.operations().filter(|one| one.file.strategy.prismatic == JobPrismatic::Flank);
    let refused = |one: &Job| {
        let tolerance = FinishTolerance { excess: one.budget.total, gouge: one.budget.gouge };
        let options = CoverOptions {
            band: ToleranceBand { lower: one.budget.lower, upper: one.budget.upper },
            ..CoverOptions::finishing(&one.cutter, tolerance)
        };
        let fits = |face: &FaceIndex| match flank_fits(face, &one.cutter, &options) {
            Ok(()) => None,
            Err(why) => Some(format!("face {}: {why}", face.face().number)),
        };
        one.faces.iter().filter_map(fits).collect::<Vec<String>>()
    };
    let why: Vec<String> = asked.flat_map(refused).collect();
    if why.is_empty() { Ok(()) } else { Err(PipelineError::NoFlank { why }) }
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

/// Arc of a cutter that does not fit.
#[derive(Debug, Clone, Copy)]
struct Miss {
    /// Concave radius of the face \[mm\].
    concave: f64,
    /// Radius of the arc \[mm\].
    radius: f64,
    arc: &'static str,
}

impl Miss {
    /// Returns the share of the arc that would fit: the nearer to 1, the smaller the miss.
    fn ratio(&self) -> f64 {
        self.concave / self.radius
    }
}

/// Returns the arc with which a cutter does not fit a face of some principal curvatures; `None` if it fits, at some
/// inclination and in some direction.
fn miss(cutter: &Cutter, [less, more]: [f64; 2]) -> Option<Miss> {
    let arc = cutter.contact_arc();
    let fails = |curvature: f64, radius: f64, arc: &'static str| {
        // A flat end mill has no corner radius, and any cutter fits where the face does not bend towards it.
        let concave = curvature.recip();
        (curvature > 0.0 && concave < radius * (1.0 - ROUNDING)).then_some(Miss {
            concave,
            radius,
            arc,
        })
    };
    if !cutter.is_barrel() {
        return fails(more, arc.radius, "corner");
    }
    // Across its arc a barrel bends most at the tip; along the arc it has the direction in which the face bends less.
    let thin = arc.radius_across(arc.inclinations.low);
    fails(less, arc.radius, "large arc").or_else(|| fails(more, thin, "body"))
}

/// Returns the principal curvatures of a face, the smaller first \[1/mm\]: positive towards the cutter.
pub(super) fn curvatures(face: &FaceIndex, Uv { u, v }: Uv) -> Option<[f64; 2]> {
    let curvature = face.face().surface.jet2(u, v).curvature()?;
    // Positive: towards S_u x S_v, which is away from the cutter on a flipped face.
    let both = [curvature.min, curvature.max];
    Some(if face.face().flip { [-both[1], -both[0]] } else { both })
}
