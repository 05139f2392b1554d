//! Proposal of a job for a part: faces, cutter and setup that run as they are.

use super::pass_cost::inset;
use crate::cover::{FinishTolerance, PassCost, ToolAccess};
use crate::cutter::{Cutter, CutterConstruction, CutterKind, CutterSpec};
use crate::import::inspect::{self, FaceSummary};
use crate::inverse::Inverse;
use crate::machine::{FIRST_ROTARY, Kinematics, Machine, MovedBody, Setup};
use crate::surface::{Face, FaceIndex, FaceSample, Surface};
use crate::types::{
    AxisVector, Cancelled, Interval, Progress, Stage, Station, ToolPose, UncutReason,
};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Diameters of the built-in cutters, the largest first \[mm\].
const DIAMETERS: [f64; 9] = [20.0, 16.0, 12.0, 8.0, 6.0, 4.0, 3.0, 2.0, 1.0];

/// Corner radius of the bull-nose cutters, as a share of the diameter: 2 mm for 16 mm.
const CORNER: f64 = 0.125;

/// Largest diameter, as a share of the second largest extent of the part: a larger cutter finishes it in a pass or
/// two, but hangs over its edges.
const LARGEST: f64 = 0.5;

/// Largest ball, as a share of the tightest concave radius: the ball of the radius itself touches along a line, where
/// rounding decides.
const CONCAVE: f64 = 0.8;

/// Tool length in diameters, and at least \[mm\].
const LENGTH: [f64; 2] = [6.0, 60.0];

/// Height of the tool above the part when its tip is at the bottom of the part \[mm\].
const OVER: f64 = 30.0;

/// About as many samples a face.
const SAMPLES: f64 = 60.0;

/// Share of a face's samples that the tool has to reach; the rest is what no pass gets to, such as its corners.
const REACHED: f64 = 0.5;

/// Share of the area reached by the best cutter that a larger cutter has to reach.
const AS_GOOD: f64 = 0.85;

/// Share of a face's samples that are reached where its tightest concave radius is no obstacle.
const WHOLE: f64 = 0.97;

/// Smallest diameter, as a share of the second largest extent of the part: a smaller cutter takes days.
const SMALLEST: f64 = 0.01;

/// Cosine between normal and z up to which a face is a wall: two degrees to either side of the horizon.
const WALL: f64 = 0.035;

/// Least z of the straight lines of a wall, of unit length: 60 degrees.
const STEEP: f64 = 0.87;

/// Distance of a wall from the bottom of the part, below which it stands where the part is held, as a share of the
/// part's height.
const HELD: f64 = 0.01;

/// Height of the part's bottom above the table, for a vice or a riser \[mm\].
const STANDOFF: f64 = 50.0;

/// Distance of the poses from the ends of travel, as a share of it.
const MARGIN: f64 = 0.02;

/// Poses by which the origin is found, at most.
const POSES: usize = 240;

/// Steps of the search for the origin: the first and the last \[mm\].
const ORIGIN_STEPS: Interval = Interval { low: 0.5, high: 256.0 };

/// Digits of the origin \[mm\].
const ORIGIN_DIGIT: f64 = 0.1;

/// Tolerance of the proposal \[mm\], and its largest share of the part's size.
const TOLERANCE: FinishTolerance = FinishTolerance { excess: 0.02, gouge: 0.002 };
const TOLERANCE_SHARE: f64 = 1e-3;

/// Cutting speed \[mm/s\], largest spindle speed \[rev/s\], feed per tooth as a share of the diameter, and teeth: modest
/// values for finishing aluminium.
const CUTTING_SPEED: f64 = 200_000.0 / 60.0;
const FASTEST_SPINDLE: f64 = 200.0;
const TOOTH_FEED: f64 = 0.005;
const TEETH: f64 = 2.0;

/// Part and machine for which a job is proposed. Begin with [`ProposalRequest::new`] and change the rest by struct
/// update.
#[derive(Debug, Clone, Copy)]
pub struct ProposalRequest<'a> {
    /// Faces of the part.
    pub faces: &'a [Face],
    /// Numbers of the faces to choose from; `None`: all.
    pub wanted: Option<&'a [usize]>,
    /// Machine that is to cut it.
    pub machine: &'a Machine,
}

impl<'a> ProposalRequest<'a> {
    /// Requests a job for all faces of a part.
    pub const fn new(faces: &'a [Face], machine: &'a Machine) -> Self {
        Self { faces, wanted: None, machine }
    }
}

/// Job that is proposed: everything that a job file needs besides names.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct JobProposal {
    /// Numbers of the faces to cut.
    pub faces: Vec<usize>,
    /// Faces that the job does not cut, each with the reason.
    pub left_out: Vec<LeftOutFace>,
    /// Cutter.
    pub cutter: CutterSpec,
    /// Tightest concave radius of the faces to cut \[mm\]; infinite where they are nowhere concave.
    pub concave_radius: f64,
    /// Workpiece origin in machine coordinates \[mm\]; the workpiece is not turned.
    pub origin: Vector3<f64>,
    /// Height of the clearance plane above the part \[mm\].
    pub clearance: f64,
    /// Tolerance.
    pub tolerance: FinishTolerance,
    /// Feed \[mm/s\].
    pub feed: f64,
    /// Spindle speed \[rev/s\].
    pub spindle: f64,
}

/// Face that a proposed job does not cut.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct LeftOutFace {
    /// Number of the face.
    pub number: usize,
    /// Reason.
    pub reason: FaceReason,
}

/// Reason why a proposed job does not cut a face.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceReason {
    /// The face cannot be worked with.
    #[error("{0}")]
    Surface(String),
    /// The face looks down, to the table.
    #[error("looks down to the table; turn the part over in a second setup")]
    Down,
    /// The face is an outer wall that goes down to the bottom of the part.
    #[error(
        "is a wall down to the bottom, where the part is held; `--faces` with its number cuts it, with the tool from the side"
    )]
    Wall,
    /// The tool reaches less than half of it; the reason at most of the points.
    #[error("the tool reaches {:.0} % of it: {reason}", 100.0 * share)]
    NotReached {
        /// Share of the face that is reached.
        share: f64,
        /// Reason at most of the other points.
        reason: UncutReason,
    },
}

/// Reason why no job can be proposed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProposalError {
    /// No face can be cut.
    #[error(
        "no face of the part can be cut from above: {}; turn the part, or take another machine", reasons(.left_out)
    )]
    NothingReached {
        /// All faces, each with the reason.
        left_out: Vec<LeftOutFace>,
    },
    /// The part does not fit into the travel of the machine.
    #[error(
        "the part does not fit into the travel of {axis}: {short:.1} mm are missing wherever the origin is; take a larger machine"
    )]
    Travel {
        /// Name of the axis.
        axis: String,
        /// Travel that is missing \[mm\].
        short: f64,
    },
    /// The operation was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Lists faces with their reasons; of many, the first few.
fn reasons(left_out: &[LeftOutFace]) -> String {
    const MOST: usize = 6;
    let one = |face: &LeftOutFace| format!("face {} {}", face.number, face.reason);
    let mut all: Vec<String> = left_out.iter().take(MOST).map(one).collect();
    if left_out.len() > MOST {
        all.push(format!("and {} more", left_out.len() - MOST));
    }
    all.join("; ")
}

/// Proposes a job that finishes the faces of a part that the machine reaches from above.
///
/// The cutter is the largest of a small built-in library that reaches nearly all that the smaller ones reach: flat
/// for planes, a ball where a face is concave, else a bull-nose. The workpiece stays as drawn, on the middle of the
/// rotary table where the machine has one, moved as far as the travel of the axes needs.
///
/// # Errors
///
/// [`ProposalError`].
pub fn propose(
    request: &ProposalRequest<'_>,
    progress: &dyn Progress,
) -> Result<JobProposal, ProposalError> {
    // Step 1: faces that look up or to the side.
    let mut left_out = Vec::new();
    let mut faces: Vec<FaceIndex> = Vec::new();
    for face in request.faces {
        match FaceIndex::new(face.clone()) {
            Ok(index) => faces.push(index),
            Err(error) => {
                let reason = FaceReason::Surface(error.to_string());
                left_out.push(LeftOutFace { number: face.number, reason });
            }
        }
    }
    let part = PartMeasure::new(&faces);
    let candidates = CandidateFaces::new(&faces, request.wanted, &part, &mut left_out);
    // Step 2: the cutter, by what each of the library reaches.
    let tried = candidates.tried(request.machine, &part, progress)?;
    let Some(chosen) = CutterTrial::choose(tried) else {
        return Err(ProposalError::NothingReached { left_out });
    };
    left_out.extend(chosen.left_out.iter().cloned());
    if chosen.cut.is_empty() {
        return Err(ProposalError::NothingReached { left_out });
    }
    left_out.sort_by_key(|face| face.number);
    // Step 3: the origin that keeps the poses inside travel.
    let clearance = part.clearance();
    let origin = OriginSearch::new(request.machine, &chosen, &part).best()?;
    // Step 4: cutting data by the diameter.
    let diameter = 2.0 * chosen.cutter.radius();
    let spindle = (CUTTING_SPEED / (std::f64::consts::PI * diameter)).min(FASTEST_SPINDLE);
    let excess = TOLERANCE.excess.min(TOLERANCE_SHARE * part.size().norm());
    let gouge = excess * TOLERANCE.gouge / TOLERANCE.excess;
    Ok(JobProposal {
        faces: chosen.cut.iter().map(|&at| faces[at].face().number).collect(),
        left_out,
        cutter: chosen.cutter.spec().clone(),
        concave_radius: chosen
            .cut
            .iter()
            .map(|&at| faces[at].smallest_concave_radius())
            .fold(f64::INFINITY, f64::min),
        origin,
        clearance,
        tolerance: FinishTolerance { excess, gouge },
        feed: spindle * TEETH * TOOTH_FEED * diameter,
        spindle,
    })
}

/// Box around a part.
struct PartMeasure {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl PartMeasure {
    fn new(faces: &[FaceIndex]) -> Self {
        let boxes = faces.iter().map(|face| inspect::summary(face.face()).bounds);
        let [low, high] = boxes
            .reduce(|[a, b], [low, high]| [a.inf(&low), b.sup(&high)])
            .unwrap_or([Point3::origin(); 2]);
        Self { low, high }
    }

    fn size(&self) -> Vector3<f64> {
        self.high - self.low
    }

    /// Middle of the bottom.
    fn foot(&self) -> Point3<f64> {
        let middle = nalgebra::center(&self.low, &self.high);
        Point3::new(middle.x, middle.y, self.low.z)
    }

    /// Returns `true` if a face whose lowest point has this height goes down to where the part is held.
    fn holds_at(&self, height: f64) -> bool {
        height - self.low.z <= HELD * self.size().z
    }

    /// Height of links above the part \[mm\].
    fn clearance(&self) -> f64 {
        (0.5 * self.size().z).clamp(10.0, 50.0).round()
    }

    /// Largest diameter of a cutter for the part \[mm\].
    fn largest_diameter(&self) -> f64 {
        let mut extents: [f64; 3] = self.size().into();
        extents.sort_by(f64::total_cmp);
        LARGEST * extents[1]
    }
}

/// Faces that may be cut, with samples.
struct CandidateFaces<'a> {
    faces: &'a [FaceIndex],
    /// Index of each candidate, its area \[mm²\] and samples.
    candidates: Vec<SampledFace>,
}

struct SampledFace {
    index: usize,
    area: f64,
    /// Height of its lowest point \[mm\].
    low: f64,
    samples: Vec<FaceSample>,
}

/// Direction in which most of a face looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FaceView {
    Up,
    Wall,
    Down,
}

impl SampledFace {
    fn view(&self) -> FaceView {
        let count = |looks: &dyn Fn(f64) -> bool| {
            let found = self.samples.iter().filter(|sample| looks(sample.normal.z)).count();
            found as f64 >= REACHED * self.samples.len() as f64
        };
        // A dome that goes a little below its equator is still worth cutting.
        if count(&|z| z < -WALL) {
            FaceView::Down
        } else if count(&|z| z > WALL) {
            FaceView::Up
        } else {
            FaceView::Wall
        }
    }
}

/// Returns `true` for planes, and for walls that the flank of an upright tool finishes.
fn is_prismatic(face: &FaceIndex) -> bool {
    let face = face.face();
    match face.surface {
        Surface::Plane(_) => true,
        Surface::Cylinder(_) | Surface::Cone(_) | Surface::Extrusion(_) => {
            let [u, v] = face.bounds().map(|[low, high]| 0.5 * (low + high));
            let ruling = face.surface.jet1(u, v).sv;
            ruling.z.abs() >= STEEP * ruling.norm()
        }
        _ => false,
    }
}

/// Distance in height within which a face stands on a floor, and beyond which it rises from it \[mm\].
const FOOT: f64 = 0.01;

/// Shape of the cutting end that suits the faces.
fn kind(faces: &[FaceIndex], candidates: &[SampledFace]) -> CutterKind {
    let all = || candidates.iter().map(|candidate| &faces[candidate.index]);
    if all().all(is_prismatic) {
        CutterKind::Flat
    } else if !all().all(|face| face.smallest_concave_radius().is_infinite()) {
        CutterKind::Ball
    } else if has_foot(faces, candidates) {
        // The rounded corner of another cutter would leave the foot of what stands on the floor.
        CutterKind::Flat
    } else {
        CutterKind::Bull
    }
}

/// Returns `true` if a face that is cut stands with a sharp edge on a floor that is cut.
fn has_foot(faces: &[FaceIndex], candidates: &[SampledFace]) -> bool {
    let height = |face: &FaceIndex| inspect::summary(face.face()).bounds.map(|corner| corner.z);
    let floors: Vec<f64> = candidates
        .iter()
        .filter(|face| matches!(faces[face.index].face().surface, Surface::Plane(_)))
        .map(|face| height(&faces[face.index]))
        .filter(|[low, high]| high - low <= FOOT)
        .map(|[low, _]| low)
        .collect();
    let stands = |[low, high]: [f64; 2]| {
        floors.iter().any(|floor| (low - floor).abs() <= FOOT && high - floor > FOOT)
    };
    candidates.iter().any(|face| stands(height(&faces[face.index])))
}

impl<'a> CandidateFaces<'a> {
    /// Samples the faces; those that look down are left out.
    fn new(
        faces: &'a [FaceIndex],
        wanted: Option<&[usize]>,
        part: &PartMeasure,
        left_out: &mut Vec<LeftOutFace>,
    ) -> Self {
        let asked = |face: &FaceIndex| wanted.is_none_or(|all| all.contains(&face.face().number));
        let sampled: Vec<SampledFace> = faces
            .par_iter()
            .enumerate()
            .filter(|(_, face)| asked(face))
            .map(|(index, face)| {
                let FaceSummary { area, bounds: [low, _], .. } = inspect::summary(face.face());
                let samples = face.face().grid((area / SAMPLES).sqrt()).unwrap_or_default();
                SampledFace { index, area, low: low.z, samples }
            })
            .collect();
        let mut candidates = Vec::new();
        for face in sampled {
            let reason = match face.view() {
                FaceView::Up => None,
                FaceView::Down => Some(FaceReason::Down),
                FaceView::Wall if wanted.is_some() || !part.holds_at(face.low) => None,
                FaceView::Wall => Some(FaceReason::Wall),
            };
            match reason {
                None => candidates.push(face),
                Some(reason) => {
                    let number = faces[face.index].face().number;
                    left_out.push(LeftOutFace { number, reason });
                }
            }
        }
        Self { faces, candidates }
    }

    /// Tries the cutters of the library that are not too large for the part; at least the smallest.
    fn tried(
        &self,
        machine: &Machine,
        part: &PartMeasure,
        progress: &dyn Progress,
    ) -> Result<Vec<CutterTrial>, Cancelled> {
        let kind = kind(self.faces, &self.candidates);
        let most = part.largest_diameter();
        let [largest, .., smallest] = DIAMETERS;
        let least = SMALLEST / LARGEST * most;
        let fits =
            |diameter: &f64| *diameter <= most.max(smallest) && *diameter >= least.min(largest);
        let diameters: Vec<f64> = DIAMETERS.into_iter().filter(fits).collect();
        let mut trials = Vec::new();
        for (done, diameter) in diameters.iter().enumerate() {
            progress.step(Stage::Cover, done as u64, diameters.len() as u64)?;
            let cutter = Cutter::new(spec(kind, *diameter, part.size().z));
            trials.extend(cutter.ok().map(|cutter| self.trial(machine, &cutter)));
        }
        Ok(trials)
    }

    fn trial(&self, machine: &Machine, cutter: &Cutter) -> CutterTrial {
        let setup = Setup::new(Vector3::zeros(), [0.0; 3], cutter.length());
        let reach = RotaryReach::new(&inset(&Kinematics::new(machine, &setup)));
        let access = ToolAccess::new(self.faces, cutter, &reach, TOLERANCE.excess);
        let mut trial = CutterTrial::empty(cutter.clone());
        for SampledFace { index, area, samples, .. } in &self.candidates {
            let found: Vec<Result<ToolPose, UncutReason>> =
                samples.par_iter().map(|sample| access.pose(*index, sample)).collect();
            let poses: Vec<ToolPose> =
                found.iter().filter_map(|pose| pose.as_ref().ok().copied()).collect();
            let share = poses.len() as f64 / samples.len().max(1) as f64;
            // A flat end cuts a hollow with its flank, which has to be narrower.
            let flat = cutter.kind() == CutterKind::Flat;
            let widest = if flat { cutter.radius() } else { cutter.minor() };
            let too_tight = self.faces[*index].smallest_concave_radius() * CONCAVE < widest;
            if share < REACHED || (too_tight && (flat || share < WHOLE)) {
                let number = self.faces[*index].face().number;
                let reason = FaceReason::NotReached { share, reason: usual(&found) };
                trial.left_out.push(LeftOutFace { number, reason });
            } else {
                trial.cut.push(*index);
                trial.area += share * area;
                trial.poses.extend(poses);
            }
        }
        trial
    }
}

/// Returns the most frequent reason.
fn usual(found: &[Result<ToolPose, UncutReason>]) -> UncutReason {
    let all: Vec<UncutReason> =
        found.iter().filter_map(|pose| pose.as_ref().err().copied()).collect();
    let count = |reason: &UncutReason| all.iter().filter(|other| *other == reason).count();
    all.iter().copied().max_by_key(count).unwrap_or(UncutReason::Passes)
}

/// Describes a cutter of the library.
fn spec(kind: CutterKind, diameter: f64, height: f64) -> CutterSpec {
    let radius = 0.5 * diameter;
    let minor = match kind {
        CutterKind::Ball => radius,
        CutterKind::Bull => CORNER * diameter,
        CutterKind::Flat => 0.0,
    };
    // Ten millimetres are how tools are set.
    let length = (LENGTH[0] * diameter).max(LENGTH[1]).max(height + OVER);
    let length = 10.0 * (0.1 * length).ceil();
    let construction = CutterConstruction::Solid;
    CutterSpec { kind, major: radius - minor, minor, length, construction, shank: Vec::new() }
}

/// Reach of one cutter of the library.
struct CutterTrial {
    cutter: Cutter,
    /// Indices of the faces that it cuts.
    cut: Vec<usize>,
    left_out: Vec<LeftOutFace>,
    /// Area reached \[mm²\].
    area: f64,
    poses: Vec<ToolPose>,
}

impl CutterTrial {
    fn empty(cutter: Cutter) -> Self {
        Self { cutter, cut: Vec::new(), left_out: Vec::new(), area: 0.0, poses: Vec::new() }
    }

    /// Returns the largest cutter that reaches about as much as any; trials come largest first.
    fn choose(trials: Vec<Self>) -> Option<Self> {
        let most = trials.iter().map(|trial| trial.area).fold(0.0, f64::max);
        trials.into_iter().find(|trial| trial.area >= AS_GOOD * most)
    }
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

/// Search for the origin that keeps poses inside the travel of the linear axes.
struct OriginSearch<'a> {
    machine: &'a Machine,
    length: f64,
    poses: Vec<ToolPose>,
    start: Vector3<f64>,
}

/// Travel that the poses need beyond the margins, over all linear axes \[mm\], and the axis that needs most.
#[derive(Debug, Clone, Copy)]
struct TravelNeed {
    sum: f64,
    axis: usize,
    short: f64,
}

impl<'a> OriginSearch<'a> {
    fn new(machine: &'a Machine, chosen: &CutterTrial, part: &PartMeasure) -> Self {
        let length = chosen.cutter.length();
        let stride = chosen.poses.len().div_ceil(POSES).max(1);
        let clearance = part.clearance();
        // Where the tool cuts, and above, where it comes from.
        let poses = chosen.poses.iter().step_by(stride).flat_map(|pose| {
            let up = pose.tip + Vector3::z() * clearance + pose.axis.scale(clearance);
            [*pose, ToolPose { tip: up, ..*pose }]
        });
        let start = first_origin(machine, length) - part.foot().coords;
        Self { machine, length, poses: poses.collect(), start }
    }

    /// Finds the origin nearest to the first one, by steps along the machine's axes that are halved.
    fn best(&self) -> Result<Vector3<f64>, ProposalError> {
        let (mut origin, mut need) = (self.start, self.need(&self.start));
        let mut step = ORIGIN_STEPS.high;
        while need.sum > 0.0 && step >= ORIGIN_STEPS.low {
            let moves = (0..3).flat_map(|axis| [step, -step].map(|by| Vector3::ith(axis, by)));
            let tried = moves.map(|by| (origin + by, self.need(&(origin + by))));
            let least = tried.min_by(|a, b| a.1.sum.total_cmp(&b.1.sum));
            match least {
                Some((moved, less)) if less.sum < need.sum => (origin, need) = (moved, less),
                _ => step *= 0.5,
            }
        }
        if need.sum > 0.0 {
            let axis = self.machine.axes[need.axis].name.clone();
            return Err(ProposalError::Travel { axis, short: need.short });
        }
        // The first steps were long: back towards the start, as far as travel allows.
        let mut start = self.start;
        while (origin - start).norm() > ORIGIN_STEPS.low {
            let middle = 0.5 * (origin + start);
            if self.need(&middle).sum > 0.0 {
                start = middle;
            } else {
                origin = middle;
            }
        }
        Ok(origin.map(|x| (x / ORIGIN_DIGIT).round() * ORIGIN_DIGIT))
    }

    fn need(&self, origin: &Vector3<f64>) -> TravelNeed {
        let none = TravelNeed { sum: f64::INFINITY, axis: 0, short: f64::INFINITY };
        let setup = Setup::new(*origin, [0.0; 3], self.length);
        let kinematics = Kinematics::new(self.machine, &setup);
        let Ok(inverse) = Inverse::new(&inset(&kinematics)) else { return none };
        let home = self.machine.home();
        let mut ranges = [Interval::new(f64::INFINITY, f64::NEG_INFINITY); FIRST_ROTARY];
        for pose in &self.poses {
            let Ok(position) = inverse.continued(pose, &home) else { continue };
            for (axis, range) in ranges.iter_mut().enumerate() {
                *range = range.hull(Interval::point(position.q[axis]));
            }
        }
        let mut need = TravelNeed { sum: 0.0, ..none };
        for (index, (axis, range)) in self.machine.axes.iter().zip(ranges).enumerate() {
            let margin = MARGIN * axis.limits.width();
            let short = (axis.limits.low + margin - range.low).max(0.0)
                + (range.high - axis.limits.high + margin).max(0.0);
            if need.sum <= 0.0 || short > need.short {
                need = TravelNeed { axis: index, short, ..need };
            }
            need.sum += short;
        }
        need
    }
}

/// Returns the place of the middle of the part's bottom: above the middle of the table where it turns, else in the
/// middle of the travel \[mm\], machine coordinates with all axes at zero.
fn first_origin(machine: &Machine, length: f64) -> Vector3<f64> {
    if machine.body(FIRST_ROTARY) == MovedBody::Part {
        return machine.axes[FIRST_ROTARY].point.coords + Vector3::z() * STANDOFF;
    }
    let mut middle = machine.home();
    for (index, axis) in machine.axes.iter().take(FIRST_ROTARY).enumerate() {
        if axis.limits.is_bounded() {
            middle[index] = axis.limits.middle();
        }
    }
    let setup = Setup::new(Vector3::zeros(), [0.0; 3], length);
    Kinematics::new(machine, &setup).forward(&middle).tip.coords
}
