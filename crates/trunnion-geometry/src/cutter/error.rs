//! Errors of a cutter description.

use super::spec::CutterKind;
use crate::types::ErrorList;

/// All errors of a cutter description.
pub type CutterErrors = ErrorList<CutterError>;

/// An error of a [`CutterSpec`](super::CutterSpec).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CutterError {
    /// A length is NaN, infinite, or negative where it must not be.
    #[error("{name} of the cutter is {value} mm: must be finite and {must}")]
    BadLength {
        /// Name of the length.
        name: &'static str,
        /// The value given \[mm\].
        value: f64,
        /// Condition it has to meet.
        must: &'static str,
    },
    /// The radii do not make the kind named.
    #[error(
        "a {kind:?} cutter has {must}, but R = {major} mm and r = {minor} mm were given; \
         correct the radius or the kind"
    )]
    WrongKind {
        /// The kind named.
        kind: CutterKind,
        /// `R` \[mm\].
        major: f64,
        /// `r` \[mm\].
        minor: f64,
        /// Radii that the kind has.
        must: &'static str,
    },
    /// No side of the kind named joins the tip arc to the diameter.
    #[error(
        "a {} cutter with a tip radius of {tip_radius} mm has no such side: {must}, but {given} was given",
        kind.name()
    )]
    WrongSide {
        /// The kind named.
        kind: CutterKind,
        /// Radius of the tip arc \[mm\].
        tip_radius: f64,
        /// Condition that the side has to meet.
        must: &'static str,
        /// The side given, in words with mm and degrees.
        given: String,
    },
    /// The rounding is higher than the tool is long.
    #[error("the cutter is {length} mm long, shorter than its corner radius of {minor} mm")]
    TooShort {
        /// Tip to gauge point \[mm\].
        length: f64,
        /// `r` \[mm\].
        minor: f64,
    },
    /// The side ends above the gauge point.
    #[error(
        "the cutter is {length} mm long, but its side reaches the diameter {height:.3} mm above the tip; \
         make the tool longer or the diameter smaller"
    )]
    SideTooLong {
        /// Tip to gauge point \[mm\].
        length: f64,
        /// Height at which the side ends \[mm\].
        height: f64,
    },
    /// Nothing is left to cut with.
    #[error(
        "inner cutting radius {inner} mm must be at least 0 and below the cutter radius {radius} mm"
    )]
    InnerRadius {
        /// The value given \[mm\].
        inner: f64,
        /// `R + r` \[mm\].
        radius: f64,
    },
    /// An entry of the shank profile is out of order or out of range.
    #[error(
        "shank entry {index} is [height {height}, radius {radius}] mm: the radius must be above 0, \
         heights must not fall and lie between the corner radius and the length of the tool"
    )]
    Shank {
        /// Index of the entry, from 0.
        index: usize,
        /// Its height above the tip \[mm\].
        height: f64,
        /// Its radius \[mm\].
        radius: f64,
    },
}
