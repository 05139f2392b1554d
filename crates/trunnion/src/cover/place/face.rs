//! All passes over one face.

use crate::cover::error::CoverError;
use crate::cover::layout::cell_grid::{CellGrid, region_without};
use crate::cover::layout::chart::Chart;
use crate::cover::layout::choose::{ChosenLayouts, WantedPart, choose};
use crate::cover::layout::region::ChartPoint;
use crate::cover::layout::trims::region;
use crate::cover::options::CoverOptions;
use crate::cover::pattern::{FeedDirection, PlacementMethod, PrismaticUse};
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::finish::{REST, finish, is_left, leaves_little, measure_rest};
use crate::cover::place::fixed_axis::fixed_axis_passes;
use crate::cover::place::flank::flank_passes;
use crate::cover::place::floor::floor_passes;
use crate::cover::place::placed::PlacedPasses;
use crate::cover::place::planner::{FacePlanner, FaceRectangle, WorkLimits};
use crate::cover::place::trim::SpanProof;
use crate::cover::place::unreachable::unreachable_cells;
use crate::cover::report::{
    CoverReport, FaceLayout, GivenUp, LayoutCost, PassFallback, PassLayout,
};
use crate::positioning::{ContactSide, ToolInclination};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Plans all passes over one face.
///
/// Where either side of the cutter may cut, the side that takes less over the whole face is used: passes that change
/// sides from point to point would have to turn the tool over. So is the side to which a barrel is inclined.
pub(crate) fn cover_face(request: &FaceRequest<'_>) -> Result<PlacedPasses, CoverError> {
    if request.options.prismatic == PrismaticUse::WallsAndFloors
        && let Some(placed) = prismatic(request)?
    {
        request.progress.report(1.0)?;
        return Ok(placed);
    }
    if request.options.prismatic == PrismaticUse::Flank {
        let face = request.face.face().number;
        let placed = flank_passes(*request).map_err(|why| CoverError::NoFlank { face, why })?;
        request.progress.report(1.0)?;
        return Ok(with_layout(placed, face, PassLayout::Flank));
    }
    let options = *request.options;
    let sides = if request.setup.cutter.is_barrel() && options.lean.towards.is_none() {
        [FRAC_PI_2, -FRAC_PI_2].map(|towards| CoverOptions {
            lean: ToolInclination { towards: Some(towards), ..options.lean },
            side: ContactSide::Ahead,
            ..options
        })
    } else if options.side == ContactSide::Either {
        [ContactSide::Ahead, ContactSide::Behind].map(|side| CoverOptions { side, ..options })
    } else {
        return on_side(request, SpanProof::Throughout, None).map(|plan| plan.placed);
    };
    // Step 1: plans on both sides, proven halfway between stations only.
    let on = |options: &CoverOptions, part: [f64; 2]| {
        let progress = request.progress.within(part);
        on_side(&FaceRequest { options, progress, ..*request }, SpanProof::Middle, None)
    };
    let [half, most] = [0.5 * COMPARED, COMPARED];
    let plans = [on(&sides[0], [0.0, half]), on(&sides[1], [half, most])];
    let (plan, options) = match plans {
        [Ok(ahead), Ok(behind)] => {
            // Compared over the whole face, as the passes of both sides do not fit together.
            let best = PlacedPasses::best([&ahead.placed, &behind.placed].into_iter());
            if best == Some(1) { (behind, &sides[1]) } else { (ahead, &sides[0]) }
        }
        [_, Err(CoverError::Cancelled(cancelled))] => return Err(cancelled.into()),
        [Err(_), Ok(behind)] => (behind, &sides[1]),
        [ahead, _] => (ahead?, &sides[0]),
    };
    if plan.proof == SpanProof::Throughout {
        return Ok(plan.placed);
    }
    // Step 2: the better one once more, with all of the proof.
    let progress = request.progress.within([COMPARED, 1.0]);
    let proven = FaceRequest { options, progress, ..*request };
    on_side(&proven, SpanProof::Throughout, Some(plan)).map(|plan| plan.placed)
}

/// Share of the time of a face that plans take which are compared; the rest is for the best of them, once more.
const COMPARED: f64 = 0.6;

/// Share of a face that a flank or floor pass has to finish: of less, strips are planned over all of it.
const PRISMATIC: f64 = 0.5;

/// Plans the flank passes of a wall, the passes of a floor or those with an axis that holds still, and passes across what
/// they leave; `None` where they finish too little.
fn prismatic(request: &FaceRequest<'_>) -> Result<Option<PlacedPasses>, CoverError> {
    let enough = |placed: &PlacedPasses| placed.left() <= (1.0 - PRISMATIC) * placed.report.area;
    let flank = || flank_passes(*request).ok().filter(enough).map(|p| (p, PassLayout::Flank));
    let floor = || floor_passes(*request).filter(enough).map(|p| (p, PassLayout::Floor));
    let fixed = || fixed_axis_passes(*request).filter(enough).map(|p| (p, PassLayout::FixedAxis));
    let Some((mut placed, layout)) = flank().or_else(floor).or_else(fixed) else { return Ok(None) };
    let face = request.face;
    let number = face.face().number;
    placed = with_layout(placed, number, layout);
    let mut work = 0;
    // Where the corner of the cutter does not fit, no inclination helps.
    if is_left(&placed) {
        let chart = Chart::straight(FeedDirection::U);
        let region = region(face, &chart);
        let cross = FaceContext::new(*request, chart, &region);
        placed = finish(&cross, placed)?;
        work = placed.report.work;
    }
    placed.report.work = work;
    Ok(Some(placed))
}

/// Enters the layout of passes over a face into their report.
fn with_layout(mut placed: PlacedPasses, face: usize, layout: PassLayout) -> PlacedPasses {
    let planned = LayoutCost { layout, cost: placed.price(), rest: placed.left() };
    placed.report.layouts = vec![FaceLayout { face, layout, planned, others: Vec::new() }];
    placed
}

/// Plan of a face on one side of the cutter.
struct SidePlan {
    placed: PlacedPasses,
    /// Extent of its proof. Plans of which one is chosen are proven after that.
    proof: SpanProof,
    /// Chart of its passes; `None` without any.
    chart: Option<Chart>,
    /// Cells that the cutter does not reach.
    unreachable: Option<Arc<CellGrid>>,
}

/// Plans the face on each of the most promising charts, and returns the best result; or anew on the chart of a plan before.
///
/// The plan is proven as far as asked, or throughout.
fn on_side(
    request: &FaceRequest<'_>,
    proof: SpanProof,
    before: Option<SidePlan>,
) -> Result<SidePlan, CoverError> {
    let FaceRequest { face, setup, options, progress } = *request;
    let (unreachable, charts, mut work, layouts) = if let Some(before) = before {
        let SidePlan { placed, chart, unreachable, .. } = before;
        let CoverReport { work, layouts, .. } = placed.report;
        (unreachable, chart.into_iter().collect(), work, layouts)
    } else {
        let unreachable = unreachable_cells(face, &setup, options).map(Arc::new);
        let part = WantedPart { face, without: unreachable.as_deref() };
        let ChosenLayouts { charts, work } = choose(part, setup.cutter, options);
        (unreachable, charts, work, Vec::new())
    };
    let share = 1.0 / charts.len().max(1) as f64;
    // At a fixed inclination the first chart is nearly always the only one.
    let compared = options.method == PlacementMethod::Widest && charts.len() > 1;
    let tried_proof = if compared { SpanProof::Middle } else { proof };
    let [trying, again] =
        if tried_proof == proof { [[0.0, 1.0]; 2] } else { [[0.0, COMPARED], [COMPARED, 1.0]] };
    let trying = progress.within(trying);

    // Step 1: each chart in earnest, as long as the work for wide strips lasts.
    let mut tried: Vec<PlacedPasses> = Vec::new();
    let mut tried_charts: Vec<Chart> = Vec::new();
    let mut refused = None;
    let mut badly_begun = None;
    for (i, chart) in charts.into_iter().enumerate() {
        let part = [i, i + 1].map(|i| share * i as f64);
        let request = FaceRequest { progress: trying.within(part), ..*request };
        let region = region_without(face, &chart, unreachable.as_ref());
        let context = FaceContext::new(request, chart.clone(), &region);
        let limits = work_limits(&context);
        // At a fixed inclination all strips are alike: the estimate that put the first chart first is good, but for what
        // the tool does not get to along it.
        let is_done = match options.method {
            PlacementMethod::Inclined => {
                work > limits.all || tried.iter().any(|placed| leaves_little(&context, placed))
            }
            PlacementMethod::Widest => work > limits.wide,
        };
        if !tried.is_empty() && is_done {
            break;
        }
        match on_chart(&context, unreachable.as_deref(), limits, tried_proof) {
            Ok(ChartPlan { placed, badly_begun: false }) => {
                work += placed.report.work;
                tried.push(placed);
                tried_charts.push(chart);
            }
            // No other chart has much work left for wide strips.
            Ok(ChartPlan { placed, .. }) => {
                work += placed.report.work;
                badly_begun = tried.is_empty().then(|| context.fallback_everywhere());
                break;
            }
            Err(CoverError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    trying.report(1.0)?;
    if let Some(fallback) = badly_begun {
        return at_fixed_inclination(request, fallback, work);
    }

    // Step 2: the best of them, or the first error.
    let Some(index) = PlacedPasses::best(tried.iter()) else {
        let none = SidePlan { placed: PlacedPasses::new(), proof, chart: None, unreachable };
        return refused.map_or(Ok(none), Err);
    };
    let mut costs: Vec<LayoutCost> =
        tried.iter().zip(&tried_charts).map(|(placed, chart)| placed.cost_on(chart)).collect();
    let planned = costs.remove(index);
    let (mut best, chart) = (tried.swap_remove(index), tried_charts.swap_remove(index));
    let (number, layout) = (face.face().number, planned.layout);
    costs.extend(layouts.into_iter().flat_map(|layout| layout.others));
    best.report.layouts = vec![FaceLayout { face: number, layout, planned, others: costs }];
    best.report.work = work;
    if tried_proof != proof {
        let before = SidePlan { placed: best, proof: tried_proof, chart: Some(chart), unreachable };
        let progress = progress.within(again);
        return on_side(&FaceRequest { progress, ..*request }, proof, Some(before));
    }

    // Step 3: further passes over the remaining material.
    if !best.report.rest.is_empty() {
        let crossed = chart.crossed();
        let region = region_without(face, &crossed, unreachable.as_ref());
        let request = FaceRequest { progress: progress.within([1.0; 2]), ..*request };
        let cross = FaceContext::new(request, crossed, &region);
        best.report.work = 0;
        best = finish(&cross, best)?;
        best.report.work += work;
    }
    Ok(SidePlan { placed: best, proof, chart: Some(chart), unreachable })
}

/// Plans a face anew at the fixed inclination, after wide strips on it took some work.
fn at_fixed_inclination(
    request: &FaceRequest<'_>,
    fallback: PassFallback,
    work: u64,
) -> Result<SidePlan, CoverError> {
    let options = CoverOptions { method: PlacementMethod::Inclined, ..*request.options };
    let progress = request.progress.within([1.0; 2]);
    let request = FaceRequest { options: &options, progress, ..*request };
    let mut plan = on_side(&request, SpanProof::Throughout, None)?;
    let report = &mut plan.placed.report;
    report.work += work;
    report.given_up = Some(GivenUp { face: fallback.face, uv: fallback.at, share: 0.0 });
    report.fallbacks.push(fallback);
    Ok(plan)
}

/// Passes over a face on one chart.
struct ChartPlan {
    placed: PlacedPasses,
    /// `true` if wide strips have used up their work over a small part of the face, or are narrow: the passes end there.
    badly_begun: bool,
}

/// Plans all passes on one chart.
fn on_chart<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    unreachable: Option<&CellGrid>,
    limits: WorkLimits,
    proof: SpanProof,
) -> Result<ChartPlan, CoverError> {
    let rectangle = FaceRectangle::whole(context.whole.bounds, context.options.method);
    let mut placed = PlacedPasses::new();
    placed.missed = unreachable.map_or_else(Vec::new, CellGrid::ranges);
    let mut planner =
        FacePlanner { context, placed, work: 0, limits, proof, share: 0.0, badly_begun: false };
    planner.cover_whole(&rectangle)?;
    let badly_begun = planner.badly_begun;
    let mut placed = planner.placed;
    placed.report.work = planner.work;
    if !badly_begun {
        measure_rest(context, &mut placed);
        placed.report.area = context.area();
    }
    Ok(ChartPlan { placed, badly_begun })
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
