//! What of the faces the machine can reach, looked at before the passes are placed.
//!
//! Passes take minutes on a large face, and axes that cannot follow them are found out afterwards.
//! What decides is known beforehand: a place whose normal the tool cannot come near, whatever its
//! lean, cannot be cut in this setup.

use super::error::PipelineError;
use super::job::Job;
use crate::cutter::Cutter;
use crate::inverse::{Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, Kinematics, RotaryJoint};
use crate::surface::{FaceIndex, FaceSample};
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

/// Finer steps of leans \[deg\] and distance between neighbouring directions of a lean \[deg\], for places
/// that seem out of reach: no direction is farther than [`COVERING`] from one that is tried.
const FINE: [f64; 2] = [2.5, 3.5];
const COVERING: f64 = 2.2;

/// By how much farther than the last of [`LEANS`] the tool is leaned then \[deg\]. Where there is a direction
/// in reach, near it there are some more: directions in reach form a patch between the ends of two
/// travels, and a disc of radius `c` fits into a corner of angle `a` within `c / sin(a / 2)` of its tip. So with the
/// covering of the directions one of those tried is in reach, if corners are wider than 20 degrees.
const FARTHER: f64 = 15.0;

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
    sample: FaceSample,
    by: f64,
    axes: String,
    error: InverseError,
}

/// Looks whether the tool can stand on all places of the faces, at any lean that strips may have. Takes a
/// fraction of a second; [`super::run`] begins with it.
///
/// Only what is certain is refused: a face with a place on which the tool can stand at no lean, nor at leans some way
/// beyond those, nor with a little more travel (`Margins`), nor at any lean beside it, as far as a strip is wide.
/// Passes reach a little beyond the faces, and their leans are not any: what passes here may still leave travel.
///
/// # Errors
///
/// [`PipelineError::OutOfReach`] for the first face with places out of reach.
pub fn reach(job: &Job) -> Result<(), PipelineError> {
    // A setup without numbers is refused where the axes are solved.
    let Ok(inverse) = Inverse::new(&job.kinematics) else { return Ok(()) };
    for face in &job.faces {
        let samples = samples(face);
        let stand = Stand { inverse: &inverse, cutter: &job.cutter };
        let misses: Vec<Option<Miss>> =
            samples.par_iter().map(|sample| stand.miss(sample)).collect();
        let beside = near(&job.cutter, &samples);
        let certain = |(index, sample): (usize, &FaceSample)| {
            let around = |other: &FaceSample| (other.point - sample.point).norm() <= beside;
            let missed = |index: usize| misses.get(index).is_some_and(Option::is_some);
            missed(index)
                && samples.iter().enumerate().all(|(i, other)| missed(i) || !around(other))
                && stand.certain(sample, stand.margins(sample))
        };
        if !samples.par_iter().enumerate().any(certain) {
            continue;
        }
        let missed: Vec<Miss> = misses.into_iter().flatten().collect();
        let share = |count: usize| count as f64 / samples.len().max(1) as f64;
        let home = job.kinematics.machine().home();
        let upright = |sample: &&FaceSample| {
            let pose = leans(&job.cutter, sample, coarse()).next();
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
fn samples(face: &FaceIndex) -> Vec<FaceSample> {
    let elements = crate::import::inspect::elements(face.face());
    let area: f64 = elements.iter().map(|element| element.area.norm()).sum();
    face.face().grid((area / PLACES).sqrt()).unwrap_or_default()
}

/// How far beside a place a strip that finishes it may touch: the cutter's diameter, and what lies between two samples.
fn near(cutter: &Cutter, samples: &[FaceSample]) -> f64 {
    let Some(first) = samples.first() else { return 0.0 };
    let away = samples.iter().map(|other| (other.point - first.point).norm());
    let spacing = away.filter(|distance| *distance > 0.0).fold(f64::INFINITY, f64::min);
    2.0 * cutter.radius() + if spacing.is_finite() { 2.0 * spacing } else { 0.0 }
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

/// What a place that seems out of reach is given before it is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Margins {
    /// Farther lean \[deg\].
    lean: f64,
    /// More travel of a linear axis, as a share of what it has.
    travel: f64,
}

/// A machine with a cutter, to be stood on places.
struct Stand<'a> {
    inverse: &'a Inverse,
    cutter: &'a Cutter,
}

impl Stand<'_> {
    fn kinematics(&self) -> &Kinematics {
        self.inverse.kinematics()
    }

    /// The sample, if the tool cannot stand there at any lean.
    fn miss(&self, sample: &FaceSample) -> Option<Miss> {
        let home = self.kinematics().machine().home();
        let mut nearest: Option<Miss> = None;
        for pose in leans(self.cutter, sample, coarse()) {
            let Err(error) = self.inverse.continued(&pose, &home) else { return None };
            let (by, axes) = measured(&error)?;
            if nearest.as_ref().is_none_or(|known| by < known.by) {
                nearest = Some(Miss { sample: *sample, by, axes, error });
            }
        }
        nearest
    }

    /// Directions between those tried, and contacts beside the place, move the axes by their levers.
    fn margins(&self, sample: &FaceSample) -> Margins {
        let chain = self.kinematics().chain();
        let arm = |joint: &RotaryJoint| {
            (sample.point.coords - joint.point).norm() + (chain.tip - joint.point).norm()
        };
        let levers: f64 = chain.rotary.iter().map(arm).sum();
        let axes = self.kinematics().machine().axes.iter().take(FIRST_ROTARY);
        let least = axes.map(|axis| axis.limits[1] - axis.limits[0]).fold(f64::INFINITY, f64::min);
        let more = 2.0 * self.cutter.radius() + levers * COVERING.to_radians();
        Margins { lean: FARTHER, travel: more / least }
    }

    /// Whether the tool can stand there at no direction that is tried, with the margins.
    fn certain(&self, sample: &FaceSample, margins: Margins) -> bool {
        let home = self.kinematics().machine().home();
        let out = |pose: ToolPose| match self.inverse.continued(&pose, &home) {
            // Least of all branches, each at the axis that is out by most, all as shares of travel.
            Err(InverseError::OutOfTravel(out)) if out.index < FIRST_ROTARY => {
                out.excess > margins.travel * (out.high - out.low)
            }
            Err(InverseError::OutOfTravel(_) | InverseError::Unreachable { .. }) => true,
            Ok(_) | Err(_) => false,
        };
        leans(self.cutter, sample, fine(margins.lean)).all(out)
    }
}

/// Leans and directions \[rad\] that are tried first.
fn coarse() -> impl Iterator<Item = [f64; 2]> {
    let directions = |lean: f64| (0..DIRECTIONS).map(move |k| (lean, k));
    let all = LEANS.into_iter().flat_map(directions);
    all.map(|(lean, k)| [lean.to_radians(), TAU * f64::from(k) / f64::from(DIRECTIONS)])
}

/// The finer ones, up to `more` degrees farther.
fn fine(more: f64) -> impl Iterator<Item = [f64; 2]> {
    let [step, across] = FINE;
    let [.., most] = LEANS;
    // No tool stands on a face from behind.
    let end = (most + more).min(90.0);
    let leans =
        (0_u32..).map(move |k| step * f64::from(k)).take_while(move |lean| *lean < end + step);
    leans.flat_map(move |lean| {
        let count = (360.0 * lean.to_radians().sin() / across).abs().ceil().max(1.0);
        let turns = (0_u32..).map(f64::from).take_while(move |k| *k < count);
        turns.map(move |k| [lean.to_radians(), TAU * k / count])
    })
}

/// Poses of the cutter touching the face at a sample, by lean and direction.
fn leans(
    cutter: &Cutter,
    sample: &FaceSample,
    directions: impl Iterator<Item = [f64; 2]>,
) -> impl Iterator<Item = ToolPose> {
    let (major, minor) = (cutter.major(), cutter.minor());
    let normal = sample.normal;
    let side = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let other = normal.cross(&side);
    let point = sample.point;
    directions.map(move |[lean, turn]| {
        let way = side * turn.cos() + other * turn.sin();
        let axis: UnitVector3<f64> =
            Unit::new_normalize(normal.scale(lean.cos()) + way * lean.sin());
        // The corner touches: from there up its radius, in to the axis, and down to the tip.
        let inward = normal.scale(lean.sin()) - way * lean.cos();
        let centre = point + normal.scale(minor) + inward * major;
        ToolPose { tip: centre - axis.scale(minor), axis }
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
    let Miss { sample: FaceSample { uv, point, .. }, error, .. } = worst;
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
    use crate::cutter::{CutterConstruction, CutterKind, CutterSpec};
    use crate::files::machine::built_in;
    use crate::machine::Setup;

    /// The nearest point of the tool's corner circle is the corner's radius above the sample, along the normal.
    #[test]
    fn a_leaning_cutter_touches_where_it_should() {
        let cutter = cutter();
        let (major, minor) = (cutter.major(), cutter.minor());
        let normal = Unit::new_normalize(Vector3::new(0.2, -0.4, 0.7));
        let sample = FaceSample { uv: [0.0; 2], point: Point3::new(1.0, 2.0, 3.0), normal };
        let mut poses = 0;
        for pose in leans(&cutter, &sample, coarse()).skip(24) {
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

    /// Every direction within the leans lies within the covering of one that is tried.
    #[test]
    fn fine_directions_leave_no_gap() {
        let direction = |[lean, turn]: [f64; 2]| {
            Vector3::new(lean.sin() * turn.cos(), lean.sin() * turn.sin(), lean.cos())
        };
        let tried: Vec<Vector3<f64>> = fine(FARTHER).map(direction).collect();
        let reach = COVERING.to_radians().cos();
        for k in 0..4000 {
            let (a, b) = (f64::from(k) * 0.618_034, f64::from(k) * 0.754_878);
            let any = direction([50_f64.to_radians() * a.fract().sqrt(), TAU * b.fract()]);
            let nearest = tried.iter().map(|other| other.dot(&any)).fold(-1.0, f64::max);
            assert!(nearest >= reach, "{:.3} deg", nearest.acos().to_degrees());
        }
    }

    fn cutter() -> Cutter {
        let (kind, construction) = (CutterKind::Bull, CutterConstruction::Solid);
        let (major, minor, length) = (4.0, 3.0, 60.0);
        Cutter::new(CutterSpec { kind, major, minor, length, construction, shank: Vec::new() })
            .unwrap()
    }

    /// Numbers in [-1, 1].
    fn dice(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// Where the tool can stand at some lean of up to 35 degrees no place is refused, even right beyond the end
    /// of what the coarse leans reach, on machines of all kinds in any setup.
    #[test]
    fn no_place_is_refused_that_some_lean_reaches() {
        let cutter = cutter();
        let names = ["bc-trunnion", "dmu-nutating45", "gantry-ca-fork", "layout-11-ab-head-head"];
        let (mut told, mut beyond, mut certain) = (0, 0, 0);
        for (number, name) in names.iter().enumerate() {
            let file = crate::files::machine::parse(built_in(name).unwrap()).unwrap();
            let machine = file.machine;
            let mut roll = dice(number as u64 + 1);
            for _ in 0..30 {
                let middle = |k: usize| machine.axes[k].limits.iter().sum::<f64>() * 0.5;
                let origin = Vector3::new(middle(0), middle(1), middle(2) - 100.0);
                let rotation = [0; 3].map(|_| 3.0 * roll());
                let setup = Setup::new(origin, rotation, cutter.length());
                let kinematics = Kinematics::new(&machine, &setup);
                let Ok(inverse) = Inverse::new(&kinematics) else { continue };
                let stand = Stand { inverse: &inverse, cutter: &cutter };
                let point = Point3::from(Vector3::from_fn(|_, _| 20.0 * roll()));
                let at = |normal| FaceSample { uv: [0.0; 2], point, normal };
                let [one, other] =
                    [0; 2].map(|_| Unit::new_normalize(Vector3::from_fn(|_, _| roll())));
                let out = |normal| stand.miss(&at(normal)).is_some();
                if out(one) == out(other) {
                    certain +=
                        usize::from(out(one) && stand.certain(&at(one), stand.margins(&at(one))));
                    continue;
                }
                let (mut inside, mut outside) = if out(one) { (other, one) } else { (one, other) };
                for _ in 0..12 {
                    let middle = Unit::new_normalize(inside.into_inner() + outside.into_inner());
                    if out(middle) { outside = middle } else { inside = middle }
                }
                let sample = at(outside);
                told += 1;
                let rim: Vec<[f64; 2]> =
                    (0..720).map(|k| [35_f64.to_radians(), TAU * f64::from(k) / 720.0]).collect();
                let home = machine.home();
                let reached = leans(&cutter, &sample, rim.into_iter())
                    .any(|pose| inverse.continued(&pose, &home).is_ok());
                beyond += usize::from(reached);
                let refused = stand.certain(&sample, stand.margins(&sample));
                assert!(!(reached && refused), "{name} {setup:?} {sample:?}");
            }
        }
        // The coarse leans alone would have refused some of them wrongly.
        assert!(told > 30 && beyond > 3 && certain > 3, "{told} {beyond} {certain}");
    }
}
