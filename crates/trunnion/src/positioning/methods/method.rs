//! All methods of placing a cutter behind one function, so that they can be compared.

use crate::cutter::{Cutter, CutterKind, CutterSide, CutterSpec};
use crate::positioning::error::PositioningError;
use crate::positioning::location::CutterLocation;
use crate::positioning::methods::ball::ball_location;
use crate::positioning::methods::contact::{curvature_matched, fixed_axis, lead_and_swivel, sturz};
use crate::positioning::methods::nested::{NestedGrid, nested_location};
use crate::positioning::methods::pair::{PairRule, pair_location};
use crate::positioning::methods::sides::on_sides;
use crate::positioning::methods::widest::widest_strip;
use crate::positioning::request::{ContactSide, LocationRequest, ToolInclination};
use nalgebra::UnitVector3;
use std::borrow::Cow;
use std::f64::consts::FRAC_PI_2;

/// A method of placing a cutter.
///
/// With `EndPoint`, `Nested`, `MultiPoint`, `HermiteChebyshev` and `Ball` the strip begins at
/// `request.at`; with the others the cutter touches there, and the strip lies around it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum PlacementMethod {
    /// The widest strip that keeps the band: [`widest_strip`].
    EndPoint,
    /// The same by the nested search of paper 004.
    Nested(NestedGrid),
    /// Two tangencies with the error between them at the upper end of the band (MPM); what the rest
    /// of the cutter does is only checked.
    MultiPoint,
    /// The same with the tangencies taken to lie at the nodes of Chebyshev's polynomial.
    HermiteChebyshev,
    /// One contact with the lead and the swivel of the widest strip.
    LeadSwivel {
        /// Largest angle of the inclination from the feed direction \[rad\].
        swivel: f64,
    },
    /// One contact, inclined until the circle bends like the surface, farther where that gouges.
    CurvatureMatched,
    /// One contact, inclined by a fixed angle along the feed (Sturz).
    Sturz {
        /// Angle between normal and tool axis \[rad\].
        lead: f64,
    },
    /// One contact, the tool axis given: what three axes do.
    FixedAxis {
        /// Tool axis.
        axis: UnitVector3<f64>,
    },
    /// A ball of the cutter's radius `R + r`, see [`PlacementMethod::cutter`]. A barrel touches with its large arc,
    /// inclined to the strip's side.
    Ball {
        /// Angle between normal and tool axis \[rad\]; that of a barrel is moved to its arc.
        lead: f64,
    },
}

impl PlacementMethod {
    /// Returns the cutter that the method places: the given one, or for [`PlacementMethod::Ball`] a ball as large,
    /// shank and length as they are.
    ///
    /// # Errors
    ///
    /// [`PositioningError::Cutter`] where such a ball does not go with length or shank.
    pub fn cutter<'a>(&self, cutter: &'a Cutter) -> Result<Cow<'a, Cutter>, PositioningError> {
        // The tip of a tapered cutter and the large arc of a lens are balls already, that of a barrel stands for one.
        let is_ball =
            matches!(cutter.kind(), CutterKind::Ball | CutterKind::Taper | CutterKind::Lens);
        let is_ball = is_ball && cutter.major() <= 0.0 || cutter.is_barrel();
        if !matches!(self, Self::Ball { .. }) || is_ball {
            return Ok(Cow::Borrowed(cutter));
        }
        let (kind, major, minor) = (CutterKind::Ball, 0.0, cutter.radius());
        let side = CutterSide::Straight;
        let spec = CutterSpec { kind, major, minor, side, ..cutter.spec().clone() };
        Cutter::new(spec).map(Cow::Owned).map_err(PositioningError::Cutter)
    }
}

/// Places a cutter by a method.
///
/// Every method's pose passes the same check: nothing of it gouges, and it touches only where the
/// cutter cuts.
///
/// `offset_range` counts for the methods through two end points, `axis_cone` for
/// [`PlacementMethod::EndPoint`] only.
///
/// # Errors
///
/// See [`PositioningError`]; [`PositioningError::Gouges`] where the method's pose cuts too deep.
///
/// # Source
///
/// `docs/sources.md#004`: the paper's search, and the methods it compares itself with.
pub fn place(
    request: &LocationRequest,
    method: &PlacementMethod,
) -> Result<CutterLocation, PositioningError> {
    request.validate()?;
    method.check(request)?;
    let cutter = method.cutter(request.cutter)?;
    let request = &LocationRequest { cutter: &cutter, ..*request };
    let on_each_side = |find: &dyn Fn(ContactSide) -> Result<CutterLocation, PositioningError>| {
        on_sides(request, find)
    };
    match *method {
        PlacementMethod::EndPoint => widest_strip(request, None),
        PlacementMethod::Nested(grid) => {
            on_each_side(&|side| nested_location(request, side, &grid))
        }
        PlacementMethod::MultiPoint => {
            on_each_side(&|side| pair_location(request, side, PairRule::Extrema))
        }
        PlacementMethod::HermiteChebyshev => {
            on_each_side(&|side| pair_location(request, side, PairRule::Nodes))
        }
        PlacementMethod::LeadSwivel { swivel } => {
            on_each_side(&|side| lead_and_swivel(request, side, swivel))
        }
        PlacementMethod::CurvatureMatched => on_each_side(&|side| curvature_matched(request, side)),
        PlacementMethod::Sturz { lead } => on_each_side(&|side| sturz(request, side, lead)),
        PlacementMethod::FixedAxis { axis } => fixed_axis(request, axis),
        PlacementMethod::Ball { lead } => {
            let lean = ToolInclination { angle: lead, towards: None };
            on_each_side(&|side| ball_location(request, side, lean))
        }
    }
}

impl PlacementMethod {
    /// Refuses cutters and angles that the method cannot work with.
    fn check(&self, request: &LocationRequest) -> Result<(), PositioningError> {
        let circle = matches!(self, Self::Nested(_) | Self::MultiPoint | Self::HermiteChebyshev);
        let is_barrel = request.cutter.is_barrel();
        if circle && !is_barrel && request.cutter.major() <= 0.0 {
            return Err(PositioningError::NoCircle);
        }
        if is_barrel && !matches!(self, Self::EndPoint | Self::Ball { .. }) {
            return Err(PositioningError::BarrelArc);
        }
        let (name, value, range, must) = match *self {
            Self::Sturz { lead } | Self::Ball { lead } => {
                ("lead", lead, -FRAC_PI_2..FRAC_PI_2, "between -90 and 90 deg")
            }
            Self::LeadSwivel { swivel } => {
                ("swivel", swivel, 0.0..FRAC_PI_2, "at least 0 and below 90 deg")
            }
            _ => return Ok(()),
        };
        if range.contains(&value) {
            Ok(())
        } else {
            Err(PositioningError::Angle { name, value, must })
        }
    }
}
