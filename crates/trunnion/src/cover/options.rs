//! Options of a covering, and the preset for finishing.

use super::error::CoverError;
use super::pattern::{CutPattern, FeedDirection, PlacementMethod, PrismaticUse};
use crate::cutter::Cutter;
use crate::math;
use crate::positioning::{ContactSide, ToleranceBand, ToolInclination};
use crate::types::Interval;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6, PI};

/// Least and largest distance between stations, as shares of the cutter's radius.
const SPACING: Interval = Interval::new(0.003, 0.125);

/// Offset directions that are searched \[rad\].
const OFFSET_RANGE: Interval = Interval::new(-FRAC_PI_6, FRAC_PI_6);

/// Lead angle of passes where no wide strip fits \[rad\].
const FALLBACK_LEAD: f64 = 5.0 * PI / 180.0;

/// Work allowed for the wide strips of a face, over that of finishing the face at the fixed lead.
const EFFORT: f64 = 3.0;

/// Share of the excess that the curve between two stations may add to the error of the stations.
const PATH_SHARE: f64 = 0.05;

/// Length that is cut in the time of one link, in radii of the cutter: up, over and down again.
const LINK: f64 = 10.0;

/// Largest turn of the tool axis along a pass, over one turn by the cutter's radius \[rad\].
const AXIS_TURN: f64 = 0.5;

/// Tolerance of a finished face \[mm\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinishTolerance {
    /// Material that may be left on the face \[mm\].
    pub excess: f64,
    /// Depth to which the tool may cut into the face \[mm\].
    pub gouge: f64,
}

/// Options of [`cover`](super::cover). There is no `Default`, since tolerances are the caller's decision;
/// [`CoverOptions::finishing`] fills in good values for the rest, which struct update changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoverOptions {
    /// Feed direction of the passes.
    pub feed_direction: FeedDirection,
    /// Order of the feed directions.
    pub pattern: CutPattern,
    /// Placement of the tool.
    pub method: PlacementMethod,
    /// Use of passes for walls and floors, before strips.
    pub prismatic: PrismaticUse,
    /// Side of the cutter that cuts.
    pub side: ContactSide,
    /// Tolerance band for the error of each cutter location \[mm\].
    pub band: ToleranceBand,
    /// Excess that the passes may leave \[mm\], at least `band.upper`: spots between strips that are no higher get no
    /// passes of their own. What follows adds its errors to it.
    pub excess: f64,
    /// Cost of one more pass besides its own length: leads and a link, as the length that is cut in that
    /// time \[mm\].
    pub link: f64,
    /// Largest amount by which the curve between stations may leave the band on either side \[mm\].
    pub path_share: f64,
    /// Least and largest distance between stations along the end-point track \[mm\].
    pub spacing: Interval,
    /// Largest turn of the tool axis, and of the offset direction about the surface normal, per mm
    /// of the end-point track \[rad/mm\].
    pub max_axis_turn: f64,
    /// Offset directions to search, from the strip side towards the feed \[rad\].
    pub offset_range: Interval,
    /// Inclination of the tool with [`PlacementMethod::Inclined`]. Where the tool would touch something at this
    /// inclination, others are tried. A barrel without a direction is inclined square to the feed, to the side that takes
    /// less over the whole face.
    pub lean: ToolInclination,
    /// Work that a face may take before wide strips are given up and its remainder is finished at the fixed
    /// lead. It is relative to the work of finishing all of the face at the fixed lead, estimated from its area.
    /// Work is counted in locations tried and not timed, so it is the same on every machine.
    pub effort: f64,
}

impl CoverOptions {
    /// Returns the options for finishing with `cutter` within `tolerance`: adaptive zigzag passes of wide strips.
    ///
    /// The preset takes 5 % of the excess for the curves between stations. The link is a guess of ten cutter
    /// radii; set [`CoverOptions::link`] if the machine is known.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion::cover::{CoverOptions, CutPattern, FinishTolerance};
    /// use trunnion::cutter::{Cutter, CutterSpec};
    ///
    /// let cutter = Cutter::new(CutterSpec::ball(8.0)).expect("a ball of radius 4 mm");
    ///
    /// let tolerance = FinishTolerance { excess: 0.02, gouge: 0.004 };
    /// let options = CoverOptions {
    ///     pattern: CutPattern::OneWay,
    ///     ..CoverOptions::finishing(&cutter, tolerance)
    /// };
    /// // 0.001 mm on either side is left to the curves between the stations.
    /// assert!((options.path_share - 0.001).abs() < 1e-15);
    /// assert!((options.band.lower + 0.003).abs() < 1e-15);
    /// assert!((options.band.upper - 0.019).abs() < 1e-15);
    /// // Stations lie at most an eighth of the radius apart.
    /// assert_eq!(options.spacing.high, 0.5);
    /// ```
    pub fn finishing(cutter: &Cutter, tolerance: FinishTolerance) -> Self {
        let radius = cutter.radius();
        let path_share = PATH_SHARE * tolerance.excess;
        Self {
            feed_direction: FeedDirection::Adaptive,
            pattern: CutPattern::ZigZag,
            method: PlacementMethod::Widest,
            prismatic: PrismaticUse::Never,
            side: ContactSide::Ahead,
            band: ToleranceBand {
                lower: path_share - tolerance.gouge,
                upper: tolerance.excess - path_share,
            },
            excess: tolerance.excess,
            link: LINK * radius,
            path_share,
            spacing: Interval::new(SPACING.low * radius, SPACING.high * radius),
            max_axis_turn: AXIS_TURN / radius,
            offset_range: OFFSET_RANGE,
            lean: usual_inclination(cutter),
            effort: EFFORT,
        }
    }

    /// Checks that every number is within its range.
    pub(super) fn check(&self) -> Result<(), CoverError> {
        let bad = |name, value, must| Err(CoverError::BadOption { name, value, must });
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let [least, most] = self.spacing.ends();
        if !positive(least) {
            return bad("least spacing", least, "positive (mm)");
        }
        if !(most >= least && most.is_finite()) {
            return bad("largest spacing", most, "at least the least one (mm)");
        }
        if !positive(self.path_share) {
            return bad("path share", self.path_share, "positive (mm)");
        }
        if !(self.link >= 0.0 && self.link.is_finite()) {
            return bad("link", self.link, "0 or more (mm)");
        }
        if !positive(self.max_axis_turn) {
            return bad("largest axis turn", self.max_axis_turn, "positive (rad/mm)");
        }
        if self.effort.is_nan() || self.effort <= 0.0 {
            return bad("effort", self.effort, "positive");
        }
        if !(0.0..FRAC_PI_2).contains(&self.lean.angle) {
            return bad("lean", self.lean.angle, "from 0 to below a right angle (rad)");
        }
        Ok(())
    }
}

/// Returns the inclination of a cutter for which none is given: the fallback lead, or the middle of a barrel's arc.
fn usual_inclination(cutter: &Cutter) -> ToolInclination {
    let inclinations = cutter.contact_arc().inclinations;
    let angle = if cutter.is_barrel() { inclinations.middle() } else { FALLBACK_LEAD };
    ToolInclination { angle, towards: None }
}

/// Returns the distance from the tip at which an axis turn counts as movement when a curve is laid through the
/// stations of a pass \[mm\]: the cutter's outer radius, or the distance of the upper end of a barrel's arc.
///
/// `cover` checks passes on curves with this lever, so the tool path must use the same.
///
/// # Example
///
/// ```
/// use trunnion::cutter::{Cutter, CutterSpec};
///
/// let spec = CutterSpec { length: 60.0, ..CutterSpec::bull(5.0, 3.0) };
/// let cutter = Cutter::new(spec).expect("a bull-nose cutter");
/// assert_eq!(trunnion::cover::lever(&cutter), 8.0);
/// ```
pub fn lever(cutter: &Cutter) -> f64 {
    let arc = cutter.contact_arc();
    let [rho, z] = arc.point(arc.inclinations.high);
    if cutter.is_barrel() { math::hypot(rho, z) } else { cutter.radius() }
}
