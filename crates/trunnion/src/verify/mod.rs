//! Checks programs: replays them as the control would, measures them against the surface, audits the axes.
//!
//! The checker shares only surface, cutter, machine and `nc::read` with the planners and never calls their inverse
//! kinematics (`replay::orient` has its own), so that a planner's mistake cannot hide in the checker.
//!
//! [`Inspection`] runs every check in one call; see its example. [`check`] is the part about faces and axes,
//! [`simulate`] cuts stock, [`clearance`] watches fixtures, and [`MotionAudit`] audits a table of setpoints.
//!
//! [`check`] runs a [program](crate::nc::read::ProgramSource) from the machine's home position. Without
//! tool-centre-point control (TCP) all axes are linear in a block; with it the tip (table frame, see
//! [`nc`](crate::nc)) and the rotaries are. For every point `p` of a grid over the faces it finds the lowest `s` at which
//! the normal `p + s n` meets the tool in any pose of any cut: below 0 a gouge, above 0 excess. This is a minimum over
//! continuous time to a stated tolerance, not over sampled poses (`docs/sources.md`, verification).
//!
//! Rapids are checked for gouges, with all axes together and with each axis at its own speed. The material that a rapid
//! cuts does not count as finished. A tool that meets the normal only below `p` is behind a wall thinner than the search
//! range, and gouges, if anything, the face on the other side of the wall.
//!
//! Moves are streamed in chunks. Memory is that of the measured points and of the program's source; use
//! [`ProgramText`](crate::nc::read::ProgramText) for a long one.

mod assumed_error;
mod axes;
mod broken_regions;
mod check;
mod clash;
mod deviation;
mod error;
mod fast_block;
mod finding_kind;
mod findings;
mod fixture;
mod input;
mod inspect;
mod line_stats;
mod options;
mod replay;
mod report;
mod setpoints;
mod state;
mod stock;
mod swept;

pub use assumed_error::AssumedError;
pub use check::check;
pub(crate) use clash::watch::StandingBodies;
pub use clash::{BodyApproach, BodyMeeting, BodyReport, MachineBodies};
pub use deviation::side::{FacesFromBehind, behind};
pub use error::{VerifyError, VerifyRemedy};
pub use fast_block::FastBlock;
pub use finding_kind::FindingKind;
pub use fixture::{
    ClearanceOptions, ClearanceReport, DEPTH_SHARE, Fixture, FixtureApproach, clearance,
};
pub use input::CheckInput;
pub use inspect::{CutStock, FeedMeaning, Inspection, InspectionReport, OtherFaces};
pub use line_stats::LineCount;
pub use options::{BoundMargins, BoundOptions, CheckOptions, DeviationTolerance, LEAST_GOUGE};
pub use replay::{
    Changes, Choice, Choices, ReplayedBlock, ReplayedCourse, ReplayedSpeed, Tables, TimedPose,
    TimelineOptions, TimelinePoint, Tool, Track, WorkOffset, offset_name, offset_short_name,
    replay_blocks, timeline, track,
};
pub use report::{
    Audit, AuditedMotion, AxisAudit, AxisRatio, Deviation, ExtremeHeight, FaceMap, Finding,
    HeightBounds, HeightSample, HistogramBin, LimitRatio, ModelAudit, Report, Sensitivity,
    ShortBlocks, SingularPassages, SlowBlocks, TravelOverrun, UnendedCut,
};
pub use setpoints::{
    AxisMotion, MotionAudit, MotionError, MotionFinding, MotionOptions, MotionReport, MotionRow,
    RowRatio, Unevenness,
};
pub use state::{
    ActiveSmoothing, AffectedCuts, CoolantDemand, PlannedCuts, StateFinding, StateReport,
};
pub use stock::{
    Collision, CollisionKind, Solid, Stock, StockBrick, StockChanges, StockOptions, StockReport,
    TimedStock, TimedStockOptions, UndecidedCollision, simulate,
};
