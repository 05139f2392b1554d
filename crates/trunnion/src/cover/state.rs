//! What is placed on the way to a whole face.

use super::chart::Chart;
use super::clock::Clock;
use super::left::Column;
use super::options::FallbackReason;
use super::options::{CoverOptions, CoverReport, Covering, Direction, Fallback};
use super::region::Local;
use super::split::{Costs, Part};
use super::stretch::Stretch;
use super::sweep::Sweep;
use crate::math::angle::angle_between;
use crate::positioning::PositioningError;
use crate::types::Pass;
use std::sync::Arc;

/// Passes before the last one whose finish is taken into account.
const MEMORY: usize = 8;

/// How a pass brought a task on.
pub(super) struct Step {
    /// How far across.
    pub(super) next: f64,
    /// Length of a step across by the parameter \[mm\].
    pub(super) rate: f64,
    /// What another pass over all of it costs \[mm\].
    pub(super) again: f64,
}

/// What is cut on one track, and what it leaves.
pub(super) struct Lot {
    /// Length of a step across by the parameter \[mm\].
    pub(super) rate: f64,
    pub(super) stretches: Vec<Stretch>,
    pub(super) columns: Vec<Column>,
    pub(super) parts: Vec<Part>,
    /// Columns that no other pass at the fixed lean would finish farther: it has nothing there, or keeps off something.
    pub(super) ended: Vec<bool>,
    pub(super) costs: Costs,
    /// Where no location was found, and why.
    pub(super) refused: Option<(Local, PositioningError)>,
    /// What it took to lay it.
    pub(super) work: u64,
}

impl Lot {
    /// Length along \[mm\].
    pub(super) fn length(&self) -> f64 {
        self.parts.iter().map(|part| part.length).sum()
    }

    /// Length of what it finishes narrower than `width` \[mm\].
    pub(super) fn length_below(&self, width: f64) -> f64 {
        let narrow = self.parts.iter().filter(|part| part.width < width);
        narrow.map(|part| part.length).sum()
    }

    /// Parts that further passes would finish.
    pub(super) fn open(&self) -> Vec<Part> {
        let open = self.parts.iter().zip(&self.ended).filter(|(_, ended)| !**ended);
        open.map(|(part, _)| *part).collect()
    }

    /// How far across all columns that count for `width` \[mm\] are finished.
    pub(super) fn reach(&self, width: f64) -> f64 {
        let counting = self.columns.iter().zip(&self.parts).filter(|(_, part)| part.width >= width);
        counting.map(|(column, _)| column.finished).fold(f64::INFINITY, f64::min)
    }

    /// Range along of some columns.
    pub(super) fn along(&self, [first, last]: [usize; 2]) -> [f64; 2] {
        [self.columns[first].along[0], self.columns[last].along[1]]
    }

    /// Why wide strips are not taken on some columns.
    pub(super) fn fallback(
        &self,
        [first, last]: [usize; 2],
        (face, chart): (usize, &Chart),
    ) -> Option<Fallback> {
        let (a, b) = (self.columns.get(first)?, self.columns.get(last)?);
        let near = |at: &Local| (a.along[0]..=b.along[1]).contains(&at[1]);
        let refused = self.refused.clone().filter(|(at, _)| near(at));
        let (at, reason) = refused.map_or_else(
            || ([a.finished, a.along[0]], FallbackReason::Missed(last + 1 - first)),
            |(at, error)| (at, FallbackReason::NoStrip(error)),
        );
        Some(Fallback { face, at: chart.uv(at), uv: [[0.0; 2]; 2], reason })
    }
}

/// What was placed so far. Cheap to copy: what is placed is shared.
#[derive(Debug, Clone, Default)]
pub(super) struct State {
    pub(super) passes: Vec<Arc<Pass>>,
    pub(super) report: CoverReport,
    /// What all passes cost, as a length \[mm\].
    price: f64,
    /// Whether the next pass runs towards growing parameters.
    pub(super) forward: bool,
    /// Curves of the last passes.
    pub(super) recent: Vec<Arc<Sweep>>,
    /// Curves of all passes before these.
    pub(super) swept: Vec<Arc<Sweep>>,
    /// Ranges of u and v in which something was left unfinished when it should have been finished.
    pub(super) missed: Vec<[[f64; 2]; 2]>,
    /// To what the area of what is left is told \[mm²\].
    pub(super) resolved: f64,
}

impl State {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        Self { forward: true, ..Self::default() }
    }

    /// The same with the next pass run the other way.
    pub(super) fn turned(&self) -> Self {
        Self { forward: !self.forward, ..self.clone() }
    }

    /// What all passes cost, as a length that is cut at the feed in that time \[mm\].
    pub(super) fn price(&self) -> f64 {
        self.price
    }

    /// The best of some, the first of equals: what finishes all comes before what does not; of what leaves something, the
    /// cheapest that leaves no more than the least, as far as areas are told.
    pub(super) fn best<'a, T>(tried: &'a [(Self, T)]) -> Option<&'a (Self, T)> {
        let states = || tried.iter().map(|(state, _)| state);
        let least = states().min_by(|a, b| a.left().total_cmp(&b.left()))?;
        let price = |tried: &&'a (Self, T)| tried.0.price;
        let as_good = tried.iter().filter(|(state, _)| !state.leaves_more(least));
        as_good.min_by(|a, b| price(a).total_cmp(&price(b)))
    }

    /// Whether this leaves more unfinished than another one, and not only by what its area is told to.
    pub(super) fn leaves_more(&self, other: &Self) -> bool {
        let more = self.left() - other.left();
        let finished = other.report.rest.is_empty();
        if finished { more > 0.0 } else { more > self.resolved.max(other.resolved) }
    }

    /// Area of what is left unfinished \[mm²\].
    pub(super) fn left(&self) -> f64 {
        self.report.rest.iter().map(|part| part.area).sum()
    }

    /// The result.
    pub(super) fn covering(self) -> Covering {
        let passes = self.passes.into_iter().map(Arc::unwrap_or_clone).collect();
        Covering { passes, report: CoverReport { price: self.price, ..self.report } }
    }

    /// Adds the passes of one lane on a face, whose curves are `sweeps`.
    pub(super) fn add(
        &mut self,
        mut stretches: Vec<Stretch>,
        sweeps: impl Iterator<Item = Sweep>,
        (face, chart, options): (usize, &Chart, &CoverOptions),
        clock: &dyn Clock,
    ) {
        if stretches.is_empty() {
            return;
        }
        self.recent.extend(sweeps.map(Arc::new));
        let old = self.recent.len().saturating_sub(MEMORY);
        self.swept.extend(self.recent.drain(..old));
        if !self.forward {
            stretches.reverse();
        }
        for stretch in stretches {
            self.note(&stretch, options);
            let pass = self.pass(stretch, (face, chart));
            let pairs = pass.stations.windows(2);
            self.report.length += pairs.map(|s| (s[1].contact - s[0].contact).norm()).sum::<f64>();
            self.report.stations += pass.stations.len();
            self.price += self.seconds(&pass, clock) * clock.feed();
            self.passes.push(Arc::new(pass));
        }
        if options.direction == Direction::ZigZag {
            self.forward = !self.forward;
        }
    }

    /// What a pass takes, with the way to it. That to the first is taken to be as long as any.
    fn seconds(&self, pass: &Pass, clock: &dyn Clock) -> f64 {
        let Some(first) = pass.stations.first() else { return 0.0 };
        let before = self.passes.last().and_then(|pass| pass.stations.last());
        clock.link(before.unwrap_or(first), first) + clock.pass(&pass.stations)
    }

    fn note(&mut self, stretch: &Stretch, options: &CoverOptions) {
        let report = &mut self.report;
        report.shortened += usize::from(stretch.shortened.contains(&true));
        for check in stretch.checks.iter().filter(|check| !check.good) {
            report.coarse_spans += 1;
            report.worst_gouge = report.worst_gouge.max(check.gouge);
        }
        for pair in stretch.placed.windows(2) {
            let turn = angle_between(&pair[0].station.pose.axis, &pair[1].station.pose.axis);
            let rate = turn / (pair[1].way - pair[0].way);
            report.axis_turn = report.axis_turn.max(rate);
            report.fast_turns += usize::from(rate > options.max_axis_turn);
        }
    }

    /// Stations in cutting order.
    fn pass(&self, stretch: Stretch, (face, chart): (usize, &Chart)) -> Pass {
        let mut placed = stretch.placed;
        if !self.forward {
            placed.reverse();
        }
        let track = placed.iter().map(|p| chart.uv([p.across, p.along])).collect();
        let widths = placed.iter().map(|p| p.location.strip_width).collect();
        let stations = placed.into_iter().map(|p| p.station).collect();
        Pass { face, stations, widths, track }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{UncutReason, UncutRegion};
    use nalgebra::Point3;

    fn state(area: f64, price: f64) -> (State, ()) {
        let rest = UncutRegion {
            face: 1,
            cells: Vec::new(),
            area,
            uv: [[0.0; 2]; 2],
            bounds: [Point3::origin(); 2],
            depth: 0.0,
            deepest: [0.0; 2],
            point: Point3::origin(),
            ball: 1.0,
            balls: [1.0; 2],
            reason: UncutReason::Hollow,
        };
        let rest = if area > 0.0 { vec![rest] } else { Vec::new() };
        let report = CoverReport { rest, ..CoverReport::default() };
        (State { price, report, resolved: 0.1, ..State::new() }, ())
    }

    fn best(tried: &[(f64, f64)]) -> f64 {
        let tried: Vec<_> = tried.iter().map(|(area, price)| state(*area, *price)).collect();
        State::best(&tried).unwrap().0.price
    }

    #[test]
    fn an_area_that_is_not_told_from_another_does_not_outvote_the_price() {
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
