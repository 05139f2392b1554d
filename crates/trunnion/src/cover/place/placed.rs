//! Passes that are placed so far, with their report.

use crate::cover::cost::PassCost;
use crate::cover::layout::chart::Chart;
use crate::cover::options::CoverOptions;
use crate::cover::pattern::CutPattern;
use crate::cover::place::trim::PassSegment;
use crate::cover::prove::sweep::PassSweep;
use crate::cover::report::{CoverReport, Covering, LayoutCost};
use crate::math::angle::angle_between;
use crate::types::Pass;
use std::sync::Arc;

/// Number of the last passes whose sweeps are compared with each new candidate.
const MEMORY: usize = 8;

/// Passes placed so far. Cheap to copy, since the passes are shared.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlacedPasses {
    pub(crate) passes: Vec<Arc<Pass>>,
    pub(crate) report: CoverReport,
    /// Cost of all passes, as a length \[mm\].
    price: f64,
    /// `true` if the next pass runs towards growing parameters.
    pub(crate) forward: bool,
    /// Curves of the last passes.
    pub(crate) recent: Vec<Arc<PassSweep>>,
    /// Curves of all passes before these.
    pub(crate) swept: Vec<Arc<PassSweep>>,
    /// Ranges of u and v that were left unfinished when they should have been finished.
    pub(crate) missed: Vec<[[f64; 2]; 2]>,
    /// Resolution of the remaining area \[mm²\].
    pub(crate) resolved: f64,
}

/// Face, chart and options of passes that are added.
#[derive(Clone, Copy)]
pub(crate) struct PassSource<'a> {
    /// Number of the face.
    pub(crate) face: usize,
    pub(crate) chart: &'a Chart,
    pub(crate) options: &'a CoverOptions,
    pub(crate) cost: &'a dyn PassCost,
}

impl PlacedPasses {
    /// Starts without passes.
    pub(crate) fn new() -> Self {
        Self { forward: true, ..Self::default() }
    }

    /// Returns a copy whose next pass runs the other way.
    pub(crate) fn turned(&self) -> Self {
        Self { forward: !self.forward, ..self.clone() }
    }

    /// Returns the curves of all passes.
    pub(crate) fn sweeps(&self) -> impl Iterator<Item = &PassSweep> {
        self.swept.iter().chain(&self.recent).map(AsRef::as_ref)
    }

    /// Returns the cost of all passes, as the length that is cut at the feed in that time \[mm\].
    pub(crate) fn price(&self) -> f64 {
        self.price
    }

    /// Returns the cost of the passes, which are on a chart.
    pub(crate) fn cost_on(&self, chart: &Chart) -> LayoutCost {
        LayoutCost { layout: chart.layout(), cost: self.price(), rest: self.left() }
    }

    /// Returns the index of the best of several results, the first of equals.
    ///
    /// A result that finishes everything comes before one that does not. Among results that leave something, it is
    /// the cheapest that leaves no more than the least, as far as areas are resolved.
    pub(crate) fn best<'a>(tried: impl Iterator<Item = &'a Self> + Clone) -> Option<usize> {
        let least = tried.clone().min_by(|a, b| a.left().total_cmp(&b.left()))?;
        let as_good = tried.enumerate().filter(|(_, one)| !one.leaves_more(least));
        as_good.min_by(|(_, a), (_, b)| a.price.total_cmp(&b.price)).map(|(index, _)| index)
    }

    /// Returns `true` if this leaves more unfinished than `other`, by more than the resolution of the areas.
    pub(crate) fn leaves_more(&self, other: &Self) -> bool {
        let more = self.left() - other.left();
        let finished = other.report.rest.is_empty();
        if finished { more > 0.0 } else { more > self.resolved.max(other.resolved) }
    }

    /// Returns the area that is left unfinished \[mm²\].
    pub(crate) fn left(&self) -> f64 {
        self.report.rest.iter().map(|part| part.area).sum()
    }

    /// Returns the result.
    pub(crate) fn covering(self) -> Covering {
        let passes = self.passes.into_iter().map(Arc::unwrap_or_clone).collect();
        Covering { passes, report: CoverReport { cost: self.price, ..self.report } }
    }

    /// Adds the segments of one candidate pass, whose curves are `sweeps`.
    pub(crate) fn add(
        &mut self,
        mut segments: Vec<PassSegment>,
        sweeps: impl Iterator<Item = PassSweep>,
        source: PassSource<'_>,
    ) {
        if segments.is_empty() {
            return;
        }
        self.recent.extend(sweeps.map(Arc::new));
        // Only the last sweeps are compared with new candidates; older ones serve the final proof.
        // No pass reaches back farther across than a few of its predecessors.
        let old = self.recent.len().saturating_sub(MEMORY);
        self.swept.extend(self.recent.drain(..old));
        if !self.forward {
            segments.reverse();
        }
        for segment in segments {
            self.note(&segment, source.options);
            let pass = self.pass(segment, source);
            self.add_pass(pass, source);
        }
        if source.options.pattern == CutPattern::ZigZag {
            self.forward = !self.forward;
        }
    }

    /// Adds a pass that is one segment.
    pub(crate) fn add_whole(&mut self, pass: Pass, sweep: PassSweep, source: PassSource<'_>) {
        self.recent.push(Arc::new(sweep));
        self.add_pass(pass, source);
    }

    fn add_pass(&mut self, pass: Pass, source: PassSource<'_>) {
        let pairs = pass.stations.windows(2);
        self.report.length += pairs.map(|s| (s[1].contact - s[0].contact).norm()).sum::<f64>();
        self.report.stations += pass.stations.len();
        self.price += self.seconds(&pass, source.cost) * source.cost.feed();
        self.passes.push(Arc::new(pass));
    }

    /// Returns the time of a pass with the link to it \[s\]. The first link is taken to be as long as any.
    fn seconds(&self, pass: &Pass, cost: &dyn PassCost) -> f64 {
        let Some(first) = pass.stations.first() else { return 0.0 };
        let before = self.passes.last().and_then(|pass| pass.stations.last());
        cost.link(before.unwrap_or(first), first) + cost.pass(&pass.stations)
    }

    /// Adds the checks and axis turns of a segment to the report.
    fn note(&mut self, segment: &PassSegment, options: &CoverOptions) {
        let report = &mut self.report;
        report.shortened += usize::from(segment.shortened.contains(&true));
        for check in segment.checks.iter().filter(|check| !check.good) {
            report.coarse_spans += 1;
            report.worst_gouge = report.worst_gouge.max(check.gouge);
        }
        for pair in segment.placed.windows(2) {
            let turn = angle_between(&pair[0].station.pose.axis, &pair[1].station.pose.axis);
            let rate = turn / (pair[1].arc - pair[0].arc);
            report.axis_turn = report.axis_turn.max(rate);
            report.fast_turns += usize::from(rate > options.max_axis_turn);
        }
    }

    /// Makes a pass of a segment, with its stations in cutting order.
    fn pass(&self, segment: PassSegment, source: PassSource<'_>) -> Pass {
        let mut placed = segment.placed;
        if !self.forward {
            placed.reverse();
        }
        let track = placed.iter().map(|p| source.chart.uv([p.across, p.along]).into()).collect();
        let widths = placed.iter().map(|p| p.location.strip_width).collect();
        let stations = placed.into_iter().map(|p| p.station).collect();
        Pass { face: source.face, stations, widths, track }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::types::{Interval, Uv};
    use crate::types::{UncutReason, UncutRegion};
    use nalgebra::Point3;

    /// A region of which only the area \[mm²\] matters.
    pub(crate) fn region_of_area(area: f64) -> UncutRegion {
        UncutRegion {
            face: 1,
            cells: Vec::new(),
            area,
            uv: [Interval::point(0.0); 2],
            bounds: [Point3::origin(); 2],
            depth: 0.0,
            deepest: Uv::new(0.0, 0.0),
            point: Point3::origin(),
            ball: 1.0,
            balls: Interval::point(1.0),
            reason: UncutReason::Hollow,
        }
    }

    fn placed(area: f64, price: f64) -> PlacedPasses {
        let rest = if area > 0.0 { vec![region_of_area(area)] } else { Vec::new() };
        let report = CoverReport { rest, ..CoverReport::default() };
        PlacedPasses { price, report, resolved: 0.1, ..PlacedPasses::new() }
    }

    fn best(tried: &[(f64, f64)]) -> f64 {
        let tried: Vec<_> = tried.iter().map(|(area, price)| placed(*area, *price)).collect();
        tried[PlacedPasses::best(tried.iter()).unwrap()].price
    }

    #[test]
    fn an_area_within_the_resolution_does_not_outvote_the_price() {
        assert!((best(&[(2.0, 900.0), (2.001, 500.0)]) - 500.0).abs() < 1e-12);
        assert!((best(&[(2.001, 500.0), (2.0, 900.0)]) - 500.0).abs() < 1e-12);
        assert!((best(&[(2.0, 900.0), (2.2, 500.0)]) - 900.0).abs() < 1e-12);
        // Each is as good as the next, but the last is not as good as the first.
        assert!((best(&[(2.0, 900.0), (2.08, 700.0), (2.16, 500.0)]) - 700.0).abs() < 1e-12);
        // A face that is finished is, whatever it takes.
        assert!((best(&[(0.0, 900.0), (0.001, 500.0)]) - 900.0).abs() < 1e-12);
        assert!((best(&[(0.0, 900.0), (0.0, 500.0)]) - 500.0).abs() < 1e-12);
    }
}
