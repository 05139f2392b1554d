//! Least squares with B-splines: normal equations of half band width 5.

use super::bezier::DEGREE;
use crate::types::PoseCoordinates;

/// Symmetric positive definite band matrix with right-hand sides.
pub(super) struct NormalEquations {
    /// Diagonal, then the entries right of it.
    rows: Vec<[f64; DEGREE + 1]>,
    sums: Vec<PoseCoordinates>,
}

impl NormalEquations {
    pub(super) fn new(unknowns: usize) -> Self {
        let rows = vec![[0.0; DEGREE + 1]; unknowns];
        Self { rows, sums: vec![PoseCoordinates::zeros(); unknowns] }
    }

    /// Adds one observation, with weights on the unknowns from `first` on.
    pub(super) fn add(&mut self, first: usize, weights: &[f64], value: &PoseCoordinates) {
        for (i, &weight) in weights.iter().enumerate() {
            // Only the upper triangle: A += w w', within the band.
            for (entry, other) in self.rows[first + i].iter_mut().zip(&weights[i..]) {
                *entry += weight * other;
            }
            self.sums[first + i] += value * weight;
        }
    }

    /// Solves the equations; `None` where the observations do not determine the solution.
    pub(super) fn solve(mut self) -> Option<Vec<PoseCoordinates>> {
        let count = self.rows.len();
        for i in 0..count {
            // Gaussian elimination of a symmetric matrix: the rows below see only what is right of
            // the diagonal.
            let pivot = self.rows[i];
            // A pivot that lost all its digits: every span holds observations, so its own weight on
            // the diagonal is of the order of 1e-3 or more.
            if pivot[0].is_nan() || pivot[0] <= 1e-13 {
                return None;
            }
            let sum = self.sums[i];
            for k in 1..=DEGREE.min(count - 1 - i) {
                let factor = pivot[k] / pivot[0];
                for (entry, above) in self.rows[i + k].iter_mut().zip(&pivot[k..]) {
                    *entry -= factor * above;
                }
                self.sums[i + k] -= sum * factor;
            }
        }
        // Back substitution over the band.
        for i in (0..count).rev() {
            let mut sum = self.sums[i];
            for k in 1..=DEGREE.min(count - 1 - i) {
                sum -= self.sums[i + k] * self.rows[i][k];
            }
            self.sums[i] = sum / self.rows[i][0];
        }
        Some(self.sums)
    }
}
