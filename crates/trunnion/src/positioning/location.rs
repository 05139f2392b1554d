//! One cutter location and the strip it leaves.

use crate::cutter::Cutter;
use crate::positioning::active::ActiveConstraint;
use crate::positioning::request::{ContactSide, LocationRequest, StripSide};
use crate::positioning::strip::MeasuredStrip;
use crate::types::{ToolPose, Uv};
use nalgebra::Point3;

/// One cutter location and the strip it leaves.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct CutterLocation {
    /// Width of the strip \[mm\]: projection on `v` of the connected part of the circle through
    /// `P1` whose error stays in the band.
    pub strip_width: f64,
    /// `w cos(alpha)` \[mm\]: the part between the two end points.
    pub chord_width: f64,
    /// Offset `w` from `P1` to `P3` in the tangent plane \[mm\].
    pub offset: f64,
    /// Offset direction alpha, from the strip side towards the feed \[rad\].
    pub offset_direction: f64,
    /// Rotation theta about the chord \[rad\].
    pub rotation: f64,
    /// Centre of the torus circle, of the ball, or of the arc of a barrel above the contact \[mm\].
    pub center: Point3<f64>,
    /// Tip and tool axis.
    pub pose: ToolPose,
    /// Side of the cutter that cuts: `Ahead` or `Behind`.
    pub side: ContactSide,
    /// Side of the feed on which the strip lies.
    pub strip: StripSide,
    /// Angle of the arc between the end points \[rad\].
    pub arc: f64,
    /// Minima of the error inside the strip, as angles on the circle from `P1` \[rad\].
    pub contact_angles: Vec<f64>,
    /// Constraints that limit the strip.
    pub active: Vec<ActiveConstraint>,
    /// Largest error found on the strip \[mm\].
    pub front_max: f64,
    /// Upper bound on the error of the strip \[mm\].
    pub front_max_bound: f64,
    /// Least error found on the strip \[mm\].
    pub front_min: f64,
    /// Least distance found from the rest of the circle and the disc to the surface \[mm\].
    pub rear_min: f64,
    /// Lower bound on that distance, strip included \[mm\].
    pub rear_min_bound: f64,
    /// Closest-point queries spent.
    pub queries: u32,
    /// The first contact: foot of the circle point with the least error \[mm\].
    pub contact: Point3<f64>,
    /// Its parameters.
    pub contact_uv: Uv,
    /// Parameters of the second end point `P2`.
    pub end: Uv,
    /// Parameters of the strip's end on the first end point's side; `at` or beyond it.
    pub near: Uv,
    /// Parameters of the strip's other end; `end` or beyond it.
    pub far: Uv,
    /// Extrema of the error: initial guesses for those of a neighbouring location.
    pub(crate) marks: Vec<ExtremumMark>,
}

/// An extremum of the error round the circle, kept as a guess for neighbouring locations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ExtremumMark {
    pub(crate) kind: ActiveConstraint,
    /// Share of half the arc between the end points; on the rear the angle itself \[rad\].
    pub(crate) place: f64,
    /// Offset of its foot from the first end point, in parameters.
    pub(crate) out: [f64; 2],
}

/// Parts of a location that a method knows besides the strip.
#[derive(Debug)]
pub(crate) struct LocationParts {
    pub(crate) pose: ToolPose,
    pub(crate) side: ContactSide,
    /// Offset, its direction, and rotation.
    pub(crate) x: [f64; 3],
    /// Width of the strip, and of the chord.
    pub(crate) widths: [f64; 2],
    pub(crate) arc: f64,
    pub(crate) contact_angles: Vec<f64>,
    pub(crate) active: Vec<ActiveConstraint>,
    /// Parameters of the second end point.
    pub(crate) end: Uv,
    pub(crate) queries: u32,
    pub(crate) marks: Vec<ExtremumMark>,
}

/// Returns the centre of the circle, ball or arc with which a cutter touches at `contact` \[mm\].
pub(crate) fn contact_center(
    cutter: &Cutter,
    pose: &ToolPose,
    contact: &Point3<f64>,
) -> Point3<f64> {
    if cutter.is_barrel() {
        cutter.contact_arc().center_at(pose, contact)
    } else {
        pose.tip + pose.axis.scale(cutter.minor())
    }
}

impl CutterLocation {
    pub(crate) fn new(
        request: &LocationRequest,
        strip: &MeasuredStrip,
        found: LocationParts,
    ) -> Self {
        let LocationParts { pose, side, arc, contact_angles, active, end, queries, marks, .. } =
            found;
        let ([strip_width, chord_width], [offset, offset_direction, rotation]) =
            (found.widths, found.x);
        Self {
            strip_width,
            chord_width,
            offset,
            offset_direction,
            rotation,
            center: contact_center(request.cutter, &pose, &strip.contact.point),
            pose,
            side,
            strip: request.strip,
            arc,
            contact_angles,
            active,
            front_max: strip.front_max,
            front_max_bound: strip.front_max_bound,
            front_min: strip.front_min,
            rear_min: strip.rear_min,
            rear_min_bound: strip.rear_min_bound,
            queries,
            contact: strip.contact.point,
            contact_uv: strip.contact.uv,
            end,
            near: strip.near.uv,
            far: strip.far.uv,
            marks,
        }
    }
}
