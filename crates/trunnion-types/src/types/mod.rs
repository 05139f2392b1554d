//! The vocabulary: plain data that stages hand on. Units: mm, rad, s.
//!
//! A path is described several times, each time closer to the machine:
//!
//! | data | made by | contents |
//! |---|---|---|
//! | [`Pass`], [`Leg`] | `cover` | cutter locations, as computed |
//! | [`ToolPath`] | `toolpath` | smooth curves of tip, tool axis and contact through them |
//! | [`AxisPath`] | `axes` | the machine's axes along those curves, with exact derivatives |
//! | [`Schedule`] | `feed` | the time at which each point of the axis path is passed |
//! | [`Block`] | `blocks` | the moves of a program |

mod axis_path;
mod diagnostic;
mod error_list;
mod linear_segment;
mod mesh;
mod path_state;
mod progress;
mod schedule;
mod setpoint;
mod tolerance;
mod tool_path;
mod uncut;
mod uv;
mod waypoints;

pub use crate::math::Interval;
pub use axis_path::{AXES, AxisNode, AxisPath, AxisPiece, AxisVector, Block, TRAVEL_ROUNDING};
pub use diagnostic::{Diagnostic, Diagnostics};
pub use error_list::ErrorList;
pub use linear_segment::LinearSegment;
pub use mesh::Mesh;
pub use path_state::PathState;
pub use progress::{Cancelled, Progress, Silent, Stage};
pub use schedule::{AccelerationProfile, Schedule, ScheduleError, SchedulePiece};
pub use setpoint::Setpoint;
pub use tolerance::{PoseDeviation, PoseTolerance};
pub use tool_path::{
    Leg, Motion, Pass, PieceGeometry, PoseCoordinates, PoseCurve, PoseRates, PoseSpan, Station,
    ToolPath, ToolPiece, ToolPose,
};
pub use uncut::{UncutReason, UncutRegion};
pub use uv::Uv;
pub use waypoints::WaypointError;
