//! Replay a program as the control would, measure it against the surface, audit the axes.
//!
//! Shares only surface, cutter, machine and `nc::read` with the makers and never calls their inverse (where a program tells
//! a direction, `turns` has its own), so that a maker's mistake cannot hide in the checker.
//!
//! [`check`] runs a [program](ProgramSource) from the machine's home position: without TCP all axes are linear in
//! a block, with it the tip (table frame, see [`nc`](crate::nc)) and the rotaries. For every point
//! `p` of a grid over the faces it finds the lowest `s` at which the normal `p + s n` meets the tool
//! in any pose of any cut: below 0 a gouge, above 0 excess. Rapids gouge likewise, with all axes together and with each at
//! its own speed; what they cut is not counted on. A tool that is on the
//! normal only below `p` is behind a wall thinner than the check looks, and gouges, if anything, the face
//! on its other side. That is a minimum over continuous time to a stated tolerance, not over sampled poses
//! (`docs/sources.md`, verification). Moves are taken so many at a time: memory is that of the measured points and
//! of the program's source, [`ProgramText`](crate::nc::read::ProgramText) for a long one.

mod audit;
mod blocks;
mod check;
mod control_model;
mod deviation;
mod error;
mod findings;
mod fixture;
mod inner;
mod input;
mod inspect;
mod known;
mod ledger;
mod motion;
mod options;
mod place;
mod replay;
mod report;
mod run;
mod stock;
mod swept;
mod tools;
mod track;
mod turns;

pub use check::check;
pub use control_model::{AxisRatio, ModelAudit};
pub use deviation::side::{FacesFromBehind, behind};
pub use error::VerifyError;
pub use fixture::{
    ClearanceOptions, ClearanceReport, DEPTH_SHARE, Fixture, FixtureApproach, clearance,
};
pub use input::CheckInput;
pub use inspect::{CutStock, FeedMeaning, Inspection, InspectionReport, OtherFaces};
pub use ledger::Lines;
pub use motion::{
    AxisMotion, MotionAudit, MotionError, MotionFinding, MotionOptions, MotionReport, MotionRow,
    RowRatio, Unevenness,
};
pub use options::{BoundOptions, CheckOptions, DeviationTolerance, LEAST_GOUGE};
pub use report::{
    Audit, AxisAudit, Bin, Bounds, Brief, Deviation, Extreme, FaceMap, Finding, Overrun, Ratio,
    Report, Sample, Sensitivity, Singular,
};
pub use stock::{
    Collision, CollisionKind, Solid, Stock, StockOptions, StockReport, UndecidedCollision, simulate,
};
pub use tools::{Changes, Tables, Tool, WorkOffset};
pub use track::{Track, track};
pub use turns::{Choice, Choices};
