//! Trial of a candidate pass: the segments that it cuts, and how far they finish the face.

use crate::cover::layout::advance::{AdvanceCosts, PassPart};
use crate::cover::layout::effort::WorkCounter;
use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::cover::layout::track::EndPointTrack;
use crate::cover::pattern::PlacementMethod;
use crate::cover::place::candidate::{CandidatePass, PlacedStation};
use crate::cover::place::context::FaceContext;
use crate::cover::place::placed::PlacedPasses;
use crate::cover::place::trim::{PassSegment, PassTrimmer, SpanProof};
use crate::cover::prove::coverage::PassColumn;
use crate::cover::prove::sweep::PassSweep;
use crate::cover::report::FallbackReason;
use crate::positioning::PositioningError;

/// Largest number of times that stations are added where a pass finishes nothing at its track.
const DENSER: usize = 3;

/// Width that a pass may cut across, in radii of the cutter.
const WINDOW: f64 = 4.0;

/// Point of a candidate pass without cutter location, with the reason.
#[derive(Debug, Clone)]
pub(crate) struct RefusedPlace {
    /// Point across and along.
    pub(crate) at: ChartPoint,
    pub(crate) error: PositioningError,
}

/// Candidate pass as it would be cut, and the strip that it finishes.
pub(crate) struct TrialPass {
    /// Length of a step across by the parameter \[mm\].
    pub(crate) rate: f64,
    pub(crate) segments: Vec<PassSegment>,
    /// Columns of the face across the pass.
    pub(crate) columns: Vec<PassColumn>,
    /// Length and finished width of each column.
    pub(crate) parts: Vec<PassPart>,
    /// `true` for columns that no other pass at the fixed inclination would finish farther: it has nothing there, or
    /// keeps off something.
    pub(crate) ended: Vec<bool>,
    pub(crate) costs: AdvanceCosts,
    /// First point in the region without a location.
    pub(crate) refused: Option<RefusedPlace>,
    /// Work of the trial.
    pub(crate) work: u64,
}

impl TrialPass {
    /// Returns the length along \[mm\].
    pub(crate) fn length(&self) -> f64 {
        self.parts.iter().map(|part| part.length).sum()
    }

    /// Returns the length of the parts that are finished narrower than `width` \[mm\].
    pub(crate) fn length_below(&self, width: f64) -> f64 {
        let narrow = self.parts.iter().filter(|part| part.width < width);
        narrow.map(|part| part.length).sum()
    }

    /// Returns the parts that further passes would finish.
    pub(crate) fn open(&self) -> Vec<PassPart> {
        let open = self.parts.iter().zip(&self.ended).filter(|(_, ended)| !**ended);
        open.map(|(part, _)| *part).collect()
    }

    /// Returns `true` if the pass finishes some columns up to the end of the region across and has nothing in the others, of
    /// which more than a strip is left: passes beyond the next track may finish these.
    pub(crate) fn ends_early(&self, end: f64) -> bool {
        let strip = self.costs.narrow / self.rate;
        let mut columns = self.columns.iter().zip(&self.ended);
        let mut left = self.columns.iter().map(|column| end - column.finished);
        columns.all(|(column, ended)| *ended || column.finished >= end)
            && left.any(|left| left > strip)
    }

    /// Returns the parameter across to which all columns at least `width` \[mm\] wide are finished.
    pub(crate) fn reach(&self, width: f64) -> f64 {
        let counting = self.columns.iter().zip(&self.parts).filter(|(_, part)| part.width >= width);
        counting.map(|(column, _)| column.finished).fold(f64::INFINITY, f64::min)
    }

    /// Returns the range along of some columns.
    pub(crate) fn along(&self, [first, last]: [usize; 2]) -> [f64; 2] {
        [self.columns[first].along[0], self.columns[last].along[1]]
    }

    /// Returns the reason why wide strips are not taken on some columns, and the point across and
    /// along that caused it.
    pub(crate) fn fallback(
        &self,
        [first, last]: [usize; 2],
    ) -> Option<(ChartPoint, FallbackReason)> {
        let (a, b) = (self.columns.get(first)?, self.columns.get(last)?);
        let near = |at: &ChartPoint| (a.along[0]..=b.along[1]).contains(&at[1]);
        let refused = self.refused.clone().filter(|refused| near(&refused.at));
        Some(refused.map_or_else(
            || ([a.finished, a.along[0]], FallbackReason::Missed(last + 1 - first)),
            |RefusedPlace { at, error }| (at, FallbackReason::NoStrip(error)),
        ))
    }
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> FaceContext<'_, Inside> {
    /// Lays a candidate pass at `across`, beside the passes that are placed; `None` where the track is a point, as at a
    /// collapsed edge.
    pub(crate) fn lay(
        &self,
        region: &TrimmedRegion<&Inside>,
        across: f64,
        method: PlacementMethod,
        proof: SpanProof,
        placed: &PlacedPasses,
    ) -> Option<TrialPass> {
        let keep_off = self.keep_off();
        let clearance = self.clearance(keep_off.precision);
        let candidate = CandidatePass {
            face: self.face,
            cutter: self.setup.cutter,
            options: self.options,
            chart: &self.chart,
            across,
            across_range: region.bounds[0],
            track: self.track(region, across)?,
            forward: placed.forward,
            method,
            keep_off,
            work: WorkCounter::default(),
        };
        let trimmer = PassTrimmer { candidate: &candidate, region, clearance, proof };
        // Step 1: the segments as stations along the track give them, and how far they finish the region.
        let (mut segments, refused) = trimmer.segments();
        let rate = candidate.rate_across();
        let start = ColumnStart { across, rate };
        let mut columns = self.columns(region, start, &segments, placed);
        candidate.work.columns(columns.len());
        // Step 2: more stations where columns are not finished at the track itself.
        for _ in 0..DENSER {
            let missed: Vec<[f64; 2]> = columns
                .iter()
                .filter(|column| column.part.width < self.least())
                .map(|column| column.along)
                .collect();
            let Some(denser) = trimmer.denser(&segments, &missed) else { break };
            segments = denser;
            columns = self.columns(region, start, &segments, placed);
            candidate.work.columns(columns.len());
        }
        let parts = columns.iter().map(|c| c.part).collect();
        let ended = match method {
            PlacementMethod::Widest => vec![false; columns.len()],
            PlacementMethod::Inclined => self.ended(&columns, &segments, across),
        };
        let refused = refused.map(|refused| RefusedPlace {
            at: [across, candidate.track.at(refused.arc)],
            error: refused.error,
        });
        let (costs, work) = (candidate.costs(), candidate.work.done());
        Some(TrialPass { rate, segments, columns, parts, ended, costs, refused, work })
    }

    /// Finds the columns that no other pass at the fixed inclination would finish farther.
    ///
    /// They do not lie between two stations, or one of these lies before the track because the tool has to keep off
    /// something.
    fn ended(&self, columns: &[PassColumn], segments: &[PassSegment], across: f64) -> Vec<bool> {
        let range = |pair: &[PlacedStation]| {
            let along = |placed: &PlacedStation| {
                [placed.along, self.chart.local(placed.contact_uv.into())[1]]
            };
            let all = pair.iter().flat_map(along);
            let low = all.clone().fold(f64::INFINITY, f64::min);
            ([low, all.fold(f64::NEG_INFINITY, f64::max)], pair.iter().any(|p| p.across < across))
        };
        let pairs: Vec<([f64; 2], bool)> =
            segments.iter().flat_map(|segment| segment.placed.windows(2)).map(range).collect();
        let ends = |column: &PassColumn| {
            let [low, high] = column.along;
            // Pairs of stations whose range along overlaps the column.
            let near = || pairs.iter().filter(|([a, b], _)| *a < high && *b > low);
            column.part.width < self.least()
                || near().any(|(_, barred)| *barred)
                || near().map(|([_, b], _)| *b).fold(f64::NEG_INFINITY, f64::max) < high
                || near().map(|([a, _], _)| *a).fold(f64::INFINITY, f64::min) > low
        };
        columns.iter().map(ends).collect()
    }

    /// Finds how far across the region is finished by the segments and the passes before them.
    fn columns(
        &self,
        region: &TrimmedRegion<&Inside>,
        start: ColumnStart,
        segments: &[PassSegment],
        placed: &PlacedPasses,
    ) -> Vec<PassColumn> {
        let mine: Vec<PassSweep> = segments.iter().map(|segment| self.sweep(segment)).collect();
        let recent = placed.recent.iter().map(AsRef::as_ref);
        let sweeps: Vec<&PassSweep> = recent.chain(&mine).collect();
        let across = [start.across, region.bounds[0][1]];
        self.coverage(region, &sweeps).columns(across, start.rate)
    }

    /// Returns the end-point track at `across`; `None` if it is shorter than the least spacing of stations.
    fn track(&self, region: &TrimmedRegion<&Inside>, across: f64) -> Option<EndPointTrack> {
        let chart = &self.chart;
        let extension = self.setup.cutter.radius();
        let along = self.over_region(region, across);
        let track = EndPointTrack::new(self.face, chart, across, along, extension);
        let [start, end] = track.range();
        (end - start > self.options.spacing.low).then_some(track)
    }

    /// Returns the range along in which a pass may have something to cut.
    ///
    /// Straight lines of the face's own parameters are taken whole; bent lines leave the face anywhere.
    fn over_region(&self, region: &TrimmedRegion<&Inside>, across: f64) -> [f64; 2] {
        if self.chart.is_straight() {
            return region.bounds[1];
        }
        let [first, last] = region.bounds[0];
        // Convert the window from mm to the parameter across, by the extent of the face.
        let window = WINDOW * self.setup.cutter.radius() / self.extent(0) * (last - first);
        region.range_along([across, across + window]).unwrap_or(region.bounds[1])
    }
}

/// Track from which columns are measured.
#[derive(Debug, Clone, Copy)]
struct ColumnStart {
    /// Parameter across.
    across: f64,
    /// Length of a unit step across \[mm\].
    rate: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trial from 0 on, of columns that are finished up to a parameter, or have ended there.
    fn trial(columns: &[(f64, bool)]) -> TrialPass {
        let part = PassPart { length: 1.0, width: 1.0 };
        let column = |(finished, _): &(f64, bool)| PassColumn {
            along: [0.0, 1.0],
            finished: *finished,
            part,
        };
        TrialPass {
            rate: 2.0,
            segments: Vec::new(),
            columns: columns.iter().map(column).collect(),
            parts: vec![part; columns.len()],
            ended: columns.iter().map(|(_, ended)| *ended).collect(),
            costs: AdvanceCosts { pass: 1.0, narrow: 4.0 },
            refused: None,
            work: 0,
        }
    }

    #[test]
    fn a_pass_ends_early_where_other_columns_are_more_than_a_strip_from_the_end() {
        // A strip is 2 across.
        assert!(trial(&[(10.0, false), (0.0, true)]).ends_early(10.0));
        assert!(!trial(&[(10.0, false), (9.0, true)]).ends_early(10.0));
        // Columns that go on give the next track.
        assert!(!trial(&[(10.0, false), (1.0, false), (0.0, true)]).ends_early(10.0));
        assert!(!trial(&[(10.0, false)]).ends_early(10.0));
    }
}
