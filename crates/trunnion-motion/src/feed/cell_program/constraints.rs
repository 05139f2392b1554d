//! The linear constraints of one cell.

use crate::feed::accelerations::CellAccelerations;
use nalgebra::SVector;

/// Constraints `-minus <= a x0 + b x1 <= 1` of one cell: one per axis and Bernstein coefficient (`K` = 5), or
/// per axis and row alone (`K` = 2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellConstraints<const N: usize, const K: usize = 5> {
    pub(crate) a: [SVector<f64, N>; K],
    pub(crate) b: [SVector<f64, N>; K],
    /// Limit towards minus, axis by axis.
    pub(crate) minus: [f64; N],
}

impl<const N: usize, const K: usize> CellConstraints<N, K> {
    /// Writes all constraints of a cell as `a x0 + b x1`.
    pub(crate) fn of(cell: &CellAccelerations<N>) -> Self {
        let mut strips =
            Self { a: [SVector::zeros(); K], b: [SVector::zeros(); K], minus: cell.minus };
        for place in 0..K {
            for axis in 0..N {
                let [a, b] = cell.constraint::<K>([place, axis]);
                (strips.a[place][axis], strips.b[place][axis]) = (a, b);
            }
        }
        strips
    }

    /// Returns the limit of a constraint of this axis, by the sign of the side.
    #[inline]
    pub(crate) fn limit(&self, axis: usize, sign: f64) -> f64 {
        if sign < 0.0 { self.minus[axis] } else { 1.0 }
    }
}

/// Returns the smallest `y >= 0` that satisfies all constraints for this `x`, if there is one.
pub(crate) fn least<const N: usize, const K: usize>(strips: &CellConstraints<N, K>, x: f64) -> f64 {
    let mut y = 0.0;
    for k in 0..K {
        for axis in 0..N {
            let [a, b] = [strips.a[k][axis], strips.b[k][axis]];
            // The side that a growing y leaves behind: it binds y from below.
            let limit = strips.limit(axis, -b);
            let lacking = if b > 0.0 { -limit - a * x } else { a * x - limit };
            if b != 0.0 && y * b.abs() < lacking {
                y = lacking / b.abs();
            }
        }
    }
    y
}
