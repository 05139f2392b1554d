//! Symmetric positive definite systems whose unknowns couple with two neighbours on each side.

/// Rows of the lower triangle (diagonal, then the two entries left of it) and right-hand side.
#[derive(Debug, Clone, Default)]
pub(super) struct BandMatrix {
    pub(super) rows: Vec<[f64; 3]>,
    pub(super) right: Vec<f64>,
}

impl BandMatrix {
    /// Clears the system and sizes it for so many unknowns.
    pub(super) fn reset(&mut self, unknowns: usize) {
        self.rows.clear();
        self.rows.resize(unknowns, [0.0; 3]);
        self.right.clear();
        self.right.resize(unknowns, 0.0);
    }

    /// Solves in place by `L D L^T`; the solution is left in `right`. `false` if the matrix is not
    /// positive definite in rounding.
    pub(super) fn solve(&mut self) -> bool {
        // Of the two rows before: [diagonal of D, entry of L left of it, solved right-hand side].
        let [mut before, mut last] = [[1.0, 0.0, 0.0]; 2];
        for (row, right) in self.rows.iter_mut().zip(&mut self.right) {
            let second = row[2] / before[0];
            let coupling = row[1] - second * before[0] * last[1];
            let first = coupling / last[0];
            let diagonal = row[0] - first * coupling - second * row[2];
            if !(diagonal > 0.0 && diagonal.is_finite()) {
                return false;
            }
            *right -= first * last[2] + second * before[2];
            *row = [diagonal, first, second];
            (before, last) = (last, [diagonal, first, *right]);
        }
        // Entries of L below: [row + 1][1], [row + 2][2]; solutions of those rows.
        let [mut below, mut far] = [[0.0; 3]; 2];
        for (row, right) in self.rows.iter().zip(&mut self.right).rev() {
            *right = *right / row[0] - below[1] * below[0] - far[2] * far[0];
            (far, below) = ([below[0], 0.0, below[2]], [*right, row[1], row[2]]);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_reproduces_the_right_hand_side() {
        let rows = [[4.0, 0.0, 0.0], [5.0, 1.0, 0.0], [6.0, -2.0, 0.5], [7.0, 1.5, -1.0]];
        let right = vec![1.0, -2.0, 3.0, 0.5];
        let mut band = BandMatrix { rows: rows.to_vec(), right: right.clone() };
        assert!(band.solve());
        let x = &band.right;
        for (i, want) in right.iter().enumerate() {
            let mut sum = rows[i][0] * x[i];
            for k in 1..=2 {
                sum += if i >= k { rows[i][k] * x[i - k] } else { 0.0 };
                sum += if i + k < 4 { rows[i + k][k] * x[i + k] } else { 0.0 };
            }
            assert!((sum - want).abs() < 1e-14, "row {i}: {sum}");
        }
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let mut band =
            BandMatrix { rows: vec![[1.0, 0.0, 0.0], [1.0, 2.0, 0.0]], right: vec![1.0; 2] };
        assert!(!band.solve());
    }
}
