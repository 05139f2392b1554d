//! Chart of a face: an invertible map from points across and along the passes to the parameters of
//! the face.
//!
//! Passes lie at constant `across`. Along u or v the map exchanges the parameters. Otherwise passes
//! bend: about a straight frame in the plane of the parameters, `uv = o + x ex + y ey`, a pass is
//! the graph `x = across + s(across, y)` with a bicubic spline `s`, smooth and monotone in
//! `across`.

use crate::cover::layout::region::ChartPoint;
use crate::cover::pattern::FeedDirection;
use crate::cover::report::PassLayout;
use nalgebra::DMatrix;
use std::sync::Arc;

/// Least and largest slope of `x` by `across`. Neighbouring passes come no nearer, and go no
/// farther apart, than these shares of their mean distance.
pub(crate) const SLOPES: [f64; 2] = [0.2, 5.0];

/// Steps of the inverse: each halves the bracket at least; a Newton step squares the error.
const STEPS: u32 = 60;

/// Map from local parameters to those of the face.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chart {
    shape: ChartShape,
    /// `true` if across and along have changed places.
    crossed: bool,
}

#[derive(Debug, Clone, PartialEq)]
enum ChartShape {
    /// Across is u, along is v.
    Straight,
    Bent(Arc<BentChart>),
}

/// Passes as graphs over a straight frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BentChart {
    /// Point `x = y = 0`, in u and v.
    pub(crate) origin: [f64; 2],
    /// Steps of u and v by one x, and by one y.
    pub(crate) axes: [[f64; 2]; 2],
    pub(crate) bend: ChartSpline,
}

/// Bicubic spline over evenly spaced knots; beyond its ranges it goes on straight.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ChartSpline {
    /// Ranges of across and along.
    pub(crate) ranges: [[f64; 2]; 2],
    /// One row per knot across; three more each way than there are intervals.
    pub(crate) coefficients: DMatrix<f64>,
}

impl Chart {
    /// Returns the chart of lines of constant u or v.
    pub(crate) fn straight(along: FeedDirection) -> Self {
        Self { shape: ChartShape::Straight, crossed: along == FeedDirection::U }
    }

    /// Returns the layout of passes on the chart.
    pub(crate) fn layout(&self) -> PassLayout {
        match (&self.shape, self.crossed) {
            (ChartShape::Straight, true) => PassLayout::U,
            (ChartShape::Straight, false) => PassLayout::V,
            (ChartShape::Bent(_), _) => PassLayout::Bent,
        }
    }

    pub(crate) fn bent(bent: BentChart) -> Self {
        Self { shape: ChartShape::Bent(Arc::new(bent)), crossed: false }
    }

    /// Returns the chart with across and along exchanged.
    pub(crate) fn crossed(&self) -> Self {
        Self { shape: self.shape.clone(), crossed: !self.crossed }
    }

    /// Returns `true` if local parameters are those of the face, in some order.
    pub(crate) fn is_straight(&self) -> bool {
        self.shape == ChartShape::Straight
    }

    /// Returns the parameters `[u, v]` of a point across and along the passes.
    pub(crate) fn uv(&self, local: ChartPoint) -> [f64; 2] {
        let local = self.exchange(local);
        match &self.shape {
            ChartShape::Straight => local,
            ChartShape::Bent(bent) => bent.uv(local),
        }
    }

    /// Inverts [`Chart::uv`].
    pub(crate) fn local(&self, uv: [f64; 2]) -> ChartPoint {
        match &self.shape {
            ChartShape::Straight => self.exchange(uv),
            ChartShape::Bent(bent) => self.exchange(bent.local(uv)),
        }
    }

    /// Returns the steps of u and v by one across, and by one along.
    pub(crate) fn steps(&self, local: ChartPoint) -> [[f64; 2]; 2] {
        let steps = match &self.shape {
            ChartShape::Straight => [[1.0, 0.0], [0.0, 1.0]],
            ChartShape::Bent(bent) => bent.steps(self.exchange(local)),
        };
        self.exchange(steps)
    }

    /// Returns `true` if the turn from across to along is the turn from u to v.
    pub(crate) fn right_handed(&self) -> bool {
        let same = match &self.shape {
            ChartShape::Straight => true,
            // The step of x by across is positive, so the axes of the frame decide.
            ChartShape::Bent(bent) => determinant(bent.axes) > 0.0,
        };
        same != self.crossed
    }

    fn exchange<T>(&self, [first, second]: [T; 2]) -> [T; 2] {
        if self.crossed { [second, first] } else { [first, second] }
    }
}

fn determinant([[a, b], [c, d]]: [[f64; 2]; 2]) -> f64 {
    a * d - b * c
}

impl BentChart {
    fn uv(&self, [across, y]: ChartPoint) -> [f64; 2] {
        // uv = o + x ex + y ey with x = across + s(across, y).
        let x = across + self.bend.at([across, y])[0];
        let [ex, ey] = self.axes;
        [0, 1].map(|k| self.origin[k] + x * ex[k] + y * ey[k])
    }

    fn steps(&self, local: ChartPoint) -> [[f64; 2]; 2] {
        let [_, by_across, by_along] = self.bend.at(local);
        let [ex, ey] = self.axes;
        // Chain rule: duv / d(across) = ex (1 + s_across), duv / d(along) = ey + ex s_along.
        [ex.map(|e| e * (1.0 + by_across)), [0, 1].map(|k| ey[k] + by_along * ex[k])]
    }

    /// Returns the point in the straight frame.
    pub(crate) fn frame(&self, uv: [f64; 2]) -> [f64; 2] {
        let from = [0, 1].map(|k| uv[k] - self.origin[k]);
        let [ex, ey] = self.axes;
        // Cramer's rule for uv - o = x ex + y ey.
        let whole = determinant(self.axes);
        [determinant([from, ey]) / whole, determinant([ex, from]) / whole]
    }

    fn local(&self, uv: [f64; 2]) -> ChartPoint {
        let [x, y] = self.frame(uv);
        [self.bend.across(x, y), y]
    }
}

impl ChartSpline {
    /// Creates a spline without bend, with `intervals` across and along.
    pub(crate) fn flat(ranges: [[f64; 2]; 2], intervals: [usize; 2]) -> Self {
        let coefficients = DMatrix::zeros(intervals[0] + 3, intervals[1] + 3);
        Self { ranges, coefficients }
    }

    fn intervals(&self) -> [usize; 2] {
        let (rows, columns) = self.coefficients.shape();
        [rows.saturating_sub(3).max(1), columns.saturating_sub(3).max(1)]
    }

    /// Returns the length of an interval.
    fn pitch(&self, k: usize) -> f64 {
        (self.ranges[k][1] - self.ranges[k][0]) / self.intervals()[k] as f64
    }

    /// Returns the first coefficient, four weights, those of the derivative, and the distance of
    /// the point outside the range.
    pub(crate) fn basis(&self, k: usize, at: f64) -> (usize, [f64; 4], [f64; 4], f64) {
        let [low, high] = self.ranges[k];
        let inside = at.clamp(low, high);
        // The interval, and the share of it.
        let t = (inside - low) / self.pitch(k);
        let last = self.intervals()[k] - 1;
        // Within 0..=intervals.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
        let first = (t as usize).min(last);
        let t = t - first as f64;
        let s = 1.0 - t;
        // Uniform cubic B-spline basis on the interval, and its derivative by t.
        let weights = [
            s * s * s / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
            t * t * t / 6.0,
        ];
        let rates = [
            -0.5 * s * s,
            0.5 * (3.0 * t * t - 4.0 * t),
            0.5 * (4.0 * s - 3.0 * s * s),
            0.5 * t * t,
        ];
        (first, weights, rates.map(|rate| rate / self.pitch(k)), at - inside)
    }

    /// Returns the value and its derivatives by across and along.
    fn at(&self, [across, along]: ChartPoint) -> [f64; 3] {
        let (i, a, da, beyond) = self.basis(0, across);
        let (j, b, db, past) = self.basis(1, along);
        let (mut value, mut by_across, mut by_along, mut mixed) = (0.0, 0.0, 0.0, 0.0);
        // Tensor product: sum of c_mn B_m(across) B_n(along), with either factor differentiated.
        for m in 0..4 {
            for n in 0..4 {
                let c = self.coefficients[(i + m, j + n)];
                value += c * a[m] * b[n];
                by_across += c * da[m] * b[n];
                by_along += c * a[m] * db[n];
                mixed += c * da[m] * db[n];
            }
        }
        // Beyond the ranges the spline goes on straight; the mixed term makes both ways round a
        // corner agree.
        [
            value + by_across * beyond + by_along * past + mixed * beyond * past,
            by_across + mixed * past,
            by_along + mixed * beyond,
        ]
    }

    /// Returns `true` if the slope of `x = across + s` is within [`SLOPES`] everywhere in the
    /// ranges.
    ///
    /// The derivative of a spline lies in the hull of the differences of its coefficients.
    pub(crate) fn is_monotone(&self) -> bool {
        let pitch = self.pitch(0);
        let (rows, columns) = self.coefficients.shape();
        // Coefficients of ds / d(across), a quadratic spline: differences over the pitch.
        let slope = |i: usize, j: usize| {
            1.0 + (self.coefficients[(i + 1, j)] - self.coefficients[(i, j)]) / pitch
        };
        let within = |slope: f64| (SLOPES[0]..=SLOPES[1]).contains(&slope);
        (0..columns).all(|j| (0..rows - 1).all(|i| within(slope(i, j))))
    }

    /// Returns the parameter across at which a pass comes through `x` at `along`, by Newton's
    /// method within a bracket.
    fn across(&self, x: f64, along: f64) -> f64 {
        // Root of f(across) = across + s(across, y) - x.
        let excess = |across: f64| {
            let [value, slope, _] = self.at([across, along]);
            (across + value - x, 1.0 + slope)
        };
        let start = excess(x).0;
        // The slope is at least SLOPES[0], so the root lies within this distance.
        let far = x - start / SLOPES[0];
        let (mut low, mut high) = (x.min(far), x.max(far));
        let mut at = x - start;
        for _ in 0..STEPS {
            // A Newton step that leaves the bracket is replaced by bisection.
            if !(at > low && at < high) {
                at = 0.5 * (low + high);
            }
            let (value, slope) = excess(at);
            if value > 0.0 {
                high = at;
            } else {
                low = at;
            }
            let next = at - value / slope;
            if (next - at).abs() <= f64::EPSILON * (1.0 + at.abs()) {
                return next;
            }
            at = next;
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wavy() -> Chart {
        let mut bend = ChartSpline::flat([[-0.2, 1.2], [0.0, 1.0]], [3, 2]);
        for (k, c) in bend.coefficients.iter_mut().enumerate() {
            *c = 0.2 * (1.7 * k as f64).sin();
        }
        assert!(bend.is_monotone());
        Chart::bent(BentChart { origin: [3.0, -1.0], axes: [[2.0, 1.0], [-1.0, 4.0]], bend })
    }

    #[test]
    fn local_parameters_and_back() {
        for chart in [wavy(), Chart::straight(FeedDirection::U)] {
            for i in 0..100_u32 {
                // Also beyond the ranges.
                let [a, b] = [f64::from(i % 10) * 0.2 - 0.4, f64::from(i / 10) * 0.2 - 0.4];
                let back = chart.local(chart.uv([a, b]));
                assert!((back[0] - a).abs() < 1e-12 && (back[1] - b).abs() < 1e-12, "{back:?}");
            }
        }
    }

    #[test]
    fn steps_are_differences() {
        let (chart, h) = (wavy(), 1e-6);
        for [a, b] in [[0.1, 0.2], [0.7, 0.9], [1.3, 0.5], [-0.3, 1.2]] {
            let steps = chart.steps([a, b]);
            let ends = [
                [chart.uv([a + h, b]), chart.uv([a - h, b])],
                [chart.uv([a, b + h]), chart.uv([a, b - h])],
            ];
            for (step, [p, q]) in steps.iter().zip(ends) {
                for k in 0..2 {
                    assert!((step[k] - 0.5 * (p[k] - q[k]) / h).abs() < 1e-7);
                }
            }
        }
    }

    #[test]
    fn hands_by_pencil() {
        let [v, u] = [FeedDirection::V, FeedDirection::U].map(Chart::straight);
        assert!(v.right_handed() && !u.right_handed());
        assert!(wavy().right_handed());
    }

    #[test]
    fn passes_that_cross_are_refused() {
        let mut bend = ChartSpline::flat([[0.0, 1.0]; 2], [1, 1]);
        for j in 0..4 {
            bend.coefficients[(3, j)] = -0.9;
        }
        // From one row of knots to the next, 1 mm apart, x grows by 0.1 only.
        assert!(!bend.is_monotone());
    }
}
