//! Inspects boxes between the rays by running the program again.

use super::boxes::{CloseBox, EarlierBody, halves};
use super::search::{DepthSearch, SearchOutcome, SearchScale};
use crate::types::{Progress, Stage};
use crate::verify::error::VerifyError;
use crate::verify::replay::segments::Run;
use crate::verify::stock::broad_phase::MovingPart;
use crate::verify::stock::collision::{Collision, CollisionKind};
use crate::verify::stock::moving_tools::MovingTools;
use crate::verify::swept::bvh::{BoxTree, ContentId, TreeItem};
use crate::verify::swept::mesh::ClosedMesh;
use crate::verify::swept::quadratic::MotionPiece;
use crate::verify::swept::relative::RelativeMotion;
use crate::verify::swept::tool::ConvexBody;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Result of inspecting a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BoxFinding {
    pub(crate) line: u32,
    pub(crate) kind: CollisionKind,
    /// The rays have shown the collision already.
    pub(crate) known: bool,
    pub(crate) hit: Option<Collision>,
    /// Depth that remains possible because the search met its limit \[mm\].
    pub(crate) open: Option<f64>,
}

/// Depth in material between rays that need not be reported \[mm\].
pub(crate) const LEAST: f64 = 0.002;
/// Accuracy of depths as a share of [`LEAST`].
const DEPTH: f64 = 0.25;
/// Accuracy of times as a share of [`LEAST`].
const TIME: f64 = 0.1;
/// Most pieces kept at a time, so that memory does not grow with the program.
const MOST_BEFORE: usize = 200_000;
/// Most repetitions of the program in one call; boxes not decided by then are reported as undecided.
const MOST_RUNS: u32 = 64;
/// Boxes between two chances to cancel.
const BATCH: usize = 256;

/// Result of a second run: the bodies that come to boxes, in order, and the bodies that the boxes are about.
struct SecondRun {
    before: Vec<EarlierBody>,
    suspects: BTreeMap<usize, (ConvexBody, MotionPiece)>,
    tree: BoxTree,
}

/// Inspects boxes for collisions between the rays.
pub(crate) fn inspect_boxes(
    run: &Run<'_>,
    tools: &MovingTools,
    shell: &ClosedMesh,
    close: Vec<CloseBox>,
    progress: &dyn Progress,
) -> Result<Vec<BoxFinding>, VerifyError> {
    let (total, mut found, mut done) = (close.len(), Vec::new(), 0);
    let (mut waiting, mut runs) = (vec![close], 0);
    while let Some(close) = waiting.pop() {
        runs += 1;
        let again = again(run, tools, &close)?;
        // Too many earlier bodies for memory: run the program again for half of the boxes each.
        if again.is_none() && close.len() > 1 && runs < MOST_RUNS {
            waiting.extend(halves(close));
            continue;
        }
        for some in close.chunks(BATCH) {
            let of = |close: &CloseBox| inspect_box(tools, shell, close, again.as_ref());
            found.par_extend(some.par_iter().filter_map(of));
            done += some.len();
            progress.step(Stage::Verify, done as u64, total as u64)?;
        }
    }
    Ok(found)
}

/// Runs the program up to the last of the boxes' bodies; `None` if too many bodies come to the boxes.
fn again(
    run: &Run<'_>,
    tools: &MovingTools,
    close: &[CloseBox],
) -> Result<Option<SecondRun>, VerifyError> {
    let last = close.iter().map(|close| close.part).max().unwrap_or(0);
    let item = |(index, close): (u32, &CloseBox)| TreeItem {
        bounds: close.bounds,
        content: ContentId::item(index),
    };
    let boxes = BoxTree::new((0..).zip(close).map(item).collect());
    let mut suspects: BTreeMap<usize, Option<(ConvexBody, MotionPiece)>> =
        close.iter().map(|close| (close.part, None)).collect();
    let (mut before, mut items, mut parts, mut number) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for segment in run.segments() {
        parts.clear();
        tools.parts(&run.mover, &segment?, number, &mut parts)?;
        number += parts.len();
        for MovingPart { number, body, harm, straight, bounds, whole, .. } in &parts {
            if let Some(suspect) = suspects.get_mut(number) {
                *suspect = Some((*body, whole.piece));
            }
            for bounded in straight.iter().filter(|_| boxes.meets(bounds)) {
                items.push(TreeItem { bounds: *bounds, content: ContentId::item(index(&before)) });
                let (number, body, harm, bounded) = (*number, *body, *harm, *bounded);
                before.push(EarlierBody { number, harm, body, bounded });
            }
        }
        if before.len() > MOST_BEFORE {
            return Ok(None);
        }
        // Bodies after the last suspect cannot have removed material before it.
        if number > last {
            break;
        }
    }
    let suspects = suspects.into_iter().filter_map(|(number, found)| Some((number, found?)));
    Ok(Some(SecondRun { before, suspects: suspects.collect(), tree: BoxTree::new(items) }))
}

/// Returns the number of the next entry.
fn index(before: &[EarlierBody]) -> u32 {
    u32::try_from(before.len()).unwrap_or(u32::MAX)
}

/// Inspects one box.
fn inspect_box(
    tools: &MovingTools,
    shell: &ClosedMesh,
    close: &CloseBox,
    again: Option<&SecondRun>,
) -> Option<BoxFinding> {
    let &CloseBox { line, kind, known, .. } = close;
    let Some(SecondRun { before, suspects, tree }) = again else {
        // Undecided: the body may be as deep as it is wide, unless the rays show the collision anyway.
        let open = Some(close.most).filter(|_| known <= 0.0);
        return Some(BoxFinding { line, kind, known: known > 0.0, hit: None, open });
    };
    let (body, piece) = suspects.get(&close.part)?;
    let motion = RelativeMotion { body: *body, piece, sag: piece.sag(tools.size(piece.tool)) };
    let mut near = Vec::new();
    tree.near(&close.bounds, &mut near);
    let before = near.iter().filter_map(|id| before.get(id.item as usize));
    // A collision that a move cut itself on the way still counts as a collision.
    let own = |before: &EarlierBody| before.number >= close.first && before.harm == Some(kind);
    let before = before.filter(|before| before.number < close.part && !own(before)).collect();
    // Depths within twice the clipping tolerance may be due to that alone.
    let least = LEAST.max(2.0 * tools.tolerance);
    let scale = SearchScale { least, depth: DEPTH * least, tolerance: TIME * least };
    let SearchOutcome { deepest, open } =
        DepthSearch::new(shell, motion, scale).run(&close.bounds, before, known);
    let hit = deepest.map(|found| Collision { kind, line, depth: found.depth, point: found.point });
    let finding = BoxFinding { line, kind, known: known > 0.0, hit, open };
    (hit.is_some() || open.is_some()).then_some(finding)
}
