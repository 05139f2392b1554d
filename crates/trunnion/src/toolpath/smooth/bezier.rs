//! Quintics in Bernstein form: restriction, products of conversion.

use crate::types::PoseCoordinates;

/// Degree of every curve here.
pub(super) const DEGREE: usize = 5;

/// Control points of a quintic over its interval: the curve lies in their convex hull.
pub(super) type QuinticBezier = [PoseCoordinates; DEGREE + 1];

/// Weights of the Bernstein polynomials in the middle of the interval, times 32.
const MIDDLE: [f64; DEGREE + 1] = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];

/// Splits a curve at the share `t` (de Casteljau's scheme: convex combinations only).
pub(super) fn split(whole: &QuinticBezier, t: f64) -> [QuinticBezier; 2] {
    let mut right = *whole;
    let mut left = *whole;
    for (step, point) in left.iter_mut().enumerate().skip(1) {
        for i in 0..=DEGREE - step {
            // One level of de Casteljau: b_i <- (1 - t) b_i + t b_{i+1}; the first point of each
            // level belongs to the left part, the last row is the right one.
            right[i] += (right[i + 1] - right[i]) * t;
        }
        *point = right[0];
    }
    [left, right]
}

/// Returns the part of a curve between two shares.
pub(super) fn part(whole: &QuinticBezier, [from, to]: [f64; 2]) -> QuinticBezier {
    // What is left of `from` goes first; `to` is then a share of the remainder.
    let rest = if from > 0.0 { split(whole, from)[1] } else { *whole };
    if to < 1.0 { split(&rest, (to - from) / (1.0 - from))[0] } else { rest }
}

/// Returns the curve moved by `by`.
pub(super) fn moved(curve: &QuinticBezier, by: &PoseCoordinates) -> QuinticBezier {
    curve.map(|point| point + by)
}

/// Returns the value in the middle of the interval.
pub(super) fn middle(whole: &QuinticBezier) -> PoseCoordinates {
    let sum = whole.iter().zip(MIDDLE).fold(PoseCoordinates::zeros(), |sum, (p, w)| sum + p * w);
    sum / 32.0
}

/// Returns the coefficients of the powers of the distance from the start of an interval of `width`.
pub(super) fn powers(whole: &QuinticBezier, width: f64) -> QuinticBezier {
    let mut row = *whole;
    for step in 1..=DEGREE {
        for i in (step..=DEGREE).rev() {
            // Forward differences: after step k, row k holds the k-th difference of the control
            // points.
            let before = row[i - 1];
            row[i] -= before;
        }
    }
    let mut scale = 1.0;
    for (k, coefficient) in row.iter_mut().enumerate() {
        // c_k = C(n, k) Delta^k b_0 / width^k.
        *coefficient *= MIDDLE[k] * scale;
        scale /= width;
    }
    row
}

/// Returns the control points on `[0, width]` of a polynomial given by powers.
pub(super) fn from_powers(powers: &QuinticBezier, width: f64) -> QuinticBezier {
    let mut row = *powers;
    let mut scale = 1.0;
    for (k, point) in row.iter_mut().enumerate() {
        // The inverse: scaled powers c_k width^k / C(n, k), then repeated sums instead of
        // differences.
        *point *= scale / MIDDLE[k];
        scale *= width;
    }
    for step in (1..=DEGREE).rev() {
        for i in step..=DEGREE {
            let before = row[i - 1];
            row[i] += before;
        }
    }
    row
}

/// Returns the line between two points in Bernstein form.
pub(super) fn line(from: &PoseCoordinates, to: &PoseCoordinates) -> QuinticBezier {
    let step = (to - from) / DEGREE as f64;
    let mut points = [*from; DEGREE + 1];
    for (k, point) in points.iter_mut().enumerate() {
        *point += step * k as f64;
    }
    points
}

/// Returns the cubic through two points with two tangents, over an interval of `width`.
pub(super) fn cubic(
    points: [&PoseCoordinates; 2],
    tangents: [&PoseCoordinates; 2],
    width: f64,
) -> QuinticBezier {
    let third = width / 3.0;
    // Inner control points of a cubic: a third of the width along the tangents.
    let inner = [points[0] + tangents[0] * third, points[1] - tangents[1] * third];
    let four = [*points[0], inner[0], inner[1], *points[1]];
    // Twice one degree up: b_j of degree n from those of degree n - 1.
    let mut five = [four[0]; 5];
    for (j, point) in five.iter_mut().enumerate().skip(1) {
        let share = j as f64 / 4.0;
        *point = four[j - 1] * share + four[j.min(3)] * (1.0 - share);
    }
    let mut six = [five[0]; 6];
    for (j, point) in six.iter_mut().enumerate().skip(1) {
        let share = j as f64 / 5.0;
        *point = five[j - 1] * share + five[j.min(4)] * (1.0 - share);
    }
    six
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wild() -> QuinticBezier {
        std::array::from_fn(|k| PoseCoordinates::from_fn(|i, _| ((3 * k + i * i) as f64).sin()))
    }

    fn at(powers: &QuinticBezier, x: f64) -> PoseCoordinates {
        powers.iter().rev().fold(PoseCoordinates::zeros(), |sum, c| sum * x + c)
    }

    #[test]
    fn forms_agree_on_value_part_and_middle() {
        let curve = wild();
        let power = powers(&curve, 3.0);
        let again = from_powers(&power, 3.0);
        for k in 0..=DEGREE {
            assert!((again[k] - curve[k]).norm() < 1e-13);
        }
        assert!((middle(&curve) - at(&power, 1.5)).norm() < 1e-14);
        let inside = powers(&part(&curve, [0.25, 0.75]), 1.5);
        for t in [0.0, 0.3, 0.8, 1.0] {
            let whole = at(&power, 0.75 + 1.5 * t);
            assert!((at(&inside, 1.5 * t) - whole).norm() < 1e-13);
        }
    }

    #[test]
    fn a_cubic_and_a_line_keep_their_tangents() {
        let [a, b, ..] = wild();
        let [ta, tb] = [wild()[2], wild()[3]];
        let power = powers(&cubic([&a, &b], [&ta, &tb], 2.0), 2.0);
        assert!((power[1] - ta).norm() < 1e-14 && power[4].norm() + power[5].norm() < 1e-13);
        assert!((at(&power, 2.0) - b).norm() < 1e-14);
        let straight = powers(&line(&a, &b), 2.0);
        assert!((straight[1] - (b - a) / 2.0).norm() < 1e-15 && straight[2].norm() < 1e-14);
    }
}
