//! All passes over one face.

use super::clear::Clearing;
use super::lane::{Lane, Placed};
use super::left::{Column, Swept};
use super::options::{Along, CoverError, CoverOptions, Covering, Direction};
use super::options::{Fallback, FallbackReason, Method, Place};
use super::region::{Local, Region};
use super::sheet::Sheet;
use super::solid::Tool;
use super::split;
use super::state::{Lot, State, Step, price};
use super::stretch::{Stretch, Trimmer};
use super::sweep::Sweep;
use super::track::Track;
use crate::cutter::Cutter;
use crate::math::angle::angle_between;
use crate::positioning::{Band, ContactSide};
use crate::surface::FaceIndex;
use crate::types::{Cancelled, Pass};

/// Trim loops are followed to this share of the face's extent in u and in v. Passes run on the cutter's
/// radius beyond, and their strips begin at a border and end beyond it.
const LOOP_SHARE: f64 = 1e-4;

/// Size of the cells that a face is divided into beforehand, as a share of the cutter's radius: bows of
/// smaller ones are far below tolerances.
pub(super) const SHEET_SHARE: f64 = 1.0 / 32.0;

/// Share of the path's share to which breaches of the band between stations are found.
const PRECISION: f64 = 0.05;

/// Passes before the last one whose finish is taken into account.
const MEMORY: usize = 8;

/// How often stations are added where a pass finishes nothing at its track.
const DENSER: usize = 3;

/// Size of the cells of the last look, as a share of those before.
const FINER: f64 = 0.25;

/// Width that is worth a pass, as a share of the strip on a plane of a ball as wide as the cutter: on an edge rounded
/// with a hundredth of that ball's radius, a ball's strip is still a tenth as wide.
const WORTH: f64 = 1.0 / 16.0;

/// Tasks within tasks.
const DEPTH: u32 = 2;

/// Tells how much of the face is covered, 0 to 1.
type Report<'a> = &'a (dyn Fn(f64) -> Result<(), Cancelled> + Sync);

/// All passes over one face. Where either side of the cutter may cut, that which takes less over
/// the whole face: passes that change sides from place to place would have to turn the tool over.
pub(super) fn cover(
    face: &FaceIndex,
    cutter: &Cutter,
    options: &CoverOptions,
    report: Report<'_>,
) -> Result<Covering, CoverError> {
    if options.side != ContactSide::Either {
        return on_side(face, cutter, options, report);
    }
    let half = |side: ContactSide, from: f64| {
        let sided = CoverOptions { side, ..*options };
        on_side(face, cutter, &sided, &|share| report(from + 0.5 * share))
    };
    let (ahead, behind) = (half(ContactSide::Ahead, 0.0), half(ContactSide::Behind, 0.5));
    let price = |done: &Covering| price(done, options);
    let better = |a: &Covering, b: &Covering| {
        a.report.missed.cmp(&b.report.missed).then(price(a).total_cmp(&price(b))).is_lt()
    };
    match (ahead, behind) {
        (Ok(ahead), Ok(behind)) => Ok(if better(&behind, &ahead) { behind } else { ahead }),
        (_, Err(CoverError::Cancelled(cancelled))) => Err(cancelled.into()),
        (Err(_), Ok(behind)) => Ok(behind),
        (ahead, _) => ahead,
    }
}

fn on_side(
    face: &FaceIndex,
    cutter: &Cutter,
    options: &CoverOptions,
    report: Report<'_>,
) -> Result<Covering, CoverError> {
    let whole = region(face, options.along);
    let mut job = Job {
        face,
        cutter,
        options,
        sheet: Sheet::new(face, options.along, &whole, SHEET_SHARE * cutter.radius()),
        tool: Tool::new(cutter),
        whole: &whole,
        state: State {
            done: Covering::default(),
            forward: true,
            recent: Vec::new(),
            swept: Vec::new(),
            missed: Vec::new(),
        },
        report,
        share: 0.0,
    };
    let (bounds, method) = (whole.bounds, options.method);
    job.finish(&Task { bounds, method, depth: 0, worth: f64::INFINITY })?;
    job.audit();
    report(1.0)?;
    Ok(job.state.done)
}

/// The trimmed region in local parameters; loops on periodic surfaces also a period further on
/// either side, so that every line across the face meets them.
pub(super) fn region(face: &FaceIndex, along: Along) -> Region<impl Fn(Local) -> bool + Sync> {
    let face = face.face();
    let [u, v] = face.bounds();
    let tolerance = [u, v].map(|range| LOOP_SHARE * (range[1] - range[0]));
    let shifts = |period: Option<f64>| match period {
        Some(period) => vec![-period, 0.0, period],
        None => vec![0.0],
    };
    let [pu, pv] = face.surface.periods();
    let mut loops = Vec::new();
    for points in face.loops.iter().map(|trim| trim.polyline(tolerance)) {
        for du in shifts(pu) {
            for dv in shifts(pv) {
                loops.push(points.iter().map(|p| along.local([p[0] + du, p[1] + dv])).collect());
            }
        }
    }
    let bounds = match along {
        Along::U => [v, u],
        Along::V => [u, v],
    };
    Region::new(bounds, loops, move |local| {
        let [u, v] = along.uv(local);
        face.contains(u, v)
    })
}

/// A rectangle of local parameters to be finished.
struct Task {
    bounds: [[f64; 2]; 2],
    method: Method,
    /// How many tasks this is part of.
    depth: u32,
    /// What it costs to leave one millimetre across to the task it is part of \[mm/mm\].
    worth: f64,
}

/// A face while its passes are placed.
struct Job<'a, Inside> {
    face: &'a FaceIndex,
    cutter: &'a Cutter,
    options: &'a CoverOptions,
    sheet: Sheet,
    tool: Tool,
    whole: &'a Region<Inside>,
    state: State,
    report: Report<'a>,
    /// How much of the face is done.
    share: f64,
}

impl<Inside: Fn(Local) -> bool + Sync> Job<'_, Inside> {
    /// Passes over a rectangle of the region, one beside the other; how far across they bring it. A rest
    /// that is cheaper to leave to the task this is part of is left.
    fn finish(&mut self, task: &Task) -> Result<f64, CoverError> {
        let region = self.whole.within(task.bounds);
        let [first, last] = task.bounds[0];
        let mut next = first;
        loop {
            if task.depth == 0 {
                self.share = (next - first) / (last - first);
            }
            (self.report)(self.share)?;
            let Some(step) = self.lane(&region, next, task)? else { return Ok(last) };
            next = step.next;
            if (last - next) * step.rate * task.worth < step.again {
                return Ok(next);
            }
        }
    }

    /// Adds the pass at `across`, and those that finish what it leaves; how far it brings the task, `None` at its end.
    fn lane(
        &mut self,
        region: &Region<&Inside>,
        across: f64,
        task: &Task,
    ) -> Result<Option<Step>, CoverError> {
        let lot = self.place(region, across, task.method)?;
        let mut advances = if task.depth == 0 {
            split::advances(&lot.parts, &lot.costs)
        } else if task.depth < DEPTH {
            vec![split::advance(&lot.parts, &lot.costs)]
        } else {
            let widths = lot.parts.iter().map(|part| part.width);
            vec![widths.filter(|width| *width >= self.least()).fold(f64::INFINITY, f64::min)]
        };
        advances.retain(|advance| advance.is_finite() && *advance >= self.least());
        let next = match *advances {
            [] => return self.stuck(region, across, task, &lot),
            [advance] => self.go_on(&lot, advance, across, task)?,
            _ => self.go_on_best(&lot, &advances, across, task)?,
        };
        let (again, rate) = (lot.length() + lot.costs.pass, lot.rate);
        Ok((next < region.bounds[0][1]).then_some(Step { next, rate, again }))
    }

    /// Adds the pass and those that finish what it leaves narrower than `advance` \[mm\].
    fn go_on(
        &mut self,
        lot: &Lot,
        advance: f64,
        across: f64,
        task: &Task,
    ) -> Result<f64, CoverError> {
        let mut next = lot.reach(advance).min(across + advance / lot.rate);
        self.add(lot.stretches.clone());
        for run in split::narrower(&lot.parts, advance) {
            next = self.again(lot, run, [across, next], task)?.min(next);
        }
        Ok(next)
    }

    /// As [`Job::go_on`] by each of several widths; keeps what costs least for what it brings.
    fn go_on_best(
        &mut self,
        lot: &Lot,
        advances: &[f64],
        across: f64,
        task: &Task,
    ) -> Result<f64, CoverError> {
        let before = self.state.clone();
        let mut best: Option<(usize, f64, f64, State)> = None;
        for &advance in advances {
            self.state = before.clone();
            let next = self.go_on(lot, advance, across, task)?;
            let cost = self.state.price(self.options) - before.price(self.options);
            let (missed, rate) = (self.state.missed.len(), cost / (next - across));
            let better = |(m, r, ..): &(usize, f64, f64, State)| (missed, rate) < (*m, *r);
            if best.as_ref().is_none_or(better) {
                best = Some((missed, rate, next, self.state.clone()));
            }
        }
        let Some((_, _, next, state)) = best else { return Ok(across) };
        self.state = state;
        Ok(next)
    }

    /// A pass that would finish nothing: placed otherwise, given up, or an error if it is the whole face's.
    fn stuck(
        &mut self,
        region: &Region<&Inside>,
        across: f64,
        task: &Task,
        lot: &Lot,
    ) -> Result<Option<Step>, CoverError> {
        if task.method == Method::Widest {
            self.fall_back(lot, [0, lot.parts.len().saturating_sub(1)]);
            return self.lane(region, across, &Task { method: Method::Inclined, ..*task });
        }
        if task.depth > 0 {
            self.miss(&lot.columns, region.bounds[0][1]);
            return Ok(None);
        }
        let face = self.face.face().number;
        if let Some((at, error)) = lot.refused.clone() {
            let at = Box::new(Place::new(self.face, self.options.along.uv(at)));
            return Err(CoverError::NoPose { face, at, error });
        }
        let widest = lot.parts.iter().enumerate().max_by(|a, b| a.1.width.total_cmp(&b.1.width));
        let (index, advance) = widest.map_or((0, 0.0), |(index, part)| (index, part.width));
        let along = lot.columns.get(index).map_or(region.bounds[1][0], |c| c.along[0]);
        let at = Box::new(Place::new(self.face, self.options.along.uv([across, along])));
        Err(CoverError::TooNarrow { face, at, advance, least: self.least() })
    }

    /// Passes of their own over columns that the pass leaves narrower than the others; how far across these
    /// are finished then.
    fn again(
        &mut self,
        lot: &Lot,
        [first, last]: [usize; 2],
        [across, next]: [f64; 2],
        task: &Task,
    ) -> Result<f64, CoverError> {
        let columns = &lot.columns[first..=last];
        let widths = || lot.parts[first..=last].iter().map(|part| part.width);
        let narrowest = widths().fold(f64::INFINITY, f64::min);
        let wide = narrowest >= lot.costs.narrow;
        let same = wide || task.method == Method::Inclined;
        if task.depth > DEPTH || (task.method == Method::Inclined && narrowest < self.least()) {
            let missed = columns.iter().filter(|c| c.part.width < self.least());
            self.miss(&missed.copied().collect::<Vec<_>>(), next);
            if narrowest < self.least() {
                return Ok(next);
            }
        }
        if !same {
            self.fall_back(lot, [first, last]);
        }
        let from = columns.iter().map(|c| c.finished).fold(next, f64::min).max(across);
        let along = [columns[0].along[0], columns[columns.len() - 1].along[1]];
        let method = if same { task.method } else { Method::Inclined };
        let worth = (lot.length() + lot.costs.pass) / ((next - across) * lot.rate);
        let bounds = [[from, next], along];
        let reached = self.finish(&Task { bounds, method, depth: task.depth + 1, worth })?;
        // The pass has to bring the whole task on.
        let least = across + self.least() / lot.rate;
        if reached >= least {
            return Ok(reached);
        }
        let rest = [[reached, next], along];
        self.finish(&Task { bounds: rest, method, depth: task.depth + 1, worth: f64::INFINITY })
    }

    /// Remembers columns that stay unfinished so far, up to `end`.
    fn miss(&mut self, columns: &[Column], end: f64) {
        let open = columns.iter().filter(|c| c.finished < end);
        self.state.missed.extend(open.map(|c| [[c.finished, end], c.along]));
    }

    /// Reports what is unfinished in the end of what was missed: passes further on may have swept over it.
    fn audit(&mut self) {
        let boxes = std::mem::take(&mut self.state.missed);
        let sweeps: Vec<&Sweep> = self.state.swept.iter().chain(&self.state.recent).collect();
        let open = |bounds: &[[f64; 2]; 2]| {
            let region = self.whole.within(*bounds);
            let mut swept = self.over(&region, &sweeps);
            // The borders of passes lie anywhere in these cells: finer ones find their overlap.
            swept.smallest *= FINER;
            let columns = swept.columns(bounds[0], 1.0);
            let open = columns.iter().find(|column| column.finished < bounds[0][1]);
            open.map(|c| [c.finished, 0.5 * (c.along[0] + c.along[1])])
        };
        let places: Vec<Local> = boxes.iter().filter_map(open).collect();
        let report = &mut self.state.done.report;
        report.missed = places.len();
        let number = self.face.face().number;
        report.missed_at = places.first().map(|&at| (number, self.options.along.uv(at)));
    }

    /// What sweeps have finished of a region.
    fn over<'b>(
        &'b self,
        region: &'b Region<&'b Inside>,
        sweeps: &'b [&'b Sweep],
    ) -> Swept<'b, &'b Inside> {
        Swept {
            face: self.face,
            chart: self.options.along,
            region,
            end: self.tool.end,
            limit: self.options.band.upper + self.options.path_share,
            smallest: 0.5 * self.options.spacing[0],
            sweeps,
        }
    }

    /// Notes why wide strips are not taken on some columns.
    fn fall_back(&mut self, lot: &Lot, [first, last]: [usize; 2]) {
        let (Some(a), Some(b)) = (lot.columns.get(first), lot.columns.get(last)) else { return };
        let chart = self.options.along;
        let face = self.face.face().number;
        let near = |at: &Local| (a.along[0]..=b.along[1]).contains(&at[1]);
        let fallback = if let Some((at, error)) = lot.refused.clone().filter(|(at, _)| near(at)) {
            Fallback { face, at: chart.uv(at), reason: FallbackReason::NoStrip(error) }
        } else {
            let at = chart.uv([a.finished, a.along[0]]);
            Fallback { face, at, reason: FallbackReason::Missed(last + 1 - first) }
        };
        self.state.done.report.fallbacks.push(fallback);
    }

    /// Least width a pass has to finish \[mm\].
    fn least(&self) -> f64 {
        let Band { lower, upper } = self.options.band;
        let ball = (8.0 * self.cutter.radius() * (upper - lower)).sqrt();
        self.options.spacing[0].max(WORTH * ball)
    }

    fn place(
        &self,
        region: &Region<&Inside>,
        across: f64,
        method: Method,
    ) -> Result<Lot, CoverError> {
        let lane = Lane {
            face: self.face,
            cutter: self.cutter,
            options: self.options,
            across,
            across_range: region.bounds[0],
            track: self.track(region, across)?,
            forward: self.state.forward,
            method,
        };
        let CoverOptions { band, path_share, .. } = *self.options;
        let precision = PRECISION * path_share;
        let clearing = Clearing {
            face: self.face,
            chart: self.options.along,
            sheet: &self.sheet,
            tool: &self.tool,
            target: band.lower - path_share + precision,
            precision,
        };
        let trimmer = Trimmer { lane: &lane, region, clearing };
        let (mut stretches, refused) = trimmer.stretches();
        let rate = lane.rate_across();
        let mut columns = self.columns(region, [across, rate], &stretches);
        for _ in 0..DENSER {
            let missed: Vec<[f64; 2]> = columns
                .iter()
                .filter(|column| column.part.width < self.least())
                .map(|column| column.along)
                .collect();
            let Some(denser) = trimmer.denser(&stretches, &missed) else { break };
            stretches = denser;
            columns = self.columns(region, [across, rate], &stretches);
        }
        let parts = columns.iter().map(|c| c.part).collect();
        let refused = refused.map(|(way, error)| ([across, lane.track.at(way)], error));
        Ok(Lot { rate, stretches, columns, parts, costs: lane.costs(), refused })
    }

    /// How far across the region is finished by the stretches and what was before.
    fn columns(
        &self,
        region: &Region<&Inside>,
        [across, rate]: [f64; 2],
        stretches: &[Stretch],
    ) -> Vec<Column> {
        let mine: Vec<Sweep> = stretches.iter().map(|stretch| self.sweep(stretch)).collect();
        let sweeps: Vec<&Sweep> = self.state.recent.iter().chain(&mine).collect();
        self.over(region, &sweeps).columns([across, region.bounds[0][1]], rate)
    }

    fn sweep(&self, stretch: &Stretch) -> Sweep {
        Sweep::new(&stretch.placed, super::lever(self.cutter))
    }

    fn track(&self, region: &Region<&Inside>, across: f64) -> Result<Track, CoverError> {
        let chart = self.options.along;
        let extension = self.cutter.radius();
        let track = Track::new(self.face, chart, across, region.bounds[1], extension);
        let [start, end] = track.range();
        if end - start > self.options.spacing[0] {
            Ok(track)
        } else {
            Err(CoverError::NoTrack { face: self.face.face().number, along: chart, across })
        }
    }

    fn add(&mut self, mut stretches: Vec<Stretch>) {
        if stretches.is_empty() {
            return;
        }
        let sweeps: Vec<Sweep> = stretches.iter().map(|stretch| self.sweep(stretch)).collect();
        self.state.recent.extend(sweeps);
        let old = self.state.recent.len().saturating_sub(MEMORY);
        self.state.swept.extend(self.state.recent.drain(..old));
        if !self.state.forward {
            stretches.reverse();
        }
        for stretch in stretches {
            self.note(&stretch);
            let pass = self.pass(stretch.placed);
            self.state.done.report.length +=
                pass.stations.windows(2).map(|s| (s[1].contact - s[0].contact).norm()).sum::<f64>();
            self.state.done.report.stations += pass.stations.len();
            self.state.done.passes.push(pass);
        }
        if self.options.direction == Direction::ZigZag {
            self.state.forward = !self.state.forward;
        }
    }

    fn note(&mut self, stretch: &Stretch) {
        let report = &mut self.state.done.report;
        report.shortened += usize::from(stretch.shortened.contains(&true));
        for check in stretch.checks.iter().filter(|check| !check.good) {
            report.coarse_spans += 1;
            report.worst_gouge = report.worst_gouge.max(check.gouge);
        }
        for pair in stretch.placed.windows(2) {
            let turn = angle_between(&pair[0].station.pose.axis, &pair[1].station.pose.axis);
            let rate = turn / (pair[1].way - pair[0].way);
            report.axis_turn = report.axis_turn.max(rate);
            report.fast_turns += usize::from(rate > self.options.max_axis_turn);
        }
    }

    /// Stations in cutting order.
    fn pass(&self, mut placed: Vec<Placed>) -> Pass {
        if !self.state.forward {
            placed.reverse();
        }
        let chart = self.options.along;
        let track = placed.iter().map(|p| chart.uv([p.across, p.along])).collect();
        let widths = placed.iter().map(|p| p.location.strip_width).collect();
        let stations = placed.into_iter().map(|p| p.station).collect();
        Pass { face: self.face.face().number, stations, widths, track }
    }
}
