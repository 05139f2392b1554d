//! Passes over what the passes of a face have left, and the measure of it.

use crate::cover::error::CoverError;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cover::layout::trims::region;
use crate::cover::pattern::{FeedDirection, PlacementMethod};
use crate::cover::place::context::FaceContext;
use crate::cover::place::placed::PlacedPasses;
use crate::cover::place::planner::{FacePlanner, FaceRectangle, WorkLimits};
use crate::cover::place::touch_up::{may_fit, touch_up};
use crate::cover::place::trim::SpanProof;
use crate::types::UncutRegion;

/// Work, over that of passes at the fixed inclination, after which these are given up as well: several times what they
/// should take, as where the tool has to keep off something many inclinations are tried.
pub(crate) const REST: f64 = 10.0;

/// Share of a face up to which what is left is finished spot by spot.
pub(crate) const SPOTS: f64 = 0.02;

/// Rounds of short passes: each is over what the round before has left.
const TOUCH_UPS: u32 = 10;

/// Share of the area left after a round, over that before, at which another is tried.
const WORTHWHILE: f64 = 0.9;

/// Returns `true` if passes have left material that the tool may finish.
pub(crate) fn is_left(placed: &PlacedPasses) -> bool {
    placed.report.rest.iter().any(may_fit)
}

/// Finishes the material that passes have left: spots by short passes, larger regions by passes across first.
pub(crate) fn finish<Inside: Fn(ChartPoint) -> bool + Sync>(
    cross: &FaceContext<'_, Inside>,
    mut placed: PlacedPasses,
) -> Result<PlacedPasses, CoverError> {
    if placed.left() > SPOTS * placed.report.area {
        let filled = fill_across(cross, &placed)?;
        if placed.leaves_more(&filled) {
            placed = filled;
        }
    }
    touch_up_rounds(cross, placed)
}

/// Adds short passes over spots that are left, as long as they finish something.
pub(crate) fn touch_up_rounds<Inside: Fn(ChartPoint) -> bool + Sync>(
    cross: &FaceContext<'_, Inside>,
    mut placed: PlacedPasses,
) -> Result<PlacedPasses, CoverError> {
    for _ in 0..TOUCH_UPS {
        if !is_left(&placed) {
            break;
        }
        cross.progress.report(1.0)?;
        cross.progress.show(&placed);
        let mut touched = touch_up(cross, &placed);
        measure_rest(cross, &mut touched);
        // Cells at the rims count in full in both: what differs is finished.
        if touched.left() > WORTHWHILE * placed.left() {
            break;
        }
        placed = touched;
    }
    Ok(placed)
}

/// Plans passes across at the fixed inclination over the material that passes along have left. Passes across end in
/// steps at the faces that the tool keeps off, where passes along follow them.
pub(crate) fn fill_across<Inside: Fn(ChartPoint) -> bool + Sync>(
    cross: &FaceContext<'_, Inside>,
    before: &PlacedPasses,
) -> Result<PlacedPasses, CoverError> {
    let mut placed = before.clone();
    // A count of locations is far below 2^53.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
    let all = (REST * cross.usual_work()) as u64;
    let limits = WorkLimits { wide: 0, all };
    let mut work = 0;
    for part in &before.report.rest {
        let bounds = cross.local_range(part.uv.map(Into::into));
        let rectangle = FaceRectangle::whole(bounds, PlacementMethod::Inclined);
        let proof = SpanProof::Throughout;
        let mut planner = FacePlanner {
            context: cross,
            placed,
            work,
            limits,
            proof,
            share: 0.0,
            badly_begun: false,
        };
        planner.cover_whole(&rectangle)?;
        (placed, work) = (planner.placed, planner.work);
    }
    placed.report.work = work;
    // The material that was left before is measured again, and nothing else.
    placed.missed.clone_from(&before.missed);
    measure_rest(cross, &mut placed);
    Ok(placed)
}

/// Measures the material that the passes leave.
pub(crate) fn measure_rest<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &mut PlacedPasses,
) {
    placed.report.rest = rest(context, placed);
    placed.resolved = context.resolved(&placed.report.rest);
}

/// Finds the remaining material on lines of constant parameters, so that its cells are ranges of u and v.
fn rest<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &PlacedPasses,
) -> Vec<UncutRegion> {
    if context.chart.is_straight() || placed.missed.is_empty() {
        return context.rest(placed);
    }
    let chart = Chart::straight(FeedDirection::V);
    let region = region(context.face, &chart);
    FaceContext::new(context.request(), chart, &region).rest(placed)
}
