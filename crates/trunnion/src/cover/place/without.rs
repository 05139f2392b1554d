//! Passes over a face without some of them, with what the others leave.

use crate::cover::layout::chart::Chart;
use crate::cover::layout::trims::region;
use crate::cover::options::lever;
use crate::cover::pattern::FeedDirection;
use crate::cover::place::context::{FaceContext, FaceRequest};
use crate::cover::place::finish::measure_rest;
use crate::cover::place::leftover::lowered;
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::prove::sweep::PassSweep;
use crate::types::{Interval, Pass, UncutRegion};

/// Measures what passes over a face leave of it, or of the parts of it that were left before.
pub(crate) fn left_by(
    request: &FaceRequest<'_>,
    passes: &[&Pass],
    parts: Option<&[&UncutRegion]>,
) -> PlacedPasses {
    let chart = Chart::straight(FeedDirection::V);
    let region = region(request.face, &chart);
    let context = FaceContext::new(*request, chart, &region);
    let (face, options, cost) = (request.face.face().number, request.options, request.setup.cost);
    let source = PassSource { face, chart: &context.chart, options, cost };
    let mut placed = PlacedPasses::new();
    for pass in passes {
        let sweep = PassSweep::through(&pass.stations, lever(request.setup.cutter));
        placed.add_whole((*pass).clone(), sweep, source);
    }
    let Some(parts) = parts else {
        context.measure_whole(&mut placed);
        return placed;
    };
    placed.missed = parts
        .iter()
        .flat_map(|part| part.cells.iter().map(|cell| cell.map(Interval::ends)))
        .collect();
    measure_rest(&context, &mut placed);
    lowered(placed, parts)
}
