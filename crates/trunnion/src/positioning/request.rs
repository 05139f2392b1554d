//! What is asked of a cutter location, and what is answered.

use super::location::Mark;
use crate::cutter::Cutter;
use crate::surface::FaceIndex;
use crate::types::ToolPose;
use nalgebra::Point3;
use nalgebra::UnitVector3;

/// Where the signed error of the finished surface has to lie \[mm\]: positive is excess.
///
/// On the strip the error stays in `[lower, upper]`; everything else of the cutter stays at least
/// `lower` away from the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToleranceBand {
    /// Least distance of the cutter from the surface \[mm\].
    pub lower: f64,
    /// Largest error on the strip \[mm\].
    pub upper: f64,
}

/// Side of the feed on which the strip lies, seen along the feed with the normal up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StripSide {
    /// Towards `feed x normal`.
    Right,
    /// Away from it: what the return pass of a zigzag needs.
    Left,
}

impl StripSide {
    /// +1 for right, -1 for left.
    pub fn sign(self) -> f64 {
        match self {
            Self::Right => 1.0,
            Self::Left => -1.0,
        }
    }

    /// The other side.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Right => Self::Left,
            Self::Left => Self::Right,
        }
    }
}

/// Where the contact arc lies from the cutter centre, along the feed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ContactSide {
    /// The front of the cutter cuts.
    Ahead,
    /// The rear cuts: only for a centre-cutting tool.
    Behind,
    /// Whichever gives the wider strip.
    Either,
}

/// Keeps the tool axis close to a given direction, for instance that of the location before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCone {
    /// The direction, from tip to spindle.
    pub axis: UnitVector3<f64>,
    /// Largest angle from it \[rad\], above 0.
    pub max_turn: f64,
}

/// How the tool axis leans from the surface normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolInclination {
    /// Angle between them \[rad\]; for cutters that are not balls at least this.
    pub angle: f64,
    /// To which side: 0 is along the feed, a quarter turn on the strip's side \[rad\]. `None`: along the feed for a
    /// ball, and as the offset range allows for other cutters.
    pub towards: Option<f64>,
}

impl ToolInclination {
    /// The tool axis leans by `lead` along the feed, and by `tilt` to the strip's side, both seen square to the
    /// other \[rad\], below 90 degrees.
    pub fn of(lead: f64, tilt: f64) -> Self {
        let [ahead, beside] = [lead.tan(), tilt.tan()];
        Self { angle: ahead.hypot(beside).atan(), towards: Some(beside.atan2(ahead)) }
    }
}

/// One cutter location to be found.
#[derive(Debug, Clone, Copy)]
pub struct LocationRequest<'a> {
    /// The surface.
    pub face: &'a FaceIndex,
    /// The cutter.
    pub cutter: &'a Cutter,
    /// Where the error has to lie.
    pub band: ToleranceBand,
    /// Parameters `[u, v]` of the first end point `P1`, where the strip begins.
    pub at: [f64; 2],
    /// Feed direction `[du, dv]`; its sign counts, its length does not.
    pub feed: [f64; 2],
    /// Side of the feed on which the strip lies.
    pub strip: StripSide,
    /// Side of the cutter that cuts.
    pub side: ContactSide,
    /// Range of the offset direction alpha, from the strip side towards the feed \[rad\].
    pub offset_range: [f64; 2],
    /// Keeps the tool axis near a direction; `None` leaves it free.
    pub axis_cone: Option<AxisCone>,
}

/// What holds the widest strip back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ActiveConstraint {
    /// The cutter touches the lower end of the band inside the strip.
    Touch,
    /// The error reaches the upper end of the band inside the strip.
    Middle,
    /// The error curve is level at the first end point: it would leave the band inside the strip.
    FirstSlope,
    /// The same at the second end point.
    SecondSlope,
    /// The rear of the centre circle.
    Rear,
    /// The flat disc inside the cutting circle.
    Disc,
    /// The chord is as long as the cutter is wide.
    Chord,
    /// An end of the range of the offset direction.
    OffsetRange,
    /// The bound on the turn of the tool axis.
    AxisTurn,
    /// The angle between tool axis and normal was given, not found.
    GivenLead,
}

/// One cutter location and the strip it leaves.
#[derive(Debug, Clone, PartialEq)]
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
    /// Centre of the torus circle \[mm\].
    pub center: Point3<f64>,
    /// Tip and tool axis.
    pub pose: ToolPose,
    /// Side of the cutter that cuts: `Ahead` or `Behind`.
    pub side: ContactSide,
    /// Side of the feed on which the strip lies.
    pub strip: StripSide,
    /// Angle of the arc between the end points \[rad\].
    pub arc: f64,
    /// Where the error is least inside the strip, as angle on the circle from `P1` \[rad\].
    pub contact_angles: Vec<f64>,
    /// What holds the strip back.
    pub active: Vec<ActiveConstraint>,
    /// Largest error found on the strip \[mm\].
    pub front_max: f64,
    /// What no error of the strip exceeds \[mm\].
    pub front_max_bound: f64,
    /// Least error found on the strip \[mm\].
    pub front_min: f64,
    /// Least distance found from the rest of the circle and the disc to the surface \[mm\].
    pub rear_min: f64,
    /// What that distance is at least, strip included \[mm\].
    pub rear_min_bound: f64,
    /// Closest-point queries spent.
    pub queries: u32,
    /// The first contact: foot of the circle point with the least error \[mm\].
    pub contact: Point3<f64>,
    /// Its parameters.
    pub contact_uv: [f64; 2],
    /// Parameters of the second end point `P2`.
    pub end: [f64; 2],
    /// Parameters of the strip's end on the first end point's side; `at` or beyond it.
    pub near: [f64; 2],
    /// Parameters of the strip's other end; `end` or beyond it.
    pub far: [f64; 2],
    /// Where a neighbour looks for the extrema of its error.
    pub(super) marks: Vec<Mark>,
}
