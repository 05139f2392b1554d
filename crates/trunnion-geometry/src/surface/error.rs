//! Errors of surfaces, trims and closest-point queries.

use crate::math::bspline::KnotError;
use crate::types::{ErrorList, Interval, Uv};

/// Reason for which a surface, curve, trim loop or face is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A knot vector is wrong.
    #[error("{direction} knots: {error}")]
    Knots {
        /// `u`, `v`, or `curve`.
        direction: &'static str,
        /// Error of the knots.
        error: KnotError,
    },
    /// The rows of a net have different lengths, or weights and points differ in number.
    #[error("{what}: row {row} has {found} entries, {expected} are needed")]
    RowLength {
        /// `points` or `weights`.
        what: &'static str,
        /// Index of the row (along u).
        row: usize,
        /// Entries found.
        found: usize,
        /// Entries needed.
        expected: usize,
    },
    /// A number is NaN or infinite.
    #[error("{what} is {value}, not a finite number")]
    NotFinite {
        /// Name of the number, with indices.
        what: String,
        /// Its value.
        value: f64,
    },
    /// A weight is zero or negative: the surface would leave the hull of its control points.
    #[error("weight {value} at {place} is not positive")]
    Weight {
        /// Indices of the control point.
        place: String,
        /// The weight.
        value: f64,
    },
    /// A radius is out of its range.
    #[error("{what} is {value} mm; it must be {need}")]
    Size {
        /// Name of the size.
        what: &'static str,
        /// Its value \[mm\].
        value: f64,
        /// Allowed range in words.
        need: &'static str,
    },
    /// The half angle of a cone is out of its range.
    #[error("half angle of the cone is {} deg; it must be between 0 and 90 deg", angle.to_degrees())]
    ConeAngle {
        /// Its value \[rad\].
        angle: f64,
    },
    /// A patch has no area: its points lie on a line or in a point.
    #[error(
        "the patch u [{}, {}], v [{}, {}] is degenerate: its points lie on a line or in one point; remove repeated control points or the patch",
        .u.low, .u.high, .v.low, .v.high
    )]
    DegeneratePatch {
        /// Range of u.
        u: Interval,
        /// Range of v.
        v: Interval,
    },
    /// Neighbouring trim curves do not meet.
    #[error(
        "trim curves {curve} and {next} of the loop do not meet: they end {gap:.3e} apart in u,v near ({:.6}, {:.6}), more than the allowed {tolerance:.3e}",
        .at.u, .at.v
    )]
    OpenLoop {
        /// Index of the curve.
        curve: usize,
        /// Index of the curve after it.
        next: usize,
        /// Distance in u,v.
        gap: f64,
        /// End of the first.
        at: Uv,
        /// Allowed distance in u,v.
        tolerance: f64,
    },
    /// A trim loop encloses no area.
    #[error("the trim loop is degenerate: {reason}; remove it from the face")]
    DegenerateLoop {
        /// Reason.
        reason: &'static str,
    },
    /// A trim loop crosses itself: its inside is ambiguous.
    #[error(
        "the trim loop crosses itself near u,v = ({:.6}, {:.6}); put its curves in order, or make a loop of each part",
        .at.u, .at.v
    )]
    CrossedLoop {
        /// Point in u, v.
        at: Uv,
    },
    /// The surface has no end in some direction and no trims bound it.
    #[error("face {face} has no bounds in {direction}: an endless surface needs trim loops")]
    Unbounded {
        /// Number of the face.
        face: usize,
        /// `u` or `v`.
        direction: &'static str,
    },
}

/// Reason for which there is no closest point.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClosestError {
    /// The query point is NaN or infinite.
    #[error("the query point is not finite")]
    NotFinite,
    /// The surface has no normal at its closest point.
    #[error(
        "the surface has no normal at its closest point, u,v = ({:.6}, {:.6}), {distance:.6} mm away",
        .uv.u, .uv.v
    )]
    NoNormal {
        /// Parameters.
        uv: Uv,
        /// Distance \[mm\].
        distance: f64,
    },
    /// Too many places are equally close (a point near a centre of curvature).
    #[error(
        "no unique closest point: the best found is {distance:.9} mm away at u,v = ({:.6}, {:.6}), but {bound:.9} mm cannot be excluded elsewhere",
        .uv.u, .uv.v
    )]
    Undecided {
        /// Parameters of the best point found.
        uv: Uv,
        /// Its distance \[mm\].
        distance: f64,
        /// Lower bound on the distance \[mm\].
        bound: f64,
    },
}

/// Several faults of one surface or curve, reported together.
pub type SurfaceErrors = ErrorList<SurfaceError>;
