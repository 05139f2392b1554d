//! Cutters of a proposed job, from the largest to the smallest: each cuts what it can, the last what is left.

use super::borders::NarrowBorders;
use super::candidates::{CandidateFaces, kind};
use super::corners::SharpCorners;
use super::cutters::{CutterTrial, RotaryReach, long_enough, with_length};
use super::left_out::LeftOutFace;
use super::part_measure::PartMeasure;
use crate::cover::corner_reach;
use crate::cutter::{Cutter, CutterKind};
use crate::files::job::JobArea;
use crate::machine::Machine;
use crate::surface::{FaceIndex, FaceSample};
use crate::types::{Cancelled, Progress};

/// Share of the area that planes and walls must have for a flat end mill of their own.
const WORTH_A_TOOL: f64 = 0.2;

/// Least radius of a ball for narrow borders, as a share of that of the ball before it.
const FINEST: f64 = 0.2;

/// Least concave radius under a bull-nose cutter, over its radius. A cutter with a small corner has to lean by 20 degrees there
/// (arc sine of a third) before its back is clear.
const GENTLE: f64 = 3.0;

/// Least radius of a bull-nose cutter in place of a ball, over that of the ball.
const SMALLER: f64 = 0.6;

/// Share of the area whose convex radius may be less than that of a bull-nose cutter: on it strips are hardly wider than a
/// ball's, and the tool has to turn much.
const FILLETS: f64 = 0.5;

/// Cutters in the order in which they cut.
pub(super) struct CutterLadder {
    pub(super) steps: Vec<LadderStep>,
    /// Faces that none of them cuts.
    pub(super) left_out: Vec<LeftOutFace>,
}

/// Cutter, with the faces that it cuts.
pub(super) struct LadderStep {
    pub(super) trial: CutterTrial,
    /// Indices of the faces.
    pub(super) faces: Vec<usize>,
    pub(super) area: JobArea,
}

/// Cutters to choose from, and what they have to suit.
#[derive(Clone, Copy)]
pub(super) struct CutterOffer<'a> {
    pub(super) library: &'a [Cutter],
    pub(super) machine: &'a Machine,
    pub(super) part: &'a PartMeasure,
}

impl CutterLadder {
    /// Chooses the cutters; `None` without a cutter for the part.
    pub(super) fn choose(
        candidates: CandidateFaces<'_>,
        offer: CutterOffer<'_>,
        progress: &dyn Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let faces = candidates.faces;
        let ladder = Self::choose_for_faces(candidates, offer, progress)?;
        let step = |ladder: &Self| {
            let last = &ladder.steps.last()?.trial.cutter;
            let corners = corners_left(faces, &rounded_faces(&ladder.steps), last, offer.machine)?;
            corner_step(&corners, last, offer)
        };
        Ok(ladder.map(|ladder| {
            let step = step(&ladder);
            ladder.followed_by(step)
        }))
    }

    /// Chooses the cutters for the faces, sharp corners aside.
    fn choose_for_faces(
        candidates: CandidateFaces<'_>,
        offer: CutterOffer<'_>,
        progress: &dyn Progress,
    ) -> Result<Option<Self>, Cancelled> {
        let CutterOffer { library, machine, part } = offer;
        let has = |kind: CutterKind| library.iter().any(|cutter| cutter.kind() == kind);
        // A ball cuts every face, and stands in for a kind that the library does not have.
        let best = kind(candidates.faces, &candidates.candidates);
        let shape = [best, CutterKind::Ball, CutterKind::Bull, CutterKind::Flat];
        let Some(shape) = shape.into_iter().find(|kind| has(*kind)) else { return Ok(None) };
        let one = |candidates: CandidateFaces<'_>| -> Result<Option<Self>, Cancelled> {
            let tried = candidates.tried(library, shape, machine, part, progress)?;
            Ok(CutterTrial::choose(&tried).map(|fine| Self::of(Vec::new(), tried, fine)))
        };
        if !has(CutterKind::Ball) {
            return one(candidates);
        }
        // Step 1: planes and walls beside other faces get a flat end mill. Without them, wide strips of a bull-nose cut
        // faces that are nowhere concave.
        let all = candidates.area();
        let [prismatic, mut others] = candidates.prismatic_and_others();
        let is_mixed = prismatic.area() >= WORTH_A_TOOL * all && !others.candidates.is_empty();
        if shape == CutterKind::Flat && !is_mixed {
            others.join(prismatic.candidates);
            return one(others);
        }
        if shape == CutterKind::Bull && !is_mixed {
            others.join(prismatic.candidates);
            return one(others);
        }
        let mut steps = Vec::new();
        let mut flat = None;
        if is_mixed {
            let mut tried = prismatic.tried(library, CutterKind::Flat, machine, part, progress)?;
            let chosen = CutterTrial::choose(&tried).filter(|at| !tried[*at].cut().is_empty());
            flat = chosen.map(|at| tried.swap_remove(at));
        }
        let is_cut = |index: usize| flat.as_ref().is_some_and(|flat| flat.cuts(index));
        others.join(prismatic.candidates.into_iter().filter(|face| !is_cut(face.index)));
        if let Some(trial) = flat {
            let faces = trial.cut();
            steps.push(LadderStep { trial, faces, area: JobArea::Whole });
        }
        // Step 2: a ball for all other faces, and a much larger one before it where that cuts most of them.
        let mut tried = others.tried(library, CutterKind::Ball, machine, part, progress)?;
        let Some(fine) = CutterTrial::choose(&tried) else { return Ok(None) };
        let balls = library.iter().filter(|cutter| cutter.kind() == CutterKind::Ball);
        let border = |trial: &CutterTrial| {
            border_step(&others, trial, balls.clone(), |ball| {
                others.trial(machine, &long_enough(ball, part.size().z))
            })
        };
        // A larger one instead, where a flat end mill finishes all that it leaves.
        let leaves_corners = |trial: &CutterTrial| {
            let cut = tried[fine].cut();
            let all = cut.iter().all(|index| trial.cuts(*index));
            all && border(trial).is_none() && flat_finishes(trial, &cut, others.faces, offer)
        };
        if let Some(large) = (0..fine).find(|at| leaves_corners(&tried[*at])) {
            return Ok(Some(Self::of(steps, tried, large)));
        }
        let large = CutterTrial::choose_before(&tried, fine);
        // Step 3: a bull-nose instead of a single ball where the faces bend gently.
        // It leaves the foot of what stands on a floor.
        if large.is_none() && shape != CutterKind::Flat {
            let bulls = gentle_bulls(&others, library, tried[fine].cutter.radius());
            let mut wide = others.tried(&bulls, CutterKind::Bull, machine, part, progress)?;
            wide.retain(CutterTrial::reaches_all);
            if !wide.is_empty() {
                return Ok(Some(Self::of(steps, wide, 0)));
            }
        }
        // Step 4: a smaller ball along borders where that one does not fit.
        let borders = border(&tried[fine]);
        if let Some(large) = large {
            let trial = tried.remove(large);
            let faces = trial.partly_cut.clone();
            steps.push(LadderStep { trial, faces, area: JobArea::Whole });
            return Ok(Some(Self::of(steps, tried, fine - 1).followed_by(borders)));
        }
        Ok(Some(Self::of(steps, tried, fine).followed_by(borders)))
    }

    /// Ends a ladder with the cutter of index `fine`, which cuts what those before leave.
    fn of(mut steps: Vec<LadderStep>, mut tried: Vec<CutterTrial>, fine: usize) -> Self {
        let trial = tried.swap_remove(fine);
        let left_out = trial.left_out.clone();
        let mut faces = trial.cut();
        let area = if steps.is_empty() { JobArea::Whole } else { JobArea::Rest };
        // A face that the finest cutter does not reach is not begun by another.
        for step in &mut steps {
            step.faces.retain(|index| !trial.leaves_out(*index));
            faces.extend(&step.faces);
        }
        steps.retain(|step| !step.faces.is_empty());
        faces.sort_unstable();
        faces.dedup();
        steps.push(LadderStep { trial, faces, area });
        Self { steps: equally_long(steps), left_out }
    }

    /// Adds a last step.
    fn followed_by(self, last: Option<LadderStep>) -> Self {
        let steps = self.steps.into_iter().chain(last).collect();
        Self { steps: equally_long(steps), ..self }
    }
}

/// Returns the bull-nose cutters that suit some faces: hollows are gentle, fillets are few, and the cutter is not much smaller
/// than a ball of some radius \[mm\].
fn gentle_bulls(candidates: &CandidateFaces<'_>, library: &[Cutter], ball: f64) -> Vec<Cutter> {
    let faces = candidates.candidates.iter().map(|face| &candidates.faces[face.index]);
    let concave = faces.map(FaceIndex::smallest_concave_radius).fold(f64::INFINITY, f64::min);
    let is_gentle = |cutter: &&Cutter| {
        let radius = cutter.radius();
        cutter.kind() == CutterKind::Bull
            && radius >= SMALLER * ball
            && GENTLE * radius <= concave
            && candidates.fillet_area(radius) <= FILLETS * candidates.area()
    };
    library.iter().filter(is_gentle).cloned().collect()
}

/// Makes the cutters of all steps as long as the longest.
fn equally_long(steps: Vec<LadderStep>) -> Vec<LadderStep> {
    let longest = steps.iter().map(|step| step.trial.cutter.length()).fold(0.0, f64::max);
    let as_long = |step: LadderStep| LadderStep { trial: step.trial.with_length(longest), ..step };
    steps.into_iter().map(as_long).collect()
}

/// Returns the step of the largest ball that fits along the borders where a larger one does not.
fn border_step<'a>(
    candidates: &CandidateFaces<'_>,
    before: &CutterTrial,
    balls: impl Iterator<Item = &'a Cutter> + Clone,
    trial: impl Fn(&Cutter) -> CutterTrial,
) -> Option<LadderStep> {
    let allowed = balls.filter(|ball| ball.minor() >= FINEST * before.cutter.minor());
    let least = allowed.clone().map(Cutter::minor).reduce(f64::min)?;
    let borders = NarrowBorders::find(candidates.faces, &before.cut(), &before.cutter, least)?;
    let fitting = allowed.filter(|ball| borders.fits(ball));
    let ball = fitting.max_by(|a, b| a.minor().total_cmp(&b.minor()))?;
    let trial = trial(ball);
    let faces: Vec<usize> = borders.faces.into_iter().filter(|at| trial.cuts(*at)).collect();
    (!faces.is_empty()).then_some(LadderStep { trial, faces, area: JobArea::Rest })
}

/// Returns the faces that no flat end mill cuts.
fn rounded_faces(steps: &[LadderStep]) -> Vec<usize> {
    let (flats, others): (Vec<_>, Vec<_>) =
        steps.iter().partition(|step| step.trial.cutter.minor() <= 0.0);
    let by_flat = |at: &usize| flats.iter().flat_map(|step| &step.faces).any(|face| face == at);
    let mut rounded: Vec<usize> = others.into_iter().flat_map(|step| step.faces.clone()).collect();
    rounded.retain(|at| !by_flat(at));
    rounded.sort_unstable();
    rounded.dedup();
    rounded
}

/// Returns the sharp corners that a cutter leaves on some faces.
fn corners_left<'a>(
    faces: &'a [FaceIndex],
    cut: &[usize],
    cutter: &Cutter,
    machine: &Machine,
) -> Option<SharpCorners<'a>> {
    if cutter.minor() <= 0.0 {
        return None;
    }
    SharpCorners::find(faces, cut, cutter, &RotaryReach::new(machine, cutter))
}

/// Returns `true` if all that a ball leaves of some faces lies beside sharp corners into which a flat end mill gets.
fn flat_finishes(
    ball: &CutterTrial,
    cut: &[usize],
    faces: &[FaceIndex],
    offer: CutterOffer<'_>,
) -> bool {
    let Some(corners) = corners_left(faces, cut, &ball.cutter, offer.machine) else { return false };
    let Some(step) = corner_step(&corners, &ball.cutter, offer) else { return false };
    let within = corner_reach(&ball.cutter);
    let is_finished = |(index, sample): &(usize, FaceSample)| {
        step.faces.contains(index) && corners.is_near(*index, &sample.point, within)
    };
    ball.missed.iter().filter(|(index, _)| cut.contains(index)).all(is_finished)
}

/// Returns the step of the largest flat end mill that gets into the sharp corners which the last cutter leaves.
fn corner_step(
    corners: &SharpCorners<'_>,
    last: &Cutter,
    CutterOffer { library, machine, part }: CutterOffer<'_>,
) -> Option<LadderStep> {
    let mut flats: Vec<&Cutter> = library
        .iter()
        .filter(|flat| flat.kind() == CutterKind::Flat)
        .filter(|flat| 2.0 * flat.radius() <= part.largest_diameter())
        .filter(|flat| flat.radius() >= FINEST * last.radius())
        .collect();
    flats.sort_by(|a, b| b.radius().total_cmp(&a.radius()));
    // All tools of a job are as long as the longest.
    let fits = flats.into_iter().map(|flat| {
        let flat = with_length(flat, last.length().max(long_enough(flat, part.size().z).length()));
        let fit = corners.fit(&flat, &RotaryReach::new(machine, &flat));
        (flat, fit)
    });
    // The first that gets into the corners of as many faces as any.
    let best =
        fits.reduce(|best, next| if next.1.faces.len() > best.1.faces.len() { next } else { best });
    let (flat, fit) = best.filter(|(_, fit)| !fit.faces.is_empty())?;
    let trial = CutterTrial::at(flat, fit.poses);
    Some(LadderStep { trial, faces: fit.faces, area: JobArea::Rest })
}
