//! Refusals of the inverse as plain numbers, for callers that must not allocate.

use crate::machine::{RotaryPair, TravelExcess};
use nalgebra::UnitVector3;

/// Reason why a pose has no axis position: an [`InverseError`](super::InverseError) without the names of the axes.
///
/// It is a copy of numbers, so that a control can refuse a pose inside its servo cycle.
/// [`Inverse::named`](super::Inverse::named) adds the names for a message.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum PoseRefusal {
    /// The direction is outside the cone the two rotaries reach.
    Unreachable {
        /// Wanted direction, workpiece frame.
        direction: UnitVector3<f64>,
        /// Nearest direction within reach.
        nearest: UnitVector3<f64>,
        /// Angle between them \[rad\].
        miss: f64,
    },
    /// Every solution is outside the travel of some axis; the nearest one is reported.
    OutOfTravel(TravelExcess),
    /// The linear axes lie in one plane with the rotaries where they are.
    FlatSlides {
        /// The rotary positions \[rad\].
        at: RotaryPair,
    },
    /// A number of setup, tool or pose is NaN or infinite, or the tool axis vanishes.
    NotFinite {
        /// Name of the quantity.
        what: &'static str,
    },
}
