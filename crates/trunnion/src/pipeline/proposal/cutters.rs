//! Cutters of a library, and what each of them reaches.

use super::candidates::{CandidateFaces, REACHED, SampledFace};
use super::left_out::{FaceReason, LeftOutFace};
use super::part_measure::{LARGEST, PartMeasure};
use super::request::TOLERANCE;
use crate::cover::{PassCost, ToolAccess};
use crate::cutter::{Cutter, CutterKind, CutterSpec};
use crate::inverse::Inverse;
use crate::machine::{Kinematics, Machine, Setup};
use crate::pipeline::pass_cost::{LinearTravel, inset};
use crate::surface::FaceSample;
use crate::types::{AxisVector, Cancelled, Progress, Stage, Station, ToolPose, UncutReason};
use nalgebra::Vector3;
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

/// Ratio of radii from which a larger cutter in front of a small one is worth a change of tool.
const MUCH_LARGER: f64 = 2.0;

/// Share of the area of the small cutter that the larger one has to cut.
const GOOD_PART: f64 = 0.5;

/// Share of a face's samples that may be too concave for a ball.
const NARROW: f64 = 0.03;

/// Smallest diameter, as a share of the second largest extent of the part: a smaller cutter takes days.
const SMALLEST: f64 = 0.01;

/// Reach of one cutter of the library.
pub(super) struct CutterTrial {
    pub(super) cutter: Cutter,
    /// Indices of the faces that it cuts.
    pub(super) cut: Vec<usize>,
    pub(super) left_out: Vec<LeftOutFace>,
    /// Indices of the faces that are left out.
    pub(super) not_cut: Vec<usize>,
    /// Area reached \[mm²\].
    pub(super) area: f64,
    /// Indices of the faces of which it cuts a good part, tight hollows aside.
    pub(super) partly_cut: Vec<usize>,
    /// Area of these parts \[mm²\].
    pub(super) partly_area: f64,
    pub(super) poses: Vec<ToolPose>,
}

impl CutterTrial {
    fn empty(cutter: Cutter) -> Self {
        Self {
            cutter,
            cut: Vec::new(),
            left_out: Vec::new(),
            not_cut: Vec::new(),
            area: 0.0,
            partly_cut: Vec::new(),
            partly_area: 0.0,
            poses: Vec::new(),
        }
    }

    /// Returns the index of the largest cutter that reaches about as much as any; trials come largest first.
    pub(super) fn choose(trials: &[Self]) -> Option<usize> {
        let most = trials.iter().map(|trial| trial.area).fold(0.0, f64::max);
        trials.iter().position(|trial| trial.area >= AS_GOOD * most)
    }

    /// Returns the index of a far larger cutter than that of index `fine` which cuts most of what that one reaches.
    pub(super) fn choose_before(trials: &[Self], fine: usize) -> Option<usize> {
        let fine = trials.get(fine)?;
        let larger = |trial: &Self| trial.cutter.radius() >= MUCH_LARGER * fine.cutter.radius();
        let most = |trial: &Self| trial.partly_area >= GOOD_PART * fine.area;
        trials.iter().position(|trial| larger(trial) && most(trial))
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
            trials.push(self.trial(machine, &long_enough(cutter, part.size().z)));
        }
        Ok(trials)
    }

    fn trial(&self, machine: &Machine, cutter: &Cutter) -> CutterTrial {
        let setup = Setup::new(Vector3::zeros(), [0.0; 3], cutter.length());
        let reach =
            RotaryReach::new(&inset(&Kinematics::new(machine, &setup), LinearTravel::Unbounded));
        let access = ToolAccess::new(self.faces, cutter, &reach, TOLERANCE.excess);
        let mut trial = CutterTrial::empty(cutter.clone());
        for SampledFace { index, area, samples, .. } in &self.candidates {
            // The pose nearest to the upright one: rotaries and linear axes travel least.
            let found: Vec<Result<ToolPose, UncutReason>> = samples
                .par_iter()
                .map(|sample| access.pose_along(&Vector3::z_axis(), *index, sample))
                .collect();
            let poses: Vec<ToolPose> =
                found.iter().filter_map(|pose| pose.as_ref().ok().copied()).collect();
            let share = poses.len() as f64 / samples.len().max(1) as f64;
            let tight = self.tight(&access, cutter, *index, samples);
            // A few narrow points of a large face are no obstacle, a hollow of the ball's own radius is.
            let narrow = tight.iter().filter(|tight| **tight).count() as f64;
            let too_tight = narrow > NARROW * samples.len() as f64;
            let fits =
                |(pose, tight): (&Result<ToolPose, UncutReason>, &bool)| pose.is_ok() && !tight;
            let partly = found.iter().zip(&tight).filter(|pair| fits(*pair)).count() as f64
                / samples.len().max(1) as f64;
            if partly >= REACHED {
                trial.partly_cut.push(*index);
                trial.partly_area += partly * area;
            }
            if share < REACHED || too_tight {
                let number = self.faces[*index].face().number;
                let reason = FaceReason::NotReached { share, reason: usual(&found) };
                trial.left_out.push(LeftOutFace { number, reason });
                trial.not_cut.push(*index);
            } else {
                trial.cut.push(*index);
                trial.area += share * area;
                trial.poses.extend(poses);
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

/// Returns the most frequent reason.
fn usual(found: &[Result<ToolPose, UncutReason>]) -> UncutReason {
    let all: Vec<UncutReason> =
        found.iter().filter_map(|pose| pose.as_ref().err().copied()).collect();
    let count = |reason: &UncutReason| all.iter().filter(|other| *other == reason).count();
    all.iter().copied().max_by_key(count).unwrap_or(UncutReason::Passes)
}

/// Returns the cutter, as long as a part of this height \[mm\] needs it.
fn long_enough(cutter: &Cutter, height: f64) -> Cutter {
    // Ten millimetres are how tools are set.
    let length = 10.0 * (0.1 * cutter.length().max(height + OVER)).ceil();
    with_length(cutter, length)
}

/// Returns the same cutter with another length \[mm\].
fn with_length(cutter: &Cutter, length: f64) -> Cutter {
    let spec = CutterSpec { length, ..cutter.spec().clone() };
    // A longer cutter is as valid as it was.
    Cutter::new(spec).unwrap_or_else(|_| cutter.clone())
}

/// Reach of the rotary axes, wherever the workpiece is.
struct RotaryReach {
    inverse: Option<Inverse>,
    home: AxisVector,
}

impl RotaryReach {
    fn new(kinematics: &Kinematics) -> Self {
        Self { inverse: Inverse::new(kinematics).ok(), home: kinematics.machine().home() }
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
