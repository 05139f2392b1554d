//! What a user decides about passes, and what can go wrong with them.

use crate::cutter::Cutter;
use crate::positioning::{ContactSide, PositioningError, ToleranceBand, ToolInclination};
use crate::surface::{Curvature, FaceIndex};
use crate::types::{Cancelled, Pass, UncutRegion};
use nalgebra::Point3;
use std::f64::consts::FRAC_PI_2;
use std::fmt;

/// What a pass follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Along {
    /// The first: passes lie at constant v.
    U,
    /// The second: passes lie at constant u.
    V,
    /// The direction in which the face is bent least towards the cutter (most away from it): across it, where
    /// the strip lies, the face is bent most like the cutter.
    Curvature,
    /// Whichever way promises least: u, v, or passes that bend so that strips are wide where they lie.
    Adaptive,
}

/// Whether every second pass runs back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// To and fro; the return pass has its strip on the other side of the feed.
    ZigZag,
    /// All passes towards growing parameters.
    OneWay,
}

/// How the tool is placed at a station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The widest strip; where there is none, the whole pass is placed at the least lead.
    Widest,
    /// At the fixed lead everywhere.
    Inclined,
}

/// How a face is covered. No `Default`: every number is the caller's decision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoverOptions {
    /// What the passes follow.
    pub along: Along,
    /// Order of directions.
    pub direction: Direction,
    /// How the tool is placed.
    pub method: Method,
    /// Side of the cutter that cuts.
    pub side: ContactSide,
    /// Where the error of each cutter location has to lie \[mm\].
    pub band: ToleranceBand,
    /// What a further pass costs besides its own length: leads and a link, as the length that is cut in
    /// that time \[mm\].
    pub link: f64,
    /// By how much the curve between stations may leave the band on either side \[mm\].
    pub path_share: f64,
    /// Least and largest distance between stations along the end-point track \[mm\].
    pub spacing: [f64; 2],
    /// Largest turn of the tool axis, and of the offset direction about the surface normal, per mm
    /// of the end-point track \[rad/mm\].
    pub max_axis_turn: f64,
    /// Offset directions to search, from the strip side towards the feed \[rad\].
    pub offset_range: [f64; 2],
    /// How the tool leans with [`Method::Inclined`]; where it would touch something then, another lean is taken.
    pub lean: ToolInclination,
    /// Work that a face may take before wide strips are given up and its rest is finished at the fixed
    /// lead, over the work of finishing all of it at the fixed lead (an estimate from its area).
    /// Counted in locations tried, not timed: the same on every machine.
    pub effort: f64,
}

impl CoverOptions {
    pub(super) fn check(&self) -> Result<(), CoverError> {
        let bad = |name, value, must| Err(CoverError::BadOption { name, value, must });
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let [least, most] = self.spacing;
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

/// Distance from the tip at which an axis turn counts as movement when a curve is laid through the
/// stations of a pass \[mm\]: the cutter's outer radius. `cover` checks passes on curves with this
/// lever, so the tool path must use the same.
pub fn lever(cutter: &Cutter) -> f64 {
    cutter.radius()
}

/// Passes, and what there is to know about them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Covering {
    /// Passes in cutting order, face after face.
    pub passes: Vec<Pass>,
    /// What happened on the way.
    pub report: CoverReport,
}

/// What happened while passes were placed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CoverReport {
    /// Length of all contact tracks \[mm\].
    pub length: f64,
    /// Number of stations.
    pub stations: usize,
    /// What all passes take with the ways between them, as the length that is cut at the feed in that time \[mm\].
    pub price: f64,
    /// Passes placed [`Method::Inclined`] because wide strips failed somewhere, with the reason.
    pub fallbacks: Vec<Fallback>,
    /// Passes that could not be run out in full beyond the face.
    pub shortened: usize,
    /// Spans between stations at the least spacing that still leave the band.
    pub coarse_spans: usize,
    /// Farthest that any span leaves the widened band to the side of a gouge \[mm\]; 0 if none does.
    pub worst_gouge: f64,
    /// What no pass finishes, face after face, the largest first; empty if all is finished.
    pub rest: Vec<UncutRegion>,
    /// Area of the faces \[mm²\].
    pub area: f64,
    /// Largest turn of the tool axis per mm of end-point track \[rad/mm\].
    pub axis_turn: f64,
    /// Pairs of stations between which the axis turns by more than the limit.
    pub fast_turns: usize,
    /// Which way passes run on each face: its number, and how.
    pub ways: Vec<(usize, Way)>,
    /// Where wide strips were given up because they had taken all the work of [`CoverOptions::effort`]:
    /// number of the face, parameters `[u, v]`, and the share of the face before that place. The first of them.
    pub given_up: Option<(usize, [f64; 2], f64)>,
    /// The first place that no location was found for, however the tool leans: number of the face, parameters
    /// `[u, v]`, and why.
    pub refused: Option<(usize, [f64; 2], PositioningError)>,
    /// Work it took, in cutter locations tried; what is looked at besides is counted in them.
    pub work: u64,
}

impl CoverReport {
    /// Adds what happened on another face.
    pub(super) fn add(&mut self, other: Self) {
        self.length += other.length;
        self.stations += other.stations;
        self.price += other.price;
        self.fallbacks.extend(other.fallbacks);
        self.shortened += other.shortened;
        self.coarse_spans += other.coarse_spans;
        self.worst_gouge = self.worst_gouge.max(other.worst_gouge);
        self.rest.extend(other.rest);
        self.area += other.area;
        self.axis_turn = self.axis_turn.max(other.axis_turn);
        self.fast_turns += other.fast_turns;
        self.ways.extend(other.ways);
        self.given_up = self.given_up.or(other.given_up);
        self.refused = self.refused.take().or(other.refused);
        self.work += other.work;
    }
}

/// Which way passes run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Along u, on lines of constant v.
    U,
    /// Along v, on lines of constant u.
    V,
    /// Bent to the face.
    Bent,
}

/// A pass placed at the least lead.
#[derive(Debug, Clone, PartialEq)]
pub struct Fallback {
    /// Number of the face.
    pub face: usize,
    /// Parameters `[u, v]` of the place.
    pub at: [f64; 2],
    /// Ranges of u and v that it was for.
    pub uv: [[f64; 2]; 2],
    /// Why no wide strips were taken.
    pub reason: FallbackReason,
}

/// Why a pass is not made of the widest strips.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum FallbackReason {
    /// There is none somewhere on the pass.
    NoStrip(PositioningError),
    /// On this many columns across nothing would have been finished.
    Missed(usize),
    /// Wide strips had taken the work that is allowed them.
    Effort,
}

/// A place of a face, and what fits there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Parameters `[u, v]`.
    pub uv: [f64; 2],
    /// Point \[mm\].
    pub point: Point3<f64>,
    /// Least radius by which the face bends towards the cutter there \[mm\]: no larger ball fits. Infinite where
    /// it does not.
    pub hollow: f64,
    /// The same over the whole face, or a little less.
    pub least_hollow: f64,
}

impl Place {
    pub(super) fn new(face: &FaceIndex, [u, v]: [f64; 2]) -> Self {
        let jet = face.face().surface.jet2(u, v);
        let towards = |c: Curvature| if face.face().flip { -c.min } else { c.max };
        let bend = jet.curvature().map_or(0.0, towards).max(0.0);
        let least_hollow = face.smallest_concave_radius();
        Self { uv: [u, v], point: jet.s, hollow: bend.recip(), least_hollow }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([u, v], p) = (self.uv, self.point);
        write!(
            f,
            "at (u, v) = ({u:.6}, {v:.6}), X {:.3} Y {:.3} Z {:.3}, the face is ",
            p.x, p.y, p.z
        )?;
        if self.hollow.is_finite() {
            let hollow = self.hollow;
            write!(f, "hollow with a radius of {hollow:.3} mm, the largest ball that fits there")?;
        } else {
            write!(f, "not hollow")?;
        }
        if self.least_hollow < self.hollow && self.least_hollow > 0.0 {
            write!(
                f,
                "; one of {:.3} mm fits all over the face, as far as it bends",
                self.least_hollow
            )?;
        }
        Ok(())
    }
}

/// Why a face is not covered, or passes are not joined.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CoverError {
    /// An option that makes no sense.
    #[error("{name} is {value}; it must be {must}")]
    BadOption {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be.
        must: &'static str,
    },
    /// Passes along this parameter have no length.
    #[error(
        "face {face}: at {across} the pass along {along:?} has no length; cover it along the other parameter"
    )]
    NoTrack {
        /// Number of the face.
        face: usize,
        /// Parameter followed.
        along: Along,
        /// Value of the other parameter.
        across: f64,
    },
    /// There is not one place of any face that the tool can finish.
    #[error("face {face}: the cutter cannot be placed anywhere, however it leans: {error}; {at}")]
    NoPose {
        /// Number of the face.
        face: usize,
        /// The place.
        at: Box<Place>,
        /// Why not.
        error: PositioningError,
    },
    /// No way down to a pass or up from it.
    #[error(
        "pass {pass} on face {face}: every lead between the pass and the link height gouges \
         (by {depth:.4} mm or more) or does not lead up; use a slimmer or longer tool, machine the face in a \
         setup of its own, or lower the plane of the links"
    )]
    LeadGouges {
        /// Index of the pass.
        pass: usize,
        /// Number of the face.
        face: usize,
        /// A gouge on one of the ways tried, the deepest seen \[mm\].
        depth: f64,
    },
    /// Leads up from both passes, but no link between them.
    #[error(
        "pass {pass} on face {face}: on no link round the part from the pass before it does the tool keep clear of \
         all faces; use a slimmer or shorter tool or a larger clearance, or machine the face in several setups"
    )]
    NoWayRound {
        /// Index of the pass.
        pass: usize,
        /// Number of the face.
        face: usize,
    },
    /// Stopped through `Progress`.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
