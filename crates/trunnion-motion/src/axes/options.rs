//! Options for following a tool path.

use crate::machine::{RotaryPair, SingularPolicy};
use crate::types::{AxisVector, PoseTolerance};
use nalgebra::UnitVector3;
use std::f64::consts::TAU;

/// Point that the programmed feed refers to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FeedPoint {
    /// The tool tip.
    Tip,
    /// The cutter contact.
    Contact,
}

/// Options for following a tool path.
///
/// Begin with [`AxesOptions::within`] and change what matters by struct update. There is no `Default`: the caller knows the
/// part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxesOptions {
    /// Largest deviation of the axis path from the tool path. A singular direction that is passed within
    /// a tenth of `tolerance.axis` is passed straight through, if the tip stays within its tolerance.
    pub tolerance: PoseTolerance,
    /// Largest rotary move between two nodes \[rad\].
    pub max_rotary_step: f64,
    /// Point that `feed_rate` of the nodes refers to.
    pub feed_at: FeedPoint,
    /// Cost of a radian of each rotary; the whole path is made as cheap as possible.
    pub rotary_weights: RotaryPair,
    /// Position of the axes before the path; usually [`crate::machine::Machine::home`].
    pub start: AxisVector,
    /// Retract to use where travel ends on a segment between two links; `None`: that is an
    /// error.
    pub retract: Option<RetractOptions>,
    /// Permitted change of the tool axis where a cut passes a singular direction; `None`: no change.
    pub singular: Option<SingularOptions>,
}

impl AxesOptions {
    /// Creates options for axes within `tolerance` of the tool path, which start at `start`.
    ///
    /// Presets: rotary steps of 2 degrees, the feed at the tip, equal weights, no retracts, and no changes
    /// at singular directions.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_motion::axes::{AxesOptions, FeedPoint};
    /// use trunnion_motion::types::{AxisVector, PoseTolerance};
    ///
    /// let tolerance = PoseTolerance { tip: 1e-3, axis: 1e-4 };
    /// let options = AxesOptions {
    ///     feed_at: FeedPoint::Contact,
    ///     ..AxesOptions::within(tolerance, AxisVector::zeros())
    /// };
    /// assert_eq!(options.tolerance.tip, 1e-3);
    /// ```
    #[must_use]
    pub const fn within(tolerance: PoseTolerance, start: AxisVector) -> Self {
        Self {
            tolerance,
            max_rotary_step: 2.0 * std::f64::consts::PI / 180.0,
            feed_at: FeedPoint::Tip,
            rotary_weights: RotaryPair::new(1.0, 1.0),
            start,
            retract: None,
            singular: None,
        }
    }
}

/// Retract that unwinds a rotary axis, and its cost. The move of the machine itself is
/// [`crate::machine::RetractPolicy`].
///
/// Begin with [`RetractOptions::to_plane`] and change the rest by struct update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetractOptions {
    /// Direction out of the part.
    pub up: UnitVector3<f64>,
    /// Height of the tip along `up` at which the tool may turn \[mm\]; reached along the tool axis.
    pub plane: f64,
    /// Least distance along the tool axis \[mm\].
    pub least: f64,
    /// Part of this distance, next to the part, that is run as a lead \[mm\]; infinite: all of it.
    pub approach: f64,
    /// Distance kept from the ends of travel of the retracting axis \[mm\]: what blocks of a link may
    /// be off.
    pub margin: f64,
    /// Price of a retract between two pieces \[rad\], beside the rotary travel: much more than any
    /// rotary travel it could save, so that there is one only where the path cannot go on.
    pub price: f64,
    /// The same inside a cut.
    pub price_in_cut: f64,
}

/// Rotary travel that a retract between two pieces must save \[turns\]: more than a path needs, so the tool
/// retracts only where travel ends, and inside a cut only where nothing else is possible.
const RETRACT_TURNS: f64 = 100.0;

impl RetractOptions {
    /// Retracts along the tool axis up to `plane` \[mm\] along `up`.
    ///
    /// Presets: no least distance, all of the retract is a lead, no margin at the ends of travel. A retract costs a
    /// hundred turns, and inside a cut, where it marks the part, ten times as much.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// use trunnion_motion::axes::RetractOptions;
    ///
    /// let retract = RetractOptions { least: 8.0, ..RetractOptions::to_plane(Vector3::z_axis(), 120.0) };
    /// assert!(retract.price_in_cut > retract.price && retract.approach.is_infinite());
    /// ```
    #[must_use]
    pub const fn to_plane(up: UnitVector3<f64>, plane: f64) -> Self {
        Self {
            up,
            plane,
            least: 0.0,
            approach: f64::INFINITY,
            margin: 0.0,
            price: RETRACT_TURNS * TAU,
            // A mark on the part is worse than any retract between passes.
            price_in_cut: 10.0 * RETRACT_TURNS * TAU,
        }
    }
}

/// Permitted changes inside the singular cone.
///
/// Begin with [`SingularOptions::tilted_by`] and change the rest by struct update. There is no `Default`: the
/// changes cost tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularOptions {
    /// Half angle of the cone about the singular direction in which the tool axis may be moved \[rad\].
    pub cone: f64,
    /// Turn of the workpiece-side rotary inside the cone below which nothing is done \[rad\].
    pub min_rotary: f64,
    /// Largest turn of the tool axis \[rad\]; the tip stays.
    pub tilt: f64,
}

impl SingularOptions {
    /// Turns the tool axis by at most `tilt` \[rad\], in the cone and from the rotary move of
    /// [`SingularPolicy::STANDARD`].
    #[must_use]
    pub const fn tilted_by(tilt: f64) -> Self {
        let SingularPolicy { cone, min_rotary, .. } = SingularPolicy::STANDARD;
        Self { cone, min_rotary, tilt }
    }
}
