//! Errors of the request, as opposed to places at which no cutter location exists.

use crate::outcome::Failure;
use trunnion::positioning::PositioningError;

/// Returns true if the request itself is wrong, at any point of the face.
pub(super) fn is_request_error(error: &PositioningError) -> bool {
    use PositioningError as E;
    matches!(
        error,
        E::EmptyBand { .. }
            | E::OffsetRange { .. }
            | E::NoDirection { .. }
            | E::NotCentreCutting { .. }
            | E::NoCircle
            | E::Angle { .. }
            | E::Cutter(_)
    )
}

/// Refuses a wrong request.
pub(super) fn refusal(error: &PositioningError) -> Failure {
    Failure::input(with_help(error))
}

/// Returns the reason, and the remedy on a line of its own.
pub(super) fn with_help(error: &PositioningError) -> String {
    let help = error.remedy().map_or_else(String::new, |remedy| format!("\n  help: {remedy}"));
    format!("{error}{help}")
}
