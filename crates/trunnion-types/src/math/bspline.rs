//! Knot vectors, B-spline and Bernstein basis functions, and the Bezier form of a B-spline.
//!
//! Everything that runs per evaluation works on the stack, in arrays of two sizes: [`SMALL`] for the degrees
//! that nearly all models have, [`LARGE`] for the rest. The degree is bounded by [`MAX_DEGREE`].

use std::error::Error;
use std::fmt;
use std::ops::Add;
use std::ops::Deref;
use std::ops::Mul;

/// Highest degree supported: the highest that the CAD kernel Open CASCADE writes.
pub const MAX_DEGREE: usize = 25;

/// Number of control points of one piece that an array of the small size holds: degrees up to 9.
pub const SMALL: usize = 10;

/// Number of control points of one piece of the highest degree: size of the large arrays.
pub const LARGE: usize = MAX_DEGREE + 1;

/// Highest derivative computed.
pub const MAX_ORDER: usize = 3;

/// `basis[k][i]`: `k`-th derivative of the `i`-th function that is not zero on a span.
pub type BasisTable<const N: usize = LARGE> = [[f64; N]; MAX_ORDER + 1];

/// Defect of a knot vector.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KnotError {
    /// The degree is 0 or above [`MAX_DEGREE`].
    #[error("degree {degree} is not supported (1 to {MAX_DEGREE}); reduce it when exporting")]
    Degree {
        /// Degree given.
        degree: usize,
    },
    /// The number of knots does not fit the number of control points.
    #[error(
        "{knots} knots for {points} control points of degree {degree}; {expected} are needed (points + degree + 1, end knots repeated)"
    )]
    Count {
        /// Degree.
        degree: usize,
        /// Control points.
        points: usize,
        /// Knots given.
        knots: usize,
        /// Knots needed.
        expected: usize,
    },
    /// Fewer control points than degree + 1.
    #[error("{points} control points are too few for degree {degree}; at least {} are needed", degree + 1)]
    TooFewPoints {
        /// Degree.
        degree: usize,
        /// Control points.
        points: usize,
    },
    /// A knot is NaN or infinite.
    #[error("knot {index} is {value}, not a finite number")]
    NotFinite {
        /// Index of the knot.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// Knots must not decrease.
    #[error("knot {index} = {value} is less than the knot before it, {before}")]
    Decreasing {
        /// Index of the knot.
        index: usize,
        /// Its value.
        value: f64,
        /// The knot before.
        before: f64,
    },
    /// A knot inside the range repeated more often than the degree tears the spline apart.
    #[error(
        "knot {value} is repeated {multiplicity} times; inside the range at most {degree} (the degree) keep the spline in one piece"
    )]
    Torn {
        /// Value of the knot.
        value: f64,
        /// Number of times that it occurs.
        multiplicity: usize,
        /// Degree.
        degree: usize,
    },
    /// The parameter range is a single point.
    #[error("the knots span no range: first and last are both {value}")]
    Empty {
        /// Value of all knots.
        value: f64,
    },
}

/// All errors of a knot vector, as one error that displays one a line.
///
/// The list dereferences to a slice.
#[derive(Debug, Clone, PartialEq)]
pub struct KnotErrors(Vec<KnotError>);

impl Deref for KnotErrors {
    type Target = [KnotError];

    fn deref(&self) -> &[KnotError] {
        &self.0
    }
}

impl IntoIterator for KnotErrors {
    type Item = KnotError;
    type IntoIter = std::vec::IntoIter<KnotError>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl fmt::Display for KnotErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<String> = self.iter().map(ToString::to_string).collect();
        f.write_str(&lines.join("\n"))
    }
}

impl Error for KnotErrors {}

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
    pub fn range(&self) -> [f64; 2] {
        [self.breaks[0], self.breaks[self.breaks.len() - 1]]
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

/// Computes the Bernstein polynomials of `degree` (below `N`) at `t`, and their derivatives up to
/// `order` by a parameter that runs `1 / rate` from `t = 0` to `t = 1`.
///
/// `N` is [`SMALL`] or [`LARGE`]: both give the same bits for a degree that fits.
#[inline]
pub fn bernstein<const N: usize>(degree: usize, t: f64, rate: f64, order: usize) -> BasisTable<N> {
    match degree {
        1 => bernstein_of::<1, N>(t, rate, order),
        2 => bernstein_of::<2, N>(t, rate, order),
        3 => bernstein_of::<3, N>(t, rate, order),
        4 => bernstein_of::<4, N>(t, rate, order),
        5 => bernstein_of::<5, N>(t, rate, order),
        6 => bernstein_of::<6, N>(t, rate, order),
        7 => bernstein_of::<7, N>(t, rate, order),
        8 => bernstein_of::<8, N>(t, rate, order),
        _ => bernstein_rows(degree, t, rate, order),
    }
}

/// Computes the Bernstein polynomials of degree `N - 1`, at least 2, with first and second derivatives, bit
/// for bit as [`bernstein`] does, but in loops that unroll.
#[inline]
pub fn bernstein2<const N: usize>(t: f64, rate: f64) -> [[f64; N]; 3] {
    // De Casteljau's triangle upwards: rows of degree N - 3, N - 2 and N - 1 are kept on the way.
    let s = 1.0 - t;
    let mut basis = [[0.0; N]; 3];
    let mut row = [0.0; N];
    row[0] = 1.0;
    for m in 0..N {
        let missing = N - 1 - m;
        if missing <= 2 {
            basis[missing] = row;
        }
        if m + 1 < N {
            for i in (0..=m).rev() {
                row[i + 1] += t * row[i];
                row[i] *= s;
            }
        }
    }
    for (missing, row) in basis.iter_mut().enumerate() {
        for m in N - missing..N {
            // B'_(i,m) = m (B_(i-1,m-1) - B_(i,m-1)), times the rate of t.
            let scale = m as f64 * rate;
            for i in (1..=m).rev() {
                row[i] = (row[i - 1] - row[i]) * scale;
            }
            row[0] *= -scale;
        }
    }
    basis
}

/// Computes [`bernstein`] for one degree, so that the loops unroll.
#[inline]
fn bernstein_of<const P: usize, const N: usize>(t: f64, rate: f64, order: usize) -> BasisTable<N> {
    bernstein_rows(P, t, rate, order)
}

/// Builds de Casteljau's triangle upwards; rows of degree `degree - k` become `k`-th derivatives on the way.
#[inline]
fn bernstein_rows<const N: usize>(degree: usize, t: f64, rate: f64, order: usize) -> BasisTable<N> {
    let s = 1.0 - t;
    let mut basis = [[0.0; N]; MAX_ORDER + 1];
    let mut row = [0.0; N];
    row[0] = 1.0;
    for m in 0..=degree {
        let missing = degree - m;
        if missing <= order && missing <= MAX_ORDER {
            basis[missing] = derivative_weights(row, degree, missing, rate);
        }
        if m < degree {
            for i in (0..=m).rev() {
                row[i + 1] += t * row[i];
                row[i] *= s;
            }
        }
    }
    basis
}

/// Returns the weights of the `k`-th derivative from the Bernstein polynomials of degree `degree - k`.
#[inline]
fn derivative_weights<const N: usize>(
    mut row: [f64; N],
    degree: usize,
    k: usize,
    rate: f64,
) -> [f64; N] {
    for m in degree - k + 1..=degree {
        let scale = m as f64 * rate;
        for i in (1..=m).rev() {
            row[i] = (row[i - 1] - row[i]) * scale;
        }
        row[0] *= -scale;
    }
    row
}

/// Highest degree whose binomial coefficients [`binomial`] has: that of a product of two polynomials of the
/// highest degree.
pub const MAX_BINOMIAL: usize = 2 * MAX_DEGREE;

/// Pascal's triangle; every entry, at most `C(50, 25) = 1.3e14 < 2^53`, is exact.
static PASCAL: [[f64; MAX_BINOMIAL + 1]; MAX_BINOMIAL + 1] = {
    let mut rows = [[0.0; MAX_BINOMIAL + 1]; MAX_BINOMIAL + 1];
    let mut n = 0;
    while n <= MAX_BINOMIAL {
        rows[n][0] = 1.0;
        let mut k = 1;
        while k <= n {
            rows[n][k] = rows[n - 1][k - 1] + rows[n - 1][k];
            k += 1;
        }
        n += 1;
    }
    rows
};

/// Returns `n` over `k`, exact; `n` is at most [`MAX_BINOMIAL`], and 0 stands for what is not in the triangle.
#[inline]
pub fn binomial(n: usize, k: usize) -> f64 {
    PASCAL.get(n).and_then(|row| row.get(k)).copied().unwrap_or(0.0)
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
    fn bernstein_derivatives_sum_to_nothing() {
        for degree in 1..=MAX_DEGREE {
            let basis = bernstein::<LARGE>(degree, 0.3, 2.0, 3);
            assert!((basis[0].iter().sum::<f64>() - 1.0).abs() < 1e-14);
            for row in &basis[1..] {
                assert!(row.iter().sum::<f64>().abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_unrolled_form_is_the_same() {
        let [wide, narrow] =
            [bernstein::<SMALL>(3, 0.3, 1.7, 2), bernstein::<SMALL>(2, 0.9, 0.2, 2)];
        for k in 0..3 {
            let bits = |row: &[f64]| row.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&bernstein2::<4>(0.3, 1.7)[k]), bits(&wide[k][..4]));
            assert_eq!(bits(&bernstein2::<3>(0.9, 0.2)[k]), bits(&narrow[k][..3]));
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
    fn both_sizes_give_the_same_bits() {
        for degree in 1..SMALL {
            let (small, large) = (
                bernstein::<SMALL>(degree, 0.37, 1.9, 3),
                bernstein::<LARGE>(degree, 0.37, 1.9, 3),
            );
            for k in 0..=MAX_ORDER {
                for i in 0..=degree {
                    assert_eq!(small[k][i].to_bits(), large[k][i].to_bits(), "{degree} {k} {i}");
                }
            }
        }
    }

    /// `C(n, i) a^i b^(n - i)` with `t = a / (a + b)`: integers, exact in 128 bits; the oracle shares no step
    /// with the triangle of de Casteljau.
    #[test]
    fn values_of_every_degree_are_those_of_exact_integers() {
        let power = |base: u128, exponent: usize| (0..exponent).fold(1_u128, |x, _| x * base);
        let choose =
            |n: usize, k: usize| (0..k).fold(1_u128, |x, i| x * (n - i) as u128 / (i + 1) as u128);
        for degree in 1..=MAX_DEGREE {
            for (a, b) in [(3, 5), (1, 7), (7, 9), (1, 1)] {
                let [row, ..] = bernstein::<LARGE>(degree, a as f64 / (a + b) as f64, 1.0, 0);
                for (i, value) in row.iter().enumerate().take(degree + 1) {
                    let exact = choose(degree, i) * power(a, i) * power(b, degree - i);
                    let exact = exact as f64 / power(a + b, degree) as f64;
                    let error = (value - exact).abs() / exact;
                    assert!(error < 4.0 * degree as f64 * f64::EPSILON, "{degree} {i}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn pascals_triangle_is_the_product_formula() {
        for n in 0..=MAX_BINOMIAL {
            for k in 0..=n {
                let exact = (0..k as u128).fold(1, |x, i| x * (n as u128 - i) / (i + 1));
                assert_eq!(binomial(n, k).to_bits(), (exact as f64).to_bits(), "{n} over {k}");
            }
            assert!(binomial(n, n + 1) == 0.0);
        }
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
