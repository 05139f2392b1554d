//! Proposal of a job for a part: faces, cutter and setup that run as they are.

use super::candidates::CandidateFaces;
use super::cutters::{CutterTrial, leaning_poses};
use super::ladder::{CutterLadder, CutterOffer, LadderStep};
use super::left_out::{FaceReason, LeftOutFace, ProposalError};
use super::orientation;
use super::origin::origin;
use super::part_measure::PartMeasure;
use super::request::{JobProposal, ProposalRequest, ProposedOperation, TOLERANCE};
use crate::cover::FinishTolerance;
use crate::cutter::{Cutter, CutterKind};
use crate::files::job::JobArea;
use crate::files::library::{self, LibraryCutter};
use crate::math;
use crate::pipeline::assemble::cutter_spec;
use crate::surface::{Face, FaceIndex};
use crate::types::Progress;
use rayon::prelude::*;
use std::borrow::Cow;

/// Largest tolerance, as a share of the part's size.
const TOLERANCE_SHARE: f64 = 1e-3;

/// Cutting speed \[mm/s\], largest spindle speed \[rev/s\], feed per tooth as a share of the diameter, and teeth: modest
/// values for finishing aluminium.
const CUTTING_SPEED: f64 = 200_000.0 / 60.0;
const FASTEST_SPINDLE: f64 = 200.0;
const TOOTH_FEED: f64 = 0.005;
const TEETH: f64 = 2.0;

/// Proposes a job that finishes the faces of a part that the machine reaches from above.
///
/// The cutter is the largest of a library that reaches nearly all that the smaller ones reach: flat
/// for planes, a ball where a face is concave or stands on a floor, else a bull-nose. Planes beside such faces are cut by a
/// flat end mill first, and most of the others by a large ball where only hollows and corners need a small one; the small one
/// then cuts the rest, and a flat end mill what stays in sharp corners. Where those are all that the large ball leaves, there is
/// no small one. The part stays as drawn unless the request turns it, or a tool reaches much more of another side.
/// It stands on the middle of the rotary table where the machine has one, moved as far as the travel of the axes needs. A
/// sheet that looks down is cut on its other side.
///
/// # Errors
///
/// [`ProposalError`].
pub fn propose(
    request: &ProposalRequest<'_>,
    progress: &dyn Progress,
) -> Result<JobProposal, ProposalError> {
    let drawn = [0.0; 3];
    if let Some(angles) = request.angles {
        return turned(request, angles, progress);
    }
    let other_side =
        orientation::choose(request.faces).map(|angles| turned(request, angles, progress));
    match other_side {
        // What cannot be proposed for the other side may be for that of the drawing.
        None | Some(Err(ProposalError::NothingReached { .. } | ProposalError::Travel { .. })) => {
            turned(request, drawn, progress)
        }
        Some(proposal) => proposal,
    }
}

/// Proposes a job for the part turned by angles about x, y and z \[rad\].
fn turned(
    request: &ProposalRequest<'_>,
    angles: [f64; 3],
    progress: &dyn Progress,
) -> Result<JobProposal, ProposalError> {
    let rotation = math::exact_rotation_of_xyz(angles.into());
    let faces: Vec<Face> =
        request.faces.iter().map(|face| face.clone().turned(&rotation)).collect();
    let request = ProposalRequest { faces: &faces, ..*request };
    let proposal = match of_side(&request, progress) {
        // No solid looks down all over: these faces are a sheet, whose sides are as good as each other.
        Err(ProposalError::NothingReached { left_out })
            if request.wanted.is_none()
                && left_out.iter().all(|face| matches!(face.reason, FaceReason::Down)) =>
        {
            let faces: Vec<Face> = faces.iter().map(|face| face.clone().flipped()).collect();
            let other = ProposalRequest { faces: &faces, ..request };
            JobProposal { flip: true, ..of_side(&other, progress)? }
        }
        proposal => proposal?,
    };
    Ok(JobProposal { angles, ..proposal })
}

/// Proposes a job for the side of the faces that they have.
fn of_side(
    request: &ProposalRequest<'_>,
    progress: &dyn Progress,
) -> Result<JobProposal, ProposalError> {
    // Step 1: faces that look up or to the side.
    let mut left_out = Vec::new();
    let mut faces: Vec<FaceIndex> = Vec::new();
    let indexed: Vec<_> =
        request.faces.par_iter().map(|face| FaceIndex::new(face.clone())).collect();
    for (face, index) in request.faces.iter().zip(indexed) {
        match index {
            Ok(index) => faces.push(index),
            Err(error) => {
                let reason = FaceReason::Surface(error.to_string());
                left_out.push(LeftOutFace { number: face.number, reason });
            }
        }
    }
    let part = PartMeasure::new(&faces);
    let candidates = CandidateFaces::new(&faces, request.wanted, &part, &mut left_out);
    let library = cutters(request)?;
    if library.is_empty() {
        return Err(ProposalError::NoCutter);
    }
    // Step 2: the cutters, by what each of the library reaches.
    let offer = CutterOffer { library: &library, machine: request.machine, part: &part };
    let ladder = CutterLadder::choose(candidates, offer, progress)?;
    let Some(CutterLadder { steps, left_out: not_reached }) = ladder else {
        return Err(ProposalError::NothingReached { left_out });
    };
    left_out.extend(not_reached);
    let mut cut: Vec<usize> = steps.iter().flat_map(|step| step.faces.iter().copied()).collect();
    cut.sort_unstable();
    cut.dedup();
    if cut.is_empty() {
        return Err(ProposalError::NothingReached { left_out });
    }
    left_out.sort_by_key(|face| face.number);
    // Step 3: the origin that keeps the poses inside travel.
    let clearance = part.clearance();
    let number = |at: &usize| faces[*at].face().number;
    let mut trials = Vec::new();
    let mut operations = Vec::new();
    let mut leaning = Vec::new();
    for LadderStep { trial, faces: of_step, area } in steps {
        leaning.extend(leaning_poses(&faces, &of_step, request.machine, &trial.cutter));
        operations.push(operation(&trial, of_step.iter().map(number).collect(), area));
        trials.push(trial);
    }
    let origin = origin(request.machine, &trials, &leaning, &part)?;
    let excess = TOLERANCE.excess.min(TOLERANCE_SHARE * part.size().norm());
    let gouge = excess * TOLERANCE.gouge / TOLERANCE.excess;
    Ok(JobProposal {
        faces: cut.iter().map(number).collect(),
        angles: [0.0; 3],
        flip: false,
        left_out,
        operations,
        concave_radius: cut
            .iter()
            .map(|&at| faces[at].smallest_concave_radius())
            .fold(f64::INFINITY, f64::min),
        origin,
        clearance,
        tolerance: FinishTolerance { excess, gouge },
    })
}

/// Returns the flat, bull-nose and ball end mills of the library.
fn cutters(request: &ProposalRequest<'_>) -> Result<Vec<Cutter>, ProposalError> {
    let library = request.library.map_or_else(|| Cow::Owned(library::standard()), Cow::Borrowed);
    let cutter = |one: &LibraryCutter| {
        let bad = |errors| ProposalError::BadCutter { name: one.name.clone(), errors };
        Cutter::new(cutter_spec(&one.tool)).map_err(bad)
    };
    let mut all: Vec<Cutter> = library.cutters.iter().map(cutter).collect::<Result<_, _>>()?;
    all.retain(|one| matches!(one.kind(), CutterKind::Flat | CutterKind::Bull | CutterKind::Ball));
    Ok(all)
}

/// Returns an operation with cutting data by the diameter.
fn operation(trial: &CutterTrial, faces: Vec<usize>, area: JobArea) -> ProposedOperation {
    let diameter = 2.0 * trial.cutter.radius();
    let spindle = (CUTTING_SPEED / (std::f64::consts::PI * diameter)).min(FASTEST_SPINDLE);
    let feed = spindle * TEETH * TOOTH_FEED * diameter;
    ProposedOperation { faces, area, cutter: trial.cutter.spec().clone(), feed, spindle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::Reader;
    use crate::import::step::StepReader;
    use crate::machine::Machine;
    use crate::surface::{
        ConeSurface, NurbsSurface, PlaneSurface, Surface, SurfaceFrame, TorusSurface, TrimCurve,
        TrimLoop,
    };
    use crate::types::Silent;
    use nalgebra::{Point3, Vector3};
    use std::f64::consts::{PI, TAU};

    /// A sheet of 40 mm square that bulges by 4 mm.
    fn sheet() -> Face {
        let point = |i: u8, j: u8| {
            let bulge = if (i, j) == (1, 1) { 16.0 } else { 0.0 };
            Point3::new(20.0 * f64::from(i), 20.0 * f64::from(j), bulge)
        };
        let net = (0..3).map(|i| (0..3).map(|j| point(i, j)).collect()).collect();
        let knots = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let surface = NurbsSurface::new([2, 2], [knots(), knots()], net, None).unwrap();
        Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
    }

    #[test]
    fn a_sheet_that_looks_down_is_cut_on_its_other_side() {
        let machine = Machine::new(crate::sample_machine::ac_trunnion()).unwrap();
        let propose_for =
            |face: Face| propose(&ProposalRequest::new(&[face], &machine), &Silent).unwrap();
        let up = propose_for(sheet());
        let down = propose_for(sheet().flipped());
        assert!(!up.flip && down.flip);
        assert_eq!(JobProposal { flip: false, ..down }, up);
    }

    /// A trough of 40 mm square, `depth` mm deep in its middle.
    fn trough(depth: f64) -> Face {
        let point = |i: u8, j: u8| {
            let z = if i == 1 { -2.0 * depth } else { 0.0 };
            Point3::new(20.0 * f64::from(i), 40.0 * f64::from(j), z)
        };
        let net = (0..3).map(|i| (0..2).map(|j| point(i, j)).collect()).collect();
        let knots = [vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
        let surface = NurbsSurface::new([2, 1], knots, net, None).unwrap();
        Face::new(1, Surface::Nurbs(surface), Vec::new()).unwrap()
    }

    #[test]
    fn a_gentle_hollow_gets_a_bull_nose_and_a_tight_one_a_ball() {
        let machine = Machine::new(crate::sample_machine::ac_trunnion()).unwrap();
        let kinds = |face: Face| -> Vec<CutterKind> {
            let found = propose(&ProposalRequest::new(&[face], &machine), &Silent).unwrap();
            let kind = |step: &ProposedOperation| Cutter::new(step.cutter.clone()).unwrap().kind();
            found.operations.iter().map(kind).collect()
        };
        // The curvature in the middle of a parabola is 8 depth / width²: radii of 100 and 17 mm.
        assert_eq!(kinds(trough(2.0)), [CutterKind::Bull]);
        assert_eq!(kinds(trough(12.0)), [CutterKind::Ball]);
    }

    #[test]
    fn cutters_are_those_of_the_library() {
        let machine = Machine::new(crate::sample_machine::ac_trunnion()).unwrap();
        let faces = [sheet()];
        let with = |text: &str| {
            let text = format!("schema = \"trunnion-library/1\"\nname = \"shop\"\n{text}");
            let library = library::parse(&text).unwrap();
            let request = ProposalRequest {
                library: Some(&library),
                ..ProposalRequest::new(&faces, &machine)
            };
            propose(&request, &Silent)
        };
        assert_eq!(with(""), Err(ProposalError::NoCutter));
        let ball =
            "[[cutter]]\nname = \"b\"\nnumber = 1\nkind = \"ball\"\ndiameter = 7\nlength = 83\n";
        let found = with(ball).unwrap();
        let [only] = &found.operations[..] else { panic!("{found:?}") };
        assert_eq!((only.cutter.minor, only.cutter.length), (3.5, 83.0));
        // Its shank is below the end of its ball.
        let stout = ball.to_owned() + "shank = [[1, 5]]\n";
        let refused = with(&stout).unwrap_err().to_string();
        assert!(refused.starts_with("cutter \"b\" of the library: shank entry 0"), "{refused}");
        // A cutter that is too short for the part is clamped farther out; its holder stays at the gauge point.
        let short = ball.replace("83", "31") + "holder = [[20, 9], [31, 12]]\n";
        let found = with(&short).unwrap();
        let [only] = &found.operations[..] else { panic!("{found:?}") };
        assert_eq!((only.cutter.minor, only.cutter.length), (3.5, 40.0));
        assert_eq!(only.cutter.shank, [[29.0, 3.5], [29.0, 9.0], [40.0, 12.0]]);
    }

    /// A face inside some outlines of its parameters.
    fn face(number: usize, surface: Surface, outlines: &[Vec<[f64; 2]>]) -> Face {
        let outline = |corners: &Vec<[f64; 2]>| {
            let curve = TrimCurve::polyline(corners).unwrap();
            TrimLoop::new(vec![curve], [None, None], 1e-9).unwrap()
        };
        Face::new(number, surface, outlines.iter().map(outline).collect()).unwrap()
    }

    fn rectangle([left, low]: [f64; 2], [right, high]: [f64; 2]) -> Vec<[f64; 2]> {
        vec![[left, low], [right, low], [right, high], [left, high], [left, low]]
    }

    /// A circle about the origin, in parts of a degree.
    fn circle(radius: f64) -> Vec<[f64; 2]> {
        let corner = |degree: u32| {
            let angle = f64::from(degree % 360).to_radians();
            [radius * angle.cos(), radius * angle.sin()]
        };
        (0..=360).map(corner).collect()
    }

    fn level(z: f64) -> SurfaceFrame {
        SurfaceFrame::new(Point3::new(0.0, 0.0, z), Vector3::z(), Vector3::x()).unwrap()
    }

    fn plane(z: f64) -> Surface {
        Surface::Plane(PlaneSurface { frame: level(z) })
    }

    fn operations(faces: &[Face]) -> Vec<(CutterKind, f64, JobArea, Vec<usize>)> {
        let machine = Machine::new(crate::sample_machine::ac_trunnion()).unwrap();
        let found = propose(&ProposalRequest::new(faces, &machine), &Silent).unwrap();
        let operation = |step: &ProposedOperation| {
            let cutter = Cutter::new(step.cutter.clone()).unwrap();
            (cutter.kind(), 2.0 * cutter.radius(), step.area, step.faces.clone())
        };
        found.operations.iter().map(operation).collect()
    }

    /// Half a torus on a plate, 14 mm inside: all that a ball of 20 mm leaves of it lies beside the plate, and the flat end mill
    /// that cuts the plate finishes it. A ball in between that fits nearer to the plate would only add time.
    #[test]
    fn sharp_corners_that_a_ball_leaves_get_a_flat_end_mill() {
        let torus = Surface::Torus(TorusSurface::new(level(0.0), 20.0, 6.0).unwrap());
        let around = rectangle([0.0, 0.0], [TAU, PI]);
        let plate = [rectangle([-35.0; 2], [35.0; 2]), circle(26.0)];
        let faces = [
            face(1, plane(0.0), &plate),
            face(2, torus, &[around]),
            face(3, plane(0.0), &[circle(14.0)]),
        ];
        let found = operations(&faces);
        let [flat, ball, last] = &found[..] else { panic!("{found:?}") };
        assert_eq!((flat.0, &flat.3[..]), (CutterKind::Flat, &[1, 3][..]));
        assert!(ball.0 == CutterKind::Ball && ball.1 >= 16.0 && ball.3.contains(&2), "{ball:?}");
        assert_eq!((last.0, last.2, &last.3[..]), (CutterKind::Flat, JobArea::Rest, &[2][..]));
    }

    /// A conical pocket, 18 mm deep and 10 mm round at its floor, with walls that rise by 50 degrees: the flank of a flat end mill
    /// finishes them down to the corner. One of the size of the floor would stand on it in a single place.
    #[test]
    fn a_conical_pocket_gets_one_flat_end_mill() {
        let cone = ConeSurface::new(level(-18.0), 10.0, (15.0_f64 / 18.0).atan()).unwrap();
        let wall = face(2, Surface::Cone(cone), &[rectangle([0.0, 0.0], [TAU, 18.0])]).flipped();
        let plate = [rectangle([-40.0; 2], [40.0; 2]), circle(25.0)];
        let faces = [face(1, plane(0.0), &plate), wall, face(3, plane(-18.0), &[circle(10.0)])];
        let found = operations(&faces);
        let [(CutterKind::Flat, diameter, _, cut)] = &found[..] else { panic!("{found:?}") };
        assert!((8.0..=16.0).contains(diameter), "{diameter}");
        assert_eq!(cut[..], [1, 2, 3]);
    }

    /// Returns the faces and the diameters proposed for a part of the corpus \[mm\].
    fn proposed(step: &[u8]) -> (Vec<usize>, Vec<f64>) {
        let machine = Machine::new(crate::sample_machine::ac_trunnion()).unwrap();
        let reader = StepReader { chord: 0.002, same: 0.01 };
        let part = reader.read(step, &Silent).unwrap();
        let found = propose(&ProposalRequest::new(&part.faces, &machine), &Silent).unwrap();
        let diameter =
            |step: &ProposedOperation| 2.0 * Cutter::new(step.cutter.clone()).unwrap().radius();
        (found.faces.clone(), found.operations.iter().map(diameter).collect())
    }

    /// The walls of a slot, 10 mm wide, are cut by the flank of an upright tool: its rim reaches them only with the smallest
    /// cutters, which lean inside the slot. Its ends, 4.999 mm round, ask for less than 8 mm.
    #[test]
    fn the_walls_of_a_slot_do_not_ask_for_the_smallest_cutter() {
        let step = include_bytes!("../../../../../fixtures/corpus/gate/key_slot.step");
        assert_eq!(proposed(step).1, [6.0]);
    }

    /// The walls of the boss are lofts with a draft of 12 degrees: the flank of the tool that cuts the floor finishes them down
    /// to their foot, where a ball would leave material.
    #[test]
    fn walls_that_are_lofts_go_to_the_flat_end_mill() {
        let step = include_bytes!("../../../../../fixtures/corpus/gate/drafted_boss.step");
        assert_eq!(proposed(step), (vec![3, 7, 8, 9, 10, 11], vec![16.0]));
    }

    /// A cutter of 12 mm, which reaches 95 % of all faces, does not get between posts that are 8 mm apart.
    #[test]
    fn a_gap_between_posts_gets_a_cutter_that_fits() {
        let step = include_bytes!("../../../../../fixtures/corpus/gate/bosses.step");
        assert_eq!(proposed(step).1, [8.0]);
    }

    /// The pocket leans by 15 degrees, its corners are 5 mm round. Face 10 is the wall that hangs over.
    #[test]
    fn a_pocket_that_leans_is_cut_by_a_tool_that_leans() {
        let step = include_bytes!("../../../../../fixtures/corpus/gate/slanted_pocket.step");
        let (faces, diameters) = proposed(step);
        assert_eq!(diameters, [8.0]);
        assert_eq!(faces, [3, 7, 8, 9, 10, 11, 12, 13, 14, 15]);
    }
}
