//! Errors of tool paths.

use super::smooth::SmoothError;
use crate::types::Cancelled;

/// Reasons why no tool path could be laid through the stations.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ToolPathError {
    /// A leg without extent.
    #[error("leg {leg} has {stations} station(s); a motion needs at least 2")]
    Stations {
        /// Index of the leg.
        leg: usize,
        /// Number of its stations.
        stations: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("leg {leg}, station {station}: a coordinate is not a finite number")]
    NotFinite {
        /// Index of the leg.
        leg: usize,
        /// Index of the station.
        station: usize,
    },
    /// Two neighbouring stations are the same.
    #[error("leg {leg}: stations {station} and the one after are the same; drop one of them")]
    Repeated {
        /// Index of the leg.
        leg: usize,
        /// Index of the first of the two.
        station: usize,
    },
    /// A leg does not start where the one before ended.
    #[error(
        "leg {leg} starts {distance:.6} mm and {angle:.6} rad away from the end of the leg before"
    )]
    Gap {
        /// Index of the leg.
        leg: usize,
        /// Distance of the tips \[mm\].
        distance: f64,
        /// Angle between the axes \[rad\].
        angle: f64,
    },
    /// Neighbouring axes are too far apart for a curve between them to be defined.
    #[error(
        "leg {leg}: the tool axis turns {angle:.4} rad from station {station} to the next; \
         above {limit:.4} rad the turn is not defined: insert stations between them"
    )]
    AxisReversal {
        /// Index of the leg.
        leg: usize,
        /// Index of the first of the two stations.
        station: usize,
        /// Angle between the axes \[rad\].
        angle: f64,
        /// Largest angle for which the curve is laid \[rad\].
        limit: f64,
    },
    /// The tool turns during a lead.
    #[error(
        "leg {leg}: the tool axis turns {angle:.3e} rad during a lead; a lead has a fixed axis"
    )]
    LeadTurns {
        /// Index of the leg.
        leg: usize,
        /// Angle between the axes \[rad\].
        angle: f64,
    },
    /// The lever is not a positive number.
    #[error("lever {0} mm/rad must be positive and finite")]
    BadLever(f64),
    /// A leg that cannot be smoothed.
    #[error("leg {leg}: {error}")]
    Smooth {
        /// Index of the leg.
        leg: usize,
        /// The reason.
        error: SmoothError,
    },
    /// Stopped through [`Progress`](crate::types::Progress).
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl ToolPathError {
    /// Returns the same error for another leg.
    pub(super) fn in_leg(mut self, index: usize) -> Self {
        match &mut self {
            Self::Stations { leg, .. }
            | Self::NotFinite { leg, .. }
            | Self::Repeated { leg, .. }
            | Self::Gap { leg, .. }
            | Self::AxisReversal { leg, .. }
            | Self::LeadTurns { leg, .. }
            | Self::Smooth { leg, .. } => *leg = index,
            Self::BadLever(_) | Self::Cancelled(_) => {}
        }
        self
    }
}
