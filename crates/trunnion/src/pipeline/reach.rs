//! What of the faces the machine can reach, looked at before the passes are placed.
//!
//! Passes take minutes on a large face, and axes that cannot follow them are found out afterwards.
//! What decides is known beforehand: a place whose normal the tool cannot come near, whatever its
//! lean, cannot be cut in this setup.

use super::error::PipelineError;
use super::job::Job;
use crate::cutter::Cutter;
use crate::inverse::{Inverse, InverseError};
use crate::machine::FIRST_ROTARY;
use crate::surface::{FaceIndex, Sample};
use crate::types::ToolPose;
use nalgebra::{Point3, Unit, UnitVector3, Vector3};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Places of a face that are looked at, about.
const PLACES: f64 = 400.0;

/// Angles between tool axis and normal that are tried \[deg\], and directions of each lean. The last is a little
/// more than strips ever lean.
const LEANS: [f64; 9] = [0.0, 2.5, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0];
const DIRECTIONS: u32 = 24;

/// What of a face is out of the machine's reach.
#[derive(Debug, Clone, PartialEq)]
pub struct OutOfReach {
    /// Number of the face.
    pub face: usize,
    /// Share of its area, by samples.
    pub share: f64,
    /// The same for a tool that stands square to the face, as it nearly does in wide strips.
    pub upright: f64,
    /// Parameters `[u, v]` of the place that is farthest out.
    pub uv: [f64; 2],
    /// The place \[mm\], workpiece frame.
    pub point: Point3<f64>,
    /// Axis or axes that most of it is out of reach of, and their part of that.
    pub axes: String,
    /// What is wrong there with the lean that comes nearest.
    pub error: InverseError,
    /// What would help.
    pub remedy: String,
}

impl std::error::Error for OutOfReach {}

impl std::fmt::Display for OutOfReach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { face, share, upright, uv: [u, v], point, axes, error, remedy } = self;
        let [_, .., most] = LEANS;
        write!(
            f,
            "face {face}: {:.1} % of it is out of reach in this setup, wherever the cutter leans by up to \
             {most} deg ({:.1} % if it stands square to the face), because of {axes}; worst at (u, v) = ({u:.4}, {v:.4}), X {:.3} Y {:.3} Z {:.3}: {}; \
             {remedy}",
            100.0 * share,
            100.0 * upright,
            point.x,
            point.y,
            point.z,
            why(error)
        )
    }
}

/// A place that is out of reach: by how much of what there is, by what, and why.
struct Miss {
    sample: Sample,
    by: f64,
    axes: String,
    error: InverseError,
}

/// Looks whether the tool can stand on all places of the faces, at any lean that strips may have. Takes a
/// fraction of a second; [`super::run`] begins with it.
///
/// Passes reach a little beyond the faces, and their leans are not any: what passes here may still
/// leave travel.
///
/// # Errors
///
/// [`PipelineError::OutOfReach`] for the first face with places out of reach.
pub fn reach(job: &Job) -> Result<(), PipelineError> {
    // A setup without numbers is refused where the axes are solved.
    let Ok(inverse) = Inverse::new(&job.kinematics) else { return Ok(()) };
    for face in &job.faces {
        let samples = samples(face);
        let missed: Vec<Miss> =
            samples.par_iter().filter_map(|sample| miss(job, &inverse, sample)).collect();
        let share = |count: usize| count as f64 / samples.len().max(1) as f64;
        let home = job.kinematics.machine().home();
        let upright = |sample: &&Sample| {
            let pose = leans(&job.cutter, sample).next();
            pose.is_some_and(|pose| inverse.continued(&pose, &home).is_err())
        };
        let shares = [share(missed.len()), share(samples.iter().filter(upright).count())];
        if let Some(out) = told(face.face().number, shares, missed) {
            return Err(PipelineError::OutOfReach(Box::new(out)));
        }
    }
    Ok(())
}

/// Places about evenly spread over a face.
fn samples(face: &FaceIndex) -> Vec<Sample> {
    let elements = crate::import::inspect::elements(face.face());
    let area: f64 = elements.iter().map(|element| element.area.norm()).sum();
    face.face().grid((area / PLACES).sqrt()).unwrap_or_default()
}

/// The sample, if the tool cannot stand there at any lean.
fn miss(job: &Job, inverse: &Inverse, sample: &Sample) -> Option<Miss> {
    let home = job.kinematics.machine().home();
    let mut nearest: Option<Miss> = None;
    for pose in leans(&job.cutter, sample) {
        let Err(error) = inverse.continued(&pose, &home) else { return None };
        let (by, axes) = measured(&error)?;
        if nearest.as_ref().is_none_or(|known| by < known.by) {
            nearest = Some(Miss { sample: *sample, by, axes, error });
        }
    }
    nearest
}

/// By how much a pose is out of reach, as a share of what there is, and because of what; `None` where it is not that.
fn measured(error: &InverseError) -> Option<(f64, String)> {
    match error {
        InverseError::OutOfTravel(out) => {
            Some((out.excess / (out.high - out.low), format!("axis {}", out.axis)))
        }
        // More than any travel: no end of travel stands in the way, the axes do.
        InverseError::Unreachable { miss, first, second, .. } => {
            Some((TAU + miss, format!("the directions that {first} and {second} reach")))
        }
        _ => None,
    }
}

/// Poses of the cutter touching the face at a sample, from upright on.
fn leans(cutter: &Cutter, sample: &Sample) -> impl Iterator<Item = ToolPose> {
    let (major, minor) = (cutter.major(), cutter.minor());
    let normal = sample.normal;
    let side = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let other = normal.cross(&side);
    let point = sample.point;
    let pose = move |lean: f64, turn: f64| {
        let way = side * turn.cos() + other * turn.sin();
        let axis: UnitVector3<f64> =
            Unit::new_normalize(normal.scale(lean.cos()) + way * lean.sin());
        // The corner touches: from there up its radius, in to the axis, and down to the tip.
        let inward = normal.scale(lean.sin()) - way * lean.cos();
        let centre = point + normal.scale(minor) + inward * major;
        ToolPose { tip: centre - axis.scale(minor), axis }
    };
    LEANS.into_iter().flat_map(move |lean| {
        (0..DIRECTIONS)
            .map(move |k| pose(lean.to_radians(), TAU * f64::from(k) / f64::from(DIRECTIONS)))
    })
}

/// The places that are out of reach in one sentence; `None` if there are none.
fn told(face: usize, [share, upright]: [f64; 2], missed: Vec<Miss>) -> Option<OutOfReach> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for miss in &missed {
        *counts.entry(miss.axes.clone()).or_default() += 1;
    }
    let (axes, count) = counts.into_iter().max_by_key(|(_, count)| *count)?;
    let all = missed.len();
    let worst =
        missed.into_iter().filter(|miss| miss.axes == axes).max_by(|a, b| a.by.total_cmp(&b.by))?;
    let part = if count < all {
        format!("{axes} ({:.0} % of that)", 100.0 * count as f64 / all as f64)
    } else {
        axes
    };
    let remedy = remedy(&worst.error);
    let Miss { sample: Sample { uv, point, .. }, error, .. } = worst;
    Some(OutOfReach { face, share, upright, uv, point, axes: part, error, remedy })
}

fn why(error: &InverseError) -> String {
    let InverseError::OutOfTravel(out) = error else { return error.to_string() };
    let (unit, factor) =
        if out.index < FIRST_ROTARY { ("mm", 1.0) } else { ("deg", 1.0_f64.to_degrees()) };
    let end = if out.value > out.high { out.high } else { out.low };
    let [value, end, excess] = [out.value, end, out.excess].map(|number| number * factor);
    format!(
        "axis {} would have to go to {value:.3} {unit}, beyond its end of travel {end:.3} {unit} by {excess:.3} {unit} \
         at best",
        out.axis
    )
}

fn remedy(error: &InverseError) -> String {
    match error {
        InverseError::OutOfTravel(out) if out.index < FIRST_ROTARY => {
            let way = if out.value > out.high { "down" } else { "up" };
            format!(
                "move setup.origin so that {} comes {way} by {:.3} mm or more, or use a longer or shorter tool",
                out.axis, out.excess
            )
        }
        _ => "turn the workpiece (setup.rotation; `trunnion setup` searches for one), or cut the face in \
              several setups, split where each one's reach ends"
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cutter::{Construction, CutterSpec, Kind};

    /// The nearest point of the tool's corner circle is the corner's radius above the sample, along the normal.
    #[test]
    fn a_leaning_cutter_touches_where_it_should() {
        let (kind, construction) = (Kind::Bull, Construction::Solid);
        let (major, minor, length) = (4.0, 3.0, 60.0);
        let spec = CutterSpec { kind, major, minor, length, construction, shank: Vec::new() };
        let cutter = Cutter::new(spec).unwrap();
        let normal = Unit::new_normalize(Vector3::new(0.2, -0.4, 0.7));
        let sample = Sample { uv: [0.0; 2], point: Point3::new(1.0, 2.0, 3.0), normal };
        let mut poses = 0;
        for pose in leans(&cutter, &sample).skip(24) {
            let centre = pose.tip + pose.axis.scale(minor);
            let out = sample.point - centre;
            let flat = out - pose.axis.scale(out.dot(&pose.axis));
            let nearest = centre + flat.normalize() * major;
            assert!((nearest - (sample.point + normal.scale(minor))).norm() < 1e-12);
            assert!(pose.axis.dot(&normal) > 35.1_f64.to_radians().cos());
            poses += 1;
        }
        assert_eq!(poses, 8 * 24);
    }
}
