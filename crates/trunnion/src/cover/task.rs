//! A rectangle of a face, and the passes that finish it.

use super::left::Column;
use super::options::{CoverError, Direction, Fallback, FallbackReason, Method};
use super::region::{Local, Region};
use super::site::Site;
use super::split;
use super::state::{Lot, State, Step};
use crate::positioning::PositioningError;

/// Step across over what the tool cannot finish, in widths of a narrow strip: what it can finish again begins at most
/// that far from where it is found to.
const STEP: f64 = 0.25;

/// Share of the work allowed that trying several ways on may take.
const PACE: f64 = 0.5;

/// Tasks within tasks.
const DEPTH: u32 = 2;

/// A rectangle of local parameters to be finished.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task {
    pub(super) bounds: [[f64; 2]; 2],
    pub(super) method: Method,
    /// How many tasks this is part of.
    pub(super) depth: u32,
    /// What it costs to leave one millimetre across to the task it is part of \[mm/mm\].
    pub(super) worth: f64,
}

/// A face while its passes are placed.
pub(super) struct Job<'a, Inside> {
    pub(super) site: &'a Site<'a, Inside>,
    pub(super) state: State,
    /// Work done so far.
    pub(super) work: u64,
    /// Work from which on wide strips are given up, and from which on everything is.
    pub(super) limits: [u64; 2],
    /// How much of the face is done.
    pub(super) share: f64,
}

impl<Inside: Fn(Local) -> bool + Sync> Job<'_, Inside> {
    /// Passes over all of a face, the best lane by lane.
    pub(super) fn whole(&mut self, task: &Task) -> Result<(), CoverError> {
        let [first, last] = task.bounds[0];
        let region = self.site.whole.within(task.bounds);
        let mut next = first;
        loop {
            self.share = (next - first) / (last - first);
            let Some(step) = self.lane(&region, next, task)? else { return Ok(()) };
            next = step.next;
        }
    }

    /// Passes over a rectangle within a face, one beside the other; how far across they bring it. A rest
    /// that is cheaper to leave to the task this is part of is left.
    fn finish(&mut self, task: &Task) -> Result<f64, CoverError> {
        let region = self.site.whole.within(task.bounds);
        let [first, last] = task.bounds[0];
        let mut next = first;
        loop {
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
        (self.site.report)(self.share)?;
        if self.work > self.limits[1] {
            let [_, end] = region.bounds[0];
            self.state.missed.push(self.site.uv_range([[across, end], region.bounds[1]]));
            return Ok(None);
        }
        let Some(across) = region.next_from(across) else { return Ok(None) };
        let task = &self.within_limits(across, task);
        let lot = self.lay(region, across, task)?;
        let parts = lot.open();
        let mut advances = if task.depth == 0 {
            split::advances(&parts, &lot.costs)
        } else if task.depth < DEPTH {
            vec![split::advance(&parts, &lot.costs)]
        } else {
            let widths = parts.iter().map(|part| part.width);
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

    /// Lays a lane beside what is there. Where the machine does not get to the leans that one feed direction allows, the
    /// other is tried as well, unless all passes have to run one way.
    pub(super) fn lay(
        &mut self,
        region: &Region<&Inside>,
        across: f64,
        task: &Task,
    ) -> Result<Lot, CoverError> {
        let lot = self.site.place(region, across, task.method, &self.state)?;
        self.work += lot.work;
        let far = matches!(lot.refused, Some((_, PositioningError::OutOfReach { .. })));
        let zigzag = self.site.options.direction == Direction::ZigZag;
        if !(far && zigzag && task.method == Method::Inclined) {
            return Ok(lot);
        }
        let forward = !self.state.forward;
        let back = self.state.turned();
        let other = self.site.place(region, across, task.method, &back)?;
        self.work += other.work;
        let least = self.least();
        if other.length_below(least) < lot.length_below(least) {
            self.state.forward = forward;
            return Ok(other);
        }
        Ok(lot)
    }

    /// The task, at the fixed lead once wide strips have taken all work that they may.
    fn within_limits(&mut self, across: f64, task: &Task) -> Task {
        let face = self.site.face.face().number;
        if self.work <= self.limits[0] || task.method == Method::Inclined {
            return *task;
        }
        if self.state.report.given_up.is_none() {
            let [[_, end], along] = self.site.whole.bounds;
            let at = self.site.chart.uv([across, task.bounds[1][0]]);
            let (uv, reason) = (self.site.uv_range([[across, end], along]), FallbackReason::Effort);
            self.state.report.given_up = Some((face, at, self.share));
            self.state.report.fallbacks.push(Fallback { face, at, uv, reason });
        }
        Task { method: Method::Inclined, ..*task }
    }

    /// Adds the pass and those that finish what it leaves narrower than `advance` \[mm\].
    pub(super) fn go_on(
        &mut self,
        lot: &Lot,
        advance: f64,
        across: f64,
        task: &Task,
    ) -> Result<f64, CoverError> {
        let mut next = lot.reach(advance).min(across + advance / lot.rate);
        self.add(lot);
        for run in self.served(lot, advance, next) {
            next = self.again(lot, run, [across, next], task)?.min(next);
        }
        Ok(next)
    }

    /// Runs of columns that are narrower than `advance` \[mm\] and take passes of their own. Those that none would finish
    /// farther are left.
    fn served(&mut self, lot: &Lot, advance: f64, next: f64) -> Vec<[usize; 2]> {
        let mut served = Vec::new();
        for [first, last] in split::narrower(&lot.parts, advance) {
            let ended = |i: &usize| lot.ended[*i];
            for part in (first..=last).collect::<Vec<_>>().chunk_by(|a, b| ended(a) == ended(b)) {
                let run = [part[0], part[part.len() - 1]];
                if ended(&run[0]) {
                    self.miss(&lot.columns[run[0]..=run[1]], next);
                } else {
                    served.push(run);
                }
            }
        }
        served
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
            let cost = self.state.price() - before.price();
            let (missed, rate) = (self.state.missed.len(), cost / (next - across));
            let better = |(m, r, ..): &(usize, f64, f64, State)| (missed, rate) < (*m, *r);
            if best.as_ref().is_none_or(better) {
                best = Some((missed, rate, next, self.state.clone()));
            }
            if self.behind(next) {
                break;
            }
        }
        let Some((_, _, next, state)) = best else { return Ok(across) };
        self.state = state;
        Ok(next)
    }

    /// Whether so much work was done up to a place across that, going on like this, more than [`PACE`] of what may be
    /// done would be: then other ways on are not looked at.
    fn behind(&self, next: f64) -> bool {
        let [first, last] = self.site.whole.bounds[0];
        let [_, limit] = self.limits;
        self.work as f64 > PACE * limit as f64 * ((next - first) / (last - first))
    }

    /// A pass that would finish too little: placed otherwise, or what it cuts is taken and the rest of a narrow
    /// step left.
    fn stuck(
        &mut self,
        region: &Region<&Inside>,
        across: f64,
        task: &Task,
        lot: &Lot,
    ) -> Result<Option<Step>, CoverError> {
        if task.method == Method::Widest {
            let step = self.lane(region, across, &Task { method: Method::Inclined, ..*task })?;
            let [[_, end], along] = region.bounds;
            let next = step.as_ref().map_or(end, |step| step.next);
            self.fall_back(lot, [0, lot.parts.len().saturating_sub(1)], [[across, next], along]);
            return Ok(step);
        }
        let [_, end] = region.bounds[0];
        let next = (across + STEP * lot.costs.narrow / lot.rate).min(end);
        if lot.parts.iter().any(|part| part.width > self.site.options.spacing[0]) {
            self.add(lot);
        }
        if let (None, Some((at, error))) = (&self.state.report.refused, lot.refused.clone()) {
            let face = self.site.face.face().number;
            self.state.report.refused = Some((face, self.site.chart.uv(at), error));
        }
        self.miss(&lot.columns, next);
        let (again, rate) = (lot.length() + lot.costs.pass, lot.rate);
        Ok((next < end).then_some(Step { next, rate, again }))
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
        if task.depth > DEPTH {
            let missed = columns.iter().filter(|c| c.part.width < self.least());
            self.miss(&missed.copied().collect::<Vec<_>>(), next);
            if narrowest < self.least() {
                return Ok(next);
            }
        }
        if !same {
            let along = lot.along([first, last]);
            self.fall_back(lot, [first, last], [[across, next], along]);
        }
        let from = columns.iter().map(|c| c.finished).fold(next, f64::min).max(across);
        let along = lot.along([first, last]);
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
        let (site, open) = (self.site, columns.iter().filter(|c| c.finished < end));
        self.state.missed.extend(open.map(|c| site.uv_range([[c.finished, end], c.along])));
    }

    /// Adds the passes of a lane.
    fn add(&mut self, lot: &Lot) {
        let site = self.site;
        let sweeps = lot.stretches.iter().map(|stretch| site.sweep(stretch));
        let given = (site.face.face().number, &site.chart, site.options);
        self.state.add(lot.stretches.clone(), sweeps, given, site.clock);
    }

    /// Notes why wide strips are not taken on some columns.
    fn fall_back(&mut self, lot: &Lot, range: [usize; 2], bounds: [[f64; 2]; 2]) {
        let site = self.site;
        let fallback = lot.fallback(range, (site.face.face().number, &site.chart));
        let uv = site.uv_range(bounds);
        self.state.report.fallbacks.extend(fallback.map(|one| Fallback { uv, ..one }));
    }

    fn least(&self) -> f64 {
        self.site.least()
    }
}
