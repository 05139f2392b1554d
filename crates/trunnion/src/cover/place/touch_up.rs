//! Short passes over spots that the passes of a face leave although the tool fits there.
//!
//! A pass of a chart runs from edge to edge, at few inclinations. Beside an obstacle or at the end of a strip it leaves
//! spots that another inclination reaches. Here the contact goes from spot to spot, and at each of them the tool is
//! inclined as it fits, as near to the inclination before as it can.

use crate::cover::layout::region::ChartPoint;
use crate::cover::options::lever;
use crate::cover::place::context::FaceContext;
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::place::tool_fit::{ContactPoint, fitting_pose_near};
use crate::cover::prove::sweep::PassSweep;
use crate::math::angle::angle_between;
use crate::positioning::ToleranceBand;
use crate::types::{Interval, Pass, Station, UncutReason, UncutRegion};
use nalgebra::{Matrix3, Point3, Vector3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Distance of the spots that are touched, in widths of a narrow strip.
const SPACING: f64 = 0.7;

/// Distance over which a pass goes on to the next spot, over that of the spots.
const JOINED: f64 = 2.0;

/// Cost of a step across the long direction of a region, over one along it: passes run along.
const ACROSS: f64 = 3.0;

/// Spots of a face at most; what is left beyond them is left to passes across.
const MOST: usize = 4000;

/// Turn of the tool from spot to spot at which a pass ends \[rad\].
const TURN: f64 = 0.3;

/// Length of a pass that touches a single spot, in widths of a narrow strip.
const SINGLE: f64 = 0.1;

/// Number of times that stations are added between those of a pass that comes too deep.
const DENSER: u32 = 3;

/// Spot that is left, as a point of the face.
#[derive(Debug, Clone, Copy)]
struct Spot {
    uv: [f64; 2],
    point: Point3<f64>,
}

/// Share of the band by which the tool is raised at most.
const RAISED: f64 = 0.5;

/// Returns `true` for a region where the tool fits as far as is known, or goes into a neighbouring face that it may be
/// raised over.
pub(crate) fn may_fit(part: &UncutRegion) -> bool {
    part.reason != UncutReason::Hollow
}

/// Plans short passes over each of some regions that are left; `None` for those beyond the spots of a face.
pub(crate) fn touch_up<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    parts: &[UncutRegion],
) -> Vec<Option<Vec<SpotPass>>> {
    let mut room = MOST;
    let passes = |part: &UncutRegion| {
        let spots = spots(context, part);
        room = room.checked_sub(spots.len())?;
        let chains = chains(spots, SPACING * context.narrow()).into_par_iter();
        let passes = chains.flat_map_iter(|chain| {
            let runs = runs(context, &chain).into_iter();
            runs.flat_map(|stations| proven_passes(context, &stations))
        });
        Some(passes.collect())
    };
    parts.iter().map(passes).collect()
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
fn room<Inside: Fn(ChartPoint) -> bool + Sync>(context: &FaceContext<'_, Inside>) -> f64 {
    let ToleranceBand { lower, upper } = context.options.band;
    RAISED * (upper - lower)
}

/// Returns points of a region about [`SPACING`] apart.
fn spots<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    part: &UncutRegion,
) -> Vec<Spot> {
    let face = context.face.face();
    let spacing = SPACING * context.narrow();
    let middle = |range: &Interval| 0.5 * (range.low + range.high);
    let spot = |cell: &[Interval; 2]| {
        let [u, v] = [middle(&cell[0]), middle(&cell[1])];
        face.contains(u, v).then(|| Spot { uv: [u, v], point: face.point(u, v) })
    };
    // One spot per cube of that size: the nearest to its middle, and before all others the deepest.
    let mut cubes: BTreeMap<[i64; 3], (f64, Spot)> = BTreeMap::new();
    let mut offer = |spot: Spot, rank: &dyn Fn(f64) -> f64| {
        // Positions over a fraction of a millimetre: far below 2^63.
        #[expect(clippy::cast_possible_truncation, reason = "see above")]
        let cube = [0, 1, 2].map(|k: usize| (spot.point[k] / spacing).floor() as i64);
        let off = |k: usize| spot.point[k] / spacing - cube[k] as f64 - 0.5;
        let rank = rank(Vector3::new(off(0), off(1), off(2)).norm_squared());
        let known = cubes.entry(cube).or_insert((rank, spot));
        if rank < known.0 {
            *known = (rank, spot);
        }
    };
    part.cells.iter().filter_map(spot).for_each(|spot| offer(spot, &|off| off));
    offer(Spot { uv: part.deepest.into(), point: part.point }, &|_| -1.0);
    cubes.into_values().map(|(_, spot)| spot).collect()
}

/// Orders spots to chains, along the long direction of the region where that is possible.
fn chains(mut spots: Vec<Spot>, spacing: f64) -> Vec<Vec<Spot>> {
    let along = long_direction(&spots);
    let cost = |a: &Spot, b: &Spot| {
        let step = b.point - a.point;
        let ahead = along.dot(&step);
        ahead.abs() + ACROSS * (step - along * ahead).norm()
    };
    let mut chains: Vec<Vec<Spot>> = Vec::new();
    while !spots.is_empty() {
        // A chain begins at the end of the region.
        let least = |a: &Spot| along.dot(&a.point.coords);
        let first = index_of_least(&spots, least);
        let mut chain = vec![spots.swap_remove(first)];
        while let Some(last) = chain.last() {
            let near = |spot: &Spot| {
                let apart = (spot.point - last.point).norm();
                if apart <= JOINED * spacing { cost(last, spot) } else { f64::INFINITY }
            };
            let next = index_of_least(&spots, near);
            if !spots.get(next).is_some_and(|spot| near(spot).is_finite()) {
                break;
            }
            chain.push(spots.swap_remove(next));
        }
        chains.push(chain);
    }
    chains
}

fn index_of_least(spots: &[Spot], of: impl Fn(&Spot) -> f64) -> usize {
    let values = spots.iter().map(of).enumerate();
    values.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
}

/// Returns the direction in which points are spread most.
fn long_direction(spots: &[Spot]) -> Vector3<f64> {
    let count = spots.len().max(1) as f64;
    let mean = spots.iter().map(|spot| spot.point.coords).sum::<Vector3<f64>>() / count;
    let spread: Matrix3<f64> =
        spots.iter().map(|spot| spot.point.coords - mean).map(|off| off * off.transpose()).sum();
    let eigen = spread.symmetric_eigen();
    eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned()
}

/// Returns the stations over a chain, in as many runs as the tool is lifted between.
fn runs<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    chain: &[Spot],
) -> Vec<Vec<Station>> {
    let keep_off = context.keep_off().rough();
    let cutter = context.setup.cutter;
    let mut runs: Vec<Vec<Station>> = Vec::new();
    let mut before: Option<Station> = None;
    for spot in chain {
        let station = ContactPoint::new(context.face, spot.uv).and_then(|contact| {
            let before = before.map(|station| station.pose);
            let pose = fitting_pose_near(&keep_off, &contact, cutter, room(context), before)?;
            Some(Station { pose, contact: contact.point })
        });
        let goes_on = |a: Station, b: Station| angle_between(&a.pose.axis, &b.pose.axis) <= TURN;
        match (before, station, runs.last_mut()) {
            (Some(last), Some(next), Some(run)) if goes_on(last, next) => run.push(next),
            (_, Some(next), _) => runs.push(vec![next]),
            _ => {}
        }
        before = station;
    }
    runs
}

/// A pass over spots, with its curve.
pub(crate) struct SpotPass {
    pub(crate) pass: Pass,
    sweep: PassSweep,
}

/// Returns the pass through stations if the tool keeps off all faces on it, with more stations between them where that
/// helps, or else passes through its halves.
fn proven_passes<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    stations: &[Station],
) -> Vec<SpotPass> {
    let mut dense = match *stations {
        [single] => match beside(context, single) {
            Some(next) => vec![single, next],
            None => return Vec::new(),
        },
        _ => stations.to_vec(),
    };
    for _ in 0..=DENSER {
        let sweep = PassSweep::through(&dense, lever(context.setup.cutter));
        if context.keeps_off(&sweep) {
            return vec![SpotPass { pass: context.whole_pass(dense, context.narrow()), sweep }];
        }
        // On a face that bulges, the tool cuts the corner between stations far apart.
        let Some(more) = denser(context, &dense) else { break };
        dense = more;
    }
    if stations.len() <= 2 {
        return Vec::new();
    }
    let (first, last) = stations.split_at(stations.len() / 2);
    [first, last].into_iter().flat_map(|part| proven_passes(context, part)).collect()
}

/// Returns stations with another one in the middle of each span; `None` where the tool does not fit there, or has to
/// turn.
fn denser<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    stations: &[Station],
) -> Option<Vec<Station>> {
    let mut denser = vec![*stations.first()?];
    for pair in stations.windows(2) {
        let middle = nalgebra::center(&pair[0].contact, &pair[1].contact);
        let foot = context.face.closest(&middle).ok()?;
        denser.push(near(context, foot.uv.into(), &pair[0])?);
        denser.push(pair[1]);
    }
    Some(denser)
}

/// Returns a station a little beside another: a pass needs two.
fn beside<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    station: Station,
) -> Option<Station> {
    let face = context.face.face();
    let uv: [f64; 2] = context.face.closest(&station.contact).ok()?.uv.into();
    let jet = face.surface.jet1(uv[0], uv[1]);
    // Near a pole only one of the parameters moves the point.
    let paces = [jet.su.norm(), jet.sv.norm()];
    let k = usize::from(paces[1] > paces[0]);
    let by = SINGLE * context.narrow() / paces[k].max(f64::MIN_POSITIVE);
    let mut to = uv;
    // Away from the nearer end of the range.
    to[k] += if uv[k] > face.bounds()[k].middle() { -by } else { by };
    near(context, to, &station)
}

/// Returns the station at a point of the face with about the inclination of another.
fn near<Inside: Fn(ChartPoint) -> bool + Sync>(
    context: &FaceContext<'_, Inside>,
    uv: [f64; 2],
    other: &Station,
) -> Option<Station> {
    let contact = ContactPoint::new(context.face, uv)?;
    let (keep_off, cutter) = (context.keep_off().rough(), context.setup.cutter);
    let pose = fitting_pose_near(&keep_off, &contact, cutter, room(context), Some(other.pose))?;
    (angle_between(&pose.axis, &other.pose.axis) <= TURN)
        .then_some(Station { pose, contact: contact.point })
}
