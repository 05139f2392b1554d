//! Quintic B-splines through the stations between two corners.

use super::bezier::{DEGREE, QuinticBezier, cubic, from_powers, line, moved, split};
use super::bound::{AxisFrame, RoundingBound, deviation};
use super::knots::{JET, SpanKnots, from_start};
use super::normal_equations::NormalEquations;
use super::options::{SmoothLimits, SmoothReference};
use super::report::PathDeviation;
use crate::toolpath::interpolation::tangent_at;
use crate::types::PoseCoordinates;

/// A station with its parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct StationNode {
    pub(super) u: f64,
    pub(super) x: PoseCoordinates,
    /// Number of the station.
    pub(super) index: usize,
    /// Largest distances of merged stations from this one \[mm, rad\].
    pub(super) slack: [f64; 2],
    /// Distance from the chord of its neighbours, in tolerances.
    pub(super) height: f64,
    pub(super) corner: bool,
}

/// Start condition of a fit.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time")]
pub(super) enum FitStart {
    /// A value; the direction is free.
    Place(PoseCoordinates),
    /// Value and three derivatives of the curve before.
    Jet([PoseCoordinates; 4]),
}

/// Condition at the last station of a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FitEnd {
    /// The curve ends at the station exactly.
    Fixed,
    /// More stations follow: the curve only comes close.
    Open,
}

/// Path between two stations.
#[derive(Debug, Clone)]
pub(super) struct PathSegment {
    pub(super) range: [f64; 2],
    pub(super) curve: QuinticBezier,
    pub(super) frame: AxisFrame,
    pub(super) slack: [f64; 2],
}

/// Run of stations to fit.
pub(super) struct FitTask<'a> {
    /// Stations of the run, and those around it for tangents.
    pub(super) nodes: &'a [StationNode],
    /// Rates of the path at the stations, where they are given.
    pub(super) rates: &'a [PoseCoordinates],
    /// Indices of the first and the last station of the run.
    pub(super) first: usize,
    pub(super) last: usize,
    pub(super) start: FitStart,
    /// Condition at the last station.
    pub(super) end: FitEnd,
    pub(super) limits: SmoothLimits,
    /// Intervals a span takes at first.
    pub(super) coarse: usize,
}

/// Spline that keeps the tolerances.
pub(super) struct SplineFit {
    /// Stations at which spans start and end.
    pub(super) breaks: Vec<usize>,
    /// Control points relative to `origin`, so that third derivatives of small spans far from zero
    /// keep their digits.
    pub(super) curves: Vec<QuinticBezier>,
    pub(super) origin: PoseCoordinates,
    pub(super) deviated: Vec<PathDeviation>,
    pub(super) paths: Vec<PathSegment>,
}

/// Least intervals of a span: with one, stations would not determine the spline.
const LEAST: usize = 2;

/// The error of a quintic falls with the sixth power of the width of spans: a thousandth of the
/// tolerance at the stations costs 3.2 times the spans.
const FIDELITY: f64 = 1.0 / 1024.0;

/// Halving a span divides the residual of what is smooth by 64 and that of noise by less than 1.5.
/// Between the two, a fit that gains less is left as it is.
const WORTH: f64 = 3.0;

/// Share of the tolerances a fit may use; the rest is for rounding and for stations merged.
const USABLE: f64 = 1.0 - 1.0 / 32.0;

#[derive(Clone, Copy)]
struct SpanStations {
    from: usize,
    to: usize,
    /// Residual before it was halved.
    before: f64,
}

/// Result of the check of one span.
struct SpanCheck {
    deviated: PathDeviation,
    /// Root mean square of the residual at stations, in tolerances.
    residual: f64,
    kept: bool,
}

impl FitTask<'_> {
    fn intervals(&self) -> usize {
        self.last - self.first
    }

    /// Fits a spline. Spans are halved where the tolerance fails or the stations could be met better.
    ///
    /// # Errors
    ///
    /// Stations that have to become corners, in order.
    pub(super) fn fit(&self) -> Result<SplineFit, Vec<usize>> {
        let paths = self.paths();
        // Fewer stations than a quintic has coefficients: one polynomial through all of them.
        if matches!(self.start, FitStart::Place(_)) && self.intervals() < DEGREE {
            return self.polynomial(paths);
        }
        let mut parts = self.first_parts();
        loop {
            let breaks: Vec<f64> = self.breaks(&parts);
            // Stations that do not determine the spline: divide the run in the middle.
            let Some(points) = self.solve(&parts, &breaks) else {
                return Err(vec![usize::midpoint(self.first, self.last)]);
            };
            let curves: Vec<QuinticBezier> = (0..parts.len())
                .map(|span| SpanKnots::new(&breaks, span).bezier(&points[span..=span + DEGREE]))
                .collect();
            let seen: Vec<SpanCheck> = parts
                .iter()
                .zip(&curves)
                .map(|(part, curve)| self.see(part, curve, &paths))
                .collect();
            let finer = self.halved(&parts, &seen);
            // Refine as long as it pays; then either all spans keep the tolerances, or corners have
            // to divide the run.
            if finer.len() > parts.len() {
                parts = finer;
            } else if seen.iter().all(|seen| seen.kept) {
                let breaks = std::iter::once(self.first).chain(parts.iter().map(|part| part.to));
                let deviated = seen.iter().map(|seen| seen.deviated).collect();
                return Ok(SplineFit {
                    breaks: breaks.collect(),
                    curves,
                    origin: self.origin(),
                    deviated,
                    paths,
                });
            } else {
                return Err(self.corners(&parts, &seen));
            }
        }
    }

    fn breaks(&self, parts: &[SpanStations]) -> Vec<f64> {
        let ends = parts.iter().map(|part| self.nodes[part.to].u);
        std::iter::once(self.nodes[self.first].u).chain(ends).collect()
    }

    /// Returns the largest number of spans that the stations determine.
    fn most(&self) -> usize {
        let intervals = self.intervals();
        match self.start {
            FitStart::Place(_) => (intervals / LEAST).min(intervals - (DEGREE - 1)),
            FitStart::Jet(_) => (intervals / LEAST).max(1),
        }
    }

    fn first_parts(&self) -> Vec<SpanStations> {
        let count = self.intervals().div_ceil(self.coarse).clamp(1, self.most());
        let at = |k: usize| self.first + k * self.intervals() / count;
        let part = |k: usize| SpanStations { from: at(k), to: at(k + 1), before: f64::INFINITY };
        (0..count).map(part).collect()
    }

    fn paths(&self) -> Vec<PathSegment> {
        (self.first..self.last)
            .map(|at| {
                let [from, to] = [&self.nodes[at], &self.nodes[at + 1]];
                let range = [from.u, to.u];
                let (curve, frame) = match self.limits.reference {
                    SmoothReference::Chords => {
                        (line(&from.x, &to.x), AxisFrame::chord(&from.x, &to.x))
                    }
                    SmoothReference::Curve => {
                        let tangents = [at, at + 1].map(|at| self.tangent(at));
                        let width = range[1] - range[0];
                        let curve = cubic([&from.x, &to.x], [&tangents[0], &tangents[1]], width);
                        (curve, AxisFrame::curve(&curve))
                    }
                };
                let slack = [0, 1].map(|part: usize| from.slack[part].max(to.slack[part]));
                PathSegment { range, curve, frame, slack }
            })
            .collect()
    }

    /// Returns the tangent of the path: as given, or that of the local cubic through the stations of
    /// the run.
    fn tangent(&self, at: usize) -> PoseCoordinates {
        if let Some(rate) = self.rates.get(at) {
            return *rate;
        }
        let from = match self.start {
            FitStart::Place(_) => self.first,
            FitStart::Jet(_) => 0,
        };
        let to = if self.end == FitEnd::Fixed { self.last } else { self.nodes.len() - 1 };
        tangent_at(at, [from, to], |k| self.nodes[k].u, |k| &self.nodes[k].x)
    }

    fn origin(&self) -> PoseCoordinates {
        self.nodes[self.first].x
    }

    /// Returns the target of the fit at a station, from the origin on.
    fn target(&self, at: usize) -> PoseCoordinates {
        match self.start {
            FitStart::Place(place) if at == self.first => place - self.origin(),
            _ => self.nodes[at].x - self.origin(),
        }
    }

    /// Solves for the control points by least squares over the stations. Those that the ends
    /// prescribe are not moved.
    fn solve(&self, parts: &[SpanStations], breaks: &[f64]) -> Option<Vec<PoseCoordinates>> {
        // A quintic spline of n spans with simple inner knots has n + 5 control points.
        let count = parts.len() + DEGREE;
        let mut points = vec![PoseCoordinates::zeros(); count];
        let fixed = match self.start {
            FitStart::Place(_) => {
                points[0] = self.target(self.first);
                1
            }
            FitStart::Jet([place, first, second, third]) => {
                // Value and three derivatives of the curve before fix the first four control
                // points: C3.
                let jet = [place - self.origin(), first, second, third];
                points[..JET].copy_from_slice(&from_start(breaks, &jet));
                JET
            }
        };
        let free_end = if self.end == FitEnd::Fixed {
            points[count - 1] = self.target(self.last);
            count - 1
        } else {
            count
        };
        let mut normal = NormalEquations::new(free_end - fixed);
        for (span, part) in parts.iter().enumerate() {
            let around = SpanKnots::new(breaks, span);
            // Of the six control points of the span, those from `low` to `high` are unknown.
            let [low, high] = [fixed.max(span) - span, free_end.min(span + DEGREE + 1) - span];
            // Each station belongs to one span; the last one counts only if it is not interpolated.
            let last = part.to + usize::from(self.end == FitEnd::Open && span + 1 == parts.len());
            for at in part.from.max(self.first + 1)..last {
                let basis = around.basis(self.nodes[at].u);
                let mut rest = self.target(at);
                for k in (0..low).chain(high..=DEGREE) {
                    // The known ones move to the right-hand side.
                    rest -= points[span + k] * basis[k];
                }
                normal.add(span + low - fixed, &basis[low..high], &rest);
            }
        }
        points[fixed..free_end].copy_from_slice(&normal.solve()?);
        Some(points)
    }

    /// Measures one span interval by interval.
    fn see(&self, part: &SpanStations, curve: &QuinticBezier, paths: &[PathSegment]) -> SpanCheck {
        let [start, end] = [self.nodes[part.from].u, self.nodes[part.to].u];
        let mut seen = SpanCheck { deviated: PathDeviation::default(), residual: 0.0, kept: true };
        let rounding = RoundingBound::new(curve, &self.origin(), part.to - part.from);
        let (mut rest, mut from) = (moved(curve, &self.origin()), start);
        for at in part.from..part.to {
            let path = &paths[at - self.first];
            // Cut the span off interval by interval, so that each piece is compared with the path
            // between the same two stations.
            let piece = if at + 1 == part.to {
                rest
            } else {
                let [left, right] = split(&rest, (path.range[1] - from) / (end - from));
                (rest, from) = (right, path.range[1]);
                left
            };
            let here = deviation(&piece, &path.curve, &path.frame, &rounding);
            let here = here.with_slack(path.slack);
            seen.kept &= here.within(&self.limits, USABLE);
            seen.deviated = seen.deviated.worst(&here);
            // Residual at the stations only: what a finer spline could gain.
            seen.residual += self.limits.square(&(piece[0] - path.curve[0]));
        }
        seen.residual = (seen.residual / (part.to - part.from) as f64).sqrt();
        seen
    }

    fn halved(&self, parts: &[SpanStations], seen: &[SpanCheck]) -> Vec<SpanStations> {
        let mut room = self.most().saturating_sub(parts.len());
        let mut finer = Vec::with_capacity(2 * parts.len());
        for (part, seen) in parts.iter().zip(seen) {
            // Worth halving for fidelity only while the residual falls as that of something smooth
            // does.
            let better = seen.residual > FIDELITY && seen.residual * WORTH < part.before;
            let halves = part.to - part.from >= 2 * LEAST && room > 0;
            if halves && (!seen.kept || better) {
                room -= 1;
                let middle = usize::midpoint(part.from, part.to);
                let before = seen.residual;
                finer.push(SpanStations { from: part.from, to: middle, before });
                finer.push(SpanStations { from: middle, to: part.to, before });
            } else {
                finer.push(*part);
            }
        }
        finer
    }

    /// Returns the station that stands out most in every group of spans that fail.
    fn corners(&self, parts: &[SpanStations], seen: &[SpanCheck]) -> Vec<usize> {
        let mut corners = Vec::new();
        // Neighbouring spans that fail have one cause: one corner for each group of them.
        let failed: Vec<(&SpanStations, bool)> =
            parts.iter().zip(seen).map(|(part, seen)| (part, !seen.kept)).collect();
        for group in failed.chunk_by(|a, b| a.1 == b.1).filter(|group| group[0].1) {
            let [from, to] = [group[0].0.from, group[group.len() - 1].0.to];
            corners.extend(self.peak(from, to));
        }
        if corners.is_empty() {
            corners.push(usize::midpoint(self.first, self.last));
        }
        corners
    }

    fn peak(&self, from: usize, to: usize) -> Option<usize> {
        let height = |at: &usize| self.nodes[*at].height;
        (from.max(self.first + 1)..=to.min(self.last - 1))
            .max_by(|a, b| height(a).total_cmp(&height(b)))
    }

    /// Fits a run of few stations: the polynomial through them, of the least degree.
    fn polynomial(&self, paths: Vec<PathSegment>) -> Result<SplineFit, Vec<usize>> {
        let [start, end] = [self.first, self.last].map(|at| self.nodes[at].u);
        let at = |k: usize| self.nodes[self.first + k].u - start;
        let count = self.intervals() + 1;
        // Divided differences, then Newton's form multiplied out.
        let mut table: Vec<PoseCoordinates> =
            (self.first..=self.last).map(|at| self.target(at)).collect();
        // f[x_i .. x_j] = (f[x_i+1 .. x_j] - f[x_i .. x_j-1]) / (x_j - x_i), in place from the
        // highest index down.
        for order in 1..count {
            for k in (order..count).rev() {
                table[k] = (table[k] - table[k - 1]) / (at(k) - at(k - order));
            }
        }
        let mut powers = [PoseCoordinates::zeros(); DEGREE + 1];
        // Horner's scheme with polynomials: p <- p (x - x_k) + f[x_0 .. x_k].
        for k in (0..count).rev() {
            for degree in (1..=DEGREE).rev() {
                let lower = powers[degree - 1];
                powers[degree] = lower - powers[degree] * at(k);
            }
            powers[0] = table[k] - powers[0] * at(k);
        }
        let mut curve = from_powers(&powers, end - start);
        if let (SmoothReference::Curve, [path]) = (self.limits.reference, &paths[..]) {
            // A cubic between two stations is a quintic, too.
            curve = moved(&path.curve, &-self.origin());
        }
        let part = SpanStations { from: self.first, to: self.last, before: f64::INFINITY };
        let seen = self.see(&part, &curve, &paths);
        // Between two stations the curve is the path itself.
        if seen.kept || count == 2 {
            let breaks = vec![self.first, self.last];
            let (curves, deviated) = (vec![curve], vec![seen.deviated]);
            return Ok(SplineFit { breaks, curves, origin: self.origin(), deviated, paths });
        }
        Err(self.corners(&[part], &[seen]))
    }
}
