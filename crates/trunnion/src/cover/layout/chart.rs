//! Where passes run: an invertible map from places across and along them to the parameters of the face.
//!
//! Passes lie at constant `across`. Along u or v the map is an exchange of parameters; otherwise
//! passes bend: about a straight frame in the plane of the parameters, `uv = o + x ex + y ey`, a pass is
//! the graph `x = across + s(across, y)` with a bicubic spline `s`, smooth and monotone in `across`.

use crate::cover::layout::region::ChartPoint;
use crate::cover::options::FeedDirection;
use crate::cover::report::PassLayout;
use nalgebra::DMatrix;
use std::sync::Arc;

/// Least slope of `x` by `across`, and its largest: neighbouring passes come no nearer, and go no
/// farther apart, than these shares of their mean distance.
pub(crate) const SLOPES: [f64; 2] = [0.2, 5.0];

/// Steps of the inverse: each halves the bracket at least, Newton's own square the error.
const STEPS: u32 = 60;

/// A map from local parameters to those of the face.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chart {
    shape: ChartShape,
    /// Whether across and along have changed places.
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
    /// Place of `x = y = 0`, in u and v.
    pub(crate) origin: [f64; 2],
    /// A step by x, and one by y, in u and v.
    pub(crate) axes: [[f64; 2]; 2],
    pub(crate) bend: ChartSpline,
}

/// A bicubic spline over evenly spaced knots; beyond its ranges it goes on straight.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ChartSpline {
    /// Ranges of across and along.
    pub(crate) ranges: [[f64; 2]; 2],
    /// One row per knot across; three more each way than there are intervals.
    pub(crate) coefficients: DMatrix<f64>,
}

impl Chart {
    /// Lines of constant u or v.
    pub(crate) fn straight(along: FeedDirection) -> Self {
        Self { shape: ChartShape::Straight, crossed: along == FeedDirection::U }
    }

    /// Which way passes run on it.
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

    /// Across becomes along, and along across.
    pub(crate) fn crossed(&self) -> Self {
        Self { shape: self.shape.clone(), crossed: !self.crossed }
    }

    /// Whether local parameters are those of the face, in some order.
    pub(crate) fn is_straight(&self) -> bool {
        self.shape == ChartShape::Straight
    }

    /// Parameters `[u, v]` of a place across and along the passes.
    pub(crate) fn uv(&self, local: ChartPoint) -> [f64; 2] {
        let local = self.exchange(local);
        match &self.shape {
            ChartShape::Straight => local,
            ChartShape::Bent(bent) => bent.uv(local),
        }
    }

    /// The inverse of [`Chart::uv`].
    pub(crate) fn local(&self, uv: [f64; 2]) -> ChartPoint {
        match &self.shape {
            ChartShape::Straight => self.exchange(uv),
            ChartShape::Bent(bent) => self.exchange(bent.local(uv)),
        }
    }

    /// Steps of u and v by a step across, and by one along.
    pub(crate) fn steps(&self, local: ChartPoint) -> [[f64; 2]; 2] {
        let steps = match &self.shape {
            ChartShape::Straight => [[1.0, 0.0], [0.0, 1.0]],
            ChartShape::Bent(bent) => bent.steps(self.exchange(local)),
        };
        self.exchange(steps)
    }

    /// Whether from across to along is the turn from u to v, and not the other one.
    pub(crate) fn right_handed(&self) -> bool {
        let same = match &self.shape {
            ChartShape::Straight => true,
            // Steps of x by across are positive.
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
        let x = across + self.bend.at([across, y])[0];
        let [ex, ey] = self.axes;
        [0, 1].map(|k| self.origin[k] + x * ex[k] + y * ey[k])
    }

    fn steps(&self, local: ChartPoint) -> [[f64; 2]; 2] {
        let [_, by_across, by_along] = self.bend.at(local);
        let [ex, ey] = self.axes;
        [ex.map(|e| e * (1.0 + by_across)), [0, 1].map(|k| ey[k] + by_along * ex[k])]
    }

    /// Place in the straight frame.
    pub(crate) fn frame(&self, uv: [f64; 2]) -> [f64; 2] {
        let from = [0, 1].map(|k| uv[k] - self.origin[k]);
        let [ex, ey] = self.axes;
        let whole = determinant(self.axes);
        [determinant([from, ey]) / whole, determinant([ex, from]) / whole]
    }

    fn local(&self, uv: [f64; 2]) -> ChartPoint {
        let [x, y] = self.frame(uv);
        [self.bend.across(x, y), y]
    }
}

impl ChartSpline {
    /// No bend, with `intervals` across and along.
    pub(crate) fn flat(ranges: [[f64; 2]; 2], intervals: [usize; 2]) -> Self {
        let coefficients = DMatrix::zeros(intervals[0] + 3, intervals[1] + 3);
        Self { ranges, coefficients }
    }

    fn intervals(&self) -> [usize; 2] {
        let (rows, columns) = self.coefficients.shape();
        [rows.saturating_sub(3).max(1), columns.saturating_sub(3).max(1)]
    }

    /// Length of an interval.
    fn pitch(&self, k: usize) -> f64 {
        (self.ranges[k][1] - self.ranges[k][0]) / self.intervals()[k] as f64
    }

    /// First coefficient, weights of four, those of the derivative, and how far the place lies outside.
    pub(crate) fn basis(&self, k: usize, at: f64) -> (usize, [f64; 4], [f64; 4], f64) {
        let [low, high] = self.ranges[k];
        let inside = at.clamp(low, high);
        let t = (inside - low) / self.pitch(k);
        let last = self.intervals()[k] - 1;
        // Within 0..=intervals.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "see above")]
        let first = (t as usize).min(last);
        let t = t - first as f64;
        let s = 1.0 - t;
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

    /// Value and derivatives by across and along.
    fn at(&self, [across, along]: ChartPoint) -> [f64; 3] {
        let (i, a, da, beyond) = self.basis(0, across);
        let (j, b, db, past) = self.basis(1, along);
        let (mut value, mut by_across, mut by_along, mut mixed) = (0.0, 0.0, 0.0, 0.0);
        for m in 0..4 {
            for n in 0..4 {
                let c = self.coefficients[(i + m, j + n)];
                value += c * a[m] * b[n];
                by_across += c * da[m] * b[n];
                by_along += c * a[m] * db[n];
                mixed += c * da[m] * db[n];
            }
        }
        // Straight on, and the same by either way round at the corners.
        [
            value + by_across * beyond + by_along * past + mixed * beyond * past,
            by_across + mixed * past,
            by_along + mixed * beyond,
        ]
    }

    /// Whether `x = across + s` grows by [`SLOPES`] everywhere within the ranges: the derivative of a
    /// spline lies in the hull of the differences of its coefficients.
    pub(crate) fn is_monotone(&self) -> bool {
        let pitch = self.pitch(0);
        let (rows, columns) = self.coefficients.shape();
        let slope = |i: usize, j: usize| {
            1.0 + (self.coefficients[(i + 1, j)] - self.coefficients[(i, j)]) / pitch
        };
        let within = |slope: f64| (SLOPES[0]..=SLOPES[1]).contains(&slope);
        (0..columns).all(|j| (0..rows - 1).all(|i| within(slope(i, j))))
    }

    /// The place across at which a pass comes through `x` at `along`: Newton's method, held in a bracket.
    fn across(&self, x: f64, along: f64) -> f64 {
        let excess = |across: f64| {
            let [value, slope, _] = self.at([across, along]);
            (across + value - x, 1.0 + slope)
        };
        let start = excess(x).0;
        // The slope is at least the least one.
        let far = x - start / SLOPES[0];
        let (mut low, mut high) = (x.min(far), x.max(far));
        let mut at = x - start;
        for _ in 0..STEPS {
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
        // From one row of knots, 1 mm apart, to the next x does not grow but by 0.1.
        assert!(!bend.is_monotone());
    }
}
