//! Runs of finished spans of a smoothed path, and the blends between them.

use super::bezier::{QuinticBezier, moved, part, powers};
use super::bound::{RoundingBound, deviation};
use super::coordinates::tip;
use super::fit::{PathSegment, SplineFit, StationNode};
use super::knots::{SpanKnots, from_end, from_start};
use super::options::SmoothLimits;
use super::report::PathDeviation;
use super::span::SmoothSpan;
use crate::math;
use crate::types::{PoseCoordinates, PoseSpan};

/// Spans between two joins, with the path they stand for.
#[derive(Debug, Clone)]
pub(super) struct SpanRun {
    pub(super) spans: Vec<SmoothSpan>,
    pub(super) paths: Vec<PathSegment>,
    /// Length before blends were cut off.
    length: f64,
}

/// Curve over a corner.
pub(super) struct CornerBlend {
    pub(super) range: [f64; 2],
    pub(super) spans: Vec<SmoothSpan>,
}

/// Share of a chunk that a blend may replace: two of them leave something in between.
const MOST: f64 = 0.45;

/// Half length of a blend, over the tolerance divided by the difference `d` of the rates on both sides: a blend
/// of lines passes their corner at a distance of 0.122 `d` times its half length.
const LONGEST: f64 = 8.0;

/// Splits before blend and path are compared: two of each.
const BLEND_SPLITS: usize = 4;

/// Halvings of a blend until the corner becomes a stop.
const HALVINGS: u32 = 8;

/// Makes a span of control points relative to `origin`.
fn span(
    range: [f64; 2],
    curve: &QuinticBezier,
    origin: &PoseCoordinates,
    deviated: PathDeviation,
    station: usize,
) -> SmoothSpan {
    let mut coefficients = powers(curve, range[1] - range[0]);
    // The fit is relative to the origin; only the constant term knows it.
    coefficients[0] += origin;
    SmoothSpan {
        range: range.into(),
        span: PoseSpan { coefficients },
        deviated,
        station,
        after_stop: false,
    }
}

impl SpanRun {
    /// Makes a run of the spans `from..to` of a fit; `node` returns a station by the fit's index.
    pub(super) fn new<'a>(
        fit: &SplineFit,
        [from, to]: [usize; 2],
        node: impl Fn(usize) -> &'a StationNode,
    ) -> Self {
        let spans: Vec<SmoothSpan> = (from..to)
            .map(|k| {
                let [start, end] = [k, k + 1].map(|k| node(fit.breaks[k]));
                span([start.u, end.u], &fit.curves[k], &fit.origin, fit.deviated[k], start.index)
            })
            .collect();
        let first = fit.breaks[0];
        let paths = fit.paths[fit.breaks[from] - first..fit.breaks[to] - first].to_vec();
        let length = node(fit.breaks[to]).u - node(fit.breaks[from]).u;
        Self { spans, paths, length }
    }

    /// Returns value and derivatives at the end.
    pub(super) fn end(&self) -> [PoseCoordinates; 4] {
        let last = self.spans.last();
        last.map_or([PoseCoordinates::zeros(); 4], |last| last.at(last.range.high))
    }

    fn at(&self, u: f64) -> [PoseCoordinates; 4] {
        let after = self.spans.partition_point(|span| span.range.low <= u);
        let span = self.spans.get(after.saturating_sub(1));
        span.map_or([PoseCoordinates::zeros(); 4], |span| span.at(u))
    }

    pub(super) fn cut_end(&mut self, u: f64) {
        self.spans.retain(|span| span.range.low < u);
        if let Some(last) = self.spans.last_mut() {
            last.range.high = u;
        }
    }

    pub(super) fn cut_start(&mut self, u: f64) {
        self.spans.retain(|span| span.range.high > u);
        if let Some(first) = self.spans.first_mut() {
            let shift = u - first.range.low;
            let c = &mut first.span.coefficients;
            // Taylor shift: repeated synthetic division gives the coefficients about the new start.
            for from in 0..5 {
                for k in (from..5).rev() {
                    let above = c[k + 1];
                    c[k] += above * shift;
                }
            }
            first.range.low = u;
        }
    }
}

/// Lays a C3 curve over the corner between two runs, within the tolerances; `None` if the tool has to
/// stop there.
///
/// A clamped quintic B-spline of three spans has eight control points: what value and three
/// derivatives at both ends determine.
pub(super) fn blend(
    left: &SpanRun,
    right: &SpanRun,
    limits: &SmoothLimits,
    largest: f64,
) -> Option<CornerBlend> {
    let (before, after) = (left.spans.last()?, right.spans.first()?);
    let corner = before.range.high;
    let [arriving, leaving] = [before.at(corner)[1], after.at(corner)[1]];
    let [a, b] = [tip(&arriving), tip(&leaving)];
    if math::atan2(a.cross(&b).norm(), a.dot(&b)) > largest && a.norm() > 0.0 && b.norm() > 0.0 {
        return None;
    }
    let spans = before.length().min(after.length());
    let longest = (MOST * left.length.min(right.length)).min(2.0 * spans);
    // Change of the rate in tolerances per unit of the parameter.
    let kink = limits.square(&(leaving - arriving)).sqrt();
    // From the longest blend that could keep the tolerance, halved until it does.
    let mut half = longest.min(LONGEST / kink);
    for _ in 0..=HALVINGS {
        let range = [corner - half, corner + half];
        if range[0] >= corner || range[1] <= corner {
            return None;
        }
        let [mut start, mut end] = [left.at(range[0]), right.at(range[1])];
        let origin = start[0];
        start[0] -= origin;
        end[0] -= origin;
        let over = over(range, &start, &end);
        let spans: Option<Vec<SmoothSpan>> = over
            .iter()
            .map(|(range, curve)| {
                let rounding = RoundingBound::new(curve, &origin, BLEND_SPLITS);
                let at = moved(curve, &origin);
                let deviated = strays(*range, &at, &rounding, [left, right]);
                let station = before.station;
                deviated
                    .within(limits, 1.0)
                    .then(|| span(*range, curve, &origin, deviated, station))
            })
            .collect();
        if let Some(spans) = spans {
            return Some(CornerBlend { range, spans });
        }
        half *= 0.5;
    }
    None
}

fn over(
    [from, to]: [f64; 2],
    start: &[PoseCoordinates; 4],
    end: &[PoseCoordinates; 4],
) -> Vec<([f64; 2], QuinticBezier)> {
    // Three equal spans, eight control points: four from either end.
    let third = (to - from) / 3.0;
    let breaks = [from, from + third, to - third, to];
    let mut points = from_start(&breaks, start).to_vec();
    points.extend(from_end(&breaks, end).iter().rev());
    (0..3)
        .map(|k| ([breaks[k], breaks[k + 1]], SpanKnots::new(&breaks, k).bezier(&points[k..k + 6])))
        .collect()
}

/// Bounds the deviation of a curve from the path on either side of a corner.
fn strays(
    range: [f64; 2],
    curve: &QuinticBezier,
    rounding: &RoundingBound,
    sides: [&SpanRun; 2],
) -> PathDeviation {
    let width = range[1] - range[0];
    let mut worst = PathDeviation::default();
    for side in sides {
        let first = side.paths.partition_point(|path| path.range[1] <= range[0]);
        for path in side.paths[first..].iter().take_while(|path| path.range[0] < range[1]) {
            let [from, to] = [range[0].max(path.range[0]), range[1].min(path.range[1])];
            // The part of blend and path over the same parameters, each by its own shares.
            let mine = part(curve, [from, to].map(|u| (u - range[0]) / width));
            let length = path.range[1] - path.range[0];
            let its = part(&path.curve, [from, to].map(|u| (u - path.range[0]) / length));
            let here = deviation(&mine, &its, &path.frame, rounding);
            worst = worst.worst(&here.with_slack(path.slack));
        }
    }
    worst
}

impl SmoothSpan {
    fn length(&self) -> f64 {
        self.range.width()
    }

    /// Returns value and derivatives at `u`.
    fn at(&self, u: f64) -> [PoseCoordinates; 4] {
        self.span.derivatives(u - self.range.low)
    }
}
