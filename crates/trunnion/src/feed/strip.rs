//! The two-variable linear program of one cell, in closed form.
//!
//! The squared speeds `(x, y)` at both ends of a cell lie in an intersection of strips
//! `|a x + b y| <= 1` about the origin, so zero is always allowed and there is always an answer.

use super::cell::{Accelerations, Strips, largest};

/// Most rounds of a search. Each round drops at least one line for good, and a cell has
/// `2 (5 N + 1)`; where rounding repeats a line, the search ends with a point that is allowed.
const ROUNDS: usize = 64;

/// Where the largest `x` of all leaves rest at the end of a cell, it would be bought dearly, and what
/// rounding leaves of that rest would decide what comes after. There `x` is at most the largest from
/// which the cell can stop over this, and this times as much as `y` more: about half the speed at the
/// end. Whatever follows, the bound stays the same, so more room ahead never gives less.
const STEEPEST: f64 = 4.0;

/// A bound on `x` that is linear in `y`: `x <= at_zero + slope y`.
#[derive(Debug, Clone, Copy)]
struct Line {
    at_zero: f64,
    slope: f64,
    /// Coefficient and axis of the strip it bounds.
    place: Option<[usize; 2]>,
}

impl Line {
    fn flat(at_zero: f64) -> Self {
        Self { at_zero, slope: 0.0, place: None }
    }
}

impl Line {
    fn at(self, y: f64) -> f64 {
        self.at_zero + self.slope * y
    }
}

/// Upper and lower bounds of `x` as lines in `y`, one pair per strip.
///
/// Strips that hardly depend on `x` bound `y` instead.
struct Bounds<const N: usize, const K: usize> {
    at_zero: [[f64; N]; K],
    slope: [[f64; N]; K],
    x_max: f64,
    y_max: f64,
    steepest: Line,
}

impl<const N: usize, const K: usize> Bounds<N, K> {
    fn new(strips: &Strips<N, K>, x_max: f64, y_max: f64) -> Self {
        let mut bounds = Self {
            at_zero: [[f64::INFINITY; N]; K],
            slope: [[0.0; N]; K],
            x_max,
            y_max,
            steepest: Line::flat(f64::INFINITY),
        };
        // Below this a term a x is lost in the rounding of the limit 1.
        let negligible = f64::EPSILON / x_max;
        for k in 0..K {
            for axis in 0..N {
                let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
                if a.abs() > negligible {
                    bounds.at_zero[k][axis] = 1.0 / a.abs();
                    bounds.slope[k][axis] = -b / a;
                } else if b != 0.0 {
                    bounds.y_max = bounds.y_max.min(1.0 / b.abs());
                }
            }
        }
        let at_rest = bounds.upper(0.0);
        if at_rest.slope < 0.0 {
            let at_zero = at_rest.at_zero / STEEPEST;
            bounds.steepest = Line { at_zero, slope: STEEPEST, place: None };
        }
        bounds
    }

    /// The lowest upper bound at `y`.
    fn upper(&self, y: f64) -> Line {
        let mut line = Line::flat(self.x_max);
        let mut lowest = self.x_max;
        if self.steepest.at(y) < lowest {
            (lowest, line) = (self.steepest.at(y), self.steepest);
        }
        for k in 0..K {
            for axis in 0..N {
                let [at_zero, slope] = [self.at_zero[k][axis], self.slope[k][axis]];
                let value = at_zero + slope * y;
                if value < lowest {
                    (lowest, line) = (value, Line { at_zero, slope, place: Some([k, axis]) });
                }
            }
        }
        line
    }

    /// The highest lower bound at `y`.
    fn lower(&self, y: f64) -> Line {
        let mut line = Line::flat(0.0);
        let mut highest = 0.0;
        for k in 0..K {
            for axis in 0..N {
                let [at_zero, slope] = [-self.at_zero[k][axis], self.slope[k][axis]];
                let value = at_zero + slope * y;
                if value > highest {
                    (highest, line) = (value, Line { at_zero, slope, place: Some([k, axis]) });
                }
            }
        }
        line
    }
}

/// What bound a cell before: on smooth paths it binds the next one too, and that is quickly checked. It
/// only saves time: answers do not depend on it but for rounding.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Guess {
    /// Coefficient and axis of the strip, where the end is as fast as what follows allows.
    one: Option<[usize; 2]>,
    /// The two sides of strips whose corner it is.
    corner: Option<[Side; 2]>,
    /// Whether it was a corner.
    at_corner: bool,
}

/// `sign (a x + b y) = 1` for the strip of a coefficient and an axis.
#[derive(Debug, Clone, Copy)]
struct Side {
    place: [usize; 2],
    sign: f64,
}

/// Roundings in the value of a constraint, of the terms it is the sum of: three products and sums,
/// and one in the answer itself.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Whether all `K` constraints hold, up to the rounding of one with a term of this size.
#[inline]
fn kept<const N: usize, const K: usize>(cell: &Accelerations<N>, x: [f64; 2], term: f64) -> bool {
    cell.most::<K>(x) <= allowed(term)
}

/// Values of constraints up to this are 1 up to the rounding of one with a term of this size.
#[inline]
fn allowed(term: f64) -> f64 {
    1.0 + ROUNDING * (1.0 + 2.0 * term.abs())
}

/// Largest `x <= x_max` for which some `y` in `[0, y_max]` satisfies all strips, and whether a
/// larger `y_max` would leave it as it is.
#[inline]
pub(super) fn backward<const N: usize, const K: usize>(
    cell: &Accelerations<N>,
    x_max: f64,
    y: f64,
    guess: &mut Guess,
) -> (f64, bool) {
    if guess.at_corner
        && let Some(x) = corner::<N, K>(cell, [x_max, y], guess)
    {
        return (x, true);
    }
    let [mut x, mut term, mut slope] = [x_max, 0.0, 0.0];
    if let Some(place) = guess.one {
        let [a, b] = cell.constraint::<K>(place);
        let room = 1.0 - b.copysign(a * b) * y;
        if x * a.abs() > room {
            (x, slope) = (room / a.abs(), -a * b);
            term = a * x;
        }
    }
    // At most this much by that one constraint, and allowed by the others.
    if x >= 0.0 && slope >= 0.0 && kept::<N, K>(cell, [x, y], term) {
        guess.at_corner = false;
        return (x, slope <= 0.0);
    }
    if !guess.at_corner
        && let Some(x) = corner::<N, K>(cell, [x_max, y], guess)
    {
        guess.at_corner = true;
        return (x, true);
    }
    anywhere(&cell.strips::<K>(), x_max, y, guess)
}

/// The answer at the corner guessed, if that is it: allowed, and moving along neither side gives more
/// (both multipliers of the linear program are positive).
#[inline]
fn corner<const N: usize, const K: usize>(
    cell: &Accelerations<N>,
    [x_max, y_max]: [f64; 2],
    guess: &Guess,
) -> Option<f64> {
    /// Sides nearer to parallel than this meet where rounding will have it.
    const PARALLEL: f64 = 1e-6;
    let [p, q] = guess.corner?;
    let [[a, b], [c, d]] = [p, q].map(|side| cell.constraint::<K>(side.place));
    let [ad, bc] = [a * d, b * c];
    let across = ad - bc;
    // Signs of the multipliers, without division.
    let best = d * p.sign * across >= 0.0 && b * q.sign * across <= 0.0;
    if !best || across.abs() <= PARALLEL * (ad.abs() + bc.abs()) {
        return None;
    }
    let per = 1.0 / across;
    let x = (p.sign * d - q.sign * b) * per;
    let y = (q.sign * a - p.sign * c) * per;
    let inside = x >= 0.0 && x <= x_max && y >= 0.0 && y <= y_max;
    let term = largest((a * x).abs(), (c * x).abs());
    (inside && kept::<N, K>(cell, [x, y], term)).then_some(x)
}

/// The same by looking at all strips.
#[inline(never)]
fn anywhere<const N: usize, const K: usize>(
    strips: &Strips<N, K>,
    x_max: f64,
    y_max: f64,
    guess: &mut Guess,
) -> (f64, bool) {
    if let Some((x, slope, place)) = largest_at(strips, x_max, y_max) {
        (guess.one, guess.at_corner) = (place, false);
        return (x, slope <= 0.0);
    }
    let (x, below, lines) = search(strips, x_max, y_max);
    let side = |(line, sign): (Line, f64)| {
        let place = line.place?;
        Some(Side { place, sign: sign.copysign(sign * strips.a[place[0]][place[1]]) })
    };
    if let [Some(p), Some(q)] = lines.map(side) {
        (guess.corner, guess.at_corner) = (Some([p, q]), true);
    }
    (x, below)
}

/// The answer where it lies at `y_max`, as it does on most cells: there some `x` is left, and its
/// upper bound does not fall with `y`: `x`, a multiple of that slope, and which constraint bounds it.
#[inline]
fn largest_at<const N: usize, const K: usize>(
    strips: &Strips<N, K>,
    x_max: f64,
    y: f64,
) -> Option<(f64, f64, Option<[usize; 2]>)> {
    let [mut x, mut slope] = [x_max, 0.0];
    let mut place = None;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            let room = 1.0 - b.copysign(a * b) * y;
            if x * a.abs() > room {
                (x, slope) = (room / a.abs(), -a * b);
                place = Some([k, axis]);
            }
        }
    }
    if !(x >= 0.0 && slope >= 0.0) {
        return None;
    }
    let mut least = f64::INFINITY;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            let room = x * a.abs() + (1.0 + b.copysign(a * b) * y);
            least = if room < least { room } else { least };
        }
    }
    (least >= 0.0).then_some((x, slope, place))
}

/// The answer wherever it lies, with the two lines that meet there: upper bounds of `x` (1) or lower
/// ones (-1).
#[cold]
fn search<const N: usize, const K: usize>(
    strips: &Strips<N, K>,
    x_max: f64,
    y_max: f64,
) -> (f64, bool, [(Line, f64); 2]) {
    let bounds = Bounds::new(strips, x_max, y_max);
    let mut y = bounds.y_max;
    let mut closing = (Line::flat(0.0), 1.0);
    for _ in 0..ROUNDS {
        let [upper, lower] = [bounds.upper(y), bounds.lower(y)];
        // The gap closes between 0 and y: both lines leave some room at 0. Where rounding opens it
        // again at the very place where it closes, it is closed.
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
    let flat = Line::flat(0.0);
    (bounds.upper(0.0).at(0.0), false, [(flat, 1.0); 2])
}

/// Maximum over `[0, y]` of the upper bound, which falls along `right` at `y`, and the lines that meet
/// there.
fn peak<const N: usize, const K: usize>(
    bounds: &Bounds<N, K>,
    mut right: Line,
    mut y: f64,
) -> (f64, [Line; 2]) {
    let mut left = bounds.upper(0.0);
    let mut best = left.at(0.0);
    if left.slope <= 0.0 {
        return (best, [left, right]);
    }
    for _ in 0..ROUNDS {
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

/// Largest `y <= y_max` that satisfies all strips for this `x`, and the largest constraint there.
#[inline]
pub(super) fn forward<const N: usize, const K: usize>(
    cell: &Accelerations<N>,
    x: f64,
    y_max: f64,
    guess: &mut Guess,
) -> (f64, f64) {
    let [mut y, mut term] = [y_max, 0.0];
    if let Some(place) = guess.one {
        let [a, b] = cell.constraint::<K>(place);
        let room = if b > 0.0 { 1.0 - a * x } else { 1.0 + a * x };
        if y * b.abs() > room {
            y = room / b.abs();
            term = b * y;
        }
    }
    if y >= 0.0 {
        let most = cell.most::<K>([x, y]);
        if most <= allowed(term) {
            return (y, most);
        }
    }
    let y = onward(&cell.strips::<K>(), x, y_max, guess);
    (y, cell.most::<K>([x, y]))
}

/// The same by looking at all strips.
#[inline(never)]
fn onward<const N: usize, const K: usize>(
    strips: &Strips<N, K>,
    x: f64,
    y_max: f64,
    guess: &mut Guess,
) -> f64 {
    let mut y = y_max;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            let room = if b > 0.0 { 1.0 - a * x } else { 1.0 + a * x };
            // As a product: dividing is only worth it when this strip is the narrowest so far.
            if y * b.abs() > room {
                y = room / b.abs();
                guess.one = Some([k, axis]);
            }
        }
    }
    y.max(0.0)
}

/// Smallest `y >= 0` that satisfies all strips for this `x`, if there is one.
pub(super) fn least<const N: usize, const K: usize>(strips: &Strips<N, K>, x: f64) -> f64 {
    let mut y = 0.0;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            let lacking = if b > 0.0 { -1.0 - a * x } else { a * x - 1.0 };
            if b != 0.0 && y * b.abs() < lacking {
                y = lacking / b.abs();
            }
        }
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::Reciprocals;
    use crate::feed::cell::Cell;
    use nalgebra::SVector;
    use proptest::prelude::*;

    /// Five strips on one axis.
    fn strips(rows: [[f64; 2]; 5]) -> Strips<1> {
        Strips { a: rows.map(|row| SVector::from([row[0]])), b: rows.map(|row| [row[1]].into()) }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn a_straight_line_gains_twice_acceleration_times_distance() {
        // |y - x| <= 8
        let line = strips([[-0.125, 0.125]; 5]);
        assert_eq!(anywhere(&line, 100.0, 4.0, &mut Guess::default()).0, 12.0);
        assert_eq!(anywhere(&line, 10.0, 4.0, &mut Guess::default()).0, 10.0);
        assert_eq!(onward(&line, 4.0, 100.0, &mut Guess::default()), 12.0);
        assert_eq!(onward(&line, 4.0, 9.0, &mut Guess::default()), 9.0);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn a_gap_above_is_closed_by_a_smaller_end() {
        // y <= x + 8, x <= 2: y = 50 is out of reach, but x = 2 is allowed with y = 10.
        let line = strips([[-0.125, 0.125]; 5]);
        assert_eq!(anywhere(&line, 2.0, 50.0, &mut Guess::default()).0, 2.0);
    }

    proptest! {
        /// Against a search over a grid of `y`, which can only find less.
        #[test]
        fn backward_agrees_with_a_search(
            rows in prop::array::uniform5([-3.0..3.0f64, -3.0..3.0f64]),
            x_max in 0.01..10.0f64,
            y_max in 0.01..10.0f64,
        ) {
            let strips = strips(rows);
            // From where the end can be at rest, and whether more at the end only costs.
            let steepest = rows.iter().max_by(|p, q| p[0].abs().total_cmp(&q[0].abs())).unwrap();
            let at_rest = 1.0 / steepest[0].abs();
            let dear = at_rest < x_max && steepest[0] * steepest[1] > 0.0;
            let mut best: f64 = 0.0;
            for step in 0..=20_000 {
                let y = y_max * f64::from(step) / 20_000.0;
                let bought = if dear { at_rest / STEEPEST + STEEPEST * y } else { x_max };
                let mut range = [0.0, x_max.min(bought)];
                for [a, b] in rows {
                    let [low, high] = [(-1.0 - b * y) / a, (1.0 - b * y) / a];
                    range = [range[0].max(low.min(high)), range[1].min(low.max(high))];
                }
                if range[0] <= range[1] {
                    best = best.max(range[1]);
                }
            }
            let got = anywhere(&strips, x_max, y_max, &mut Guess::default()).0;
            prop_assert!(got >= best - 1e-12 && got <= best + 0.05, "{got} against {best}");
            // Reached: going forward from it stays inside every strip.
            let y = onward(&strips, got, y_max, &mut Guess::default());
            for [a, b] in rows {
                prop_assert!((a * got + b * y).abs() <= 1.0 + 1e-9);
            }
        }

        /// A good or a bad guess changes nothing but rounding.
        #[test]
        fn answers_do_not_depend_on_the_guess(
            rates in prop::array::uniform5(prop::array::uniform2(-3.0..3.0f64)),
            x_max in 0.01..10.0f64,
            y_max in 0.01..10.0f64,
            place in prop::array::uniform2(0..2usize),
        ) {
            let limits = Reciprocals { acceleration: SVector::repeat(1.0), ..Reciprocals::none() };
            let cell = Cell {
                h: 1.0,
                rates: rates.map(SVector::from),
                doubt: SVector::zeros(),
                feed_rate: [0.0; 2],
                tip_rate: [0.0; 2],
            };
            let cell = cell.accelerations(&limits);
            let x = anywhere(&cell.strips::<5>(), x_max, y_max, &mut Guess::default()).0;
            let y = onward(&cell.strips::<5>(), x, y_max, &mut Guess::default());
            let side = |axis: usize, sign: f64| Side { place: [place[0], axis], sign };
            for (one, signs) in [(None, [1.0; 2]), (Some(place), [1.0, -1.0]), (Some([4, 0]), [-1.0, 1.0])] {
                for at_corner in [false, true] {
                    let corner = Some([side(0, signs[0]), side(1, signs[1])]);
                    let mut guess = Guess { one, corner, at_corner };
                    let (got, _) = backward::<2, 5>(&cell, x_max, y_max, &mut guess.clone());
                    prop_assert!((got - x).abs() <= 1e-10 * x_max, "{got} {x}");
                    let (got, most) = forward::<2, 5>(&cell, x, y_max, &mut guess);
                    prop_assert!(most.to_bits() == cell.most::<5>([x, got]).to_bits());
                    prop_assert!((got - y).abs() <= 1e-10 * y_max, "{got} {y}");
                }
            }
        }
    }
}
