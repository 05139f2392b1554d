//! Knots, the basis functions on them, and the Bezier form of their curves.

use super::knot_error::{KnotError, KnotErrors};
use super::sizes::{BasisTable, LARGE, MAX_DEGREE, MAX_ORDER};
use crate::math::Interval;
use std::ops::{Add, Mul};

/// Degree and checked knots of a B-spline; clamped or not.
#[derive(Debug, Clone, PartialEq)]
pub struct KnotVector {
    degree: usize,
    knots: Vec<f64>,
    /// Distinct knots in the range.
    breaks: Vec<f64>,
    /// For each piece between breaks: index of the knot it starts at (last of its repetitions).
    starts: Vec<usize>,
}

impl KnotVector {
    /// Checks `knots` for `points` control points.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_types::math::bspline::{KnotError, KnotVector};
    ///
    /// // A quadratic B-spline of four control points: two pieces, clamped at both ends.
    /// let knots = KnotVector::new(2, 4, vec![0.0, 0.0, 0.0, 1.0, 3.0, 3.0, 3.0])?;
    /// assert_eq!(knots.breaks(), [0.0, 1.0, 3.0]);
    ///
    /// let errors = KnotVector::new(1, 2, vec![0.0, 0.0, 1.0]).unwrap_err();
    /// assert!(matches!(errors[0], KnotError::Count { knots: 3, expected: 4, .. }));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// All errors found, each a [`KnotError`].
    pub fn new(degree: usize, points: usize, knots: Vec<f64>) -> Result<Self, KnotErrors> {
        let mut faults = shape_faults(degree, points, &knots);
        faults.extend(value_faults(&knots));
        if !faults.is_empty() {
            return Err(KnotErrors(faults));
        }
        // The basis is complete from knot `degree` to knot `points`: that is the parameter range.
        let (low, high) = (knots[degree], knots[points]);
        let starts: Vec<usize> = (degree..points).filter(|&i| knots[i] < knots[i + 1]).collect();
        if starts.is_empty() {
            return Err(KnotErrors(vec![KnotError::Empty { value: low }]));
        }
        let breaks: Vec<f64> = starts.iter().map(|&i| knots[i]).chain([high]).collect();
        // A knot of multiplicity degree + 1 leaves the spline without continuity.
        let torn: Vec<KnotError> = breaks[1..breaks.len() - 1]
            .iter()
            .map(|&value| (value, multiplicity(&knots, value)))
            .filter(|&(_, multiplicity)| multiplicity > degree)
            .map(|(value, multiplicity)| KnotError::Torn { value, multiplicity, degree })
            .collect();
        if torn.is_empty() {
            Ok(Self { degree, knots, breaks, starts })
        } else {
            Err(KnotErrors(torn))
        }
    }

    /// Returns the degree.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Returns the knots as given.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Returns the number of control points.
    pub fn points(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Returns the distinct knots in the range, increasing; at least two.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Returns the parameter range.
    pub fn range(&self) -> Interval {
        Interval::new(self.breaks[0], self.breaks[self.breaks.len() - 1])
    }

    /// Returns the index of the polynomial piece (between two breaks) that holds `u`; ends are clamped.
    #[inline]
    pub fn piece(&self, u: f64) -> usize {
        piece_of(&self.breaks, u)
    }

    /// Returns the basis functions that are not zero at `u` and their derivatives up to `order` (at most
    /// [`MAX_ORDER`]); the first belongs to the control point with the returned index.
    ///
    /// Outside the range the end polynomials go on.
    pub fn basis(&self, u: f64, order: usize) -> (usize, BasisTable) {
        let start = self.starts[self.piece(u)];
        (start - self.degree, self.basis_from(start, u, order.min(MAX_ORDER)))
    }

    /// Computes the triangular table of basis functions, then derivatives by differences:
    /// `N'_{i,p} = p (N_{i,p-1} / (t_{i+p} - t_i) - N_{i+1,p-1} / (t_{i+p+1} - t_{i+1}))`.
    fn basis_from(&self, start: usize, u: f64, order: usize) -> BasisTable {
        // Cox-de Boor recursion on the functions that are not zero on the span.
        let p = self.degree;
        let mut levels = [[0.0; LARGE]; LARGE];
        levels[0][0] = 1.0;
        for m in 1..=p {
            for i in 0..m {
                // The i-th function of degree m - 1 starts at knot start - (m - 1) + i.
                let low = self.knots[start + 1 + i - m];
                let high = self.knots[start + 1 + i];
                let share = levels[m - 1][i] / (high - low);
                levels[m][i] += share * (high - u);
                levels[m][i + 1] += share * (u - low);
            }
        }
        // The k-th derivative from degree p - k: each step raises the degree by one differentiation.
        let mut basis = [[0.0; LARGE]; MAX_ORDER + 1];
        basis[0] = levels[p];
        for k in 1..=order.min(p) {
            let mut row = levels[p - k];
            for m in p - k + 1..=p {
                row = self.raise(start, m, &row);
            }
            basis[k] = row;
        }
        basis
    }

    /// Turns weights on the functions of degree `m - 1` into weights of the derivative on degree `m`.
    fn raise(&self, start: usize, m: usize, row: &[f64; LARGE]) -> [f64; LARGE] {
        let mut raised = [0.0; LARGE];
        for i in 0..m {
            let width = self.knots[start + 1 + i] - self.knots[start + 1 + i - m];
            // N' = p (N_i / width_i - N_(i+1) / width_(i+1)): each function feeds two.
            let slope = m as f64 * row[i] / width;
            raised[i] -= slope;
            raised[i + 1] += slope;
        }
        raised
    }

    /// Returns the Bezier control points of all polynomial pieces, `degree + 1` each, piece after piece.
    ///
    /// The `j`-th point of the piece `[a, b]` is the polar form (blossom) at `degree - j` times `a`
    /// and `j` times `b`: convex combinations only. `points` must have [`KnotVector::points`]
    /// entries; of others the result is empty.
    pub fn bezier<P>(&self, points: &[P]) -> Vec<P>
    where
        P: Copy + Add<Output = P> + Mul<f64, Output = P>,
    {
        if points.len() != self.points() {
            return Vec::new();
        }
        let mut pieces = Vec::with_capacity(self.starts.len() * (self.degree + 1));
        for (piece, &start) in self.starts.iter().enumerate() {
            let [a, b] = [self.breaks[piece], self.breaks[piece + 1]];
            for j in 0..=self.degree {
                pieces.push(self.blossom(points, start, [a, b], j));
            }
        }
        pieces
    }

    /// Evaluates the blossom by de Boor's scheme, with `a` for the first steps and `b` for the last `count`.
    fn blossom<P>(&self, points: &[P], start: usize, [a, b]: [f64; 2], count: usize) -> P
    where
        P: Copy + Add<Output = P> + Mul<f64, Output = P>,
    {
        // The blossom is symmetric: the order of its arguments does not matter.
        let p = self.degree;
        let mut d = [points[start - p]; LARGE];
        d[..=p].copy_from_slice(&points[start - p..=start]);
        for step in 1..=p {
            let x = if step <= p - count { a } else { b };
            for i in (step..=p).rev() {
                let low = self.knots[start - p + i];
                let high = self.knots[start + 1 + i - step];
                let t = (x - low) / (high - low);
                d[i] = d[i - 1] * (1.0 - t) + d[i] * t;
            }
        }
        d[p]
    }
}

/// Returns the index of the interval between two of `breaks` that holds `u`; ends are clamped.
#[inline]
pub fn piece_of(breaks: &[f64], u: f64) -> usize {
    let after = breaks.partition_point(|&knot| knot <= u);
    after.saturating_sub(1).min(breaks.len().saturating_sub(2))
}

/// Checks degree and counts.
fn shape_faults(degree: usize, points: usize, knots: &[f64]) -> Vec<KnotError> {
    if degree == 0 || degree > MAX_DEGREE {
        return vec![KnotError::Degree { degree }];
    }
    let mut faults = Vec::new();
    if points <= degree {
        faults.push(KnotError::TooFewPoints { degree, points });
    }
    let expected = points + degree + 1;
    if knots.len() != expected {
        faults.push(KnotError::Count { degree, points, knots: knots.len(), expected });
    }
    faults
}

/// Checks single knots.
fn value_faults(knots: &[f64]) -> Vec<KnotError> {
    let mut faults: Vec<KnotError> = knots
        .iter()
        .enumerate()
        .filter(|(_, value)| !value.is_finite())
        .map(|(index, &value)| KnotError::NotFinite { index, value })
        .collect();
    let decreasing = knots.windows(2).enumerate().filter(|(_, pair)| pair[1] < pair[0]);
    faults.extend(decreasing.map(|(index, pair)| KnotError::Decreasing {
        index: index + 1,
        value: pair[1],
        before: pair[0],
    }));
    faults
}

/// Counts the times that `value` occurs in increasing `knots`.
fn multiplicity(knots: &[f64], value: f64) -> usize {
    knots.partition_point(|&knot| knot <= value) - knots.partition_point(|&knot| knot < value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::bspline::bernstein::bernstein;
    use crate::math::bspline::sizes::SMALL;

    fn clamped() -> KnotVector {
        let knots = vec![0.0, 0.0, 0.0, 1.0, 3.0, 3.0, 3.0];
        KnotVector::new(2, 4, knots).unwrap()
    }

    #[test]
    fn quadratic_basis_by_pencil() {
        // On [0, 1] with knots 0 0 0 1 3: (1-u)^2, u(2 - 4u/3), u^2/3.
        let (first, basis) = clamped().basis(0.5, 2);
        assert_eq!(first, 0);
        for (value, expected) in basis[0].iter().zip([0.25, 0.5 * (2.0 - 2.0 / 3.0), 0.25 / 3.0]) {
            assert!((value - expected).abs() < 1e-15);
        }
        for (value, expected) in basis[1].iter().zip([-1.0, 2.0 - 4.0 / 3.0, 1.0 / 3.0]) {
            assert!((value - expected).abs() < 1e-15);
        }
        for (value, expected) in basis[2].iter().zip([2.0, -8.0 / 3.0, 2.0 / 3.0]) {
            assert!((value - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn the_bezier_form_is_the_same_curve() {
        let knots = clamped();
        let points = [1.0, -2.0, 4.0, 0.5];
        let bezier = knots.bezier(&points);
        assert_eq!(bezier.len(), 6);
        for u in [0.0, 0.3, 0.99, 1.0, 1.7, 3.0] {
            let (first, basis) = knots.basis(u, 2);
            let piece = knots.piece(u);
            let [a, b] = [knots.breaks()[piece], knots.breaks()[piece + 1]];
            let local = bernstein::<SMALL>(2, (u - a) / (b - a), 1.0 / (b - a), 2);
            for k in 0..3 {
                let spline: f64 = (0..3).map(|i| basis[k][i] * points[first + i]).sum();
                let piece: f64 = (0..3).map(|i| local[k][i] * bezier[3 * piece + i]).sum();
                assert!((spline - piece).abs() < 1e-13, "u {u}, order {k}: {spline} {piece}");
            }
        }
    }

    #[test]
    fn faults_are_named_together() {
        let faults = KnotVector::new(2, 4, vec![0.0, 0.0, f64::NAN, 1.0, 0.5]).unwrap_err();
        assert!(matches!(faults[0], KnotError::Count { knots: 5, expected: 7, .. }));
        assert!(matches!(faults[1], KnotError::NotFinite { index: 2, .. }));
        assert!(matches!(faults[2], KnotError::Decreasing { index: 4, .. }));
        let torn = KnotVector::new(1, 4, vec![0.0, 0.0, 0.5, 0.5, 1.0, 1.0]).unwrap_err();
        assert!(matches!(torn[0], KnotError::Torn { multiplicity: 2, degree: 1, .. }));
        let degree = KnotVector::new(26, 27, vec![]).unwrap_err();
        assert_eq!(*degree, [KnotError::Degree { degree: 26 }]);
    }

    #[test]
    fn a_spline_of_the_highest_degree_has_its_derivatives() {
        // Knots inside, so that pieces differ; derivatives against central differences.
        let degree = MAX_DEGREE;
        let knots: Vec<f64> = std::iter::repeat_n(0.0, degree + 1)
            .chain([0.3, 0.3, 0.7])
            .chain(std::iter::repeat_n(1.0, degree + 1))
            .collect();
        let count = degree + 4;
        let knots = KnotVector::new(degree, count, knots).unwrap();
        let points: Vec<f64> = (0..count).map(|i| (0.7 * i as f64).sin()).collect();
        let value = |u: f64, k: usize| -> f64 {
            let (first, basis) = knots.basis(u, 3);
            (0..=degree).map(|i| basis[k][i] * points[first + i]).sum()
        };
        let h = 1e-5;
        for u in [0.05, 0.29, 0.31, 0.5, 0.71, 0.95] {
            for k in 0..MAX_ORDER {
                let difference = (value(u + h, k) - value(u - h, k)) / (2.0 * h);
                let error = (difference - value(u, k + 1)).abs();
                assert!(error < 1e-4 * (1.0 + difference.abs()), "u {u}, order {k}: {error:e}");
            }
        }
    }
}
