//! Result of a covering: passes, and the report about them.

use crate::positioning::PositioningError;
use crate::types::{Interval, Pass, UncutRegion, Uv};

/// Passes over faces, with the report about them.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Covering {
    /// Passes in cutting order, face after face.
    pub passes: Vec<Pass>,
    /// Lengths, fallbacks, and everything that stays unfinished.
    pub report: CoverReport,
}

/// Statistics and findings of a covering.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct CoverReport {
    /// Length of all contact tracks \[mm\].
    pub length: f64,
    /// Number of stations.
    pub stations: usize,
    /// Cost of all passes with the links between them, as the length that is cut at the feed in that time \[mm\].
    pub cost: f64,
    /// Passes placed [`PlacementMethod::Inclined`](super::PlacementMethod::Inclined) because wide strips failed
    /// somewhere, with the reason.
    pub fallbacks: Vec<PassFallback>,
    /// Number of passes that could not be run out in full beyond the face.
    pub shortened: usize,
    /// Number of spans between stations at the least spacing that still leave the band.
    pub coarse_spans: usize,
    /// Deepest gouge of any span below the widened band \[mm\]; 0 if there is none.
    pub worst_gouge: f64,
    /// Regions that no pass finishes, face after face, the largest first; empty if all is finished.
    pub rest: Vec<UncutRegion>,
    /// Area of the faces \[mm²\].
    pub area: f64,
    /// Largest turn of the tool axis per mm of end-point track \[rad/mm\].
    pub axis_turn: f64,
    /// Number of station pairs between which the axis turns by more than the limit.
    pub fast_turns: usize,
    /// Pass layout of each face.
    pub layouts: Vec<FaceLayout>,
    /// First point at which wide strips were given up because they had used up
    /// [`CoverOptions::effort`](super::CoverOptions::effort).
    pub given_up: Option<GivenUp>,
    /// First point without a cutter location at any inclination.
    pub refused: Option<RefusedPoint>,
    /// Work done, in cutter locations tried; other searches are converted to them.
    pub work: u64,
}

impl CoverReport {
    /// Adds the report of another face.
    pub(super) fn add(&mut self, other: Self) {
        self.length += other.length;
        self.stations += other.stations;
        self.cost += other.cost;
        self.fallbacks.extend(other.fallbacks);
        self.shortened += other.shortened;
        self.coarse_spans += other.coarse_spans;
        self.worst_gouge = self.worst_gouge.max(other.worst_gouge);
        self.rest.extend(other.rest);
        self.area += other.area;
        self.axis_turn = self.axis_turn.max(other.axis_turn);
        self.fast_turns += other.fast_turns;
        self.layouts.extend(other.layouts);
        self.given_up = self.given_up.or(other.given_up);
        self.refused = self.refused.take().or(other.refused);
        self.work += other.work;
    }
}

/// Layout of the passes on a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PassLayout {
    /// Along u, on lines of constant v.
    U,
    /// Along v, on lines of constant u.
    V,
    /// On curves bent to the face.
    Bent,
    /// One pass of the flank.
    Flank,
    /// Lines and borders on a plane, with an axis that holds still.
    Floor,
    /// Along u or v on a round face, with an axis that holds still.
    FixedAxis,
}

/// Pass layout that was chosen for a face, and those that it was compared with.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FaceLayout {
    /// Number of the face.
    pub face: usize,
    /// Layout of its passes.
    pub layout: PassLayout,
    /// Its cost, before material that is left is cut across.
    pub planned: LayoutCost,
    /// The other layouts that were planned whole, in the order of their estimates.
    pub others: Vec<LayoutCost>,
}

/// Cost of a layout whose passes were planned over a whole face.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LayoutCost {
    /// Layout.
    pub layout: PassLayout,
    /// Cost of passes and links, as the length that is cut at the feed in that time \[mm\].
    pub cost: f64,
    /// Area that it leaves unfinished \[mm²\].
    pub rest: f64,
}

/// Point at which the wide strips of a face were given up.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct GivenUp {
    /// Number of the face.
    pub face: usize,
    /// Parameters of the point.
    pub uv: Uv,
    /// Share of the face that lies before the point, 0 to 1; 0 if no wide strip remains, since they were no wider than those
    /// of a ball or had used up their work early.
    pub share: f64,
}

/// Point for which no cutter location was found.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RefusedPoint {
    /// Number of the face.
    pub face: usize,
    /// Parameters of the point.
    pub uv: Uv,
    /// Reason.
    pub error: PositioningError,
}

/// Pass that was placed at the fixed inclination instead of with wide strips.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PassFallback {
    /// Number of the face.
    pub face: usize,
    /// Parameters of the point that caused it.
    pub at: Uv,
    /// Range of u that the pass covers.
    pub u: Interval,
    /// Range of v that the pass covers.
    pub v: Interval,
    /// Reason.
    pub reason: FallbackReason,
}

/// Reason for a pass that is not made of the widest strips.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum FallbackReason {
    /// A station of the pass has no wide strip.
    NoStrip(PositioningError),
    /// On this many columns across the passes nothing would have been finished.
    Missed(usize),
    /// Wide strips had used up the work that is allowed them.
    Effort,
}
