//! Quintic Hermite interpolation of vectors.

use nalgebra::SVector;

/// The quintic through value, first and second derivative at both ends of an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quintic<const N: usize> {
    /// Length of the interval.
    length: f64,
    /// Coefficients of the powers of `x / length`.
    powers: [SVector<f64, N>; 6],
}

impl<const N: usize> Quintic<N> {
    /// Creates the quintic through `[q, q', q'']` at 0 and at `length`, which must not be zero.
    pub fn new(length: f64, start: [SVector<f64, N>; 3], end: [SVector<f64, N>; 3]) -> Self {
        // In t = x / length the start gives the first three coefficients; d0, d1, d2 are what is missing at
        // t = 1 in value, slope and second derivative, and fix the last three.
        let [c0, c1, c2] = [start[0], start[1] * length, start[2] * (0.5 * length * length)];
        let d0 = (end[0] - c0) - c1 - c2;
        let d1 = end[1] * length - c1 - c2 * 2.0;
        let d2 = end[2] * (length * length) - c2 * 2.0;
        let c3 = d0 * 10.0 - d1 * 4.0 + d2 * 0.5;
        let c4 = d0 * -15.0 + d1 * 7.0 - d2;
        let c5 = d0 * 6.0 - d1 * 3.0 + d2 * 0.5;
        Self { length, powers: [c0, c1, c2, c3, c4, c5] }
    }

    /// Returns value and first three derivatives at `x` from the start (Horner's scheme).
    pub fn at(&self, x: f64) -> [SVector<f64, N>; 4] {
        let t = x / self.length;
        // Repeated Horner: d[k] becomes the k-th derivative by t over k!.
        let mut d = [SVector::zeros(); 4];
        for c in self.powers.iter().rev() {
            d[3] = d[3] * t + d[2];
            d[2] = d[2] * t + d[1];
            d[1] = d[1] * t + d[0];
            d[0] = d[0] * t + c;
        }
        let [one, two] = [1.0 / self.length, 1.0 / (self.length * self.length)];
        [d[0], d[1] * one, d[2] * (2.0 * two), d[3] * (6.0 * one * two)]
    }

    /// Returns the length of the interval.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Returns the coefficients of the powers of `x / length`, lowest first.
    pub fn powers(&self) -> &[SVector<f64, N>; 6] {
        &self.powers
    }

    /// Returns the third derivative at both ends.
    pub fn thirds(&self) -> [SVector<f64, N>; 2] {
        let [_, _, _, c3, c4, c5] = &self.powers;
        // At t = 0 and t = 1: 6 c3, and 6 c3 + 24 c4 + 60 c5, by the third power of the length.
        let scale = 6.0 / self.length.powi(3);
        [c3 * scale, (c3 + c4 * 4.0 + c5 * 10.0) * scale]
    }

    /// Returns the value at `x` from the start.
    pub fn value(&self, x: f64) -> SVector<f64, N> {
        let t = x / self.length;
        self.powers.iter().rev().fold(SVector::zeros(), |sum, c| sum * t + c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector1;

    /// `x^5 - x^2`: value, slope, second and third derivative.
    fn sample(x: f64) -> [Vector1<f64>; 4] {
        [x.powi(5) - x * x, 5.0 * x.powi(4) - 2.0 * x, 20.0 * x.powi(3) - 2.0, 60.0 * x * x]
            .map(Vector1::new)
    }

    #[test]
    fn a_quintic_is_reproduced() {
        let [a, b] = [sample(1.0), sample(3.0)];
        let quintic = Quintic::new(2.0, [a[0], a[1], a[2]], [b[0], b[1], b[2]]);
        for x in [1.0, 1.3, 2.0, 2.9, 3.0] {
            for (got, want) in quintic.at(x - 1.0).iter().zip(sample(x)) {
                assert!((got - want).norm() < 1e-11 * (1.0 + want.norm()), "at {x}");
            }
            let [start, end] = quintic.thirds();
            assert!((start - a[3]).norm() < 1e-9 && (end - b[3]).norm() < 1e-9);
            assert!((quintic.value(x - 1.0) - sample(x)[0]).norm() < 1e-11 * 250.0);
        }
    }
}
