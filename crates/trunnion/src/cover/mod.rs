//! Passes over faces: pass layout, placement, lead-in, lead-out and links.
//!
//! [`cover`] lays passes over faces so that the strips of neighbouring passes meet; [`legs`] joins the passes to
//! one program of motions. The work has four phases, one folder each, in the order in which they use each other:
//!
//! | folder | task |
//! |---|---|
//! | `layout` | the map from across and along the passes to the parameters of the face; choice of the feed direction |
//! | `prove` | bounds for moving tools: clearance from faces, coverage of a face |
//! | `place` | the passes of one face: locations along a track, trimming, remaining material |
//! | `join` | hops, leads and links between passes |
//!
//! A pass starts from an end-point track: the line on which the error of each cutter location equals the upper end
//! of the tolerance band. Its strip ends at the far track, the second end points, which is no line of the
//! chart. `layout::advance` chooses the distance to the next track by cost. Narrower segments get passes of
//! their own. Passes begin and end on the continued surface, beyond the material that they cut.
//!
//! Where no wide strip fits, the tool is placed at the fixed inclination. If it would touch another face there
//! (`prove::part_faces`), other inclinations are tried (`place::inclination`), or the tool keeps off by the least
//! amount (`place::keep_off`). The report lists everything that stays unfinished (`place::uncut`), with the
//! largest ball that fits (`place::tool_fit`).
//!
//! Between stations nothing is sampled. Clearance (`prove::clearance`) and coverage (`prove::coverage`) of the curves
//! through the stations are bounded, both from the convexity of the tool (`cutter::solid`).

mod access;
mod cost;
mod error;
mod flank_refusal;
mod join;
mod layout;
mod options;
mod pattern;
mod place;
mod plan;
mod prove;
mod report;

pub use access::ToolAccess;
pub use cost::{LengthCost, PassCost};
pub use error::{CoverError, FacePoint};
pub use flank_refusal::FlankRefusal;
pub use join::axis_reach::AxisReach;
pub use join::hop::{HopOptions, TravelTime};
pub(crate) use join::leads::height;
pub use join::legs::{JoinedPasses, PassLeftOut, join, legs};
pub use join::request::{LeadKind, LinkOptions, LinkRequest};
pub(crate) use layout::border_line::border_lines;
pub use options::{CoverOptions, FinishTolerance, lever};
pub use pattern::{CutPattern, FeedDirection, PlacementMethod, PrismaticUse};
pub(crate) use place::corner_rows::corner_reach;
pub use place::flank::flank_fits;
pub use place::rulings::{flank_axis, rulings_fit};
pub use plan::{CoverRequest, LeftArea, cover, without};
pub use report::{
    CoverReport, Covering, FaceLayout, FallbackReason, GivenUp, LayoutCost, PassFallback,
    PassLayout, RefusedPoint,
};
