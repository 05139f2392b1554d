//! Bernstein polynomials and their derivatives.

use super::sizes::{BasisTable, MAX_ORDER};

/// Computes the Bernstein polynomials of `degree` (below `N`) at `t`, and their derivatives up to
/// `order` by a parameter that runs `1 / rate` from `t = 0` to `t = 1`.
///
/// `N` is [`SMALL`](super::SMALL) or [`LARGE`](super::LARGE): both give the same bits for a degree that fits.
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

/// Computes the Bernstein polynomials of degree `N - 1` alone, bit for bit as [`bernstein`] does.
#[inline]
pub fn bernstein_values<const N: usize>(t: f64) -> [f64; N] {
    let s = 1.0 - t;
    let mut row = [0.0; N];
    row[0] = 1.0;
    for m in 1..N {
        for i in (0..m).rev() {
            row[i + 1] += t * row[i];
            row[i] *= s;
        }
    }
    row
}

/// Computes the Bernstein polynomials of degree `row.len() - 1` alone, bit for bit as [`bernstein`] does.
#[inline]
pub fn fill_bernstein_values(t: f64, row: &mut [f64]) {
    let s = 1.0 - t;
    row.fill(0.0);
    if let Some(first) = row.first_mut() {
        *first = 1.0;
    }
    for m in 1..row.len() {
        for i in (0..m).rev() {
            row[i + 1] += t * row[i];
            row[i] *= s;
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::bspline::sizes::LARGE;
    use crate::math::bspline::sizes::MAX_DEGREE;
    use crate::math::bspline::sizes::SMALL;

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
        let bits = |row: &[f64]| row.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        for k in 0..3 {
            assert_eq!(bits(&bernstein2::<4>(0.3, 1.7)[k]), bits(&wide[k][..4]));
            assert_eq!(bits(&bernstein2::<3>(0.9, 0.2)[k]), bits(&narrow[k][..3]));
        }
        assert_eq!(bits(&bernstein_values::<4>(0.3)), bits(&bernstein2::<4>(0.3, 1.7)[0]));
        for degree in 1..=MAX_DEGREE {
            let mut row = [9.0; LARGE];
            fill_bernstein_values(0.37, &mut row[..=degree]);
            let whole = bernstein::<LARGE>(degree, 0.37, 1.9, 0);
            assert_eq!(bits(&row[..=degree]), bits(&whole[0][..=degree]));
        }
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
}
