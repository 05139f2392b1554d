//! Reach of the machine on the faces, checked before the passes are placed.
//!
//! Placing passes takes minutes on a large face, and only afterwards do the axes fail to follow them. The decisive fact
//! is known before: a point that no inclination of the tool reaches cannot be cut in this setup.

use super::error::PipelineError;
use super::job::Job;
use super::out_of_reach::{INCLINATIONS, OutOfReach};
use super::pass_cost::{LinearTravel, inset};
use crate::cutter::Cutter;
use crate::inverse::{Inverse, InverseError};
use crate::machine::{FIRST_ROTARY, Kinematics, RotaryJoint};
use crate::math;
use crate::surface::{FaceIndex, FaceSample};
use crate::types::{Interval, ToolPose};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Approximate number of samples of a face.
const SAMPLES: f64 = 400.0;

/// Number of directions of each inclination.
const DIRECTIONS: u32 = 24;

/// Points of the arc of a barrel with which it is tried first, as shares of the arc.
const ARC_SHARES: [f64; 3] = [0.5, 0.0, 1.0];

/// Finer steps of the inclination, and distance between neighbouring directions, for points that seem out of
/// reach \[deg\].
const FINE: [f64; 2] = [2.5, 3.5];

/// Largest distance of any direction from one that is tried with [`FINE`] steps \[deg\].
const COVERING: f64 = 2.2;

/// Inclination beyond the last of [`INCLINATIONS`] that is tried then \[deg\].
///
/// Directions in reach form a patch between the ends of two travels. A disc of radius `c` fits into a corner of angle
/// `a` within `c / sin(a / 2)` of its tip. So one of the directions tried is in reach, if corners are wider than
/// 20 degrees.
const FARTHER: f64 = 15.0;

/// Sample that is out of reach: by which share of the travel, of which axes, and the error.
struct ReachMiss {
    sample: FaceSample,
    by: f64,
    axes: String,
    error: InverseError,
}

/// Checks that the tool reaches all points of the faces, at some inclination that strips may have.
///
/// It takes a fraction of a second; [`run`](super::run) begins with it.
///
/// Only certain cases are refused: a face with a point that the tool reaches at no inclination, nor a little beyond
/// those, nor with a little more travel (`ReachMargins`), nor at any inclination beside it, within the width of a strip.
/// Passes extend a little beyond the faces, and their inclinations are restricted: a job that passes here may still
/// leave travel.
///
/// # Errors
///
/// [`PipelineError::OutOfReach`] for the first face with points out of reach.
pub fn reach(job: &Job) -> Result<(), PipelineError> {
    // A setup without numbers is refused where the axes are solved.
    let Ok(inverse) = Inverse::new(&job.kinematics) else { return Ok(()) };
    for face in &job.faces {
        let samples = samples(face);
        let probe = ReachProbe { inverse: &inverse, cutter: &job.cutter };
        let misses: Vec<Option<ReachMiss>> =
            samples.par_iter().map(|sample| probe.miss(sample)).collect();
        let beside = near(&job.cutter, &samples);
        // A sample counts only if all samples within a strip's width fail as well: a strip beside it
        // might finish it.
        let certain = |(index, sample): (usize, &FaceSample)| {
            let around = |other: &FaceSample| (other.point - sample.point).norm() <= beside;
            let missed = |index: usize| misses.get(index).is_some_and(Option::is_some);
            missed(index)
                && samples.iter().enumerate().all(|(i, other)| missed(i) || !around(other))
                && probe.certain(sample, probe.margins(sample))
        };
        if !samples.par_iter().enumerate().any(certain) {
            continue;
        }
        let missed: Vec<ReachMiss> = misses.into_iter().flatten().collect();
        let share = |count: usize| count as f64 / samples.len().max(1) as f64;
        // The first of the coarse inclinations is 0: the tool stands square to the face.
        let home = job.kinematics.machine().home();
        let upright = |sample: &&FaceSample| {
            let pose = leans(&job.cutter, sample, coarse(&job.cutter)).next();
            pose.is_some_and(|pose| inverse.continued(&pose, &home).is_err())
        };
        let tried = inclinations(&job.cutter);
        let shares = [share(missed.len()), share(samples.iter().filter(upright).count())];
        if let Some(out) = report(face.face().number, tried, shares, missed) {
            return Err(PipelineError::OutOfReach(Box::new(out)));
        }
    }
    Ok(())
}

/// Returns `true` if the ends of linear travel alone keep the tool of a job from a sample of its faces.
pub(super) fn lacks_linear_travel(job: &Job, kinematics: &Kinematics) -> bool {
    let inverse = |linear: LinearTravel| Inverse::new(&inset(kinematics, linear));
    let (Ok(inside), Ok(free)) = (inverse(LinearTravel::Inset), inverse(LinearTravel::Unbounded))
    else {
        return false;
    };
    let home = kinematics.machine().home();
    let lacks = |sample: &FaceSample| {
        let reaches = |inverse: &Inverse| {
            let mut poses = leans(&job.cutter, sample, coarse(&job.cutter));
            poses.any(|pose| inverse.continued(&pose, &home).is_ok())
        };
        !reaches(&inside) && reaches(&free)
    };
    job.faces.iter().any(|face| samples(face).par_iter().any(lacks))
}

/// Returns the most upright pose of the tool of a job at each sample of its faces, of those that the rotary axes reach.
pub(super) fn upright_poses(job: &Job) -> Vec<ToolPose> {
    let Ok(inverse) = Inverse::new(&inset(&job.kinematics, LinearTravel::Unbounded)) else {
        return Vec::new();
    };
    let home = job.kinematics.machine().home();
    let up = job.kinematics.forward(&home).axis;
    let upright = |sample: &FaceSample| {
        let poses = leans(&job.cutter, sample, coarse(&job.cutter));
        let reached = poses.filter(|pose| inverse.continued(pose, &home).is_ok());
        reached.max_by(|a, b| a.axis.dot(&up).total_cmp(&b.axis.dot(&up)))
    };
    let of =
        |face: &FaceIndex| samples(face).par_iter().filter_map(upright).collect::<Vec<ToolPose>>();
    job.faces.iter().flat_map(of).collect()
}

/// Returns samples spread about evenly over a face.
pub(super) fn samples(face: &FaceIndex) -> Vec<FaceSample> {
    let elements = crate::import::inspect::elements(face.face());
    let area: f64 = elements.iter().map(|element| element.area.norm()).sum();
    // Cells of area / SAMPLES each, taken as squares.
    face.face().grid((area / SAMPLES).sqrt()).unwrap_or_default()
}

/// Returns the distance within which a strip may finish a sample: the cutter diameter, and two sample distances.
fn near(cutter: &Cutter, samples: &[FaceSample]) -> f64 {
    let Some(first) = samples.first() else { return 0.0 };
    let away = samples.iter().map(|other| (other.point - first.point).norm());
    // Distance from one corner sample to its nearest neighbour: the grid is about even.
    let spacing = away.filter(|distance| *distance > 0.0).fold(f64::INFINITY, f64::min);
    2.0 * cutter.radius() + if spacing.is_finite() { 2.0 * spacing } else { 0.0 }
}

/// Returns the miss as a share of the travel, and the axes; `None` for other errors.
fn measured(error: &InverseError) -> Option<(f64, String)> {
    match error {
        InverseError::OutOfTravel(out) => {
            Some((out.excess / (out.high - out.low), format!("axis {}", out.axis)))
        }
        // More than any travel: the directions of the axes are the obstacle, not the ends of travel.
        InverseError::Unreachable { miss, first, second, .. } => {
            Some((TAU + miss, format!("the directions that {first} and {second} reach")))
        }
        _ => None,
    }
}

/// Margins that a sample out of reach is granted before it is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ReachMargins {
    /// Additional inclination \[deg\].
    lean: f64,
    /// Additional travel of a linear axis, as a share of its travel.
    travel: f64,
}

/// Machine with a cutter, tried at samples.
struct ReachProbe<'a> {
    inverse: &'a Inverse,
    cutter: &'a Cutter,
}

impl ReachProbe<'_> {
    fn kinematics(&self) -> &Kinematics {
        self.inverse.kinematics()
    }

    /// Returns the nearest miss if the tool reaches the sample at no inclination.
    fn miss(&self, sample: &FaceSample) -> Option<ReachMiss> {
        let home = self.kinematics().machine().home();
        let mut nearest: Option<ReachMiss> = None;
        for pose in leans(self.cutter, sample, coarse(self.cutter)) {
            let Err(error) = self.inverse.continued(&pose, &home) else { return None };
            // An error that is no miss leaves the question open: nothing is refused.
            let (by, axes) = measured(&error)?;
            if nearest.as_ref().is_none_or(|known| by < known.by) {
                nearest = Some(ReachMiss { sample: *sample, by, axes, error });
            }
        }
        nearest
    }

    /// Returns margins for directions between those tried and contacts beside the sample, which move the axes by their
    /// levers.
    fn margins(&self, sample: &FaceSample) -> ReachMargins {
        let chain = self.kinematics().chain();
        let arm = |joint: &RotaryJoint| {
            (sample.point.coords - joint.point).norm() + (chain.tip - joint.point).norm()
        };
        // A small rotation moves a point by the angle times its distance from the pivot. The sum of both
        // distances covers rotaries in the table and in the head.
        let levers: f64 = chain.rotary.iter().map(arm).sum();
        let axes = self.kinematics().machine().axes.iter().take(FIRST_ROTARY);
        let least = axes.map(|axis| axis.limits.width()).fold(f64::INFINITY, f64::min);
        // A contact beside the sample is at most a diameter away; a direction between those tried
        // differs by at most COVERING.
        let more = 2.0 * self.cutter.radius() + levers * COVERING.to_radians();
        // As a share of the shortest travel, which makes it the largest share of all axes.
        ReachMargins { lean: FARTHER, travel: more / least }
    }

    /// Returns true if the tool reaches the sample at none of the finer directions, even with the margins.
    fn certain(&self, sample: &FaceSample, margins: ReachMargins) -> bool {
        let home = self.kinematics().machine().home();
        let out = |pose: ToolPose| match self.inverse.continued(&pose, &home) {
            // The excess is the least of all branches, each at its worst axis, as shares of travel.
            Err(InverseError::OutOfTravel(out)) if out.index < FIRST_ROTARY => {
                out.excess > margins.travel * (out.high - out.low)
            }
            Err(InverseError::OutOfTravel(_) | InverseError::Unreachable { .. }) => true,
            Ok(_) | Err(_) => false,
        };
        leans(self.cutter, sample, fine(self.cutter, margins.lean)).all(out)
    }
}

/// Returns the range of the inclinations at which a cutter is tried \[deg\].
fn inclinations(cutter: &Cutter) -> Interval {
    if cutter.is_barrel() {
        let Interval { low, high } = cutter.contact_arc().inclinations;
        return Interval::new(low.to_degrees(), high.to_degrees());
    }
    let [least, .., most] = INCLINATIONS;
    Interval::new(least, most)
}

/// Returns the inclinations and directions that are tried first \[rad\].
fn coarse(cutter: &Cutter) -> impl Iterator<Item = [f64; 2]> + use<> {
    let directions = |lean: f64| (0..DIRECTIONS).map(move |k| (lean, k));
    let (tried, is_barrel) = (inclinations(cutter), cutter.is_barrel());
    let leans = INCLINATIONS.into_iter().filter(move |_| !is_barrel);
    let arc = ARC_SHARES.into_iter().map(move |share| tried.at(share)).filter(move |_| is_barrel);
    let all = leans.chain(arc).flat_map(directions);
    all.map(|(lean, k)| [lean.to_radians(), TAU * f64::from(k) / f64::from(DIRECTIONS)])
}

/// Returns the finer inclinations and directions, up to `more` degrees farther on either side \[rad\].
fn fine(cutter: &Cutter, more: f64) -> impl Iterator<Item = [f64; 2]> + use<> {
    let [step, across] = FINE;
    let Interval { low, high } = inclinations(cutter);
    // No tool touches a face from behind.
    let (start, end) = ((low - more).max(0.0), (high + more).min(90.0));
    let leans = (0_u32..)
        .map(move |k| start + step * f64::from(k))
        .take_while(move |lean| *lean < end + step);
    leans.flat_map(move |lean| {
        // The circle of directions at this inclination has a circumference of 360 sin(lean) degrees.
        let count = (360.0 * math::sin(lean.to_radians()) / across).abs().ceil().max(1.0);
        let turns = (0_u32..).map(f64::from).take_while(move |k| *k < count);
        turns.map(move |k| [lean.to_radians(), TAU * k / count])
    })
}

/// Returns poses of the cutter that touches the face at a sample, by inclination and direction.
fn leans(
    cutter: &Cutter,
    sample: &FaceSample,
    directions: impl Iterator<Item = [f64; 2]>,
) -> impl Iterator<Item = ToolPose> {
    let arc = cutter.contact_arc();
    let normal = sample.normal;
    // Any tangent will do: the component of least size keeps the cross product away from zero.
    let side = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let other = normal.cross(&side);
    let point = sample.point;
    directions.map(move |[lean, turn]| {
        let way = side * math::cos(turn) + other * math::sin(turn);
        arc.pose(point + normal.scale(arc.radius), &normal, &way, lean)
    })
}

/// Returns the report of the samples out of reach; `None` if there are none.
fn report(
    face: usize,
    inclinations: Interval,
    [share, upright]: [f64; 2],
    missed: Vec<ReachMiss>,
) -> Option<OutOfReach> {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for miss in &missed {
        *counts.entry(miss.axes.clone()).or_default() += 1;
    }
    // The axes that most samples are beyond name the cause; the worst of these is the example.
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
    let ReachMiss { sample: FaceSample { uv, point, .. }, error, .. } = worst;
    Some(OutOfReach { face, share, inclinations, upright, uv, point, axes: part, error, remedy })
}

/// Returns advice for an error.
fn remedy(error: &InverseError) -> String {
    match error {
        InverseError::OutOfTravel(out) if out.index < FIRST_ROTARY => {
            // The required position lies beyond an end of travel and must come back inside.
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
    use crate::cutter::CutterSpec;
    use crate::files::machine::built_in;
    use crate::machine::Setup;
    use crate::types::Uv;
    use nalgebra::{Point3, Unit};

    /// The nearest point of the tool's corner circle is the corner's radius above the sample, along the normal.
    #[test]
    fn a_leaning_cutter_touches_where_it_should() {
        let cutter = cutter();
        let (major, minor) = (cutter.major(), cutter.minor());
        let normal = Unit::new_normalize(Vector3::new(0.2, -0.4, 0.7));
        let sample =
            FaceSample { uv: Uv::new(0.0, 0.0), point: Point3::new(1.0, 2.0, 3.0), normal };
        let mut poses = 0;
        for pose in leans(&cutter, &sample, coarse(&cutter)).skip(24) {
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
        let tried: Vec<Vector3<f64>> = fine(&cutter(), FARTHER).map(direction).collect();
        let reach = COVERING.to_radians().cos();
        for k in 0..4000 {
            let (a, b) = (f64::from(k) * 0.618_034, f64::from(k) * 0.754_878);
            let any = direction([50_f64.to_radians() * a.fract().sqrt(), TAU * b.fract()]);
            let nearest = tried.iter().map(|other| other.dot(&any)).fold(-1.0, f64::max);
            assert!(nearest >= reach, "{:.3} deg", nearest.acos().to_degrees());
        }
    }

    fn cutter() -> Cutter {
        let (major, minor, length) = (4.0, 3.0, 60.0);
        Cutter::new(CutterSpec { length, ..CutterSpec::of_radii(major, minor) }).unwrap()
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

    /// No sample is refused that the tool reaches at some inclination of up to 35 degrees, even right beyond the end
    /// of the reach of the coarse inclinations, on machines of all kinds in any setup.
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
                let middle = |k: usize| machine.axes[k].limits.middle();
                let origin = Vector3::new(middle(0), middle(1), middle(2) - 100.0);
                let rotation = [0; 3].map(|_| 3.0 * roll());
                let setup = Setup::new(origin, rotation, cutter.length());
                let kinematics = Kinematics::new(&machine, &setup);
                let Ok(inverse) = Inverse::new(&kinematics) else { continue };
                let probe = ReachProbe { inverse: &inverse, cutter: &cutter };
                let point = Point3::from(Vector3::from_fn(|_, _| 20.0 * roll()));
                let at = |normal| FaceSample { uv: Uv::new(0.0, 0.0), point, normal };
                let [one, other] =
                    [0; 2].map(|_| Unit::new_normalize(Vector3::from_fn(|_, _| roll())));
                let out = |normal| probe.miss(&at(normal)).is_some();
                if out(one) == out(other) {
                    certain +=
                        usize::from(out(one) && probe.certain(&at(one), probe.margins(&at(one))));
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
                let refused = probe.certain(&sample, probe.margins(&sample));
                assert!(!(reached && refused), "{name} {setup:?} {sample:?}");
            }
        }
        // The coarse leans alone would have refused some of them wrongly.
        assert!(told > 30 && beyond > 3 && certain > 3, "{told} {beyond} {certain}");
    }
}
