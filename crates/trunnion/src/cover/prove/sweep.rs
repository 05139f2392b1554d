//! Curve of a pass, with bounds on its bending.

use crate::types::Interval;
use crate::types::{PoseCurve, PoseSpan, Station, ToolPose};
use nalgebra::{Point3, UnitVector3, Vector3, Vector6};

/// Distance along the curve between the poses from which searches start, as a share of the lever.
const STEP: f64 = 0.0625;

/// Curve of poses with bounds.
#[derive(Debug, Clone)]
pub(crate) struct PassSweep {
    pub(crate) curve: PoseCurve,
    /// Cubic coefficients of tip and tool-axis vector on every span, as in the curve.
    cubics: Vec<[Vector6<f64>; 4]>,
    bends: Vec<CurveBound>,
    /// Jumps of the third derivatives of tip and tool-axis vector at the knots before each span, added up.
    kinks: Vec<[f64; 2]>,
    /// Movement over half a step between poses: of the tip, and per mm of distance from it.
    pace: [f64; 2],
    /// Poses to start searches from, with their parameters.
    pub(crate) poses: Vec<(f64, ToolPose)>,
}

/// Bounds over one span, by the curve's parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CurveBound {
    /// Second derivative of the tip.
    pub(crate) tip: f64,
    /// Angular velocity of the tool without spin.
    pub(crate) turn: f64,
    /// Derivative of the angular velocity.
    pub(crate) twist: f64,
}

/// Pose, velocity and angular velocity at one parameter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SweepInstant {
    pub(crate) pose: ToolPose,
    pub(crate) velocity: Vector3<f64>,
    pub(crate) turn: Vector3<f64>,
}

impl CurveBound {
    /// Returns the larger of both, bound by bound.
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            tip: self.tip.max(other.tip),
            turn: self.turn.max(other.turn),
            twist: self.twist.max(other.twist),
        }
    }

    /// Bounds a span. Derivatives of a cubic are at most linear or quadratic, so their values at
    /// the ends bound them, the first with half the span times the second.
    fn of(curve: &PoseCurve, span: usize) -> Self {
        let [start, end] = [curve.knots[span], curve.knots[span + 1]];
        let ends = [start, end].map(|u| curve.rates_in(span, u));
        let most =
            |pick: &dyn Fn(&crate::types::PoseRates) -> f64| pick(&ends[0]).max(pick(&ends[1]));
        let (second, first) = (most(&|r| r.axis[2].norm()), most(&|r| r.axis[1].norm()));
        let half = 0.5 * (end - start);
        let first = first + half * second;
        // The axis vector is of unit length at the ends; in between it is shorter by its bow at
        // most.
        let least = (1.0 - 0.5 * half * half * second).max(0.5);
        let turn = first / least;
        // a = A / |A|: a'' = A'' / |A| and up to 3 (|A'| / |A|)^2.
        let twist = second / least + 3.0 * turn * turn;
        Self { tip: most(&|r| r.tip[2].norm()), turn, twist }
    }

    /// Bounds the second derivative of a point as seen from the tool.
    ///
    /// The point is `distance` from the tip and moves at `speed` in the workpiece. The tool's frame
    /// turns by `w`: `y'' = p'' - tip'' - 2 w x q' - w' x q + w x (w x q)`, `q = p - tip`.
    pub(crate) fn seen(&self, distance: f64, speed: f64) -> f64 {
        self.tip + 2.0 * self.turn * speed + (self.twist + self.turn * self.turn) * distance
    }
}

/// Adds up the jumps of the third derivatives of tip and tool-axis vector, up to the start of each span.
fn kinks(cubics: &[[Vector6<f64>; 4]]) -> Vec<[f64; 2]> {
    let mut sum = [0.0; 2];
    let mut before = cubics.first().map(|[.., d]| *d);
    let jump = |[.., d]: &[Vector6<f64>; 4]| {
        let jump = before.replace(*d).map_or_else(Vector6::zeros, |before| (d - before) * 6.0);
        sum[0] += jump.fixed_rows::<3>(0).norm();
        sum[1] += jump.fixed_rows::<3>(3).norm();
        sum
    };
    cubics.iter().map(jump).collect()
}

impl PassSweep {
    /// Lays the curve through `stations`.
    pub(crate) fn through(stations: &[Station], lever: f64) -> Self {
        Self::of(PoseCurve::through(stations, lever), lever)
    }

    pub(crate) fn of(curve: PoseCurve, lever: f64) -> Self {
        let bends = (0..curve.spans.len()).map(|span| CurveBound::of(&curve, span)).collect();
        let bends: Vec<CurveBound> = bends;
        let Interval { low: start, high: end } = curve.range();
        let steps = ((end - start) / (STEP * lever)).ceil().max(1.0);
        let poses = std::iter::successors(Some(0.0), |i| Some(i + 1.0))
            .take_while(|i| *i <= steps)
            .map(|i| start + (end - start) * i / steps)
            .filter_map(|u| Some((u, curve.pose(u)?)))
            .collect();
        // Half a step at the greatest speeds.
        let half = 0.5 * (end - start) / steps;
        // Speed at the ends of a span, plus half the span times the second derivative.
        let speed = (0..curve.spans.len()).map(|span| {
            let [a, b] = [curve.knots[span], curve.knots[span + 1]];
            let ends = [a, b].map(|u| curve.rates_in(span, u).tip[1].norm());
            ends[0].max(ends[1]) + 0.5 * (b - a) * bends[span].tip
        });
        let speed = speed.fold(0.0, f64::max);
        let turn = bends.iter().map(|bend| bend.turn).fold(0.0, f64::max);
        let cubic = |span: &PoseSpan| {
            let [a, b, c, d, ..] = span.coefficients;
            [a, b, c, d].map(|coefficient| coefficient.fixed_rows::<6>(0).into_owned())
        };
        let cubics: Vec<[Vector6<f64>; 4]> = curve.spans.iter().map(cubic).collect();
        let kinks = kinks(&cubics);
        Self { curve, cubics, bends, kinks, poses, pace: [speed * half, turn * half] }
    }

    /// Bounds the movement of a point `distance` from the tip, seen from the tool, from a pose of
    /// [`PassSweep::poses`] to the middle between it and the next.
    pub(crate) fn stride(&self, distance: f64) -> f64 {
        self.pace[0] + self.pace[1] * distance
    }

    pub(crate) fn bend(&self, span: usize) -> CurveBound {
        self.bends.get(span).copied().unwrap_or(CurveBound { tip: 0.0, turn: 0.0, twist: 0.0 })
    }

    /// Returns the bounds over all spans between two parameters.
    pub(crate) fn bend_between(&self, a: f64, b: f64) -> CurveBound {
        let [first, last] = [a.min(b), a.max(b)].map(|u| self.curve.span_at(u));
        (first..=last).map(|span| self.bend(span)).fold(self.bend(first), CurveBound::or)
    }

    /// Bounds how far the second derivatives of tip and tool-axis vector between two parameters are from those of one
    /// cubic: that of a span between them.
    pub(crate) fn unevenness(&self, a: f64, b: f64) -> [f64; 2] {
        let [first, last] = [a.min(b), a.max(b)].map(|u| self.curve.span_at(u));
        let at = |span: usize| self.kinks.get(span).copied().unwrap_or([0.0; 2]);
        // A spline is that cubic and J (u - k)^3 / 6 beyond each knot k where the third derivative jumps by J: its second
        // derivative differs by J (u - k).
        [0, 1].map(|k| (at(last)[k] - at(first)[k]) * (b - a).abs())
    }

    /// Returns the pose and its first derivatives. Searches evaluate them often.
    pub(crate) fn instant(&self, span: usize, u: f64) -> Option<SweepInstant> {
        let [a, b, c, d] = self.cubics.get(span)?;
        let x = u - self.curve.knots.get(span)?;
        // Horner's scheme for value and derivative of the cubic.
        let place = a + (b + (c + d * x) * x) * x;
        let rate = b + (c * 2.0 + d * (3.0 * x)) * x;
        let part = |of: &Vector6<f64>, first: usize| of.fixed_rows::<3>(first).into_owned();
        let vector = part(&place, 3);
        let axis = UnitVector3::try_new(vector, f64::MIN_POSITIVE)?;
        let pose = ToolPose { tip: Point3::from(part(&place, 0)), axis };
        // Angular velocity without spin: a x a', with a' the part of A' / |A| square to a.
        let turn = axis.cross(&part(&rate, 3)) / vector.norm();
        Some(SweepInstant { pose, velocity: part(&rate, 0), turn })
    }
}
