//! All passes over one face.

use super::beyond::Beyond;
use super::chart::Chart;
use super::clock::Clock;
use super::guide;
use super::options::{Along, CoverError, CoverOptions, Covering, Method};
use super::region::{Local, Region};
use super::site::{Report, Site, Tooling};
use super::state::State;
use super::task::{Job, Task};
use crate::positioning::ContactSide;
use crate::surface::FaceIndex;
use crate::types::UncutRegion;
use std::sync::Arc;

/// Trim loops are followed to this share of the face's extent in u and in v. Passes run on the cutter's
/// radius beyond, and their strips begin at a border and end beyond it.
const LOOP_SHARE: f64 = 1e-4;

/// The same of faces that are not cut: well below a micrometre of faces of some hundred millimetres.
const GUARDED_SHARE: f64 = 1e-7;

/// Work, over that of passes at the fixed lean, after which these are given up as well: several times what they
/// should take, as where the tool has to keep off something many leans are tried.
const REST: f64 = 10.0;

/// Edges of trim loops on passes that bend, as a share of the face's extent: straight over such a part, a
/// bend leaves an arc by less than [`LOOP_SHARE`].
const BENT_SHARE: f64 = 1.0 / 256.0;

/// All passes over one face. Where either side of the cutter may cut, that which takes less over
/// the whole face: passes that change sides from place to place would have to turn the tool over.
pub(super) fn cover(
    face: &FaceIndex,
    tool: Tooling<'_>,
    options: &CoverOptions,
    (clock, report): (&dyn Clock, Report<'_>),
) -> Result<Covering, CoverError> {
    if options.side != ContactSide::Either {
        return Ok(on_side(face, tool, options, (clock, report))?.covering());
    }
    let half = |side: ContactSide, from: f64| {
        let sided = CoverOptions { side, ..*options };
        on_side(face, tool, &sided, (clock, &|share| report(from + 0.5 * share)))
    };
    let (ahead, behind) = (half(ContactSide::Ahead, 0.0), half(ContactSide::Behind, 0.5));
    let best = match (ahead, behind) {
        (Ok(ahead), Ok(behind)) => {
            let tried = [(ahead, ()), (behind, ())];
            Ok(State::best(&tried).map_or_else(State::new, |(best, ())| best.clone()))
        }
        (_, Err(CoverError::Cancelled(cancelled))) => Err(cancelled.into()),
        (Err(_), Ok(behind)) => Ok(behind),
        (ahead, _) => ahead,
    };
    best.map(State::covering)
}

/// The best of the ways that promise most.
fn on_side(
    face: &FaceIndex,
    tool: Tooling<'_>,
    options: &CoverOptions,
    (clock, report): (&dyn Clock, Report<'_>),
) -> Result<State, CoverError> {
    let (ways, mut work) = guide::ways(face, tool.0, options);
    let share = 1.0 / ways.len().max(1) as f64;
    let beyond = Beyond::of(face, tool.0, clock).map(Arc::new);
    let mut tried: Vec<(State, Chart)> = Vec::new();
    let mut refused = None;
    for (i, chart) in ways.into_iter().enumerate() {
        let report = |done: f64| report(share * (i as f64 + done));
        let region = within_reach(face, &chart, beyond.as_ref());
        let site = Site::new((face, tool, options), (chart.clone(), &region), (clock, &report));
        let [wide, all] = limits(&site);
        if !tried.is_empty() && work > wide {
            break;
        }
        match on_site(&site, beyond.as_deref(), [wide, all]) {
            Ok(state) => {
                work += state.report.work;
                tried.push((state, chart));
            }
            Err(CoverError::Cancelled(cancelled)) => return Err(cancelled.into()),
            Err(error) => refused = refused.or(Some(error)),
        }
    }
    report(1.0)?;
    let Some((mut best, chart)) = State::best(&tried).cloned() else {
        return refused.map_or(Ok(State::new()), Err);
    };
    best.report.ways = vec![(face.face().number, chart.way())];
    if !best.report.rest.is_empty() {
        let (chart, report) = (chart.crossed(), |_: f64| report(1.0));
        let region = within_reach(face, &chart, beyond.as_ref());
        let cross = Site::new((face, tool, options), (chart, &region), (clock, &report));
        let filled = fill(&cross, &best)?;
        work += filled.report.work;
        if best.leaves_more(&filled) {
            best = filled;
        }
    }
    best.report.work = work;
    Ok(best)
}

/// Passes across at the fixed lean over what passes along left: these end in steps at what the tool keeps off, where
/// those follow it.
fn fill<Inside: Fn(Local) -> bool + Sync>(
    cross: &Site<'_, Inside>,
    before: &State,
) -> Result<State, CoverError> {
    let mut state = before.clone();
    // A count of locations is far below 2^53.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
    let limit = (REST * cross.usual_work()) as u64;
    let mut work = 0;
    for part in &before.report.rest {
        let bounds = cross.local_range(part.uv);
        let task = Task { bounds, method: Method::Inclined, depth: 0, worth: f64::INFINITY };
        let mut job = Job { site: cross, state, work, limits: [0, limit], share: 0.0 };
        job.whole(&task)?;
        (state, work) = (job.state, job.work);
    }
    state.report.work = work;
    // What was left before is looked at again, and no more than that.
    state.missed.clone_from(&before.missed);
    take_rest(cross, &mut state);
    Ok(state)
}

/// Looks at what is left.
fn take_rest<Inside: Fn(Local) -> bool + Sync>(site: &Site<'_, Inside>, state: &mut State) {
    state.report.rest = rest(site, state);
    state.resolved = site.resolved(&state.report.rest);
}

/// What is left, looked at on lines of constant parameters: its cells are ranges of u and v.
fn rest<Inside: Fn(Local) -> bool + Sync>(
    site: &Site<'_, Inside>,
    state: &State,
) -> Vec<UncutRegion> {
    if site.chart.is_straight() || state.missed.is_empty() {
        return site.rest(state);
    }
    let chart = Chart::straight(Along::V);
    let region = region(site.face, &chart);
    let tool = (site.cutter, site.guards);
    let given = (site.face, tool, site.options);
    Site::new(given, (chart, &region), (site.clock, site.report)).rest(state)
}

/// Work after which wide strips are given up, and after which everything is.
fn limits<Inside: Fn(Local) -> bool + Sync>(site: &Site<'_, Inside>) -> [u64; 2] {
    let effort = site.options.effort;
    // A count of locations is far below 2^53, and one without end saturates.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
    let limits = [0.0, REST].map(|rest| ((effort + rest) * site.usual_work()) as u64);
    limits
}

/// All passes on one chart.
fn on_site<Inside: Fn(Local) -> bool + Sync>(
    site: &Site<'_, Inside>,
    beyond: Option<&Beyond>,
    limits: [u64; 2],
) -> Result<State, CoverError> {
    let (bounds, method) = (site.whole.bounds, site.options.method);
    let task = Task { bounds, method, depth: 0, worth: f64::INFINITY };
    let mut state = State::new();
    state.missed = beyond.map_or_else(Vec::new, Beyond::ranges);
    let mut job = Job { site, state, work: 0, limits, share: 0.0 };
    job.whole(&task)?;
    let mut state = job.state;
    state.report.work = job.work;
    take_rest(site, &mut state);
    state.report.area = site.area();
    Ok(state)
}

/// The trimmed region of a face that is not cut, on lines of constant parameters. What is beyond its edges is free,
/// and a tool that cuts the next face comes as near to them as it does to that.
pub(super) fn guarded<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
) -> Region<impl Fn(Local) -> bool + Sync + use<'a>> {
    region_within(face, chart, GUARDED_SHARE)
}

/// The trimmed region in local parameters; loops on periodic surfaces also a period further on
/// either side, so that every line across the face meets them.
pub(super) fn region<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
) -> Region<impl Fn(Local) -> bool + Sync + use<'a>> {
    region_within(face, chart, LOOP_SHARE)
}

/// The same without what the machine does not get to.
fn within_reach<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
    beyond: Option<&Arc<Beyond>>,
) -> Region<impl Fn(Local) -> bool + Sync + use<'a>> {
    let region = region(face, chart);
    let Some(beyond) = beyond else { return region };
    let surface = &face.face().surface;
    let [pu, pv] = surface.periods().map(|period| shifts(period, chart));
    let shifts = pu.iter().flat_map(|du| pv.iter().map(|dv| [*du, *dv]));
    let edges = shifts.flat_map(|shift| beyond.edges(chart, shift)).collect();
    let (beyond, chart) = (Arc::clone(beyond), chart.clone());
    region.without(move |local| beyond.holds(chart.uv(local)), edges)
}

/// Loops on periodic surfaces count a period further on either side as well, where passes may run on there.
fn shifts(period: Option<f64>, chart: &Chart) -> Vec<f64> {
    match period {
        Some(period) if chart.is_straight() => vec![-period, 0.0, period],
        _ => vec![0.0],
    }
}

fn region_within<'a>(
    face: &'a FaceIndex,
    chart: &Chart,
    share: f64,
) -> Region<impl Fn(Local) -> bool + Sync + use<'a>> {
    let face = face.face();
    let [u, v] = face.bounds();
    let tolerance = [u, v].map(|range| share * (range[1] - range[0]));
    let [pu, pv] = face.surface.periods();
    let mut polylines: Vec<Vec<[f64; 2]>> =
        face.loops.iter().map(|trim| trim.polyline(tolerance)).collect();
    if !chart.is_straight() {
        if polylines.is_empty() {
            polylines.push(vec![[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]]);
        }
        let most = [u, v].map(|range| BENT_SHARE * (range[1] - range[0]));
        polylines = polylines.iter().map(|points| finer(points, most)).collect();
    }
    let mut loops: Vec<Vec<Local>> = Vec::new();
    for points in polylines {
        for du in shifts(pu, chart) {
            for dv in shifts(pv, chart) {
                loops.push(points.iter().map(|p| chart.local([p[0] + du, p[1] + dv])).collect());
            }
        }
    }
    let bounds = if chart.is_straight() {
        let [a, b] = [chart.local([u[0], v[0]]), chart.local([u[1], v[1]])];
        [[a[0], b[0]], [a[1], b[1]]]
    } else {
        [0, 1].map(|k| {
            let values = || loops.iter().flatten().map(|p| p[k]);
            [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
        })
    };
    let chart = chart.clone();
    Region::new(bounds, loops, move |local| {
        let [u, v] = chart.uv(local);
        face.contains(u, v)
    })
}

/// A closed polyline with edges no longer than `most` by u and v.
fn finer(points: &[[f64; 2]], most: [f64; 2]) -> Vec<[f64; 2]> {
    let mut fine = Vec::new();
    for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
        let way = [0, 1].map(|k| b[k] - a[k]);
        let pieces = (way[0].abs() / most[0]).max(way[1].abs() / most[1]).ceil().max(1.0);
        let steps = std::iter::successors(Some(0.0), |i| Some(i + 1.0));
        fine.extend(
            steps.take_while(|i| *i < pieces).map(|i| [0, 1].map(|k| a[k] + way[k] * (i / pieces))),
        );
    }
    fine
}
