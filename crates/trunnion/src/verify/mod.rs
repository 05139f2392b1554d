//! Replay a program as the control would, measure it against the surface, audit the axes.
//!
//! Shares only surface, cutter, machine and `nc::read` with the makers and never calls their inverse (where a program tells
//! a direction, `turns` has its own), so that a maker's mistake cannot hide in the checker.
//!
//! [`check`] runs a [program](crate::nc::read::ProgramSource) from the machine's home position: without TCP all axes are linear in
//! a block, with it the tip (table frame, see [`nc`](crate::nc)) and the rotaries. For every point
//! `p` of a grid over the faces it finds the lowest `s` at which the normal `p + s n` meets the tool
//! in any pose of any cut: below 0 a gouge, above 0 excess. Rapids gouge likewise, with all axes together and with each at
//! its own speed; what they cut is not counted on. A tool that is on the
//! normal only below `p` is behind a wall thinner than the check looks, and gouges, if anything, the face
//! on its other side. That is a minimum over continuous time to a stated tolerance, not over sampled poses
//! (`docs/sources.md`, verification). Moves are taken so many at a time: memory is that of the measured points and
//! of the program's source, [`ProgramText`](crate::nc::read::ProgramText) for a long one.

mod axes;
mod check;
mod deviation;
mod error;
mod findings;
mod fixture;
mod input;
mod inspect;
mod line_stats;
mod options;
mod replay;
mod report;
mod setpoints;
mod stock;
mod swept;

pub use check::check;
pub use deviation::side::{FacesFromBehind, behind};
pub use error::{VerifyError, VerifyRemedy};
pub use fixture::{
    ClearanceOptions, ClearanceReport, DEPTH_SHARE, Fixture, FixtureApproach, clearance,
};
pub use input::CheckInput;
pub use inspect::{CutStock, FeedMeaning, Inspection, InspectionReport, OtherFaces};
pub use line_stats::Lines;
pub use options::{BoundOptions, CheckOptions, DeviationTolerance, LEAST_GOUGE};
pub use replay::{
    Changes, Choice, Choices, Tables, TimedPose, Tool, Track, WorkOffset, offset_name,
    offset_short_name, track,
};
pub use report::{
    Audit, AxisAudit, AxisRatio, Bin, Bounds, Brief, Deviation, Extreme, FaceMap, Finding,
    ModelAudit, Overrun, Ratio, Report, Sample, Sensitivity, Singular,
};
pub use setpoints::{
    AxisMotion, MotionAudit, MotionError, MotionFinding, MotionOptions, MotionReport, MotionRow,
    RowRatio, Unevenness,
};
pub use stock::{
    Collision, CollisionKind, Solid, Stock, StockOptions, StockReport, UndecidedCollision, simulate,
};
