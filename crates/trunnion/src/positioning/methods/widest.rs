//! Cutter locations with the widest strip, free or at a given inclination.

use crate::positioning::active::ActiveConstraint;
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::methods::ball::ball_location;
use crate::positioning::methods::sides::on_sides;
use crate::positioning::methods::widest_search::{SideRequest, search_side};
use crate::positioning::request::{ContactSide, LocationRequest, ToolInclination};
use crate::positioning::solve::placement::MOST_ROTATION;
use crate::types::Interval;
use std::f64::consts::FRAC_PI_2;

/// Finds the cutter location with the widest strip from `request.at`.
///
/// `warm`, the location of a neighbour on the same side, starts the search there; without it, or
/// where it leads nowhere, several offset directions are tried. The width is `w cos(alpha)`.
///
/// Source: `docs/sources.md#004`, sections 1 and 2, with the errata named there.
///
/// # Example
///
/// A ball of radius 5 mm on a plane leaves a strip of `2 sqrt(2 r e - e^2)`.
///
/// ```
/// use nalgebra::Point3;
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::positioning::{
///     ContactSide, LocationRequest, StripSide, ToleranceBand, widest_strip,
/// };
/// use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
/// use trunnion::types::{Interval, Uv};
///
/// // The plane z = 0 over a square of 40 mm.
/// let point = |x, y| Point3::new(x, y, 0.0);
/// let points =
///     vec![vec![point(0.0, 0.0), point(0.0, 40.0)], vec![point(40.0, 0.0), point(40.0, 40.0)]];
/// let knots = vec![0.0, 0.0, 1.0, 1.0];
/// let plane = NurbsSurface::new([1, 1], [knots.clone(), knots], points, None).unwrap();
/// let face = FaceIndex::new(Face::new(1, Surface::Nurbs(plane), vec![])?)?;
///
/// let cutter = Cutter::new(CutterSpec::ball(10.0))?;
/// let location = widest_strip(
///     &LocationRequest {
///         face: &face,
///         cutter: &cutter,
///         band: ToleranceBand { lower: 0.0, upper: 0.01 },
///         at: Uv::new(0.5, 0.5),
///         feed: [1.0, 0.0],
///         strip: StripSide::Right,
///         side: ContactSide::Ahead,
///         offset_range: Interval::new(-0.5, 0.5),
///         axis_cone: None,
///     },
///     None,
/// )?;
/// let expected = 2.0 * (2.0 * 5.0 * 0.01 - 0.01_f64.powi(2)).sqrt();
/// assert!((location.strip_width - expected).abs() < 1e-6);
/// assert!(location.pose.tip.z.abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// See [`PositioningError`].
pub fn widest_strip(
    request: &LocationRequest,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    widest_strip_counted(request, warm, &mut 0)
}

/// Does what [`widest_strip`] does, and adds the closest-point queries that the search took to `queries`.
pub(crate) fn widest_strip_counted(
    request: &LocationRequest,
    warm: Option<&CutterLocation>,
    queries: &mut u64,
) -> Result<CutterLocation, PositioningError> {
    request.validate()?;
    let rotation_range = Interval::new(-MOST_ROTATION, MOST_ROTATION);
    on_sides(request, |side| {
        if !request.cutter.touches_in_one_point() {
            search_side(SideRequest { request, side, warm, rotation_range }, queries)
        } else if request.cutter.is_barrel() {
            barrel_location(request, side)
        } else {
            ball_location(request, side, ToolInclination { angle: 0.0, towards: None })
        }
    })
}

/// Returns the location of a barrel that touches with the middle of its arc, inclined square to the feed: to the strip's
/// side, or away from it where that is wider.
fn barrel_location(
    request: &LocationRequest,
    side: ContactSide,
) -> Result<CutterLocation, PositioningError> {
    let angle = request.cutter.contact_arc().inclinations.middle();
    let to = |towards: f64| {
        ball_location(request, side, ToolInclination { angle, towards: Some(towards) })
    };
    match (to(FRAC_PI_2), to(-FRAC_PI_2)) {
        (Ok(a), Ok(b)) if b.strip_width > a.strip_width => Ok(b),
        (Ok(a), _) | (Err(_), Ok(a)) => Ok(a),
        (Err(error), Err(_)) => Err(error),
    }
}

/// Finds the widest location whose rotation about the chord is at least `lead` \[rad\]: a fixed
/// inclination, more only where the rear would gouge. An offset range of `[0, 0]` keeps the chord
/// across the feed.
///
/// For points where no wide strip fits, and for ball cutters.
///
/// # Example
///
/// On a plane, a circle of radius `R` inclined by the lead rises by `R sin(lead) (1 - cos(psi))` at
/// the angle `psi` from its contact, which is the tolerance `e` at the ends of the strip.
///
/// ```
/// # use trunnion::surface::{Face, FaceIndex, NurbsSurface, Surface};
/// # let point = |x, y| nalgebra::Point3::new(x, y, 0.0);
/// # let points = vec![vec![point(0.0, 0.0), point(0.0, 40.0)], vec![point(40.0, 0.0), point(40.0, 40.0)]];
/// # let knots = vec![0.0, 0.0, 1.0, 1.0];
/// # let plane = NurbsSurface::new([1, 1], [knots.clone(), knots], points, None).unwrap();
/// # let face = FaceIndex::new(Face::new(1, Surface::Nurbs(plane), vec![])?)?;
/// use trunnion::cutter::{Cutter, CutterSpec};
/// use trunnion::positioning::{
///     ContactSide, LocationRequest, StripSide, ToleranceBand, with_lead,
/// };
/// use trunnion::types::{Interval, Uv};
///
/// # // `face` is a plane, 40 mm square.
/// let cutter = Cutter::new(CutterSpec::bull(10.0, 2.0))?;
/// let request = LocationRequest {
///     face: &face,
///     cutter: &cutter,
///     band: ToleranceBand { lower: 0.0, upper: 0.02 },
///     at: Uv::new(0.5, 0.5),
///     feed: [1.0, 0.0],
///     strip: StripSide::Right,
///     side: ContactSide::Ahead,
///     offset_range: Interval::point(0.0),
///     axis_cone: None,
/// };
/// let location = with_lead(&request, 0.1, None)?;
/// let cos = 1.0 - 0.02 / (10.0 * location.rotation.sin());
/// assert!((location.rotation - 0.1).abs() < 1e-3);
/// assert!((location.strip_width - 2.0 * 10.0 * (1.0 - cos * cos).sqrt()).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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

/// Finds the widest location as [`with_lead`] does, inclined to a given side.
///
/// For a ball the side is free. For other cutters it lies less than 90 degrees from the feed and
/// turns the chord by as much.
///
/// # Errors
///
/// See [`PositioningError`].
pub fn with_inclination(
    request: &LocationRequest,
    lean: ToolInclination,
    warm: Option<&CutterLocation>,
) -> Result<CutterLocation, PositioningError> {
    with_inclination_counted(request, lean, warm, &mut 0)
}

/// Does what [`with_inclination`] does, and adds the closest-point queries that the search took to `queries`.
pub(crate) fn with_inclination_counted(
    request: &LocationRequest,
    lean: ToolInclination,
    warm: Option<&CutterLocation>,
    queries: &mut u64,
) -> Result<CutterLocation, PositioningError> {
    let turned = lean.towards.filter(|_| !request.cutter.touches_in_one_point());
    // The chord lies square to the inclination: alpha turns it from the strip side towards the feed.
    let offset_range = turned.map_or(request.offset_range, |towards| Interval::point(-towards));
    let request = &LocationRequest { offset_range, ..*request };
    request.validate()?;
    on_sides(request, |side| {
        if request.cutter.touches_in_one_point() {
            return ball_location(request, side, lean);
        }
        let least = lean.angle.min(MOST_ROTATION);
        let rotation_range = Interval::new(least, MOST_ROTATION);
        let mut location =
            search_side(SideRequest { request, side, warm, rotation_range }, queries)?;
        if location.rotation <= lean.angle {
            location.active.push(ActiveConstraint::GivenLead);
        }
        Ok(location)
    })
}
