//! All passes over one face.

use crate::cover::error::CoverError;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::choose::{ChosenLayouts, choose};
use crate::cover::layout::region::ChartPoint;
use crate::cover::layout::trims::region;
use crate::cover::options::CoverOptions;
use crate::cover::pattern::{FeedDirection, PlacementMethod, PrismaticUse};
use crate::cover::place::context::{FaceContext, FaceRequest, ProgressFn};
use crate::cover::place::flank::flank_pass;
use crate::cover::place::floor::floor_passes;
use crate::cover::place::placed::PlacedPasses;
use crate::cover::place::planner::{FacePlanner, FaceRectangle, WorkLimits};
use crate::cover::place::touch_up::{may_fit, touch_up};
use crate::cover::place::unreachable::{UnreachableCells, within_reach};
use crate::cover::report::{Covering, FaceLayout, LayoutCost, PassLayout};
use crate::positioning::ContactSide;
use crate::types::UncutRegion;
use std::sync::Arc;

/// Work, over that of passes at the fixed inclination, after which these are given up as well: several times what they
/// should take, as where the tool has to keep off something many inclinations are tried.
const REST: f64 = 10.0;

/// Plans all passes over one face.
///
/// Where either side of the cutter may cut, the side that takes less over the whole face is used: passes that change
/// sides from point to point would have to turn the tool over.
pub(crate) fn cover_face(
    request: &FaceRequest<'_>,
    report: ProgressFn<'_>,
) -> Result<Covering, CoverError> {
    if request.options.prismatic == PrismaticUse::WallsAndFloors
        && let Some(placed) = prismatic(request)?
    {
        report(1.0)?;
        return Ok(placed.covering());
    }
    if request.options.side != ContactSide::Either {
        return Ok(on_side(request, report)?.covering());
    }
    let half = |side: ContactSide, from: f64| {
        let options = CoverOptions { side, ..*request.options };
        let sided = FaceRequest { options: &options, ..*request };
        on_side(&sided, &|share| report(from + 0.5 * share))
    };
    let ahead = half(ContactSide::Ahead, 0.0);
    let behind = half(ContactSide::Behind, 0.5);
    let best = match (ahead, behind) {
        (Ok(ahead), Ok(behind)) => {
            let tried = [ahead, behind];
            // Compared over the whole face, as the passes of both sides do not fit together.
            let best = PlacedPasses::best(tried.iter()).unwrap_or(0);
            Ok(tried.into_iter().nth(best).unwrap_or_else(PlacedPasses::new))
        }
        (_, Err(CoverError::Cancelled(cancelled))) => Err(cancelled.into()),
        (Err(_), Ok(behind)) => Ok(behind),
        (ahead, _) => ahead,
    };
    best.map(PlacedPasses::covering)
}

/// Share of a face up to which what is left is finished spot by spot.
const SPOTS: f64 = 0.02;

/// Rounds of short passes: each is over what the round before has left.
const TOUCH_UPS: u32 = 4;

/// Share of the area left after a round, over that before, at which another is tried.
const WORTHWHILE: f64 = 0.9;

/// Share of a face that a flank or floor pass has to finish: of less, strips are planned over all of it.
const PRISMATIC: f64 = 0.5;

/// Plans the flank pass of a wall or the passes of a floor, and passes across what they leave; `None` where they
/// finish too little.
fn prismatic(request: &FaceRequest<'_>) -> Result<Option<PlacedPasses>, CoverError> {
    let flank = || flank_pass(*request).map(|placed| (placed, PassLayout::Flank));
    let floor = || floor_passes(*request).map(|placed| (placed, PassLayout::Floor));
    let Some((mut placed, layout)) = flank().or_else(floor) else { return Ok(None) };
    if placed.left() > (1.0 - PRISMATIC) * placed.report.area {
        return Ok(None);
    }
    let face = request.face;
    let planned = LayoutCost { layout, cost: placed.price(), rest: placed.left() };
    let mut work = 0;
    // Where the corner of the cutter does not fit, no inclination helps.
    if is_left(&placed, request.options) {
        let chart = Chart::straight(FeedDirection::U);
        let region = region(face, &chart);
        let silent = |_: f64| Ok(());
        let cross = FaceContext::new(*request, chart, &region, &silent);
        placed = finish(&cross, placed)?;
        work = placed.report.work;
    }
    let number = face.face().number;
    placed.report.layouts = vec![FaceLayout { face: number, layout, planned, others: Vec::new() }];
    placed.report.work = work;
    Ok(Some(placed))
}

/// Plans the face on each of the most promising charts, and returns the best result.
fn on_side(request: &FaceRequest<'_>, report: ProgressFn<'_>) -> Result<PlacedPasses, CoverError> {
    let FaceRequest { face, setup, options } = *request;
    let ChosenLayouts { charts, mut work } = choose(face, setup.cutter, options);
    let share = 1.0 / charts.len().max(1) as f64;
    let unreachable = UnreachableCells::of(face, setup.cutter, setup.cost).map(Arc::new);

    // Step 1: each chart in earnest, as long as the work for wide strips lasts.
    let mut tried: Vec<PlacedPasses> = Vec::new();
    let mut tried_charts: Vec<Chart> = Vec::new();
    let mut refused = None;
    for (i, chart) in charts.into_iter().enumerate() {
        let report = |done: f64| report(share * (i as f64 + done));
        let region = within_reach(face, &chart, unreachable.as_ref());
        let context = FaceContext::new(*request, chart.clone(), &region, &report);
        let limits = work_limits(&context);
        // At a fixed inclination all strips are alike: the estimate that put the first chart first is exact, but for what
        // the tool does not get to along it.
        let alike = options.method == PlacementMethod::Inclined
            && tried.iter().any(|placed| placed.left() <= SPOTS * placed.report.area);
        if !tried.is_empty() && (alike || work > limits.wide) {
            break;
        }
        match on_chart(&context, unreachable.as_deref(), limits) {
            Ok(placed) => {
                work += placed.report.work;
                tried.push(placed);
                tried_charts.push(chart);
            }
            Err(CoverError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    report(1.0)?;

    // Step 2: the best of them, or the first error.
    let Some(index) = PlacedPasses::best(tried.iter()) else {
        return refused.map_or(Ok(PlacedPasses::new()), Err);
    };
    let mut costs: Vec<LayoutCost> =
        tried.iter().zip(&tried_charts).map(|(placed, chart)| layout_cost(placed, chart)).collect();
    let planned = costs.remove(index);
    let (mut best, chart) = (tried.swap_remove(index), tried_charts.swap_remove(index));
    let (number, layout) = (face.face().number, planned.layout);
    best.report.layouts = vec![FaceLayout { face: number, layout, planned, others: costs }];

    // Step 3: further passes over the remaining material.
    if !best.report.rest.is_empty() {
        let chart = chart.crossed();
        let region = within_reach(face, &chart, unreachable.as_ref());
        let report = |_: f64| report(1.0);
        let cross = FaceContext::new(*request, chart, &region, &report);
        best.report.work = 0;
        best = finish(&cross, best)?;
        work += best.report.work;
    }
    best.report.work = work;
    Ok(best)
}

/// Returns the cost of passes on a chart.
fn layout_cost(placed: &PlacedPasses, chart: &Chart) -> LayoutCost {
    LayoutCost { layout: chart.layout(), cost: placed.price(), rest: placed.left() }
}

/// Returns `true` if passes have left material that the tool may finish.
fn is_left(placed: &PlacedPasses, options: &CoverOptions) -> bool {
    placed.report.rest.iter().any(|part| may_fit(part, options.excess))
}

/// Finishes the material that passes have left: spots by short passes, larger regions by passes across first.
fn finish<Inside: Fn(ChartPoint) -> bool + Sync>(
    cross: &FaceContext<'_, Inside>,
    mut placed: PlacedPasses,
) -> Result<PlacedPasses, CoverError> {
    if placed.left() > SPOTS * placed.report.area {
        let filled = fill_across(cross, &placed)?;
        if placed.leaves_more(&filled) {
            placed = filled;
        }
    }
    for _ in 0..TOUCH_UPS {
        if !is_left(&placed, cross.options) {
            break;
        }
        (cross.report)(1.0)?;
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
fn fill_across<Inside: Fn(ChartPoint) -> bool + Sync>(
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
        let mut planner = FacePlanner { context: cross, placed, work, limits, share: 0.0 };
        planner.cover_whole(&rectangle)?;
        (placed, work) = (planner.placed, planner.work);
    }
    placed.report.work = work;
    // The material that was left before is measured again, and nothing else.
    placed.missed.clone_from(&before.missed);
    measure_rest(cross, &mut placed);
    Ok(placed)
}

/// Plans all passes on one chart.
fn on_chart<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    unreachable: Option<&UnreachableCells>,
    limits: WorkLimits,
) -> Result<PlacedPasses, CoverError> {
    let rectangle = FaceRectangle::whole(context.whole.bounds, context.options.method);
    let mut placed = PlacedPasses::new();
    placed.missed = unreachable.map_or_else(Vec::new, UnreachableCells::ranges);
    let mut planner = FacePlanner { context, placed, work: 0, limits, share: 0.0 };
    planner.cover_whole(&rectangle)?;
    let mut placed = planner.placed;
    placed.report.work = planner.work;
    measure_rest(context, &mut placed);
    placed.report.area = context.area();
    Ok(placed)
}

/// Measures the material that the passes leave.
fn measure_rest<Inside: Fn(ChartPoint) -> bool + Sync>(
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
    FaceContext::new(context.request(), chart, &region, context.report).rest(placed)
}

/// Returns the work after which wide strips are given up, and after which everything is.
fn work_limits<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
) -> WorkLimits {
    let effort = context.options.effort;
    // A count of locations is far below 2^53, and one without end saturates.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
    let [wide, all] = [0.0, REST].map(|rest| ((effort + rest) * context.usual_work()) as u64);
    WorkLimits { wide, all }
}
