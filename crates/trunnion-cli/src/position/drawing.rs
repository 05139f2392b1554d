//! Drawing of the error along the cutting circle.

use super::args::PositionArgs;
use trunnion::positioning::{
    CutterLocation, LocationRequest, PositioningError, error_picture, trace,
};

/// Draws the error along the cutting circle.
pub(super) fn picture(
    request: &LocationRequest,
    location: &CutterLocation,
    args: &PositionArgs,
) -> Result<String, PositioningError> {
    let cutter = args.method.placing(args).cutter(request.cutter)?;
    let name = args.method.name();
    let trace = trace(&LocationRequest { cutter: &cutter, ..*request }, location, name)?;
    Ok(error_picture(&trace, request.band, &title(args, &format!("{name}, {:.3} mm", trace.width))))
}

/// Returns the title of a drawing.
pub(super) fn title(args: &PositionArgs, what: &str) -> String {
    let ([u, v], [du, dv]) = (args.at, args.feed);
    format!("{what}, at (u, v) = ({u}, {v}), feed ({du}, {dv}), tolerance {} mm", args.tolerance)
}
