//! Request for one cutter location.

use crate::cutter::Cutter;
use crate::math;
use crate::positioning::error::PositioningError;
use crate::surface::FaceIndex;
use crate::types::{Interval, Uv};
use nalgebra::UnitVector3;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

/// Band of the signed error of the finished surface \[mm\]: positive is excess.
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

impl ToleranceBand {
    /// Share of the band that searches keep free at both ends: rounding is no gouge.
    const MARGIN: f64 = 1e-6;

    /// Width that searches keep free at both ends \[mm\].
    ///
    /// A search may break its conditions by as much and still end inside the band.
    pub(crate) fn margin(self) -> f64 {
        Self::MARGIN * (self.upper - self.lower)
    }

    /// The band without its margins.
    pub(crate) fn inner(self) -> Self {
        let margin = self.margin();
        Self { lower: self.lower + margin, upper: self.upper - margin }
    }
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
    /// Returns +1 for right, -1 for left.
    pub fn sign(self) -> f64 {
        match self {
            Self::Right => 1.0,
            Self::Left => -1.0,
        }
    }

    /// Returns the other side.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Right => Self::Left,
            Self::Left => Self::Right,
        }
    }
}

/// Side of the cutter centre, along the feed, on which the contact arc lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ContactSide {
    /// The front of the cutter cuts.
    Ahead,
    /// The rear cuts: only for a centre-cutting tool.
    Behind,
    /// Whichever gives the wider strip.
    Either,
}

/// Cone in which the tool axis has to lie, for instance around that of the location before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCone {
    /// Axis of the cone, from tip to spindle.
    pub axis: UnitVector3<f64>,
    /// Half angle of the cone \[rad\], above 0.
    pub max_turn: f64,
}

/// Inclination of the tool axis from the surface normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolInclination {
    /// Angle between them \[rad\]; for cutters that are not balls at least this.
    pub angle: f64,
    /// Direction of the inclination \[rad\]: 0 along the feed, a quarter turn on the strip's side.
    /// `None`: along the feed for a ball, and as the offset range allows for other cutters.
    pub towards: Option<f64>,
}

impl ToolInclination {
    /// Creates the inclination by the lead angle along the feed and the tilt angle to the strip's side,
    /// each seen square to the other \[rad\], below 90 degrees.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::positioning::ToolInclination;
    ///
    /// let ahead = ToolInclination::of(0.1, 0.0);
    /// assert!((ahead.angle - 0.1).abs() < 1e-15 && ahead.towards == Some(0.0));
    /// // Lead and tilt of 45 degrees: tan(angle) is the square root of 2.
    /// let both = ToolInclination::of(45_f64.to_radians(), 45_f64.to_radians());
    /// assert!((both.angle.tan() - 2_f64.sqrt()).abs() < 1e-12);
    /// ```
    pub fn of(lead: f64, tilt: f64) -> Self {
        // The axis is n + tan(lead) a + tan(tilt) b up to its length: both angles are seen in
        // planes square to each other, so their tangents are the components of the inclination.
        let [ahead, beside] = [math::tan(lead), math::tan(tilt)];
        Self {
            angle: math::atan(math::hypot(ahead, beside)),
            towards: Some(math::atan2(beside, ahead)),
        }
    }
}

/// One cutter location to be found. Begin with [`LocationRequest::new`] and change the rest by struct update.
#[derive(Debug, Clone, Copy)]
pub struct LocationRequest<'a> {
    /// The surface.
    pub face: &'a FaceIndex,
    /// The cutter.
    pub cutter: &'a Cutter,
    /// Band in which the error has to lie.
    pub band: ToleranceBand,
    /// Parameters of the first end point `P1`, where the strip begins.
    pub at: Uv,
    /// Feed direction `[du, dv]`; its sign counts, its length does not.
    pub feed: [f64; 2],
    /// Side of the feed on which the strip lies.
    pub strip: StripSide,
    /// Side of the cutter that cuts.
    pub side: ContactSide,
    /// Range of the offset direction alpha, from the strip side towards the feed \[rad\].
    pub offset_range: Interval,
    /// Cone in which the tool axis has to lie; `None` leaves it free.
    pub axis_cone: Option<AxisCone>,
}

/// Offset directions that are searched unless the caller asks for others \[rad\].
const OFFSET_RANGE: Interval = Interval::new(-FRAC_PI_6, FRAC_PI_6);

impl<'a> LocationRequest<'a> {
    /// Requests a location at `at` with that feed direction.
    ///
    /// Presets: the strip lies to the right of the feed, the front of the cutter cuts, offset directions are searched
    /// up to 30 degrees to either side, and the tool axis is free.
    pub const fn new(
        face: &'a FaceIndex,
        cutter: &'a Cutter,
        band: ToleranceBand,
        at: Uv,
        feed: [f64; 2],
    ) -> Self {
        Self {
            face,
            cutter,
            band,
            at,
            feed,
            strip: StripSide::Right,
            side: ContactSide::Ahead,
            offset_range: OFFSET_RANGE,
            axis_cone: None,
        }
    }
}

impl LocationRequest<'_> {
    /// Refuses what no search could answer: an empty band, an offset range outside (-90, 90)
    /// degrees, a rear that does not cut.
    pub(crate) fn validate(&self) -> Result<(), PositioningError> {
        let ToleranceBand { lower, upper } = self.band;
        if !(lower.is_finite() && upper.is_finite() && lower < upper) {
            return Err(PositioningError::EmptyBand { lower, upper });
        }
        let range = self.offset_range;
        // At 90 degrees the chord would lie along the feed, and the strip would have no width.
        let fits = range.low <= range.high && range.low > -FRAC_PI_2 && range.high < FRAC_PI_2;
        if !fits {
            return Err(PositioningError::OffsetRange { range });
        }
        let cutter = self.cutter;
        if self.side != ContactSide::Ahead && !cutter.centre_cutting() {
            return Err(PositioningError::NotCentreCutting {
                inner: cutter.inner_cutting_radius(),
            });
        }
        Ok(())
    }

    /// Width of the strip of a fitting cutter that stands upright on a plane, `sqrt(8 R e)`
    /// \[mm\]: about the narrowest strip there is.
    pub(crate) fn narrowest_strip(&self) -> f64 {
        (8.0 * self.cutter.major() * (self.band.upper - self.band.lower)).sqrt()
    }
}
