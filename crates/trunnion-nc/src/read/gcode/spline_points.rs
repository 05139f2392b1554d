//! Control points that splines collect from line to line.

/// A point of the plane with its weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WeightedPoint {
    /// \[mm\]
    pub(super) point: [f64; 2],
    pub(super) weight: f64,
}

/// Control points that `G5.2` collects until `G5.3`.
#[derive(Debug, Default)]
pub(super) struct SplineState {
    pub(super) points: Vec<WeightedPoint>,
    pub(super) order: usize,
    /// `G5`: from the last control point to the end, which the next spline continues.
    pub(super) continues: Option<[f64; 2]>,
}

impl SplineState {
    /// Returns true while control points wait for `G5.3`.
    pub(super) fn is_open(&self) -> bool {
        !self.points.is_empty()
    }
}
