//! Errors of smoothing.

use crate::types::Cancelled;

/// Reasons why no smooth path was laid.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SmoothError {
    /// An option is out of range.
    #[error("{name} is {value}; it must be {must} (mm, rad)")]
    BadOption {
        /// Name of the field of [`super::SmoothOptions`].
        name: &'static str,
        /// Value given.
        value: f64,
        /// Range it must be in.
        must: &'static str,
    },
    /// Nothing moves by more than a small part of the tolerance.
    #[error("{0} station(s), none of them apart: a path needs at least two different ones")]
    Stations(usize),
    /// A coordinate is NaN or infinite.
    #[error("station {0}: a coordinate is not a finite number")]
    NotFinite(usize),
    /// Two neighbouring stations of a pass are the same.
    #[error("stations {0} and the one after are the same; drop one of them")]
    Repeated(usize),
    /// Neighbouring axes are too far apart for the turn between them to be defined.
    #[error(
        "the tool axis turns {angle:.4} rad from station {station} to the next; above {limit:.4} rad \
         the turn is not defined: insert stations between them"
    )]
    AxisReversal {
        /// Index of the first of the two stations.
        station: usize,
        /// Angle between the axes \[rad\].
        angle: f64,
        /// Largest angle for which the path is laid \[rad\].
        limit: f64,
    },
    /// Stopped through [`Progress`](crate::types::Progress).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl SmoothError {
    /// Returns the same error at another station.
    pub(super) fn at(mut self, index: usize) -> Self {
        match &mut self {
            Self::NotFinite(station)
            | Self::Repeated(station)
            | Self::AxisReversal { station, .. } => *station = index,
            Self::BadOption { .. } | Self::Stations(_) | Self::Cancelled(_) => {}
        }
        self
    }
}
