//! Binomial coefficients.

use super::sizes::MAX_DEGREE;

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

#[cfg(test)]
mod tests {
    use super::*;

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
}
