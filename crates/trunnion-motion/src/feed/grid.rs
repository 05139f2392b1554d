//! The rows of a piece.

use super::cell::FeedCell;

/// Rows of a piece and the cells between them.
#[derive(Debug, Clone)]
pub(super) struct FeedGrid<const N: usize> {
    /// Path parameter of each row.
    pub(super) s: Vec<f64>,
    /// Cells between the rows: one less than rows.
    pub(super) cells: Vec<FeedCell<N>>,
}

/// Returns `true` if differences of three neighbouring `s` keep half of their digits.
pub(super) fn resolvable(before: f64, middle: f64, after: f64) -> bool {
    let size = before.abs().max(after.abs()) * f64::EPSILON.sqrt();
    middle - before > size && after - middle > size
}
