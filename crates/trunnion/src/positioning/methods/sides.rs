//! Choice between the front and the rear of the cutter.

use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::request::{ContactSide, LocationRequest};

/// Searches on the allowed sides of the cutter and returns the wider location.
pub(crate) fn on_sides(
    request: &LocationRequest,
    mut find: impl FnMut(ContactSide) -> Result<CutterLocation, PositioningError>,
) -> Result<CutterLocation, PositioningError> {
    match request.side {
        ContactSide::Either => {
            let [ahead, behind] = [find(ContactSide::Ahead), find(ContactSide::Behind)];
            match (ahead, behind) {
                (Ok(a), Ok(b)) if b.strip_width > a.strip_width => Ok(b),
                (Ok(a), _) => Ok(a),
                (Err(_), Ok(b)) => Ok(b),
                (Err(error), Err(_)) => Err(error),
            }
        }
        side => find(side),
    }
}
