//! Short passes over spots that the passes of a face leave although the tool fits there.
//!
//! A pass of a chart runs from edge to edge, at few inclinations. Beside an obstacle or at the end of a strip it leaves
//! spots that another inclination reaches. Here the contact goes from spot to spot, and at each of them the tool is
//! inclined as it fits: square to the nearest other face, or as near to the inclination before as it can.

use crate::cover::layout::region::ChartPoint;
use crate::cover::options::lever;
use crate::cover::place::context::FaceContext;
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::place::spots::{SPACING, Spot, chains, deepest_spots, spot_cubes};
use crate::cover::place::tool_fit::{ContactPoint, PoseOrder, PoseSearch, fitting_pose_near};
use crate::cover::prove::sweep::PassSweep;
use crate::math::angle::angle_between;
use crate::positioning::ToleranceBand;
use crate::types::{Pass, Station, ToolPose, UncutReason, UncutRegion};
use rayon::prelude::*;

/// Spots of a face at most; what is left beyond them is left to passes across.
const MOST: usize = 4000;

/// Turn of the tool from spot to spot at which a pass ends \[rad\].
const TURN: f64 = 0.3;

/// Length of a pass that touches a single spot, in widths of a narrow strip.
const SINGLE: f64 = 0.1;

/// Spots of one pass, for an estimate: where they are many, the tool turns and is lifted often.
const SPOTS_OF_PASS: f64 = 2.0;

/// Number of times that stations are added between those of a pass that comes too deep.
const DENSER: u32 = 3;

/// Share of the band by which the tool is raised at most.
const RAISED: f64 = 0.5;

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
            runs.flat_map(|stations| planner.proven_passes(&stations))
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

/// Returns the height by which the tool may be raised \[mm\].
pub(crate) fn room<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
) -> f64 {
    let ToleranceBand { lower, upper } = context.options.band;
    RAISED * (upper - lower)
}

/// A pass over spots, with its curve.
pub(crate) struct SpotPass {
    pub(crate) pass: Pass,
    sweep: PassSweep,
}

/// Splits stations to runs between which the tool is lifted: where it does not fit, or has to turn.
pub(crate) fn split(stations: &[Option<Station>]) -> Vec<Vec<Station>> {
    let turns = |a: &Option<Station>, b: &Option<Station>| match (a, b) {
        (Some(a), Some(b)) => angle_between(&a.pose.axis, &b.pose.axis) > TURN,
        _ => true,
    };
    let runs = stations.chunk_by(|a, b| !turns(a, b));
    let run = |run: &[Option<Station>]| run.iter().copied().flatten().collect::<Vec<_>>();
    runs.map(run).filter(|run| !run.is_empty()).collect()
}

/// Planner of the passes over a chain of spots.
pub(crate) struct ChainPlanner<'a, 'b, Inside> {
    pub(crate) context: &'a FaceContext<'b, Inside>,
    pub(crate) order: PoseOrder,
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> ChainPlanner<'_, '_, Inside> {
    /// Returns the search of a pose after another.
    fn search(&self, before: Option<ToolPose>) -> PoseSearch {
        PoseSearch { room: room(self.context), before, order: self.order }
    }

    /// Returns the stations over a chain of spots; `None` where the tool does not fit.
    fn stations(&self, chain: &[Spot]) -> Vec<Option<Station>> {
        let mut before: Option<Station> = None;
        let station = |spot: &Spot| {
            before = self.station(spot.uv, before.map(|station| station.pose));
            before
        };
        chain.iter().map(station).collect()
    }

    /// Returns the station at a point of the face, after a pose; `None` where the tool does not fit.
    pub(crate) fn station(&self, uv: [f64; 2], before: Option<ToolPose>) -> Option<Station> {
        let contact = ContactPoint::new(self.context.face, uv)?;
        let (keep_off, cutter) = (self.context.keep_off().rough(), self.context.setup.cutter);
        let pose = fitting_pose_near(&keep_off, &contact, cutter, self.search(before))?;
        Some(Station { pose, contact: contact.point })
    }

    /// Returns the pass through stations if the tool keeps off all faces on it, with more stations between them where that
    /// helps, or else passes through its halves.
    pub(crate) fn proven_passes(&self, stations: &[Station]) -> Vec<SpotPass> {
        let mut dense = match *stations {
            [single] => match self.beside(single) {
                Some(next) => vec![single, next],
                None => return Vec::new(),
            },
            _ => stations.to_vec(),
        };
        for _ in 0..=DENSER {
            let sweep = PassSweep::through(&dense, lever(self.context.setup.cutter));
            if self.context.keeps_off(&sweep) {
                return vec![SpotPass {
                    pass: self.context.whole_pass(dense, self.context.narrow()),
                    sweep,
                }];
            }
            // On a face that bulges, the tool cuts the corner between stations far apart.
            let Some(more) = self.denser(&dense) else { break };
            dense = more;
        }
        if stations.len() <= 2 {
            return Vec::new();
        }
        let (first, last) = stations.split_at(stations.len() / 2);
        [first, last].into_iter().flat_map(|part| self.proven_passes(part)).collect()
    }

    /// Returns stations with another one in the middle of each span; `None` where the tool does not fit there, or has to
    /// turn.
    fn denser(&self, stations: &[Station]) -> Option<Vec<Station>> {
        let mut denser = vec![*stations.first()?];
        for pair in stations.windows(2) {
            let middle = nalgebra::center(&pair[0].contact, &pair[1].contact);
            let foot = self.context.face.closest(&middle).ok()?;
            denser.push(self.near(foot.uv.into(), &pair[0])?);
            denser.push(pair[1]);
        }
        Some(denser)
    }

    /// Returns a station a little beside another: a pass needs two.
    fn beside(&self, station: Station) -> Option<Station> {
        let face = self.context.face.face();
        let uv: [f64; 2] = self.context.face.closest(&station.contact).ok()?.uv.into();
        let jet = face.surface.jet1(uv[0], uv[1]);
        // Near a pole only one of the parameters moves the point.
        let paces = [jet.su.norm(), jet.sv.norm()];
        let k = usize::from(paces[1] > paces[0]);
        let by = SINGLE * self.context.narrow() / paces[k].max(f64::MIN_POSITIVE);
        let mut to = uv;
        // Away from the nearer end of the range.
        to[k] += if uv[k] > face.bounds()[k].middle() { -by } else { by };
        self.near(to, &station)
    }

    /// Returns the station at a point of the face with about the inclination of another.
    fn near(&self, uv: [f64; 2], other: &Station) -> Option<Station> {
        let station = self.station(uv, Some(other.pose))?;
        (angle_between(&station.pose.axis, &other.pose.axis) <= TURN).then_some(station)
    }
}
