//! Smoothing station by station, with one window of stations in memory.

use super::coordinates::{axis, tip};
use super::error::SmoothError;
use super::fit::{FitEnd, FitStart, FitTask, SplineFit, StationNode};
use super::options::{SmoothLimits, SmoothOptions, SmoothReference};
use super::report::SmoothReport;
use super::span::SmoothSpan;
use super::span_run::{SpanRun, blend};
use crate::math;
use crate::math::angle::{angle_between, great_circle};
use crate::toolpath::interpolation::LARGEST_TURN;
use crate::types::{PoseCoordinates, Station, ToolPose};
use nalgebra::Point3;
use std::f64::consts::PI;

/// Largest turn of a great circle \[rad\]: so near to opposite axes, a change in the last digit, 1e-16,
/// turns the plane of the circle by 1e-13.
const DEFINED: f64 = PI - 1e-3;

/// Share of the tolerances within which stations are taken for one.
pub const SAME: f64 = 1.0 / 64.0;

/// A station farther than four tolerances from the chord of its neighbours: the chords to them
/// leave any smooth curve through all three by more than the tolerance.
const SHARP: f64 = 4.0;

/// Length of a step, in tolerances, below which its ratio to the next one is noise.
const TINY: f64 = 16.0;

/// Part of the tolerance of the axis by which a straight move of its vector may be out of step with the great
/// circle.
const OUT_OF_STEP: f64 = 1.0 / 16.0;

/// Largest number of parts of a move: half a turn at a tolerance of 1e-10 rad takes some 4600.
const MOST_PARTS: f64 = 8192.0;

/// Spans at the end of a window that are laid again with what follows: what is unknown beyond an
/// end fades by 0.43 a span, the largest root of the quintic spline.
const OVERLAP: usize = 8;

/// Intervals of a first span: at the start, and at most.
const COARSE: [usize; 2] = [16, 32];

/// Least number of stations between a join and a corner: a span with value and three derivatives given
/// at its start, and a value at its end, has one control point left.
const GUARD: usize = 3;

/// Stations kept before the window for the tangents in it.
const HISTORY: usize = 2;

/// Junction of a run of spans with the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum RunJoin {
    Smooth,
    Corner,
}

/// Parameter and rate of the path at a station, as the caller gives them.
#[derive(Debug, Clone, Copy)]
struct GivenRate<'a> {
    u: f64,
    rate: &'a PoseCoordinates,
}

/// Smooths a path station by station: returns spans as they are ready, and keeps one window of
/// stations in memory.
///
/// # Example
///
/// ```
/// use trunnion::toolpath::{PathSmoother, SmoothOptions, SmoothSpan};
/// use trunnion::types::{PoseTolerance, Station, ToolPose};
///
/// let options = SmoothOptions::within(PoseTolerance { tip: 0.005, axis: 1e-4 });
/// let mut smoother = PathSmoother::new(&options)?;
/// let mut spans: Vec<SmoothSpan> = Vec::new();
/// for k in 0..=100 {
///     // A circle of radius 20 mm, in steps of 0.4 mm, with an upright tool.
///     let (sin, cos) = (0.02 * f64::from(k)).sin_cos();
///     let pose = ToolPose::new([20.0 * cos, 20.0 * sin, 0.0], [0.0, 0.0, 1.0]).unwrap();
///     smoother.push(&Station { pose, contact: pose.tip })?;
///     spans.extend(smoother.take());
/// }
/// let (last, report) = smoother.finish()?;
/// spans.extend(last);
/// assert_eq!((report.stations, report.stops), (101, 0));
/// assert_eq!(report.spans, spans.len());
/// assert!(report.deviated.tip_bound <= 0.005);
/// # Ok::<(), trunnion::toolpath::SmoothError>(())
/// ```
#[derive(Debug)]
pub struct PathSmoother {
    options: SmoothOptions,
    limits: SmoothLimits,
    /// Stations of the window, with up to [`HISTORY`] before it.
    nodes: Vec<StationNode>,
    /// Rates of the path at them, where they are given.
    rates: Vec<PoseCoordinates>,
    /// Index of the first station of the window.
    first: usize,
    start: FitStart,
    /// Spans laid beyond the window's start, up to a station.
    prior: Option<(SpanRun, usize)>,
    /// The last chunk: its end may still be cut for a blend.
    held: Option<SpanRun>,
    join: RunJoin,
    ready: Vec<SmoothSpan>,
    stopped: bool,
    coarse: usize,
    last: Option<Station>,
    /// The last station, if it was merged.
    merged: Option<PoseCoordinates>,
    report: SmoothReport,
}

impl PathSmoother {
    /// Starts a path.
    ///
    /// # Errors
    ///
    /// [`SmoothError::BadOption`].
    pub fn new(options: &SmoothOptions) -> Result<Self, SmoothError> {
        let positive = [
            ("tip", options.tip),
            ("axis", options.axis),
            ("lever", options.lever),
            ("corner", options.corner),
            ("largest_blend", options.largest_blend),
        ];
        for (name, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SmoothError::BadOption { name, value, must: "positive and finite" });
            }
        }
        let value = options.step_ratio;
        if value.is_nan() || value <= 1.0 {
            return Err(SmoothError::BadOption { name: "step_ratio", value, must: "above 1" });
        }
        if options.window < 64 {
            let value = options.window as f64;
            return Err(SmoothError::BadOption { name: "window", value, must: "at least 64" });
        }
        let limits =
            SmoothLimits { tip: options.tip, axis: options.axis, reference: options.reference };
        Ok(Self {
            options: *options,
            limits,
            nodes: Vec::with_capacity(2 * options.window),
            rates: Vec::new(),
            first: 0,
            start: FitStart::Place(PoseCoordinates::zeros()),
            prior: None,
            held: None,
            join: RunJoin::Corner,
            ready: Vec::new(),
            stopped: false,
            coarse: COARSE[0],
            last: None,
            merged: None,
            report: SmoothReport::default(),
        })
    }

    /// Takes in the next station.
    ///
    /// # Errors
    ///
    /// [`SmoothError`] with its index.
    pub fn push(&mut self, station: &Station) -> Result<(), SmoothError> {
        for place in self.between(station) {
            // Inserted ones are no stations of the path: they have the number of the last.
            self.report.stations -= 1;
            self.take_in(&place, place.coordinates(), None)?;
        }
        self.take_in(station, station.coordinates(), None)
    }

    /// Returns stations to insert before the next one. There are some if the axis turns so far that its
    /// vector, moved straight, would deviate from the great circle by more than a part of the tolerance.
    fn between(&self, station: &Station) -> Vec<Station> {
        let Some(last) = self.last.filter(|_| self.limits.reference == SmoothReference::Chords)
        else {
            return Vec::new();
        };
        let angle = angle_between(&last.pose.axis, &station.pose.axis);
        // As in `bound::Frame::chord`; up to a right angle the factor is 0.147 at most.
        // The deviation grows with the cube of the angle, so that it falls with the cube of the
        // parts.
        let shift = 0.16 * (0.5 * angle).powi(3);
        if angle.is_nan() || angle > DEFINED || shift <= OUT_OF_STEP * self.limits.axis {
            return Vec::new();
        }
        let parts = math::cbrt(shift / (OUT_OF_STEP * self.limits.axis)).min(MOST_PARTS);
        let parts = parts.max(angle / LARGEST_TURN).ceil();
        let at = |part: f64| {
            let share = part / parts;
            let axis = great_circle(&last.pose.axis, &station.pose.axis, share)?;
            let tip = last.pose.tip + (station.pose.tip - last.pose.tip) * share;
            let contact = last.contact + (station.contact - last.contact) * share;
            Some(Station { pose: ToolPose { tip, axis }, contact })
        };
        let places = std::iter::successors(Some(1.0), |part| Some(part + 1.0));
        places.take_while(|part| *part < parts).filter_map(at).collect()
    }

    /// Takes in the next point of a curve that is cubic between such points: its parameter `u`, which increases
    /// from 0, its value and its derivative by `u`. The path is compared with that curve if
    /// [`SmoothOptions::reference`] is [`SmoothReference::Curve`]. All points of a path are given this way, or none.
    /// None is merged with the one before.
    ///
    /// # Errors
    ///
    /// [`SmoothError`] with its index.
    pub fn push_along(
        &mut self,
        u: f64,
        x: &PoseCoordinates,
        rate: &PoseCoordinates,
    ) -> Result<(), SmoothError> {
        let index = self.report.stations;
        let pose = ToolPose::new(tip(x).into(), axis(x).into());
        let Some(pose) = pose.filter(|_| u.is_finite() && rate.iter().all(|x| x.is_finite()))
        else {
            return Err(SmoothError::NotFinite(index));
        };
        let station = Station { pose, contact: Point3::new(x[6], x[7], x[8]) };
        self.take_in(&station, *x, Some(GivenRate { u, rate }))
    }

    /// Takes in a station: one more node of the window, or merged with the last one.
    fn take_in(
        &mut self,
        station: &Station,
        x: PoseCoordinates,
        along: Option<GivenRate<'_>>,
    ) -> Result<(), SmoothError> {
        let index = self.report.stations;
        self.report.stations += 1;
        if !x.iter().all(|x| x.is_finite()) {
            return Err(SmoothError::NotFinite(index));
        }
        let rate = along.map(|given| given.rate);
        let (Some(last), Some(end)) = (self.last, self.nodes.last_mut()) else {
            self.start = FitStart::Place(x);
            self.rates.extend(rate);
            self.add(station, along.map_or(0.0, |given| given.u), x);
            return Ok(());
        };
        let angle = angle_between(&last.pose.axis, &station.pose.axis);
        if angle > LARGEST_TURN {
            let limit = if along.is_some() { LARGEST_TURN } else { DEFINED };
            return Err(SmoothError::AxisReversal {
                station: index.saturating_sub(1),
                angle,
                limit,
            });
        }
        let moved = (station.pose.tip - last.pose.tip).norm();
        let moved = moved.max((station.contact - last.contact).norm());
        let u = along.map_or(end.u + last.advance(station, self.options.lever), |given| given.u);
        // Nearer than a small share of the tolerances: noise, and steps too short for a parameter.
        let same = moved <= SAME * self.limits.tip && angle <= SAME * self.limits.axis;
        if rate.is_some() && u <= end.u {
            return Err(SmoothError::Repeated(index.saturating_sub(1)));
        }
        if rate.is_none() && (same || u <= end.u) {
            end.slack = [end.slack[0].max(moved), end.slack[1].max(angle)];
            self.merged = Some(x);
            self.report.merged += 1;
            return Ok(());
        }
        self.rates.extend(rate);
        self.add(station, u, x);
        let at = self.nodes.len() - 2;
        if let Some(corner) = (at > self.first).then(|| self.judge(at)).flatten() {
            self.close(corner);
        } else if self.nodes.len() - self.first > self.options.window {
            self.open();
        }
        Ok(())
    }

    /// Returns the spans that are ready, in order.
    pub fn take(&mut self) -> Vec<SmoothSpan> {
        std::mem::take(&mut self.ready)
    }

    /// Ends the path, and returns the remaining spans and the report on all of them.
    ///
    /// # Errors
    ///
    /// [`SmoothError::Stations`].
    pub fn finish(mut self) -> Result<(Vec<SmoothSpan>, SmoothReport), SmoothError> {
        let end = self.nodes.len().saturating_sub(1);
        if end <= self.first {
            return Err(SmoothError::Stations(self.report.stations));
        }
        if let (Some(x), Some(last)) = (self.merged, self.nodes.last_mut()) {
            // The path ends at its last station, and passes those merged with it.
            last.x = x;
            last.slack = last.slack.map(|slack| 2.0 * slack);
        }
        self.close(end);
        if let Some(held) = self.held.take() {
            self.emit(held.spans);
        }
        Ok((self.ready, self.report))
    }

    /// Returns the lever, see [`SmoothOptions::lever`].
    pub(super) fn lever(&self) -> f64 {
        self.options.lever
    }

    /// Returns the position along the path of the last station that was taken in, as [`SmoothSpan::range`] counts.
    pub fn along(&self) -> f64 {
        self.nodes.last().map_or(0.0, |node| node.u)
    }

    fn add(&mut self, station: &Station, u: f64, x: PoseCoordinates) {
        let index = self.report.stations - 1;
        self.nodes.push(StationNode { u, x, index, slack: [0.0; 2], height: 0.0, corner: false });
        self.last = Some(*station);
        self.merged = None;
    }

    /// Measures how far a station stands out between its neighbours. Returns the last corner, if this made a
    /// new one.
    fn judge(&mut self, at: usize) -> Option<usize> {
        let [before, here, after] = [at - 1, at, at + 1].map(|at| &self.nodes[at]);
        let steps = [here.u - before.u, after.u - here.u];
        // Deviation of the station from the chord of its neighbours, at the same parameter.
        let share = steps[0] / (steps[0] + steps[1]);
        let off = here.x - (before.x + (after.x - before.x) * share);
        let turn = axis(&off);
        let own = axis(&here.x);
        // Only the part across the axis turns it; that along it is the bow of the chord of unit
        // vectors.
        let turned = (turn - own * turn.dot(&own)).norm() / self.limits.axis;
        let placed = tip(&off).norm() / self.limits.tip;
        let [a, b] = [tip(&(here.x - before.x)), tip(&(after.x - here.x))];
        // Turn of the direction of the tip, accurate for small angles and for reversals.
        let bend = math::atan2(a.cross(&b).norm(), a.dot(&b));
        let sharp = bend > self.options.corner && placed > 1.0;
        let chords = self.limits.reference == SmoothReference::Chords;
        // A short step at the start or between two long ones is a point written twice. Only a second
        // short one makes a corner where they begin, or end.
        let drops = |long: f64, short: f64| {
            long > short * self.options.step_ratio && long > TINY * self.limits.tip
        };
        let ahead = at.checked_sub(2).map(|first| before.u - self.nodes[first].u);
        let twice = ahead.is_none_or(|ahead| drops(ahead, steps[0]));
        let finer = twice && ahead.is_some_and(|ahead| drops(ahead, steps[1]));
        let coarser = drops(steps[1], steps[0]) && !twice;
        let node = &mut self.nodes[at];
        node.height = placed.max(turned);
        node.corner = sharp || chords && (node.height > SHARP || coarser);
        if node.corner {
            return Some(at);
        }
        let began = at - 1;
        if !(chords && finer && began > self.first) {
            return None;
        }
        self.nodes[began].corner = true;
        Some(began)
    }

    fn task(&self, last: usize, end: FitEnd) -> FitTask<'_> {
        FitTask {
            nodes: &self.nodes,
            rates: &self.rates,
            first: self.first,
            last,
            start: self.start,
            end,
            limits: self.limits,
            coarse: self.coarse,
        }
    }

    /// Lays spans over all stations up to a corner or the end of the path.
    fn close(&mut self, end: usize) {
        let mut end = end;
        while self.first < end {
            let corner = (self.first + 1..end).find(|&at| self.nodes[at].corner);
            let last = corner.unwrap_or(end);
            match self.task(last, FitEnd::Fixed).fit() {
                Ok(fit) => self.finished(&fit),
                Err(corners) => self.give_way(&corners),
            }
            // What was laid beyond a join may reach past the corner.
            end = end.saturating_sub(self.forget());
        }
    }

    /// Lays spans over a full window, beyond which more stations follow.
    fn open(&mut self) {
        let last = self.nodes.len() - 1;
        match self.task(last, FitEnd::Open).fit() {
            Ok(fit) => self.carried(&fit, last),
            Err(corners) => {
                let first = self.first;
                self.give_way(&corners);
                if let Some(end) = corners.last().filter(|_| self.first == first) {
                    self.close(*end);
                }
            }
        }
        self.forget();
    }

    /// Makes corners of stations. If one is too close to the join before, the spans laid beyond the join are kept,
    /// and a corner is made at their end.
    fn give_way(&mut self, corners: &[usize]) {
        // A corner so close behind the join leaves too few stations for a span that has to join
        // with three derivatives.
        let near = corners.first().is_some_and(|first| *first < self.first + GUARD);
        if near
            && matches!(self.start, FitStart::Jet(_))
            && let Some((chunk, end)) = self.prior.take()
        {
            self.start = FitStart::Place(chunk.end()[0]);
            self.hold(chunk);
            self.join = RunJoin::Corner;
            self.first = end;
            return;
        }
        for &at in corners {
            self.nodes[at].corner = true;
        }
    }

    /// Takes in a run of spans that ends at a corner.
    fn finished(&mut self, fit: &SplineFit) {
        let chunk = SpanRun::new(fit, [0, fit.curves.len()], |at| &self.nodes[at]);
        self.first = fit.breaks[fit.curves.len()];
        self.start = FitStart::Place(chunk.end()[0]);
        self.prior = None;
        self.hold(chunk);
        self.join = RunJoin::Corner;
    }

    /// Takes in a window of spans. Its last ones are laid again with the stations that follow.
    fn carried(&mut self, fit: &SplineFit, last: usize) {
        let count = fit.curves.len();
        // Keep at least half of the spans, or the window would hardly move on.
        let cut = count.saturating_sub(OVERLAP).max(count / 2).max(1);
        let chunk = SpanRun::new(fit, [0, cut], |at| &self.nodes[at]);
        // The next window starts with spans about twice as long as this one needed, and halves them
        // again.
        let mean = (fit.breaks[cut] - fit.breaks[0]) / cut;
        self.coarse = (2 * mean).clamp(COARSE[0] / 2, COARSE[1]);
        self.first = fit.breaks[cut];
        self.start = FitStart::Jet(chunk.end());
        let rest = SpanRun::new(fit, [cut, count], |at| &self.nodes[at]);
        self.prior = Some((rest, last));
        self.hold(chunk);
        self.join = RunJoin::Smooth;
    }

    /// Drops stations that are no longer needed, and returns their number.
    fn forget(&mut self) -> usize {
        let gone = self.first.saturating_sub(HISTORY);
        self.nodes.drain(..gone);
        self.rates.drain(..gone.min(self.rates.len()));
        self.first -= gone;
        if let Some((_, end)) = &mut self.prior {
            *end -= gone;
        }
        gone
    }

    /// Holds back a run of spans, and emits the one before, with the blend over the corner between them.
    fn hold(&mut self, mut chunk: SpanRun) {
        let Some(mut before) = self.held.take() else {
            self.held = Some(chunk);
            return;
        };
        if self.join == RunJoin::Smooth {
            self.emit(before.spans);
        } else if let Some(over) = blend(&before, &chunk, &self.limits, self.options.largest_blend)
        {
            before.cut_end(over.range[0]);
            chunk.cut_start(over.range[1]);
            self.emit(before.spans);
            self.emit(over.spans);
            self.report.blended += 1;
        } else {
            self.emit(before.spans);
            self.stopped = true;
            self.report.stops += 1;
        }
        self.held = Some(chunk);
    }

    fn emit(&mut self, spans: Vec<SmoothSpan>) {
        for mut span in spans {
            span.after_stop = std::mem::take(&mut self.stopped);
            self.report.spans += 1;
            self.report.deviated = self.report.deviated.worst(&span.deviated);
            self.ready.push(span);
        }
    }
}
