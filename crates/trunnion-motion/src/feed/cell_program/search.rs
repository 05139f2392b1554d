//! General solution of a cell's linear program, for answers off the upper border.

use super::constraints::CellConstraints;

/// Most rounds of a search. Each round drops at least one line for good, and a cell has
/// `2 (5 N + 1)`; where rounding repeats a line, the search ends with a point that is allowed.
const ROUNDS: usize = 64;

/// Slope limit of `x` over `y` at rest. Where the largest `x` of all leaves rest at the end of a
/// cell, it would cost much, and the rounding of that rest would decide the speeds after it. There
/// `x` is at most the largest from which the cell can stop over this, and this times as much as
/// `y` more: about half the speed at the end. Whatever follows, the bound stays the same, so more
/// room ahead never gives less.
pub(super) const STEEPEST: f64 = 4.0;

/// A bound on `x` that is linear in `y`: `x <= at_zero + slope y`.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundLine {
    at_zero: f64,
    slope: f64,
    /// Coefficient and axis of the strip it bounds.
    pub(super) place: Option<[usize; 2]>,
}

impl BoundLine {
    fn flat(at_zero: f64) -> Self {
        Self { at_zero, slope: 0.0, place: None }
    }
}

impl BoundLine {
    fn at(self, y: f64) -> f64 {
        self.at_zero + self.slope * y
    }
}

/// Upper and lower bounds of `x` as lines in `y`, one pair per strip.
///
/// Constraints that hardly depend on `x` bound `y` instead.
struct LineBounds<const N: usize, const K: usize> {
    /// Upper lines at `y = 0`, and lower ones' opposites.
    at_zero: [[[f64; N]; K]; 2],
    slope: [[f64; N]; K],
    x_max: f64,
    y_max: f64,
    steepest: BoundLine,
}

impl<const N: usize, const K: usize> LineBounds<N, K> {
    fn new(strips: &CellConstraints<N, K>, x_max: f64, y_max: f64) -> Self {
        let mut bounds = Self {
            at_zero: [[[f64::INFINITY; N]; K]; 2],
            slope: [[0.0; N]; K],
            x_max,
            y_max,
            steepest: BoundLine::flat(f64::INFINITY),
        };
        // Below this a term a x is lost in the rounding of the limit 1.
        let negligible = f64::EPSILON / x_max;
        for k in 0..K {
            for axis in 0..N {
                let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
                if a.abs() > negligible {
                    for (side, sign) in [a, -a].into_iter().enumerate() {
                        bounds.at_zero[side][k][axis] = strips.limit(axis, sign) / a.abs();
                    }
                    bounds.slope[k][axis] = -b / a;
                } else if b != 0.0 {
                    bounds.y_max = bounds.y_max.min(strips.limit(axis, b) / b.abs());
                }
            }
        }
        let at_rest = bounds.upper(0.0);
        if at_rest.slope < 0.0 {
            let at_zero = at_rest.at_zero / STEEPEST;
            bounds.steepest = BoundLine { at_zero, slope: STEEPEST, place: None };
        }
        bounds
    }

    /// Returns the lowest upper bound at `y`.
    fn upper(&self, y: f64) -> BoundLine {
        let mut line = BoundLine::flat(self.x_max);
        let mut lowest = self.x_max;
        if self.steepest.at(y) < lowest {
            (lowest, line) = (self.steepest.at(y), self.steepest);
        }
        for k in 0..K {
            for axis in 0..N {
                let [at_zero, slope] = [self.at_zero[0][k][axis], self.slope[k][axis]];
                let value = at_zero + slope * y;
                if value < lowest {
                    (lowest, line) = (value, BoundLine { at_zero, slope, place: Some([k, axis]) });
                }
            }
        }
        line
    }

    /// Returns the highest lower bound at `y`.
    fn lower(&self, y: f64) -> BoundLine {
        let mut line = BoundLine::flat(0.0);
        let mut highest = 0.0;
        for k in 0..K {
            for axis in 0..N {
                let [at_zero, slope] = [-self.at_zero[1][k][axis], self.slope[k][axis]];
                let value = at_zero + slope * y;
                if value > highest {
                    (highest, line) = (value, BoundLine { at_zero, slope, place: Some([k, axis]) });
                }
            }
        }
        line
    }
}

/// Returns the answer wherever it lies, with the two lines that meet there: upper bounds of `x`
/// (1) or lower ones (-1).
#[cold]
pub(super) fn search<const N: usize, const K: usize>(
    strips: &CellConstraints<N, K>,
    x_max: f64,
    y_max: f64,
) -> (f64, bool, [(BoundLine, f64); 2]) {
    let bounds = LineBounds::new(strips, x_max, y_max);
    let mut y = bounds.y_max;
    let mut closing = (BoundLine::flat(0.0), 1.0);
    for _ in 0..ROUNDS {
        let [upper, lower] = [bounds.upper(y), bounds.lower(y)];
        // The gap closes between 0 and y: both lines leave some room at 0. Where rounding opens it
        // again at the point where it closes, it counts as closed.
        let closer = (upper.at_zero - lower.at_zero) / (lower.slope - upper.slope);
        if lower.at(y) <= upper.at(y) || closer >= y {
            let below = upper.slope <= 0.0 || y < y_max;
            if upper.slope >= 0.0 {
                return (upper.at(y), below, [(upper, 1.0), closing]);
            }
            let (x, lines) = peak(&bounds, upper, y);
            return (x, below, lines.map(|line| (line, 1.0)));
        }
        closing = (lower, -1.0);
        y = closer;
    }
    let flat = BoundLine::flat(0.0);
    (bounds.upper(0.0).at(0.0), false, [(flat, 1.0); 2])
}

/// Returns the maximum over `[0, y]` of the upper bound, which falls along `right` at `y`, and the
/// lines that meet there.
fn peak<const N: usize, const K: usize>(
    bounds: &LineBounds<N, K>,
    mut right: BoundLine,
    mut y: f64,
) -> (f64, [BoundLine; 2]) {
    let mut left = bounds.upper(0.0);
    let mut best = left.at(0.0);
    if left.slope <= 0.0 {
        return (best, [left, right]);
    }
    for _ in 0..ROUNDS {
        // The maximum of a concave bound: cut the rising line with the falling one, and replace
        // the one on whose side the bound at the crossing lies.
        let crossing = (right.at_zero - left.at_zero) / (left.slope - right.slope);
        let line = bounds.upper(crossing);
        best = best.max(line.at(crossing));
        if line.at(crossing) >= left.at(crossing) || line.slope == 0.0 || crossing >= y {
            break;
        }
        if line.slope > 0.0 { left = line } else { (right, y) = (line, crossing) }
    }
    (best, [left, right])
}
