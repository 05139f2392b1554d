//! C2 cubic spline through points of any parameter spacing.

use nalgebra::SVector;

/// An end span longer than this many times its neighbour ends naturally (no curvature): the
/// not-a-knot condition would carry the neighbour's cubic over ground nobody sampled.
const LONGEST_END: f64 = 2.0;

/// Second derivative at the end of a spline as a combination of the next two: `M0 = a M1 + b M2`.
#[derive(Debug, Clone, Copy)]
struct End {
    next: f64,
    after: f64,
}

impl End {
    /// Returns the end condition: natural, or not-a-knot, where the third derivative does not jump at the first
    /// inner knot.
    fn of(end: f64, inner: f64) -> Self {
        if end > LONGEST_END * inner {
            return Self { next: 0.0, after: 0.0 };
        }
        // (M1 - M0) / h0 = (M2 - M1) / h1, solved for M0.
        Self { next: 1.0 + end / inner, after: -end / inner }
    }
}

/// Ascending coefficients of one cubic by the distance from the span's start.
pub type CubicSpan<const N: usize> = [SVector<f64, N>; 4];

/// Returns the cubic spline with values `points` at the increasing `knots`: one cubic a span.
///
/// Two points give a line, three a parabola, more a C2 cubic with not-a-knot ends (natural where the
/// end span is over twice as long as its neighbour). Takes as many spans as both inputs allow.
pub fn cubic_spline<const N: usize>(
    knots: &[f64],
    points: &[SVector<f64, N>],
) -> Vec<CubicSpan<N>> {
    let steps: Vec<f64> = knots.windows(2).map(|k| k[1] - k[0]).collect();
    let slopes: Vec<_> = points.windows(2).zip(&steps).map(|(p, h)| (p[1] - p[0]) / *h).collect();
    let steps = &steps[..slopes.len()];
    let bend = second_derivatives(steps, &slopes);
    (0..steps.len())
        .map(|i| {
            // f'(0) = d - h (2 M0 + M1) / 6, f''/2 = M0 / 2, f'''/6 = (M1 - M0) / 6h.
            let [m0, m1] = [bend[i], bend[i + 1]];
            let slope = slopes[i] - (m0 * 2.0 + m1) * (steps[i] / 6.0);
            [points[i], slope, m0 / 2.0, (m1 - m0) / (6.0 * steps[i])]
        })
        .collect()
}

/// Returns the second derivatives at all knots, from continuity of the first derivative at each inner knot,
/// `h0 M0 + 2 (h0 + h1) M1 + h1 M2 = 6 (d1 - d0)`, and an [`End`] on either side.
fn second_derivatives<const N: usize>(h: &[f64], d: &[SVector<f64, N>]) -> Vec<SVector<f64, N>> {
    let spans = h.len();
    if spans < 2 {
        return vec![SVector::zeros(); spans + 1];
    }
    // Three points determine a parabola, whose second derivative is constant.
    if spans == 2 {
        return vec![(d[1] - d[0]) * (2.0 / (h[0] + h[1])); 3];
    }
    let ends = [End::of(h[0], h[1]), End::of(h[spans - 1], h[spans - 2])];
    // Rows of the inner knots 1..spans; Thomas' elimination (diagonally dominant: no pivoting).
    let (mut upper, mut inner) = (Vec::new(), Vec::<SVector<f64, N>>::new());
    for i in 1..spans {
        let mut row = [h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]];
        // The unknown at an end is replaced by its combination of the next two.
        if i == 1 {
            row = [0.0, row[1] + h[0] * ends[0].next, row[2] + h[0] * ends[0].after];
        }
        if i == spans - 1 {
            let last = h[spans - 1];
            row = [row[0] + last * ends[1].after, row[1] + last * ends[1].next, 0.0];
        }
        let right = (d[i] - d[i - 1]) * 6.0;
        let (above, value) = match (upper.last(), inner.last()) {
            (Some(&above), Some(&value)) => (above, value),
            _ => (0.0, SVector::zeros()),
        };
        let pivot = row[1] - row[0] * above;
        upper.push(row[2] / pivot);
        inner.push((right - value * row[0]) / pivot);
    }
    // Back substitution.
    for i in (1..inner.len()).rev() {
        let below = inner[i];
        inner[i - 1] -= below * upper[i - 1];
    }
    let end = |end: End, next: &SVector<f64, N>, after: &SVector<f64, N>| {
        next * end.next + after * end.after
    };
    let last = inner.len() - 1;
    let mut all = vec![end(ends[0], &inner[0], &inner[1])];
    all.extend(&inner);
    all.push(end(ends[1], &inner[last], &inner[last - 1]));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    /// Value and first two derivatives of a span at distance `x` from its start.
    fn at(c: &CubicSpan<1>, x: f64) -> [f64; 3] {
        let [a, b, c, d] = c.map(|c| c.x);
        [a + x * (b + x * (c + x * d)), b + x * (2.0 * c + 3.0 * x * d), 2.0 * c + 6.0 * x * d]
    }

    fn spline(knots: &[f64], values: &[f64]) -> Vec<CubicSpan<1>> {
        cubic_spline(knots, &values.iter().map(|&x| Vector1::new(x)).collect::<Vec<_>>())
    }

    #[test]
    fn a_cubic_is_reproduced_from_uneven_samples() {
        let cubic = |u: f64| 1.0 - 2.0 * u + 0.5 * u * u - 0.25 * u * u * u;
        let knots = [0.0, 1.0, 1.8, 3.0, 3.9];
        let spans = spline(&knots, &knots.map(cubic));
        for (span, ends) in spans.iter().zip(knots.windows(2)) {
            let middle = 0.5 * (ends[1] - ends[0]);
            assert!((at(span, middle)[0] - cubic(ends[0] + middle)).abs() < 1e-13);
        }
    }

    #[test]
    fn value_slope_and_curvature_are_continuous() {
        let knots = [0.0, 0.7, 1.0, 2.5, 3.0, 9.0];
        let spans = spline(&knots, &[0.0, 1.0, -1.0, 0.4, 0.4, 2.0]);
        for (i, pair) in spans.windows(2).enumerate() {
            let (left, right) = (at(&pair[0], knots[i + 1] - knots[i]), at(&pair[1], 0.0));
            for order in 0..3 {
                assert!((left[order] - right[order]).abs() < 1e-12, "order {order} after {i}");
            }
        }
        // The last span is 12 times its neighbour: it ends without curvature.
        assert!(at(&spans[4], 6.0)[2].abs() < 1e-12);
    }

    #[test]
    fn few_points_give_a_line_and_a_parabola() {
        let line = spline(&[0.0, 2.0], &[1.0, 5.0]);
        assert!((at(&line[0], 0.5)[0] - 2.0).abs() < 1e-15 && at(&line[0], 0.5)[2].abs() < 1e-15);
        let parabola = spline(&[0.0, 1.0, 3.0], &[0.0, 1.0, 9.0]);
        assert!((at(&parabola[1], 1.0)[0] - 4.0).abs() < 1e-14);
        assert!(spline(&[0.0], &[1.0]).is_empty());
    }
}
