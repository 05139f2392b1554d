//! Passes over the regions of a face that an operation before has left.

use crate::cover::error::CoverError;
use crate::cover::layout::advance::ball_strip_width;
use crate::cover::layout::cell_grid::{CellGrid, region_without};
use crate::cover::layout::chart::Chart;
use crate::cover::layout::region::ChartPoint;
use crate::cover::pattern::FeedDirection;
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::finish::{
    LeftWithinReach, add_rows, fill_across, is_left, measure_rest, touch_up_rounds,
};
use crate::cover::place::placed::PlacedPasses;
use crate::cover::place::unreachable::unreachable_cells;
use crate::cover::prove::face_cell::FaceCell;
use crate::cover::prove::face_tree::edge;
use crate::cover::report::{FaceLayout, LayoutCost};
use crate::types::{Interval, UncutRegion};
use rayon::prelude::*;
use std::sync::Arc;

/// Size of the cells that are finished or not, as a share of a narrow strip.
const CELL: f64 = 0.25;

/// Fewest and most cells of a face each way.
const CELLS: [usize; 2] = [16, 256];

/// Share of the parts that rows along corners may leave, up to which the rest is finished spot by spot.
const MOSTLY: f64 = 0.2;

/// Plans passes over the parts of a face that are left, and over nothing else.
///
/// Their height is at most what it was before, even where no pass comes near.
pub(crate) fn cover_leftover(
    request: &FaceRequest<'_>,
    parts: &[&UncutRegion],
) -> Result<PlacedPasses, CoverError> {
    let progress = request.progress;
    let finished = finished_cells(request, parts).map(Arc::new);
    // Step 1: rows along sharp corners. Lines through the strips beside them would have the tool turn and lift.
    let chart = Chart::straight(FeedDirection::U);
    let region = region_without(request.face, &chart, finished.as_ref());
    let context = FaceContext::new(*request, chart, &region);
    let mut before = untouched(&context, parts);
    if !request.setup.cutter.is_barrel() && is_left(&before) {
        let left = LeftWithinReach::of(&context, &before);
        if add_rows(&context, &mut before, left)
            && LeftWithinReach::of(&context, &before).area <= MOSTLY * left.area
        {
            before = touch_up_rounds(&context, before)?;
            return Ok(lowered(before, parts));
        }
    }
    if !is_left(&before) {
        return Ok(lowered(before, parts));
    }
    // Step 2: lines of constant parameters, one way and the other.
    let across = |(half, direction): ([f64; 2], FeedDirection)| {
        let chart = Chart::straight(direction);
        let region = region_without(request.face, &chart, finished.as_ref());
        let half = FaceRequest { progress: progress.within(half), ..*request };
        let context = FaceContext::new(half, chart.clone(), &region);
        (fill_across(&context, &before), chart)
    };
    let both = [([0.0, 0.5], FeedDirection::U), ([0.5, 1.0], FeedDirection::V)];
    let both: Vec<_> = both.into_par_iter().map(across).collect();
    let mut tried: Vec<PlacedPasses> = Vec::new();
    let mut charts: Vec<Chart> = Vec::new();
    for (result, chart) in both {
        match result {
            Ok(placed) => {
                tried.push(placed);
                charts.push(chart);
            }
            Err(CoverError::Cancelled(cancelled)) => return Err(cancelled.into()),
            // Lines that end in a point, as at a pole, cannot be followed: those across can.
            Err(_) => {}
        }
    }
    let Some(best) = PlacedPasses::best(tried.iter()) else { return Ok(lowered(before, parts)) };
    let mut costs: Vec<LayoutCost> =
        tried.iter().zip(&charts).map(|(placed, chart)| placed.cost_on(chart)).collect();
    let planned = costs.remove(best);
    let (mut placed, chart) = (tried.swap_remove(best), charts.swap_remove(best));
    // Step 3: spots that passes from edge to edge have left.
    let region = region_without(request.face, &chart, finished.as_ref());
    let context = FaceContext::new(*request, chart, &region);
    placed = touch_up_rounds(&context, placed)?;
    let (number, layout) = (request.face.face().number, planned.layout);
    placed.report.layouts = vec![FaceLayout { face: number, layout, planned, others: costs }];
    progress.report(1.0)?;
    Ok(lowered(placed, parts))
}

/// Returns the parts as this cutter finds them: how much of them it may finish, and why not the others.
fn untouched<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    parts: &[&UncutRegion],
) -> PlacedPasses {
    let mut placed = PlacedPasses::new();
    let ranges = |part: &&UncutRegion| part.cells.iter().map(|cell| cell.map(Into::into)).collect();
    placed.missed = parts.iter().flat_map(|part| -> Vec<[[f64; 2]; 2]> { ranges(part) }).collect();
    placed.report.area = parts.iter().map(|part| part.area).sum();
    measure_rest(context, &mut placed);
    placed
}

/// Lowers the heights to those that were left before.
pub(crate) fn lowered(mut placed: PlacedPasses, parts: &[&UncutRegion]) -> PlacedPasses {
    for rest in &mut placed.report.rest {
        let over = |part: &&&UncutRegion| (0..2).all(|k| meet(part.uv[k], rest.uv[k]));
        let before = parts.iter().filter(over).map(|part| part.depth).reduce(f64::max);
        rest.depth = before.map_or(rest.depth, |before| rest.depth.min(before));
    }
    placed
}

fn meet(a: Interval, b: Interval) -> bool {
    a.low <= b.high && b.low <= a.high
}

/// Returns the cells of a face that hold nothing of the parts, or that no pass finishes.
fn finished_cells(request: &FaceRequest<'_>, parts: &[&UncutRegion]) -> Option<CellGrid> {
    let FaceRequest { face, setup, options, .. } = *request;
    let bounds = face.face().bounds();
    let size = CELL * ball_strip_width(setup.cutter, options);
    let at = |[u, v]: ChartPoint| face.face().point(u, v);
    let whole = FaceCell::new(bounds.map(Interval::ends), &at);
    let counts = [0, 1].map(|k| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        let count = (whole.extent(k) / size).ceil().min(CELLS[1] as f64) as usize;
        count.clamp(CELLS[0], CELLS[1])
    });
    // Step 1: mark the cells that the parts touch.
    let mut open = vec![false; counts[0] * counts[1]];
    for cell in parts.iter().flat_map(|part| &part.cells) {
        let [us, vs] = [0, 1].map(|k| indices(bounds[k], counts[k], cell[k]));
        for i in us {
            for j in vs.clone() {
                open[i * counts[1] + j] = true;
            }
        }
    }
    // Step 2: all others are left out, and those that no pass finishes.
    let unreachable = unreachable_cells(face, &setup, options);
    let middle = |k: usize, i: usize| edge(bounds[k].ends(), (i as f64 + 0.5) / counts[k] as f64);
    let is_beyond = |[i, j]: [usize; 2]| {
        unreachable.as_ref().is_some_and(|out| out.holds([middle(0, i), middle(1, j)]))
    };
    CellGrid::new(face, counts, |[i, j]| !open[i * counts[1] + j] || is_beyond([i, j]))
}

/// Returns the cells of a line of `count` that a range touches.
fn indices(whole: Interval, count: usize, range: Interval) -> std::ops::RangeInclusive<usize> {
    let index = |value: f64| {
        let share = ((value - whole.low) / whole.width()).clamp(0.0, 1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to count")]
        let index = (share * count as f64) as usize;
        index.min(count - 1)
    };
    index(range.low)..=index(range.high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_touches_the_cells_it_enters() {
        let range = |low, high| Interval::new(low, high);
        assert_eq!(indices(range(0.0, 10.0), 10, range(2.5, 4.5)), 2..=4);
        assert_eq!(indices(range(0.0, 10.0), 10, range(-3.0, 0.5)), 0..=0);
        assert_eq!(indices(range(0.0, 10.0), 10, range(9.5, 12.0)), 9..=9);
    }
}
