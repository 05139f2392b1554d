//! Plans the passes of a face, rectangle by rectangle.
//!
//! [`FacePlanner::cover_whole`] lays one pass after the other across a face. Each pass takes four steps:
//!
//! 1. lay a candidate pass at the next track ([`FacePlanner::trial`]);
//! 2. choose the advance to the track after it by cost (`layout::advance`);
//! 3. add the pass ([`FacePlanner::take`]), or several advances in turn of which the best is kept;
//! 4. finish the columns that the pass leaves narrower than the advance ([`FacePlanner::finish_narrow`]).
//!
//! Step 4 is the only recursion: such columns are a rectangle of their own ([`FacePlanner::cover_part`]), at most
//! [`DEPTH`] rectangles within each other.

use crate::cover::error::CoverError;
use crate::cover::layout::advance::{self, PassPart};
use crate::cover::layout::region::{ChartPoint, TrimmedRegion};
use crate::cover::pattern::{CutPattern, PlacementMethod};
use crate::cover::place::context::FaceContext;
use crate::cover::place::placed::{PassSource, PlacedPasses};
use crate::cover::place::trial::{RefusedPlace, TrialPass};
use crate::cover::place::trim::SpanProof;
use crate::cover::prove::coverage::PassColumn;
use crate::cover::report::{FallbackReason, GivenUp, PassFallback, RefusedPoint};
use crate::positioning::PositioningError;
use crate::types::Interval;

/// Step across over material that the tool cannot finish, in widths of a narrow strip. The next finished strip begins
/// at most that much late.
const STEP: f64 = 0.25;

/// Share of the work allowed that trying several advances may take.
const PACE: f64 = 0.5;

/// Share of a face that wide strips have to have finished when their work is used up; if it is less, the face is planned anew
/// at the fixed inclination: a few wide strips among many narrow ones gain little.
const WELL_BEGUN: f64 = 0.5;

/// Share of that work after which strips have to be wider than those of a ball on average, while they are over such a part of
/// the face: narrower ones gain nothing over the fixed inclination.
const EARLY: f64 = 0.3;

/// Rectangles within rectangles.
const DEPTH: u32 = 2;

/// Rectangle of local parameters to be finished.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceRectangle {
    pub(crate) bounds: [[f64; 2]; 2],
    pub(crate) method: PlacementMethod,
    /// Number of rectangles that this one is part of.
    depth: u32,
    /// Cost of leaving one millimetre across to the rectangle that this one is part of \[mm/mm\].
    worth: f64,
}

impl FaceRectangle {
    /// Starts with a rectangle that is no part of another.
    pub(crate) fn whole(bounds: [[f64; 2]; 2], method: PlacementMethod) -> Self {
        Self { bounds, method, depth: 0, worth: f64::INFINITY }
    }
}

/// Limits of the work on a face.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorkLimits {
    /// Work after which wide strips are given up.
    pub(crate) wide: u64,
    /// Work after which everything is given up.
    pub(crate) all: u64,
}

/// Advance by one pass.
struct PassStep {
    /// Parameter across of the next track.
    next: f64,
    /// Length of a step across by the parameter \[mm\].
    rate: f64,
    /// Cost of another pass over the same length \[mm\].
    again: f64,
}

/// Advance that was tried in full.
struct TriedAdvance {
    /// Ranges left unfinished, and cost per parameter across: fewer and cheaper is better.
    rank: (usize, f64),
    /// \[mm\]
    advance: f64,
    next: f64,
    placed: PlacedPasses,
}

/// Face while its passes are planned.
pub(crate) struct FacePlanner<'a, Inside> {
    pub(crate) context: &'a FaceContext<'a, Inside>,
    pub(crate) placed: PlacedPasses,
    /// Work done so far.
    pub(crate) work: u64,
    pub(crate) limits: WorkLimits,
    pub(crate) proof: SpanProof,
    /// Share of the face that is done.
    pub(crate) share: f64,
    /// `true` if wide strips have used up their work over a small part of the face, or are narrow: the passes end there, and
    /// serve nothing.
    pub(crate) badly_begun: bool,
}

impl<Inside: Fn(ChartPoint) -> bool + Sync> FacePlanner<'_, Inside> {
    /// Plans passes over all of a face, one after the other.
    pub(crate) fn cover_whole(&mut self, rectangle: &FaceRectangle) -> Result<(), CoverError> {
        let [first, last] = rectangle.bounds[0];
        let region = self.context.whole.within(rectangle.bounds);
        let mut next = first;
        loop {
            self.share = (next - first) / (last - first);
            let step = self.pass(&region, next, rectangle)?;
            self.context.progress.show(&self.placed);
            let Some(step) = step else { return Ok(()) };
            next = step.next;
        }
    }

    /// Plans passes over a rectangle within a face, and returns the parameter across to which it is finished. A
    /// remainder that is cheaper to leave to the enclosing rectangle is left.
    fn cover_part(&mut self, rectangle: &FaceRectangle) -> Result<f64, CoverError> {
        let region = self.context.whole.within(rectangle.bounds);
        let [first, last] = rectangle.bounds[0];
        let mut next = first;
        loop {
            let Some(step) = self.pass(&region, next, rectangle)? else { return Ok(last) };
            next = step.next;
            // Another pass here costs more than the enclosing rectangle loses by a smaller advance.
            if (last - next) * step.rate * rectangle.worth < step.again {
                return Ok(next);
            }
        }
    }

    /// Plans the next pass from `across` on, with the passes that finish what it leaves; `None` at the end of the
    /// rectangle.
    fn pass(
        &mut self,
        region: &TrimmedRegion<&Inside>,
        across: f64,
        rectangle: &FaceRectangle,
    ) -> Result<Option<PassStep>, CoverError> {
        self.context.progress.report(self.share)?;
        // Once true it stays so: passes that are not tried then leave material that nothing measures.
        self.badly_begun |= self.begins_badly(rectangle);
        if self.badly_begun {
            return Ok(None);
        }
        if self.work > self.limits.all || self.is_hopeless() {
            let [_, end] = region.bounds[0];
            let left = self.context.uv_range([[across, end], region.bounds[1]]);
            self.placed.missed.push(left);
            return Ok(None);
        }
        let Some(across) = region.next_from(across) else { return Ok(None) };
        let rectangle = &self.within_limits(across, rectangle);
        let Some(trial) = self.trial(region, across, rectangle.method) else {
            return Ok(self.pass_over_point(region, across));
        };

        // The outermost rectangle tries several advances where widths differ; the innermost goes on by its narrowest part.
        let parts = trial.open();
        let alike = rectangle.method == PlacementMethod::Inclined;
        let mut advances = if rectangle.depth == 0 && !alike {
            advance::advances(&parts, &trial.costs)
        } else if rectangle.depth < DEPTH {
            vec![advance::advance(&parts, &trial.costs)]
        } else {
            let widths = parts.iter().map(|part| part.width);
            vec![widths.filter(|width| *width >= self.least()).fold(f64::INFINITY, f64::min)]
        };
        advances.retain(|advance| advance.is_finite() && *advance >= self.least());
        if trial.ends_early(region.bounds[0][1]) {
            advances.clear();
        }

        let next = match *advances {
            [] => return self.pass_without_advance(region, across, rectangle, &trial),
            [advance] => self.take(&trial, advance, across, rectangle)?,
            _ => self.take_best(&trial, &advances, across, rectangle)?,
        };
        let (again, rate) = (trial.length() + trial.costs.pass, trial.rate);
        Ok((next < region.bounds[0][1]).then_some(PassStep { next, rate, again }))
    }

    /// Lays a candidate pass beside the passes that are placed.
    ///
    /// If the machine does not reach the inclinations that one feed direction allows, the other direction is tried as
    /// well, unless all passes have to run one way.
    fn trial(
        &mut self,
        region: &TrimmedRegion<&Inside>,
        across: f64,
        method: PlacementMethod,
    ) -> Option<TrialPass> {
        let trial = self.context.lay(region, across, method, self.proof, &self.placed)?;
        self.work += trial.work;
        let far = matches!(
            trial.refused,
            Some(RefusedPlace { error: PositioningError::OutOfReach { .. }, .. })
        );
        let zigzag = self.context.options.pattern == CutPattern::ZigZag;
        if !(far && zigzag && method == PlacementMethod::Inclined) {
            return Some(trial);
        }
        // The other feed direction wins if it leaves less of the length without a strip.
        let forward = !self.placed.forward;
        let back = self.placed.turned();
        let other = self.context.lay(region, across, method, self.proof, &back)?;
        self.work += other.work;
        let least = self.least();
        if other.length_below(least) < trial.length_below(least) {
            self.placed.forward = forward;
            return Some(other);
        }
        Some(trial)
    }

    /// Returns `true` if wide strips have used up their work over a small part of the face, or are narrow so far.
    fn begins_badly(&self, rectangle: &FaceRectangle) -> bool {
        let used = self.work as f64 / self.limits.wide.max(1) as f64;
        let width = self.share * self.context.area() / self.placed.report.length;
        rectangle.method == PlacementMethod::Widest
            && self.share < WELL_BEGUN
            && (used > 1.0 || used > EARLY && width < self.context.narrow() || self.is_hopeless())
    }

    /// Returns `true` if the work that usually finishes the face has placed nothing.
    fn is_hopeless(&self) -> bool {
        self.placed.report.length <= 0.0 && self.work as f64 > self.context.usual_work()
    }

    /// Goes on from a track that is a point. The first pass with a length finishes what lies before it, or it is left.
    fn pass_over_point(
        &mut self,
        region: &TrimmedRegion<&Inside>,
        across: f64,
    ) -> Option<PassStep> {
        let context = self.context;
        let ([first, last], [_, end]) = (context.whole.bounds[0], region.bounds[0]);
        let rate = context.extent(0) / (last - first);
        let next = (across + STEP * context.narrow() / rate).min(end);
        self.placed.missed.push(context.uv_range([[across, next], region.bounds[1]]));
        (next > across && next < end).then_some(PassStep { next, rate, again: 0.0 })
    }

    /// Returns the rectangle, at the fixed inclination once wide strips have used up their work.
    fn within_limits(&mut self, across: f64, rectangle: &FaceRectangle) -> FaceRectangle {
        let face = self.context.face.face().number;
        if self.work <= self.limits.wide || rectangle.method == PlacementMethod::Inclined {
            return *rectangle;
        }
        let report = &mut self.placed.report;
        if report.given_up.is_none() {
            let [[_, end], along] = self.context.whole.bounds;
            let at = self.context.chart.uv([across, rectangle.bounds[1][0]]).into();
            let [u, v] = self.context.uv_range([[across, end], along]).map(Interval::from);
            report.given_up = Some(GivenUp { face, uv: at, share: self.share });
            let reason = FallbackReason::Effort;
            report.fallbacks.push(PassFallback { face, at, u, v, reason });
        }
        FaceRectangle { method: PlacementMethod::Inclined, ..*rectangle }
    }

    /// Adds a pass and those that finish what it leaves narrower than `advance` \[mm\]; returns the next track.
    fn take(
        &mut self,
        trial: &TrialPass,
        advance: f64,
        across: f64,
        rectangle: &FaceRectangle,
    ) -> Result<f64, CoverError> {
        let mut next = trial.reach(advance).min(across + advance / trial.rate);
        self.add(trial);
        for columns in self.narrow_columns(trial, advance, next) {
            next = self.finish_narrow(trial, columns, [across, next], rectangle)?.min(next);
        }
        Ok(next)
    }

    /// Takes each of several advances in turn, and keeps the one with the least cost for what it brings.
    ///
    /// The passes beside the trial are proven once it is known which advance they belong to.
    fn take_best(
        &mut self,
        trial: &TrialPass,
        advances: &[f64],
        across: f64,
        rectangle: &FaceRectangle,
    ) -> Result<f64, CoverError> {
        let before = self.placed.clone();
        let proof = std::mem::replace(&mut self.proof, SpanProof::Middle);
        let mut best: Option<TriedAdvance> = None;
        for &advance in advances {
            self.placed = before.clone();
            let next = self.take(trial, advance, across, rectangle)?;
            // Compare by the ranges left unfinished first, then by the cost per parameter across.
            let cost = self.placed.price() - before.price();
            let rank = (self.placed.missed.len(), cost / (next - across));
            if best.as_ref().is_none_or(|best| rank < best.rank) {
                best = Some(TriedAdvance { rank, advance, next, placed: self.placed.clone() });
            }
            if self.falls_behind(next) {
                break;
            }
        }
        self.proof = proof;
        let Some(TriedAdvance { advance, next, placed, .. }) = best else { return Ok(across) };
        if proof == SpanProof::Middle {
            self.placed = placed;
            return Ok(next);
        }
        self.placed = before;
        let work = self.work;
        let next = self.take(trial, advance, across, rectangle)?;
        // The work of the tries has been counted.
        self.work = work;
        Ok(next)
    }

    /// Tests if the work up to `next` exceeds its share of [`PACE`] times the work allowed. Other advances are then
    /// not tried.
    fn falls_behind(&self, next: f64) -> bool {
        let [first, last] = self.context.whole.bounds[0];
        self.work as f64 > PACE * self.limits.all as f64 * ((next - first) / (last - first))
    }

    /// Returns runs of columns that are narrower than `advance` \[mm\] and take passes of their own. Columns that no
    /// pass would finish farther are left.
    fn narrow_columns(&mut self, trial: &TrialPass, advance: f64, next: f64) -> Vec<[usize; 2]> {
        let mut open = Vec::new();
        for [first, last] in advance::narrower(&trial.parts, advance) {
            let ended = |i: &usize| trial.ended[*i];
            for part in (first..=last).collect::<Vec<_>>().chunk_by(|a, b| ended(a) == ended(b)) {
                let run = [part[0], part[part.len() - 1]];
                if ended(&run[0]) {
                    self.leave(&trial.columns[run[0]..=run[1]], next);
                } else {
                    open.push(run);
                }
            }
        }
        open
    }

    /// Plans passes of their own over columns that the pass leaves narrower than the others, up to the next track;
    /// returns the parameter across to which they are finished then.
    fn finish_narrow(
        &mut self,
        trial: &TrialPass,
        [first, last]: [usize; 2],
        [across, next]: [f64; 2],
        rectangle: &FaceRectangle,
    ) -> Result<f64, CoverError> {
        let columns = &trial.columns[first..=last];
        let widths = || trial.parts[first..=last].iter().map(|part| part.width);
        let narrowest = widths().fold(f64::INFINITY, f64::min);
        // Strips narrower than a ball's gain nothing over the fixed inclination.
        let wide = narrowest >= trial.costs.narrow;
        let same = wide || rectangle.method == PlacementMethod::Inclined;
        if rectangle.depth > DEPTH {
            let missed = columns.iter().filter(|c| c.part.width < self.least());
            self.leave(&missed.copied().collect::<Vec<_>>(), next);
            if narrowest < self.least() {
                return Ok(next);
            }
        }
        let along = trial.along([first, last]);
        if !same {
            self.note_fallback(trial, [first, last], [[across, next], along]);
        }
        // Below the least finished parameter nothing is left to cut in these columns.
        let from = columns.iter().map(|c| c.finished).fold(next, f64::min).max(across);
        let part = FaceRectangle {
            bounds: [[from, next], along],
            method: if same { rectangle.method } else { PlacementMethod::Inclined },
            depth: rectangle.depth + 1,
            worth: (trial.length() + trial.costs.pass) / ((next - across) * trial.rate),
        };
        let reached = self.cover_part(&part)?;
        // The pass has to bring the enclosing rectangle on by the least width.
        let least = across + self.least() / trial.rate;
        if reached >= least {
            return Ok(reached);
        }
        let bounds = [[reached, next], along];
        self.cover_part(&FaceRectangle { bounds, worth: f64::INFINITY, ..part })
    }

    /// Continues after a pass that would finish too little: places it at the fixed inclination, or adds it as it is and
    /// leaves the remainder of a narrow step.
    fn pass_without_advance(
        &mut self,
        region: &TrimmedRegion<&Inside>,
        across: f64,
        rectangle: &FaceRectangle,
        trial: &TrialPass,
    ) -> Result<Option<PassStep>, CoverError> {
        if rectangle.method == PlacementMethod::Widest {
            let inclined = FaceRectangle { method: PlacementMethod::Inclined, ..*rectangle };
            let step = self.pass(region, across, &inclined)?;
            let [[_, end], along] = region.bounds;
            let next = step.as_ref().map_or(end, |step| step.next);
            let all = [0, trial.parts.len().saturating_sub(1)];
            self.note_fallback(trial, all, [[across, next], along]);
            return Ok(step);
        }
        let [_, end] = region.bounds[0];
        let next = (across + STEP * trial.costs.narrow / trial.rate).min(end);
        // A sliver at the end of the region is finished as well, however narrow it is.
        let finishes = |(part, column): (&PassPart, &PassColumn)| {
            part.width > self.context.options.spacing.low
                || (column.finished > across && column.finished >= end)
        };
        if trial.parts.iter().zip(&trial.columns).any(finishes) {
            self.add(trial);
        }
        if let (None, Some(RefusedPlace { at, error })) =
            (&self.placed.report.refused, trial.refused.clone())
        {
            let face = self.context.face.face().number;
            let uv = self.context.chart.uv(at).into();
            self.placed.report.refused = Some(RefusedPoint { face, uv, error });
        }
        self.leave(&trial.columns, next);
        let (again, rate) = (trial.length() + trial.costs.pass, trial.rate);
        Ok((next < end).then_some(PassStep { next, rate, again }))
    }

    /// Records columns that stay unfinished so far, up to `end`.
    fn leave(&mut self, columns: &[PassColumn], end: f64) {
        let (context, open) = (self.context, columns.iter().filter(|c| c.finished < end));
        self.placed.missed.extend(open.map(|c| context.uv_range([[c.finished, end], c.along])));
    }

    /// Adds the segments of a trial.
    fn add(&mut self, trial: &TrialPass) {
        let context = self.context;
        let sweeps = trial.segments.iter().map(|segment| context.sweep(segment));
        let source = PassSource {
            face: context.face.face().number,
            chart: &context.chart,
            options: context.options,
            cost: context.setup.cost,
        };
        self.placed.add(trial.segments.clone(), sweeps, source);
    }

    /// Records why wide strips are not taken on some columns.
    fn note_fallback(&mut self, trial: &TrialPass, columns: [usize; 2], bounds: [[f64; 2]; 2]) {
        let Some((at, reason)) = trial.fallback(columns) else { return };
        let context = self.context;
        let [u, v] = context.uv_range(bounds).map(Interval::from);
        let (face, at) = (context.face.face().number, context.chart.uv(at).into());
        self.placed.report.fallbacks.push(PassFallback { face, at, u, v, reason });
    }

    /// Returns the least width that a pass has to finish \[mm\].
    fn least(&self) -> f64 {
        self.context.least()
    }
}
