//! Cutter locations with the widest strip, free or at a given inclination.

use crate::positioning::active::ActiveConstraint;
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::methods::ball::ball_location;
use crate::positioning::methods::sides::on_sides;
use crate::positioning::methods::widest_search::search_side;
use crate::positioning::request::{LocationRequest, ToolInclination};
use crate::positioning::solve::placement::MOST_ROTATION;

/// The cutter location with the widest strip from `request.at` \[mm\].
///
/// `warm`, the location of a neighbour on the same side, starts the search there; without it, or
/// where it leads nowhere, several offset directions are tried. The width is `w cos(alpha)`.
///
/// Source: `docs/sources.md#004`, sections 1 and 2, with the errata named there.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn widest_strip(
    request: &LocationRequest,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    request.validate()?;
    let rotation = [-MOST_ROTATION, MOST_ROTATION];
    on_sides(request, |side| {
        if request.cutter.major() > 0.0 {
            search_side(request, side, warm, rotation)
        } else {
            ball_location(request, side, ToolInclination { angle: 0.0, towards: None })
        }
    })
}

/// The widest location whose rotation about the chord is at least `lead` \[rad\]: fixed
/// inclination, more only where the rear would gouge. An offset range of `[0, 0]` keeps the chord
/// across the feed.
///
/// For places where no wide strip fits, and for ball cutters.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn with_lead(
    request: &LocationRequest,
    lead: f64,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    with_inclination(request, ToolInclination { angle: lead, towards: None }, warm)
}

/// As [`with_lead`], leaning to a given side: for a ball any, for other cutters less than 90 degrees from the feed,
/// which turns the chord by as much.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn with_inclination(
    request: &LocationRequest,
    lean: ToolInclination,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    let turned = lean.towards.filter(|_| request.cutter.major() > 0.0);
    // The chord lies square to the lean: alpha turns it from the strip side towards the feed.
    let offset_range = turned.map_or(request.offset_range, |towards| [-towards, -towards]);
    let request = &LocationRequest { offset_range, ..*request };
    request.validate()?;
    on_sides(request, |side| {
        if request.cutter.major() <= 0.0 {
            return ball_location(request, side, lean);
        }
        let least = lean.angle.min(MOST_ROTATION);
        let mut location = search_side(request, side, warm, [least, MOST_ROTATION])?;
        if location.rotation <= lean.angle {
            location.active.push(ActiveConstraint::GivenLead);
        }
        Ok(location)
    })
}
