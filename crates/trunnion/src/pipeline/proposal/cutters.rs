//! Cutters of a library, and what each of them reaches.

use super::candidates::{CandidateFaces, REACHED, SampledFace};
use super::left_out::{FaceReason, LeftOutFace};
use super::part_measure::{LARGEST, PartMeasure};
use super::request::TOLERANCE;
use crate::cover::{PassCost, ToolAccess, flank_axis};
use crate::cutter::{Cutter, CutterKind, CutterSpec};
use crate::import::inspect;
use crate::inverse::Inverse;
use crate::machine::{Kinematics, Machine, Setup};
use crate::math;
use crate::pipeline::pass_cost::{LinearTravel, inset};
use crate::surface::{FaceIndex, FaceSample, Surface};
use crate::types::{AxisVector, Cancelled, Progress, Stage, Station, ToolPose, UncutReason};
use nalgebra::{Unit, UnitVector3, Vector3};
use rayon::prelude::*;

/// Largest flank of a flat end, as a share of the tightest concave radius: that of the radius itself touches along a line,
/// where rounding decides.
const CONCAVE: f64 = 0.8;

/// Largest ball, as a share of the largest one that fits into a hollow.
const HOLLOW: f64 = 0.9;

/// Height of the tool above the part when its tip is at the bottom of the part \[mm\].
const OVER: f64 = 30.0;

/// Share of the area reached by the best cutter that a larger cutter has to reach.
const AS_GOOD: f64 = 0.95;

/// Share of a face that counts as all of it.
const ALL: f64 = 0.99;

/// Ratio of radii from which a larger cutter in front of a small one is worth a change of tool.
const MUCH_LARGER: f64 = 2.0;

/// Share of the area of the small cutter that the larger one has to cut.
const GOOD_PART: f64 = 0.5;

/// Share of the area that a larger flat end mill has to reach where smaller ones gain only in proportion to the diameter.
const ENOUGH: f64 = 0.8;

/// Least area that a smaller one leaves then, as a share of what the proportion lets expect.
const IN_PROPORTION: f64 = 0.5;

/// Share of a face below which its samples show no area that is left: they are farther apart than a strip along its edge is
/// wide.
const SEEN: f64 = 0.1;

/// Area that a flat end mill has to leave for a smaller one to take its place, as a share of what it reaches.
const LEAVES: f64 = 0.03;

/// Share of that area that the smaller one may leave. It reaches all of a gap as soon as it fits, but never all of a sharp
/// corner.
const CLEARS: f64 = 0.2;

/// Least diameter of a cutter that takes the place of another one, as a share of that one's.
const NOT_SMALLER: f64 = 0.4;

/// Share of a face's samples that may be too concave for a ball.
const NARROW: f64 = 0.03;

/// About as many samples of all faces show how tools lean on them.
const LEANING: f64 = 100.0;

/// Inclination of a ball that leans as usual \[rad\].
const USUAL_LEAN: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Smallest diameter, as a share of the second largest extent of the part: a smaller cutter takes days.
const SMALLEST: f64 = 0.01;

/// Reach of one cutter of the library.
pub(super) struct CutterTrial {
    pub(super) cutter: Cutter,
    /// Reach on each face.
    reached: Vec<ReachedFace>,
    pub(super) left_out: Vec<LeftOutFace>,
    /// Indices of the faces of which it cuts a good part, tight hollows aside.
    pub(super) partly_cut: Vec<usize>,
    /// Area of these parts \[mm²\].
    pub(super) partly_area: f64,
    pub(super) poses: Vec<ToolPose>,
    /// Samples of faces, by index, at which it does not fit.
    pub(super) missed: Vec<(usize, FaceSample)>,
}

/// Part of a face that a cutter reaches; 0 for a face that it does not cut.
#[derive(Debug, Clone, Copy)]
struct ReachedFace {
    index: usize,
    /// Areas of the face, and of the part \[mm²\].
    area: f64,
    reached: f64,
}

impl ReachedFace {
    fn is_cut(&self) -> bool {
        self.reached > 0.0
    }

    fn left(&self) -> f64 {
        self.area - self.reached
    }
}

impl CutterTrial {
    fn empty(cutter: Cutter) -> Self {
        Self::at(cutter, Vec::new())
    }

    /// A cutter in some poses, without the faces that it reaches.
    pub(super) fn at(cutter: Cutter, poses: Vec<ToolPose>) -> Self {
        Self {
            cutter,
            reached: Vec::new(),
            left_out: Vec::new(),
            partly_cut: Vec::new(),
            partly_area: 0.0,
            poses,
            missed: Vec::new(),
        }
    }

    /// Returns the indices of the faces that it cuts.
    pub(super) fn cut(&self) -> Vec<usize> {
        self.reached.iter().filter(|face| face.is_cut()).map(|face| face.index).collect()
    }

    pub(super) fn cuts(&self, index: usize) -> bool {
        self.reached.iter().any(|face| face.index == index && face.is_cut())
    }

    /// Returns `true` for a face that was tried and is left out.
    pub(super) fn leaves_out(&self, index: usize) -> bool {
        self.reached.iter().any(|face| face.index == index && !face.is_cut())
    }

    /// Returns `true` if it cuts all faces, and reaches them all over.
    pub(super) fn reaches_all(&self) -> bool {
        self.reached.iter().all(|face| face.reached >= ALL * face.area)
    }

    /// Returns the area that it reaches \[mm²\].
    fn area(&self) -> f64 {
        self.reached.iter().map(|face| face.reached).sum()
    }

    /// Returns the area of the faces that other cutters cut, and this one leaves \[mm²\].
    fn left(&self, is_cut: impl Fn(usize) -> bool) -> f64 {
        let faces = self.reached.iter().filter(|face| is_cut(face.index));
        faces.map(ReachedFace::left).sum()
    }

    /// Returns the index of the cutter that cuts best alone; trials come largest first.
    ///
    /// It is the largest that reaches about as much as any. Of flat end mills it is a larger one where smaller ones gain
    /// little, and a smaller one where that fits into gaps.
    pub(super) fn choose(trials: &[Self]) -> Option<usize> {
        let most = trials.iter().map(Self::area).fold(0.0, f64::max);
        let good = trials.iter().position(|trial| trial.area() >= AS_GOOD * most)?;
        let chosen = trials.get(good)?;
        if chosen.cutter.kind() != CutterKind::Flat {
            return Some(good);
        }
        let is_enough = |at: &usize| {
            let large = &trials[*at];
            let mut smaller = trials[at + 1..=good].iter();
            large.area() >= ENOUGH * most && smaller.all(|trial| trial.gains_little(large))
        };
        let large = (0..good).find(is_enough).unwrap_or(good);
        Some(Self::choose_finer(trials, large))
    }

    /// Returns `true` if a larger cutter cuts the same faces, and leaves more by about the ratio of the diameters only: in
    /// sharp corners, of which no cutter finishes all.
    fn gains_little(&self, larger: &Self) -> bool {
        let is_cut = |index: usize| self.cuts(index);
        let ratio = self.cutter.radius() / larger.cutter.radius();
        let expected = ratio * larger.left(is_cut);
        let in_part = larger.reached.iter().filter(|face| is_cut(face.index) && face.left() > 0.0);
        let seen: f64 = in_part.map(|face| SEEN * face.area).sum();
        self.cut().into_iter().all(|index| larger.cuts(index))
            && (expected <= seen || self.left(is_cut) >= IN_PROPORTION * expected)
    }

    /// Returns the index of a far larger cutter than that of index `fine` which cuts most of what that one reaches.
    pub(super) fn choose_before(trials: &[Self], fine: usize) -> Option<usize> {
        let fine = trials.get(fine)?;
        let larger = |trial: &Self| trial.cutter.radius() >= MUCH_LARGER * fine.cutter.radius();
        let most = |trial: &Self| trial.partly_area >= GOOD_PART * fine.area();
        trials.iter().position(|trial| larger(trial) && most(trial))
    }

    /// Returns `large`, or the index of the largest smaller cutter that reaches nearly all of what that one leaves.
    fn choose_finer(trials: &[Self], large: usize) -> usize {
        let Some(before) = trials.get(large) else { return large };
        let least = NOT_SMALLER * before.cutter.radius();
        let smaller = || {
            let allowed = move |(_, trial): &(usize, &Self)| trial.cutter.radius() >= least;
            trials.iter().enumerate().skip(large + 1).filter(allowed)
        };
        let is_cut = |index: usize| smaller().any(|(_, trial)| trial.cuts(index));
        let left = before.left(is_cut);
        if left < LEAVES * before.area() {
            return large;
        }
        let clears = |trial: &Self| trial.left(is_cut) <= CLEARS * left;
        smaller().find(|(_, trial)| clears(trial)).map_or(large, |(at, _)| at)
    }

    /// The same cutter with another length \[mm\].
    pub(super) fn with_length(self, length: f64) -> Self {
        let cutter = with_length(&self.cutter, length);
        Self { cutter, ..self }
    }
}

impl CandidateFaces<'_> {
    /// Tries the cutters of one kind that are not too large for the part; at least the smallest.
    pub(super) fn tried(
        &self,
        library: &[Cutter],
        kind: CutterKind,
        machine: &Machine,
        part: &PartMeasure,
        progress: &dyn Progress,
    ) -> Result<Vec<CutterTrial>, Cancelled> {
        let most = part.largest_diameter();
        let mut cutters: Vec<&Cutter> =
            library.iter().filter(|cutter| cutter.kind() == kind).collect();
        cutters.sort_by(|a, b| b.radius().total_cmp(&a.radius()));
        let (Some(largest), Some(smallest)) = (cutters.first(), cutters.last()) else {
            return Ok(Vec::new());
        };
        let [largest, smallest] = [largest, smallest].map(|cutter| 2.0 * cutter.radius());
        let least = SMALLEST / LARGEST * most;
        cutters.retain(|cutter| {
            let diameter = 2.0 * cutter.radius();
            diameter <= most.max(smallest) && diameter >= least.min(largest)
        });
        let mut trials = Vec::new();
        for (done, cutter) in cutters.iter().enumerate() {
            progress.step(Stage::Cover, done as u64, cutters.len() as u64)?;
            let trial = self.trial(machine, &long_enough(cutter, part.size().z));
            // No smaller one reaches so much more that it would be chosen.
            let is_enough = trial.area() >= AS_GOOD * self.area() && kind != CutterKind::Flat;
            trials.push(trial);
            if is_enough {
                break;
            }
        }
        Ok(trials)
    }

    /// Tries a cutter.
    pub(super) fn trial(&self, machine: &Machine, cutter: &Cutter) -> CutterTrial {
        let reach = RotaryReach::new(machine, cutter);
        let access = ToolAccess::new(self.faces, cutter, &reach, TOLERANCE.excess);
        let mut trial = CutterTrial::empty(cutter.clone());
        for SampledFace { index, area, samples, .. } in &self.candidates {
            // The pose nearest to the upright one: rotaries and linear axes travel least. Else one along a wall that leans.
            let leaning = flank_axis(&self.faces[*index]);
            // The rim of a flat end that leans cuts a plane too, but in strips as narrow as lines.
            let is_plane = matches!(self.faces[*index].face().surface, Surface::Plane(_));
            let is_flush = is_plane && cutter.kind() == CutterKind::Flat;
            let along = |axis: &UnitVector3<f64>, sample: &FaceSample| {
                if is_flush {
                    access.pose_flush(axis, *index, sample)
                } else {
                    access.pose_along(axis, *index, sample)
                }
            };
            let pose = |sample: &FaceSample| {
                along(&Vector3::z_axis(), sample).or_else(|reason| {
                    let pose = leaning.map(|axis| along(&axis, sample));
                    pose.and_then(Result::ok).ok_or(reason)
                })
            };
            let found: Vec<Result<ToolPose, UncutReason>> = samples.par_iter().map(pose).collect();
            let poses: Vec<ToolPose> =
                found.iter().filter_map(|pose| pose.as_ref().ok().copied()).collect();
            let share = poses.len() as f64 / samples.len().max(1) as f64;
            let tight = self.tight(&access, cutter, *index, samples);
            // A few narrow points of a large face are no obstacle, a hollow of the ball's own radius is.
            let narrow = tight.iter().filter(|tight| **tight).count() as f64;
            let too_tight = narrow > NARROW * samples.len() as f64;
            let fits =
                |(pose, tight): (&Result<ToolPose, UncutReason>, &bool)| pose.is_ok() && !tight;
            let fitting: Vec<bool> = found.iter().zip(&tight).map(fits).collect();
            let missed = samples.iter().zip(&fitting).filter(|(_, fits)| !**fits);
            trial.missed.extend(missed.map(|(sample, _)| (*index, *sample)));
            let partly =
                fitting.iter().filter(|fits| **fits).count() as f64 / samples.len().max(1) as f64;
            if partly >= REACHED {
                trial.partly_cut.push(*index);
                trial.partly_area += partly * area;
            }
            let is_cut = share >= REACHED && !too_tight;
            let reached = if is_cut { share * area } else { 0.0 };
            trial.reached.push(ReachedFace { index: *index, area: *area, reached });
            if is_cut {
                trial.poses.extend(poses);
            } else {
                let number = self.faces[*index].face().number;
                let reason = FaceReason::NotReached { share, reason: usual(&found) };
                trial.left_out.push(LeftOutFace { number, reason });
            }
        }
        trial
    }

    /// Returns `true` for each sample of a face that is hollow for a cutter.
    ///
    /// A flat end cuts a hollow with its flank: the tightest curvature decides for all of the face. Another cutter leaves
    /// material in a hollow: it counts where the corner, made larger by [`HOLLOW`], would go into the face.
    fn tight(
        &self,
        access: &ToolAccess<'_>,
        cutter: &Cutter,
        index: usize,
        samples: &[FaceSample],
    ) -> Vec<bool> {
        let tightest = self.faces[index].smallest_concave_radius() * CONCAVE;
        let is_flat = cutter.kind() == CutterKind::Flat;
        let widest = if is_flat { cutter.radius() } else { cutter.minor() };
        if is_flat || tightest >= widest {
            return vec![tightest < widest; samples.len()];
        }
        let radius = widest / HOLLOW;
        samples.par_iter().map(|sample| access.is_hollow(radius, index, sample)).collect()
    }
}

/// Returns poses in which a cutter with a round corner leans to either side on faces, as passes may have it.
///
/// A tool that lies on a steep face needs more travel than the upright one of a trial.
pub(super) fn leaning_poses(
    faces: &[FaceIndex],
    cut: &[usize],
    machine: &Machine,
    cutter: &Cutter,
) -> Vec<ToolPose> {
    if cutter.kind() == CutterKind::Flat {
        return Vec::new();
    }
    let reach = RotaryReach::new(machine, cutter);
    let access = ToolAccess::new(faces, cutter, &reach, TOLERANCE.excess);
    let few = (LEANING / cut.len().max(1) as f64).max(1.0);
    let samples = |&index: &usize| {
        let area = inspect::summary(faces[index].face()).area;
        let samples = faces[index].face().grid((area / few).sqrt()).unwrap_or_default();
        samples.into_iter().map(move |sample| (index, sample))
    };
    let samples: Vec<(usize, FaceSample)> = cut.iter().flat_map(samples).collect();
    let poses = |(index, sample): &(usize, FaceSample)| {
        let across = sample.normal.cross(&Vector3::ith(sample.normal.iamin(), 1.0)).normalize();
        let along = sample.normal.cross(&across);
        [across, -across, along, -along].map(|way| {
            let lean = Unit::new_normalize(*sample.normal + way * math::tan(USUAL_LEAN));
            access.pose_along(&lean, *index, sample).ok()
        })
    };
    samples.par_iter().flat_map_iter(poses).flatten().collect()
}

/// Returns the most frequent reason.
fn usual(found: &[Result<ToolPose, UncutReason>]) -> UncutReason {
    let all: Vec<UncutReason> =
        found.iter().filter_map(|pose| pose.as_ref().err().copied()).collect();
    let count = |reason: &UncutReason| all.iter().filter(|other| *other == reason).count();
    all.iter().copied().max_by_key(count).unwrap_or(UncutReason::Passes)
}

/// Returns the cutter, longer where a part of this height \[mm\] needs it.
pub(super) fn long_enough(cutter: &Cutter, height: f64) -> Cutter {
    let least = height + OVER;
    if cutter.length() >= least {
        return cutter.clone();
    }
    // Ten millimetres are how tools are set.
    with_length(cutter, 10.0 * (0.1 * least).ceil())
}

/// Returns the same cutter with another length \[mm\]; shank and holder stay at the gauge point.
pub(super) fn with_length(cutter: &Cutter, length: f64) -> Cutter {
    let up = length - cutter.length();
    let shank = cutter.spec().shank.iter().map(|[height, radius]| [height + up, *radius]).collect();
    let spec = CutterSpec { length, shank, ..cutter.spec().clone() };
    // A longer cutter is as valid as it was.
    Cutter::new(spec).unwrap_or_else(|_| cutter.clone())
}

/// Reach of the rotary axes, wherever the workpiece is.
pub(super) struct RotaryReach {
    inverse: Option<Inverse>,
    home: AxisVector,
}

impl RotaryReach {
    pub(super) fn new(machine: &Machine, cutter: &Cutter) -> Self {
        let setup = Setup::new(Vector3::zeros(), [0.0; 3], cutter.length());
        let kinematics = inset(&Kinematics::new(machine, &setup), LinearTravel::Unbounded);
        Self { inverse: Inverse::new(&kinematics).ok(), home: kinematics.machine().home() }
    }
}

impl PassCost for RotaryReach {
    fn feed(&self) -> f64 {
        1.0
    }

    fn pass(&self, _: &[Station]) -> f64 {
        0.0
    }

    fn link(&self, _: &Station, _: &Station) -> f64 {
        0.0
    }

    fn reaches(&self, pose: &ToolPose) -> bool {
        self.inverse.as_ref().is_some_and(|inverse| inverse.continued(pose, &self.home).is_ok())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trials of flat end mills that cut two faces of 500 mm² and leave some of each, by diameter.
    fn choose(left: &[(f64, f64)]) -> f64 {
        let trial = |&(diameter, left): &(f64, f64)| {
            let cutter = Cutter::new(CutterSpec::of_radii(0.5 * diameter, 0.0)).unwrap();
            let reached: Vec<ReachedFace> = [0, 1]
                .map(|index| ReachedFace { index, area: 500.0, reached: 500.0 - left })
                .into();
            CutterTrial { reached, ..CutterTrial::empty(cutter) }
        };
        let trials: Vec<CutterTrial> = left.iter().map(trial).collect();
        2.0 * trials[CutterTrial::choose(&trials).unwrap()].cutter.radius()
    }

    #[test]
    fn sharp_corners_do_not_ask_for_the_smallest_cutter() {
        // Every cutter leaves strips as wide as its radius beside a corner; the samples do not see those of 2 mm.
        assert!(
            (choose(&[(16.0, 90.0), (8.0, 45.0), (4.0, 30.0), (2.0, 0.0)]) - 16.0).abs() < 1e-9
        );
        // A gap is another matter: the cutter that fits leaves nothing of it.
        assert!((choose(&[(16.0, 90.0), (8.0, 0.0), (4.0, 0.0)]) - 8.0).abs() < 1e-9);
        // Where a far smaller one gains a little, the larger stays.
        assert!((choose(&[(16.0, 20.0), (8.0, 18.0), (2.0, 0.0)]) - 16.0).abs() < 1e-9);
    }
}
