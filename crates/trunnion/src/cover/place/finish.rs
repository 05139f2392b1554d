//! Passes over what the passes of a face have left, and the measure of it.

use crate::cover::error::CoverError;
use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cover::layout::trims::region;
use crate::cover::pattern::{FeedDirection, PlacementMethod};
use crate::cover::place::chain_planner::{SpotPass, room};
use crate::cover::place::context::FaceContext;
use crate::cover::place::corner_rows::corner_rows;
use crate::cover::place::placed::PlacedPasses;
use crate::cover::place::planner::{FacePlanner, FaceRectangle, WorkLimits};
use crate::cover::place::spots::spot_areas;
use crate::cover::place::tool_fit::{ContactGap, ContactPoint, PoseOrder, keeps_off_others};
use crate::cover::place::touch_up::{OpenRegion, add_passes, may_fit, spots_price, touch_up};
use crate::cover::place::trim::SpanProof;
use crate::types::{Interval, UncutRegion};
use rayon::prelude::*;

/// Work, over that of passes at the fixed inclination, after which these are given up as well: several times what they
/// should take, as where the tool has to keep off something many inclinations are tried.
pub(crate) const REST: f64 = 10.0;

/// Share of a face up to which what is left is finished spot by spot.
pub(crate) const SPOTS: f64 = 0.02;

/// Estimated price of short passes over what is left, over that of the passes before, up to which no other layout is tried.
const CHEAP: f64 = 0.1;

/// Rounds of short passes: each is over what the round before has left.
const TOUCH_UPS: u32 = 10;

/// Share of a region that its passes finish, from which on they are kept and more of them tried.
const WORTHWHILE: f64 = 0.1;

/// The same as a share of what passes of that length may finish.
const EFFICIENT: f64 = 0.25;

/// Returns `true` if passes have left material that the tool may finish.
pub(crate) fn is_left(placed: &PlacedPasses) -> bool {
    placed.report.rest.iter().any(may_fit)
}

/// Returns `true` if passes leave so little within reach that short passes over it take a small part of their time.
pub(crate) fn leaves_little<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &PlacedPasses,
) -> bool {
    is_little(context, placed, LeftWithinReach::of(context, placed))
}

/// Returns `true` if short passes over `left`, what passes leave within reach, take a small part of their time.
fn is_little<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &PlacedPasses,
    left: LeftWithinReach,
) -> bool {
    left.area <= SPOTS * placed.report.area
        && spots_price(context, placed, left.spots) <= CHEAP * placed.price()
}

/// Finishes the material that passes have left: spots by short passes, larger regions by rows along corners, or passes across
/// first.
pub(crate) fn finish<Inside: Fn(ChartPoint) -> bool + Sync>(
    cross: &FaceContext<'_, Inside>,
    mut placed: PlacedPasses,
) -> Result<PlacedPasses, CoverError> {
    let mut left = LeftWithinReach::of(cross, &placed);
    // Passes beside a corner end up to an advance before it: a row along it is one pass, passes across are many.
    if cross.setup.cutter.has_ball_tip() && is_left(&placed) && add_rows(cross, &mut placed, left) {
        left = LeftWithinReach::of(cross, &placed);
    }
    if !is_little(cross, &placed, left) {
        let filled = fill_across(cross, &placed)?;
        if placed.leaves_more(&filled) {
            placed = filled;
        }
    }
    touch_up_rounds(cross, placed)
}

/// Adds rows along corners beside which passes leave material, `left` of it within reach, and returns `true` if they are worth
/// their length; if not, they are left out.
pub(crate) fn add_rows<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &mut PlacedPasses,
    left: LeftWithinReach,
) -> bool {
    let fitting: Vec<&UncutRegion> =
        placed.report.rest.iter().filter(|part| may_fit(part)).collect();
    let rows = corner_rows(context, &fitting);
    if rows.is_empty() {
        return false;
    }
    let mut with_rows = placed.clone();
    add_passes(context, &mut with_rows, &rows);
    measure_rest(context, &mut with_rows);
    let finished = placed.left() - with_rows.left();
    let worthwhile = WORTHWHILE * left.area.min(context.narrow() * length(&rows));
    if finished < worthwhile || finished <= 0.0 {
        return false;
    }
    *placed = with_rows;
    true
}

/// Material that is left where the corner of the cutter keeps off all other faces, raised as far as it may be.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LeftWithinReach {
    /// Number of spots.
    pub(crate) spots: usize,
    /// \[mm²\]
    pub(crate) area: f64,
}

impl LeftWithinReach {
    /// Finds what passes leave within reach.
    pub(crate) fn of<Inside: Fn(ChartPoint) -> bool + Sync>(
        context: &FaceContext<'_, Inside>,
        placed: &PlacedPasses,
    ) -> Self {
        let parts = placed.report.rest.iter().map(|part| Self::in_part(context, part));
        parts.fold(Self::default(), |all, part| Self {
            spots: all.spots + part.spots,
            area: all.area + part.area,
        })
    }

    /// Finds what is within reach of one region.
    fn in_part<Inside: Fn(ChartPoint) -> bool + Sync>(
        context: &FaceContext<'_, Inside>,
        part: &UncutRegion,
    ) -> Self {
        if !may_fit(part) {
            return Self::default();
        }
        let (face, keep_off) = (context.face, context.keep_off().rough());
        let gap = ContactGap { least: keep_off.least, raised: room(context) };
        let fits = |uv: &[f64; 2]| {
            let inside = face.face().contains(uv[0], uv[1]);
            let contact = ContactPoint::new(face, *uv).filter(|_| inside);
            contact.is_some_and(|contact| {
                keeps_off_others(&keep_off, &contact, gap, context.setup.cutter.minor())
            })
        };
        let areas = spot_areas(context, part);
        let fitting = areas.par_iter().filter(|spot| spot.points.iter().any(fits));
        // Added in order, so that the sum is the same on any number of threads.
        let fitting: Vec<f64> = fitting.map(|spot| spot.area).collect();
        Self { spots: fitting.len(), area: fitting.iter().sum() }
    }
}

/// Adds short passes over regions that are left, to each as long as they finish some of it.
pub(crate) fn touch_up_rounds<Inside: Fn(ChartPoint) -> bool + Sync>(
    cross: &FaceContext<'_, Inside>,
    mut placed: PlacedPasses,
) -> Result<PlacedPasses, CoverError> {
    let first = if cross.setup.cutter.touches_in_one_point() {
        PoseOrder::AsBefore
    } else {
        PoseOrder::Square
    };
    let opened = |part: UncutRegion| OpenRegion { part, order: first };
    // Regions that the corner gets to nowhere are not touched: their measure takes long.
    let opens = |part: &UncutRegion| LeftWithinReach::in_part(cross, part).spots > 0;
    let (open, mut given_up): (Vec<_>, Vec<_>) =
        placed.report.rest.clone().into_iter().partition(opens);
    let mut open: Vec<OpenRegion> = open.into_iter().map(opened).collect();
    let before = placed.passes.len();
    for _ in 0..TOUCH_UPS {
        if open.is_empty() {
            break;
        }
        cross.progress.report(1.0)?;
        cross.progress.show(&placed);
        let passes = touch_up(cross, &placed, &open);
        let mut touched = placed.clone();
        passes.iter().flatten().for_each(|passes| add_passes(cross, &mut touched, passes));
        let parts: Vec<UncutRegion> = open.iter().map(|one| one.part.clone()).collect();
        let left = by_part(&parts, rest_within(cross, &touched, &parts));
        let mut next = Vec::new();
        let mut goes_on = false;
        for ((region, passes), left) in open.into_iter().zip(passes).zip(left) {
            let OpenRegion { part, order } = region;
            match passes {
                // No room in this round.
                None => next.push(OpenRegion { part, order }),
                Some(passes) if is_worthwhile(&part, &left, cross.narrow() * length(&passes)) => {
                    goes_on = true;
                    add_passes(cross, &mut placed, &passes);
                    let (fits, not): (Vec<_>, Vec<_>) = left.into_iter().partition(opens);
                    next.extend(fits.into_iter().map(opened));
                    given_up.extend(not);
                }
                Some(_) if order == PoseOrder::Square => {
                    goes_on = true;
                    next.push(OpenRegion { part, order: PoseOrder::AsBefore });
                }
                // Regions whose passes finish hardly anything are given up: a corner that no pass gets into does not end
                // the work on the spots elsewhere.
                Some(_) => given_up.push(part),
            }
        }
        open = next;
        placed.report.rest = open.iter().map(|one| &one.part).chain(&given_up).cloned().collect();
        if !goes_on {
            break;
        }
    }
    // Which region a remainder belongs to decides only what is tried: what is left in the end is measured over all of them.
    if placed.passes.len() > before {
        measure_rest(cross, &mut placed);
    }
    Ok(placed)
}

/// Returns `true` if enough of a region is finished, or enough by passes that may finish an area of `most` \[mm²\]. Cells
/// at the rims count in full before and after: what differs is finished.
fn is_worthwhile(part: &UncutRegion, left: &[UncutRegion], most: f64) -> bool {
    let finished = part.area - left.iter().map(|part| part.area).sum::<f64>();
    finished >= (WORTHWHILE * part.area).min(EFFICIENT * most) && finished > 0.0
}

/// Returns the length of passes, by their contacts \[mm\].
fn length(passes: &[SpotPass]) -> f64 {
    let steps = passes.iter().flat_map(|one| one.pass.stations.windows(2));
    steps.map(|pair| (pair[1].contact - pair[0].contact).norm()).sum()
}

/// Distributes what is left to the regions that it was part of: the first that holds its first cell.
fn by_part(parts: &[UncutRegion], left: Vec<UncutRegion>) -> Vec<Vec<UncutRegion>> {
    let mut by_part: Vec<Vec<UncutRegion>> = parts.iter().map(|_| Vec::new()).collect();
    for one in left {
        let Some(cell) = one.cells.first() else { continue };
        let middle = cell.map(|range| range.middle());
        let holds = |cell: &[Interval; 2]| (0..2).all(|k| cell[k].contains(middle[k]));
        // Cells of a chart that is not straight overlap a little, and a middle may lie on a rim.
        let of = parts.iter().position(|part| part.cells.iter().any(holds)).or_else(|| {
            parts.iter().position(|part| (0..2).all(|k| part.uv[k].contains(middle[k])))
        });
        by_part[of.unwrap_or(0)].push(one);
    }
    by_part
}

/// Finds what passes leave of some regions.
fn rest_within<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &PlacedPasses,
    parts: &[UncutRegion],
) -> Vec<UncutRegion> {
    let ranges = |part: &UncutRegion| {
        part.cells.iter().map(|cell| cell.map(Interval::ends)).collect::<Vec<_>>()
    };
    let mut placed = placed.clone();
    placed.missed = parts.iter().flat_map(ranges).collect();
    rest(context, &placed)
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
        if LeftWithinReach::in_part(cross, part).spots == 0 {
            continue;
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::place::placed::tests::region_of_area;

    /// A region of an area \[mm²\] with cells over these ranges of u.
    fn part(area: f64, cells: &[[f64; 2]]) -> UncutRegion {
        let cell = |[low, high]: &[f64; 2]| [Interval::new(*low, *high), Interval::new(0.0, 1.0)];
        let cells: Vec<[Interval; 2]> = cells.iter().map(cell).collect();
        let u = Interval::new(cells[0][0].low, cells[cells.len() - 1][0].high);
        UncutRegion { uv: [u, Interval::new(0.0, 1.0)], cells, ..region_of_area(area) }
    }

    #[test]
    fn what_is_left_belongs_to_the_region_it_was_part_of() {
        // The second region lies within the box of the first.
        let parts = [part(3.0, &[[0.0, 1.0], [8.0, 9.0]]), part(1.0, &[[4.0, 5.0]])];
        let left =
            vec![part(0.25, &[[4.25, 4.5]]), part(0.5, &[[8.0, 8.5]]), part(0.75, &[[0.5, 1.0]])];
        let left: Vec<Vec<UncutRegion>> = by_part(&parts, left);
        let areas: Vec<f64> =
            left.iter().map(|left| left.iter().map(|one| one.area).sum()).collect();
        assert_eq!(areas, [1.25, 0.25]);
    }

    #[test]
    fn passes_are_worthwhile_for_a_tenth_of_a_region_or_by_what_they_finish() {
        let finished = |area: f64, most: f64| {
            is_worthwhile(&part(8.0, &[[0.0, 1.0]]), &[part(8.0 - area, &[[0.0, 1.0]])], most)
        };
        assert!(finished(0.875, 100.0) && !finished(0.75, 100.0));
        assert!(finished(0.5, 2.0) && !finished(0.25, 2.0));
        assert!(!finished(0.0, 0.0));
    }
}
