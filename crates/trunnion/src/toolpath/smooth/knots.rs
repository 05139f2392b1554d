//! Clamped quintic B-splines over increasing breaks.

use super::bezier::{DEGREE, QuinticBezier};
use crate::types::PoseCoordinates;

/// Returns knot `index` of the clamped knot vector over `breaks`, whose ends are repeated.
fn knot(breaks: &[f64], index: usize) -> f64 {
    breaks[index.saturating_sub(DEGREE).min(breaks.len() - 1)]
}

/// Twelve knots that the basis functions of one span depend on: six up to its start, six from its end.
pub(super) struct SpanKnots {
    knots: [f64; 2 * DEGREE + 2],
    /// `1 / (high - low)` of every step of the triangular scheme.
    shares: [f64; DEGREE * (DEGREE + 1) / 2],
}

impl SpanKnots {
    pub(super) fn new(breaks: &[f64], span: usize) -> Self {
        let knots: [f64; 2 * DEGREE + 2] = std::array::from_fn(|k| knot(breaks, span + k));
        let mut shares = [0.0; DEGREE * (DEGREE + 1) / 2];
        let mut at = 0;
        for level in 1..=DEGREE {
            for i in 0..level {
                let [low, high] = [knots[DEGREE + 1 + i - level], knots[DEGREE + 1 + i]];
                shares[at] = 1.0 / (high - low);
                at += 1;
            }
        }
        Self { knots, shares }
    }

    /// Returns the six basis functions that are not zero on the span, at `u`.
    pub(super) fn basis(&self, u: f64) -> [f64; DEGREE + 1] {
        let mut basis = [0.0; DEGREE + 1];
        basis[0] = 1.0;
        let mut at = 0;
        for level in 1..=DEGREE {
            // Cox and de Boor: each basis function passes the share (high - u) on to its own index,
            // and (u - low) to the next.
            let mut carried = 0.0;
            for (i, entry) in basis.iter_mut().enumerate().take(level) {
                let [low, high] = [self.knots[DEGREE + 1 + i - level], self.knots[DEGREE + 1 + i]];
                let share = *entry * self.shares[at];
                at += 1;
                *entry = carried + share * (high - u);
                carried = share * (u - low);
            }
            basis[level] = carried;
        }
        basis
    }

    /// Returns the Bernstein form of the span, from the six control points that it depends on.
    pub(super) fn bezier(&self, points: &[PoseCoordinates]) -> QuinticBezier {
        let [a, b] = [self.knots[DEGREE], self.knots[DEGREE + 1]];
        let mut bezier = [PoseCoordinates::zeros(); DEGREE + 1];
        // Row `count` starts as the scheme with `b` applied `count` times; `a` does the rest.
        let mut row = [PoseCoordinates::zeros(); DEGREE + 1];
        row.copy_from_slice(points);
        for (count, point) in bezier.iter_mut().enumerate() {
            let mut rest = row;
            self.steps(&mut rest, a, count, DEGREE);
            *point = rest[DEGREE];
            if count < DEGREE {
                self.steps(&mut row, b, count, count + 1);
            }
        }
        bezier
    }

    /// Applies steps `done + 1 ..= to` of de Boor's scheme at `x`.
    fn steps(&self, row: &mut QuinticBezier, x: f64, done: usize, to: usize) {
        for step in done + 1..=to {
            for i in (step..=DEGREE).rev() {
                let [low, high] = [self.knots[i], self.knots[DEGREE + 1 + i - step]];
                // De Boor's recurrence, from the highest index down so that it can be done in
                // place.
                let share = (x - low) / (high - low);
                let before = row[i - 1];
                row[i] = before + (row[i] - before) * share;
            }
        }
    }
}

/// Number of control points that a position and three derivatives at an end determine.
pub(super) const JET: usize = 4;

/// Returns the first four control points, from value and three derivatives at the start.
pub(super) fn from_start(breaks: &[f64], jet: &[PoseCoordinates; 4]) -> [PoseCoordinates; JET] {
    let start = breaks[0];
    let [one, two, three] = [1, 2, 3].map(|span| breaks[span.min(breaks.len() - 1)] - start);
    ends([one, two, three], jet)
}

/// Returns the last four control points, the last one first, from value and derivatives at the end.
pub(super) fn from_end(breaks: &[f64], jet: &[PoseCoordinates; 4]) -> [PoseCoordinates; JET] {
    let last = breaks.len() - 1;
    // The spline run backwards: odd derivatives change sign.
    let widths = [1, 2, 3].map(|span| breaks[last] - breaks[last.saturating_sub(span)]);
    ends(widths, &[jet[0], -jet[1], jet[2], -jet[3]])
}

/// Returns the four control points at a clamped end, whose next three breaks lie `one`, `two` and
/// `three` away. Derivatives of a B-spline are B-splines over the same knots, with differences of
/// control points over knot distances.
fn ends([one, two, three]: [f64; 3], jet: &[PoseCoordinates; 4]) -> [PoseCoordinates; JET] {
    let [value, first, second, third] = jet;
    // Control points 1 of the first and second derivative (of degree 4 and 3), from those before
    // them.
    let first_1 = first + second * (one / 4.0);
    let second_1 = second + third * (one / 3.0);
    let first_2 = first_1 + second_1 * (two / 4.0);
    // P_{i+1} = P_i + D_i (t_{i+6} - t_{i+1}) / 5; at a clamped end the knot distances are
    // `widths`.
    let p1 = value + first * (one / 5.0);
    let p2 = p1 + first_1 * (two / 5.0);
    let p3 = p2 + first_2 * (three / 5.0);
    [*value, p1, p2, p3]
}

#[cfg(test)]
mod tests {
    use super::super::bezier::powers;
    use super::*;
    use crate::math::bspline::KnotVector;

    const BREAKS: [f64; 5] = [0.5, 1.0, 1.2, 2.0, 4.0];

    fn points(count: usize) -> Vec<PoseCoordinates> {
        (0..count)
            .map(|k| PoseCoordinates::from_fn(|i, _| ((2 * k + 3 * i) as f64).cos()))
            .collect()
    }

    #[test]
    fn basis_and_bernstein_form_agree_with_the_knot_vector_of_surfaces() {
        let points = points(9);
        let full = (0..15).map(|k| knot(&BREAKS, k)).collect();
        let vector = KnotVector::new(5, 9, full).unwrap();
        let expected = vector.bezier(&points);
        for span in 0..4 {
            let around = SpanKnots::new(&BREAKS, span);
            let u = BREAKS[span] + 0.3 * (BREAKS[span + 1] - BREAKS[span]);
            let (_, rows) = vector.basis(u, 0);
            for (got, want) in around.basis(u).iter().zip(rows[0]) {
                assert!((got - want).abs() < 1e-15);
            }
            let bezier = around.bezier(&points[span..span + 6]);
            for (k, point) in bezier.iter().enumerate() {
                assert!((point - expected[6 * span + k]).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn ends_give_back_their_control_points() {
        let points = points(9);
        let jet = |span: usize, at_end: bool| {
            let width = BREAKS[span + 1] - BREAKS[span];
            let bezier = SpanKnots::new(&BREAKS, span).bezier(&points[span..span + 6]);
            let span = crate::types::PoseSpan { coefficients: powers(&bezier, width) };
            span.derivatives(if at_end { width } else { 0.0 })
        };
        for (k, point) in from_start(&BREAKS, &jet(0, false)).iter().enumerate() {
            assert!((point - points[k]).norm() < 1e-12);
        }
        for (k, point) in from_end(&BREAKS, &jet(3, true)).iter().enumerate() {
            assert!((point - points[8 - k]).norm() < 1e-12);
        }
    }
}
