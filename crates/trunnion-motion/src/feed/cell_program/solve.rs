//! The two-variable linear program of one cell, in closed form.
//!
//! The squared speeds `(x, y)` at both ends of a cell lie in an intersection of strips
//! `-minus <= a x + b y <= 1` about the origin, so zero is always allowed and there is always an answer.

use super::constraints::CellConstraints;
use super::guess::{ActiveSide, WarmStart};
use super::search::{BoundLine, search};
use crate::feed::accelerations::CellAccelerations;
use crate::feed::numeric::largest;

/// Roundings in the value of a constraint, of the terms it is the sum of: three products and sums,
/// and one in the answer itself.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Returns `true` if all `K` constraints hold, up to the rounding of one with a term of this size.
#[inline]
fn kept<const N: usize, const K: usize>(
    cell: &CellAccelerations<N>,
    x: [f64; 2],
    term: f64,
) -> bool {
    cell.most::<K>(x) <= allowed(term)
}

/// Returns the value up to which a constraint counts as 1, up to the rounding of one with a term
/// of this size.
#[inline]
fn allowed(term: f64) -> f64 {
    1.0 + ROUNDING * (1.0 + 2.0 * term.abs())
}

/// Returns the largest `x <= x_max` for which some `y` in `[0, y_max]` satisfies all constraints,
/// and `true` if a larger `y_max` would leave it as it is.
#[inline]
pub(crate) fn backward<const N: usize, const K: usize>(
    cell: &CellAccelerations<N>,
    x_max: f64,
    y: f64,
    guess: &mut WarmStart,
) -> (f64, bool) {
    if guess.at_corner
        && let Some(x) = corner::<N, K>(cell, [x_max, y], guess)
    {
        return (x, true);
    }
    // Try the constraint that bound the cell before: is its answer allowed by all others?
    let [mut x, mut term, mut slope] = [x_max, 0.0, 0.0];
    if let Some(place) = guess.one {
        let [a, b] = cell.constraint::<K>(place);
        let limit = cell.limit(place[1], a);
        let room = limit - b.copysign(a * b) * y;
        if x * a.abs() > room {
            (x, slope) = (room / a.abs(), -a * b);
            term = a * x / limit;
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
    anywhere(&CellConstraints::<N, K>::of(cell), x_max, y, guess)
}

/// Returns the answer at the corner guessed, if that is it: it is allowed, and moving along
/// neither side gives more (both multipliers of the linear program are positive).
#[inline]
fn corner<const N: usize, const K: usize>(
    cell: &CellAccelerations<N>,
    [x_max, y_max]: [f64; 2],
    guess: &WarmStart,
) -> Option<f64> {
    /// Lines nearer to parallel than this have an intersection that rounding decides.
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
    // The corner solves a x + b y = e and c x + d y = f.
    let per = 1.0 / across;
    let limits = [p, q].map(|side| cell.limit(side.place[1], side.sign));
    let [e, f] = [p.sign * limits[0], q.sign * limits[1]];
    let x = (e * d - f * b) * per;
    let y = (f * a - e * c) * per;
    let inside = x >= 0.0 && x <= x_max && y >= 0.0 && y <= y_max;
    let term = largest((a * x).abs() / limits[0], (c * x).abs() / limits[1]);
    (inside && kept::<N, K>(cell, [x, y], term)).then_some(x)
}

/// Solves the same program by checking every strip.
#[inline(never)]
fn anywhere<const N: usize, const K: usize>(
    strips: &CellConstraints<N, K>,
    x_max: f64,
    y_max: f64,
    guess: &mut WarmStart,
) -> (f64, bool) {
    if let Some((x, slope, place)) = largest_at(strips, x_max, y_max) {
        (guess.one, guess.at_corner) = (place, false);
        return (x, slope <= 0.0);
    }
    let (x, below, lines) = search(strips, x_max, y_max);
    let side = |(line, sign): (BoundLine, f64)| {
        let place = line.place?;
        Some(ActiveSide { place, sign: sign.copysign(sign * strips.a[place[0]][place[1]]) })
    };
    if let [Some(p), Some(q)] = lines.map(side) {
        (guess.corner, guess.at_corner) = (Some([p, q]), true);
    }
    (x, below)
}

/// Returns the answer where it lies at `y_max`, as it does on most cells: some `x` is left there,
/// and its upper bound does not fall with `y`. The result is `x`, a multiple of that slope, and
/// the constraint that bounds it.
#[inline]
fn largest_at<const N: usize, const K: usize>(
    strips: &CellConstraints<N, K>,
    x_max: f64,
    y: f64,
) -> Option<(f64, f64, Option<[usize; 2]>)> {
    // Step 1: the lowest upper bound of x at this y, and its slope.
    let [mut x, mut slope] = [x_max, 0.0];
    let mut place = None;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            let room = strips.limit(axis, a) - b.copysign(a * b) * y;
            if x * a.abs() > room {
                (x, slope) = (room / a.abs(), -a * b);
                place = Some([k, axis]);
            }
        }
    }
    if !(x >= 0.0 && slope >= 0.0) {
        return None;
    }
    // Step 2: no lower bound may lie above it.
    let mut least = f64::INFINITY;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            let room = x * a.abs() + (strips.limit(axis, -a) + b.copysign(a * b) * y);
            least = if room < least { room } else { least };
        }
    }
    (least >= 0.0).then_some((x, slope, place))
}

/// Returns the largest `y <= y_max` that satisfies all constraints for this `x`, and the largest
/// constraint there.
#[inline]
pub(crate) fn forward<const N: usize, const K: usize>(
    cell: &CellAccelerations<N>,
    x: f64,
    y_max: f64,
    guess: &mut WarmStart,
) -> (f64, f64) {
    // Try the constraint that bound the cell before; all others only have to allow it.
    let [mut y, mut term] = [y_max, 0.0];
    if let Some(place) = guess.one {
        let [a, b] = cell.constraint::<K>(place);
        let limit = cell.limit(place[1], b);
        let room = if b > 0.0 { limit - a * x } else { limit + a * x };
        if y * b.abs() > room {
            y = room / b.abs();
            term = b * y / limit;
        }
    }
    if y >= 0.0 {
        let most = cell.most::<K>([x, y]);
        if most <= allowed(term) {
            return (y, most);
        }
    }
    let y = onward(&CellConstraints::<N, K>::of(cell), x, y_max, guess);
    (y, cell.most::<K>([x, y]))
}

/// Solves the same program by checking every strip.
#[inline(never)]
fn onward<const N: usize, const K: usize>(
    strips: &CellConstraints<N, K>,
    x: f64,
    y_max: f64,
    guess: &mut WarmStart,
) -> f64 {
    let mut y = y_max;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            let limit = strips.limit(axis, b);
            let room = if b > 0.0 { limit - a * x } else { limit + a * x };
            // As a product: dividing is only worth it when this strip is the narrowest so far.
            if y * b.abs() > room {
                y = room / b.abs();
                guess.one = Some([k, axis]);
            }
        }
    }
    y.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::feed::cell::FeedCell;
    use crate::feed::cell_program::search::STEEPEST;
    use crate::feed::directional::DirectionalLimits;
    use crate::feed::reciprocal::ReciprocalLimits;
    use nalgebra::SVector;
    use proptest::prelude::*;

    /// The same with a limit of its own towards minus.
    fn sided(rows: [[f64; 2]; 5], minus: f64) -> CellConstraints<1> {
        let [a, b] = [0, 1].map(|side| rows.map(|row: [f64; 2]| SVector::from([row[side]])));
        CellConstraints { a, b, minus: [minus] }
    }

    /// Five strips on one axis.
    fn strips(rows: [[f64; 2]; 5]) -> CellConstraints<1> {
        sided(rows, 1.0)
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn a_straight_line_gains_twice_acceleration_times_distance() {
        // |y - x| <= 8
        let line = strips([[-0.125, 0.125]; 5]);
        assert_eq!(anywhere(&line, 100.0, 4.0, &mut WarmStart::default()).0, 12.0);
        assert_eq!(anywhere(&line, 10.0, 4.0, &mut WarmStart::default()).0, 10.0);
        assert_eq!(onward(&line, 4.0, 100.0, &mut WarmStart::default()), 12.0);
        assert_eq!(onward(&line, 4.0, 9.0, &mut WarmStart::default()), 9.0);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "dyadic numbers: exact in binary")]
    fn a_gap_above_is_closed_by_a_smaller_end() {
        // y <= x + 8, x <= 2: y = 50 is out of reach, but x = 2 is allowed with y = 10.
        let line = strips([[-0.125, 0.125]; 5]);
        assert_eq!(anywhere(&line, 2.0, 50.0, &mut WarmStart::default()).0, 2.0);
    }

    proptest! {
        /// Against a search over a grid of `y`, which can only find less.
        #[test]
        fn backward_agrees_with_a_search(
            rows in prop::array::uniform5([-3.0..3.0f64, -3.0..3.0f64]),
            x_max in 0.01..10.0f64,
            y_max in 0.01..10.0f64,
            minus in prop_oneof![Just(1.0), 0.1..10.0f64],
        ) {
            let strips = sided(rows, minus);
            let side = |sign: f64| if sign < 0.0 { minus } else { 1.0 };
            // From where the end can be at rest, and whether more at the end only costs.
            let share = |row: &[f64; 2]| row[0].abs() / side(row[0]);
            let steepest = rows.iter().max_by(|p, q| share(p).total_cmp(&share(q))).unwrap();
            let at_rest = 1.0 / share(steepest);
            let dear = at_rest < x_max && steepest[0] * steepest[1] > 0.0;
            let mut best: f64 = 0.0;
            for step in 0..=20_000 {
                let y = y_max * f64::from(step) / 20_000.0;
                let bought = if dear { at_rest / STEEPEST + STEEPEST * y } else { x_max };
                let mut range = [0.0, x_max.min(bought)];
                for [a, b] in rows {
                    let [low, high] = [(-minus - b * y) / a, (1.0 - b * y) / a];
                    range = [range[0].max(low.min(high)), range[1].min(low.max(high))];
                }
                if range[0] <= range[1] {
                    best = best.max(range[1]);
                }
            }
            let got = anywhere(&strips, x_max, y_max, &mut WarmStart::default()).0;
            prop_assert!(got >= best - 1e-12 && got <= best + 0.05, "{got} against {best}");
            // Reached: going forward from it stays inside every strip.
            let y = onward(&strips, got, y_max, &mut WarmStart::default());
            for [a, b] in rows {
                let value = a * got + b * y;
                prop_assert!(value <= 1.0 + 1e-9 && value >= -minus - 1e-9);
            }
        }

        /// A good or a bad guess changes nothing but rounding.
        #[test]
        fn answers_do_not_depend_on_the_guess(
            rates in prop::array::uniform5(prop::array::uniform2(-3.0..3.0f64)),
            x_max in 0.01..10.0f64,
            y_max in 0.01..10.0f64,
            place in prop::array::uniform2(0..2usize),
            minus in prop::array::uniform2(prop_oneof![Just(1.0), 0.1..10.0f64]),
        ) {
            let acceleration = DirectionalLimits { plus: SVector::repeat(1.0), minus: SVector::from(minus) };
            let limits = ReciprocalLimits { acceleration, ..ReciprocalLimits::none() };
            let cell = FeedCell {
                h: 1.0,
                rates: rates.map(SVector::from),
                doubt: SVector::zeros(),
                feed_rate: [0.0; 2],
                tip_rate: [0.0; 2],
            };
            let cell = cell.accelerations(&limits);
            let x = anywhere(&CellConstraints::<2, 5>::of(&cell), x_max, y_max, &mut WarmStart::default()).0;
            let y = onward(&CellConstraints::<2, 5>::of(&cell), x, y_max, &mut WarmStart::default());
            let side = |axis: usize, sign: f64| ActiveSide { place: [place[0], axis], sign };
            for (one, signs) in [(None, [1.0; 2]), (Some(place), [1.0, -1.0]), (Some([4, 0]), [-1.0, 1.0])] {
                for at_corner in [false, true] {
                    let corner = Some([side(0, signs[0]), side(1, signs[1])]);
                    let mut guess = WarmStart { one, corner, at_corner };
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
