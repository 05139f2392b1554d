//! Looking ahead: lanes are chosen by what comes after them.
//!
//! How far a pass should bring a face on depends on the passes after it: where they come to lie on
//! narrow places decides what these cost. First the face is finished lane by lane with what costs
//! least there ([`Job::whole`]). Then several ways of beginning are kept side by side, lane after
//! lane: those that promise least in the end, where what is left of the face is taken to cost as
//! much as it did the first time. The result never costs more than the first.

use super::options::CoverError;
use super::region::{Local, Region};
use super::site::Site;
use super::split;
use super::state::State;
use super::task::{Job, Mark, Task};
use rayon::prelude::*;

/// Ways that bring a face on to places nearer to each other than this, as a share of what the lane brought,
/// differ by nothing that matters: the cheaper one is kept.
const ALIKE: f64 = 0.02;

/// A way to finish a face up to a place.
struct Way {
    state: State,
    mark: Mark,
    /// What it is taken to cost in the end \[mm\].
    promise: f64,
}

impl Way {
    /// Order of merit: what is left unfinished first.
    fn rank(&self) -> (usize, f64) {
        (self.state.missed.len(), self.promise)
    }

    fn better(&self, other: &Self) -> bool {
        self.rank() < other.rank()
    }
}

/// A search from where passes over a face begin.
pub(super) struct Search<'a, Inside> {
    pub(super) site: &'a Site<'a, Inside>,
    pub(super) task: &'a Task,
    /// What is placed before.
    pub(super) start: &'a State,
    /// The first way through.
    pub(super) marks: &'a [Mark],
    pub(super) work: u64,
    /// Work after which no more is looked for.
    pub(super) limit: u64,
    /// The part of all progress this is.
    pub(super) portion: [f64; 2],
}

impl<Inside: Fn(Local) -> bool + Sync> Search<'_, Inside> {
    /// The best way of all, or the one before, if none is better.
    pub(super) fn run(&mut self, before: State) -> Result<State, CoverError> {
        let [start, end] = self.task.bounds[0];
        let price = |state: &State| state.price(self.site.options);
        let promise = price(&before);
        let mark = Mark { across: end, price: promise };
        let mut best = Way { state: before, mark, promise };
        let mark = Mark { across: start, price: price(self.start) };
        let mut ways = vec![Way { state: self.start.clone(), mark, promise }];
        // A lane costs something: a way that goes nowhere drops out.
        while !ways.is_empty() && self.work <= self.limit {
            let (done, open) = self.on(&ways)?;
            for way in done {
                if way.better(&best) {
                    best = way;
                }
            }
            ways = self.chosen(open, &best);
        }
        Ok(best.state)
    }

    /// Every way carried on by one lane: those that are at the end, and the others.
    fn on(&mut self, ways: &[Way]) -> Result<(Vec<Way>, Vec<Way>), CoverError> {
        let region = self.site.whole.within(self.task.bounds);
        let carried: Vec<_> = ways.par_iter().map(|way| self.children(&region, way)).collect();
        let mut all = Vec::new();
        for result in carried {
            let (children, work) = result?;
            self.work += work;
            all.extend(children);
        }
        let [_, last] = self.task.bounds[0];
        Ok(all.into_iter().partition(|way| way.mark.across >= last))
    }

    /// A way carried on by each of the widths that one lane offers, and the work that took. None where a lane brings
    /// nothing: the first way through knows what to do there.
    fn children(&self, region: &Region<&Inside>, way: &Way) -> Result<(Vec<Way>, u64), CoverError> {
        let across = way.mark.across;
        let [first, last] = self.task.bounds[0];
        let share = (across - first) / (last - first);
        let job = |state: State| {
            let (limits, portion) = ([u64::MAX; 2], self.portion);
            Job { site: self.site, state, work: 0, limits, share, portion }
        };
        let mut before = job(way.state.clone());
        let lot = before.lay(region, across, self.task)?;
        let mut work = before.work;
        let mut children = Vec::new();
        for advance in split::advances(&lot.parts, &lot.costs) {
            if !advance.is_finite() || advance < self.site.least() {
                continue;
            }
            let mut after = job(way.state.clone());
            let next = after.go_on(&lot, advance, across, self.task)?;
            work += after.work;
            let price = after.state.price(self.site.options);
            let mark = Mark { across: next, price };
            let promise = price + self.rest(next);
            if next > across {
                children.push(Way { state: after.state, mark, promise });
            }
        }
        Ok((children, work))
    }

    /// What the face beyond a place cost the first time \[mm\].
    fn rest(&self, across: f64) -> f64 {
        let Some(end) = self.marks.last() else { return 0.0 };
        let after = self.marks.partition_point(|mark| mark.across <= across);
        let (Some(a), Some(b)) = (self.marks.get(after.saturating_sub(1)), self.marks.get(after))
        else {
            return 0.0;
        };
        let share = (across - a.across) / (b.across - a.across);
        end.price - (a.price + share * (b.price - a.price))
    }

    /// The ways worth carrying on.
    fn chosen(&self, mut open: Vec<Way>, best: &Way) -> Vec<Way> {
        // A stable sort: equal ones stay in order.
        open.sort_by(|a, b| {
            let ((m, p), (n, q)) = (a.rank(), b.rank());
            m.cmp(&n).then(p.total_cmp(&q))
        });
        let [first, last] = self.task.bounds[0];
        let lane = (last - first) / self.marks.len().max(1) as f64;
        let mut kept: Vec<Way> = Vec::new();
        for way in open {
            let alike = |other: &Way| {
                (way.mark.across - other.mark.across).abs() < ALIKE * lane
                    && way.state.forward == other.state.forward
            };
            let cheaper =
                way.state.missed.len() <= best.state.missed.len() && way.mark.price < best.promise;
            if kept.len() < self.site.options.ahead && cheaper && !kept.iter().any(alike) {
                kept.push(way);
            }
        }
        kept
    }
}
