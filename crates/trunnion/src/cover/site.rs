//! What does not change while passes are placed over a face, and one lane laid on it.

use super::chart::Chart;
use super::clear::Clearing;
use super::clock::Clock;
use super::guard::{Around, Guards};
use super::lane::{Lane, Placed};
use super::left::{Column, Swept};
use super::options::{CoverError, CoverOptions, Method};
use super::region::{Local, Region};
use super::sheet::{Cell, Sheet};
use super::state::{Lot, State};
use super::stretch::{Stretch, Trimmer};
use super::sweep::Sweep;
use super::track::Track;
use super::work::Work;
use crate::cutter::Cutter;
use crate::cutter::solid::Tool;
use crate::surface::FaceIndex;
use crate::types::Cancelled;

/// Size of the cells that a face is divided into beforehand, as a share of the cutter's radius: bows of
/// smaller ones are far below tolerances.
pub(super) const SHEET_SHARE: f64 = 1.0 / 32.0;

/// Share of the path's share to which breaches of the band between stations are found.
const PRECISION: f64 = 0.05;

/// How often stations are added where a pass finishes nothing at its track.
const DENSER: usize = 3;

/// Width that is worth a pass, as a share of the strip on a plane of a ball as wide as the cutter: on an edge rounded
/// with a hundredth of that ball's radius, a ball's strip is still a tenth as wide.
const WORTH: f64 = 1.0 / 16.0;

/// What a pass may cut across, in radii of the cutter.
const WINDOW: f64 = 4.0;

/// Tells how much of the face is covered, 0 to 1.
pub(super) type Report<'a> = &'a (dyn Fn(f64) -> Result<(), Cancelled> + Sync);

/// A cutter; all faces of the part, and which of them is cut.
pub(super) type Tooling<'a> = (&'a Cutter, (&'a Guards<'a>, usize));

/// A face with cutter and options, ready for passes.
pub(super) struct Site<'a, Inside> {
    pub(super) face: &'a FaceIndex,
    pub(super) cutter: &'a Cutter,
    pub(super) options: &'a CoverOptions,
    /// Where passes run.
    pub(super) chart: Chart,
    pub(super) whole: &'a Region<Inside>,
    pub(super) clock: &'a dyn Clock,
    pub(super) report: Report<'a>,
    /// All faces of the part, and which of them this is.
    pub(super) guards: (&'a Guards<'a>, usize),
    sheet: Sheet,
    pub(super) tool: Tool,
}

impl<'a, Inside: Fn(Local) -> bool + Sync> Site<'a, Inside> {
    pub(super) fn new(
        (face, tool, options): (&'a FaceIndex, Tooling<'a>, &'a CoverOptions),
        (chart, whole): (Chart, &'a Region<Inside>),
        (clock, report): (&'a dyn Clock, Report<'a>),
    ) -> Self {
        let (cutter, guards) = tool;
        // Where no pass runs the tool may still go in.
        let sheet = Sheet::new(face, &chart, &whole.complete(), SHEET_SHARE * cutter.radius());
        let tool = Tool::new(cutter);
        Self { face, cutter, options, chart, whole, clock, report, guards, sheet, tool }
    }

    /// Work that passes at the fixed lead take about: as many stations as strips as narrow as a ball's need.
    pub(super) fn usual_work(&self) -> f64 {
        let narrow = super::lane::narrow(self.cutter, self.options).max(self.options.spacing[0]);
        Work::of_stations(self.sheet.area() / (narrow * self.options.spacing[1]))
    }

    /// Extent of the face by local parameter `k` \[mm\].
    pub(super) fn extent(&self, k: usize) -> f64 {
        let (face, chart) = (self.face, &self.chart);
        let at = |local: Local| {
            let [u, v] = chart.uv(local);
            face.face().point(u, v)
        };
        Cell::new(self.whole.bounds, &at).extent(k)
    }

    /// Width of a strip of a ball as wide as the cutter, on a plane \[mm\].
    pub(super) fn narrow(&self) -> f64 {
        super::lane::narrow(self.cutter, self.options)
    }

    /// Least width a pass has to finish \[mm\].
    pub(super) fn least(&self) -> f64 {
        self.options.spacing[0].max(WORTH * self.narrow())
    }

    /// Lays a lane at `across` on what `state` has finished.
    pub(super) fn place(
        &self,
        region: &Region<&Inside>,
        across: f64,
        method: Method,
        state: &State,
    ) -> Result<Lot, CoverError> {
        let CoverOptions { band, path_share, .. } = *self.options;
        let around = self.around();
        let precision = around.precision;
        let lane = Lane {
            face: self.face,
            cutter: self.cutter,
            options: self.options,
            chart: &self.chart,
            across,
            across_range: region.bounds[0],
            track: self.track(region, across)?,
            forward: state.forward,
            method,
            around,
            work: Work::default(),
        };
        let clearing = Clearing {
            face: self.face,
            chart: &self.chart,
            sheet: &self.sheet,
            tool: &self.tool,
            target: band.lower - path_share + precision,
            precision,
        };
        let trimmer = Trimmer { lane: &lane, region, clearing };
        let (mut stretches, refused) = trimmer.stretches();
        let rate = lane.rate_across();
        let mut columns = self.columns(region, [across, rate], (&stretches, state));
        lane.work.columns(columns.len());
        for _ in 0..DENSER {
            let missed: Vec<[f64; 2]> = columns
                .iter()
                .filter(|column| column.part.width < self.least())
                .map(|column| column.along)
                .collect();
            let Some(denser) = trimmer.denser(&stretches, &missed) else { break };
            stretches = denser;
            columns = self.columns(region, [across, rate], (&stretches, state));
            lane.work.columns(columns.len());
        }
        let parts = columns.iter().map(|c| c.part).collect();
        let ended = match method {
            Method::Widest => vec![false; columns.len()],
            Method::Inclined => self.ended(&columns, &stretches, across),
        };
        let refused = refused.map(|(way, error)| ([across, lane.track.at(way)], error));
        let (costs, work) = (lane.costs(), lane.work.done());
        Ok(Lot { rate, stretches, columns, parts, ended, costs, refused, work })
    }

    /// Columns that no other pass at the fixed lean would finish farther: what does not lie between two stations, and where one
    /// of them lies before the lane because the tool has to keep off something.
    fn ended(&self, columns: &[Column], stretches: &[Stretch], across: f64) -> Vec<bool> {
        let range = |pair: &[Placed]| {
            let along = |placed: &Placed| [placed.along, self.chart.local(placed.contact_uv)[1]];
            let all = pair.iter().flat_map(along);
            let low = all.clone().fold(f64::INFINITY, f64::min);
            ([low, all.fold(f64::NEG_INFINITY, f64::max)], pair.iter().any(|p| p.across < across))
        };
        let pairs: Vec<([f64; 2], bool)> =
            stretches.iter().flat_map(|stretch| stretch.placed.windows(2)).map(range).collect();
        let ends = |column: &Column| {
            let [low, high] = column.along;
            let near = || pairs.iter().filter(|([a, b], _)| *a < high && *b > low);
            column.part.width < self.least()
                || near().any(|(_, barred)| *barred)
                || near().map(|([_, b], _)| *b).fold(f64::NEG_INFINITY, f64::max) < high
                || near().map(|([a, _], _)| *a).fold(f64::INFINITY, f64::min) > low
        };
        columns.iter().map(ends).collect()
    }

    /// How far across the region is finished by the stretches and what was before.
    fn columns(
        &self,
        region: &Region<&Inside>,
        [across, rate]: [f64; 2],
        (stretches, state): (&[Stretch], &State),
    ) -> Vec<Column> {
        let mine: Vec<Sweep> = stretches.iter().map(|stretch| self.sweep(stretch)).collect();
        let recent = state.recent.iter().map(AsRef::as_ref);
        let sweeps: Vec<&Sweep> = recent.chain(&mine).collect();
        self.over(region, &sweeps).columns([across, region.bounds[0][1]], rate)
    }

    pub(super) fn sweep(&self, stretch: &Stretch) -> Sweep {
        Sweep::new(&stretch.placed, super::lever(self.cutter))
    }

    fn track(&self, region: &Region<&Inside>, across: f64) -> Result<Track, CoverError> {
        let chart = &self.chart;
        let extension = self.cutter.radius();
        let along = self.over_region(region, across);
        let track = Track::new(self.face, chart, across, along, extension);
        let [start, end] = track.range();
        if end - start > self.options.spacing[0] {
            Ok(track)
        } else {
            let (face, along) = (self.face.face().number, self.options.along);
            Err(CoverError::NoTrack { face, along, across })
        }
    }

    /// Range along in which a pass may have something to cut. Straight lines of the face's own parameters are
    /// taken whole; others leave the face where they please.
    fn over_region(&self, region: &Region<&Inside>, across: f64) -> [f64; 2] {
        if self.chart.is_straight() {
            return region.bounds[1];
        }
        let [first, last] = region.bounds[0];
        let window = WINDOW * self.cutter.radius() / self.extent(0) * (last - first);
        region.range_along([across, across + window]).unwrap_or(region.bounds[1])
    }

    /// What sweeps have finished of a region.
    pub(super) fn over<'b>(
        &'b self,
        region: &'b Region<&'b Inside>,
        sweeps: &'b [&'b Sweep],
    ) -> Swept<'b, &'b Inside> {
        Swept {
            face: self.face,
            chart: &self.chart,
            region,
            end: self.tool.end,
            limit: self.options.band.upper + self.options.path_share,
            smallest: 0.5 * self.options.spacing[0],
            sweeps,
        }
    }

    /// Area of the face \[mm²\], of its cells.
    pub(super) fn area(&self) -> f64 {
        self.sheet.area()
    }

    /// What keeps the tool off the other faces.
    pub(super) fn around(&self) -> Around<'_> {
        let CoverOptions { band, path_share, .. } = *self.options;
        let ((guards, own), tool) = (self.guards, &self.tool);
        let clock = self.clock;
        Around { clock, guards, own, tool, least: band.lower, precision: PRECISION * path_share }
    }
}
