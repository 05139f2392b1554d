//! Defects of knot vectors.

use super::sizes::MAX_DEGREE;
use std::error::Error;
use std::fmt;
use std::ops::Deref;

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
pub struct KnotErrors(pub(super) Vec<KnotError>);

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
