//! Short passes over spots that the passes of a face leave although the tool fits there.
//!
//! A pass of a chart runs from edge to edge, at few inclinations. Beside an obstacle or at the end of a strip it leaves
//! spots that another inclination reaches. Here the contact goes from spot to spot, and at each of them the tool is
//! inclined as it fits: square to the nearest other face, or as near to the inclination before as it can.

use crate::cover::layout::region::ChartPoint;
use crate::cover::place::chain_planner::{ChainPlanner, SpotPass, split};
use crate::cover::place::context::FaceContext;
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::place::spots::{SPACING, chains, deepest_spots, spot_cubes};
use crate::cover::place::tool_fit::PoseOrder;
use crate::cover::prove::sweep::PassSweep;
use crate::types::{UncutReason, UncutRegion};
use rayon::prelude::*;

/// Spots of a face at most; what is left beyond them is left to passes across.
const MOST: usize = 4000;

/// Spots of one pass, for an estimate: where they are many, the tool turns and is lifted often.
const SPOTS_OF_PASS: f64 = 2.0;

/// Returns `true` for a region where the tool fits as far as is known, or goes into a neighbouring face that it may be
/// raised over.
pub(crate) fn may_fit(part: &UncutRegion) -> bool {
    part.reason != UncutReason::Hollow
}

/// Region that is left, and the poses that are tried first there.
pub(crate) struct OpenRegion {
    pub(crate) part: UncutRegion,
    pub(crate) order: PoseOrder,
}

/// Plans short passes over each of some regions that `placed` leaves; `None` for those beyond the spots of a face.
pub(crate) fn touch_up<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &PlacedPasses,
    open: &[OpenRegion],
) -> Vec<Option<Vec<SpotPass>>> {
    let mut room = MOST;
    let sweeps: Vec<&PassSweep> = placed.sweeps().collect();
    let region = context.whole.complete();
    let swept = context.coverage(&region, &sweeps);
    let passes = |OpenRegion { part, order }: &OpenRegion| {
        let cubes = spot_cubes(context, part);
        room = room.checked_sub(cubes.len())?;
        let spots = deepest_spots(context, &cubes, &swept);
        let chains = chains(spots, SPACING * context.narrow()).into_par_iter();
        let planner = ChainPlanner { context, order: *order };
        let passes = chains.flat_map_iter(|chain| {
            let runs = split(&planner.stations(&chain)).into_iter();
            runs.flat_map(|stations| planner.proven_passes(stations))
        });
        Some(passes.collect())
    };
    open.iter().map(passes).collect()
}

/// Estimates the price of short passes over a number of spots, as a length \[mm\]: that of links to the spots.
pub(crate) fn spots_price<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &PlacedPasses,
    spots: usize,
) -> f64 {
    let Some(station) = placed.passes.first().and_then(|pass| pass.stations.first()) else {
        return 0.0;
    };
    let cost = context.setup.cost;
    spots as f64 / SPOTS_OF_PASS * cost.link(station, station) * cost.feed()
}

/// Adds short passes to those that are placed; what they leave is not measured.
pub(crate) fn add_passes<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    placed: &mut PlacedPasses,
    passes: &[SpotPass],
) {
    let (chart, options, cost) = (&context.chart, context.options, context.setup.cost);
    let source = PassSource { face: context.face.face().number, chart, options, cost };
    for SpotPass { pass, sweep } in passes {
        placed.add_whole(pass.clone(), sweep.clone(), source);
    }
}
