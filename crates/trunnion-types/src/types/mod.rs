//! The vocabulary: plain data that stages hand on. Units: mm, rad, s.
//!
//! A path is described three times, each time closer to the machine:
//!
//! | data | made by | says |
//! |---|---|---|
//! | [`Pass`], [`Leg`] | `cover` | cutter locations, as computed |
//! | [`ToolPath`] | `toolpath` | smooth curves of tip, tool axis and contact through them |
//! | [`AxisPath`] | `axes` | the machine's axes along those curves, with exact derivatives |
//! | [`Schedule`] | `feed` | when each point of the axis path is passed |
//! | [`Block`] | `blocks` | what a program says |

mod diagnostic;
mod error_list;
mod interval;
mod motion;
mod path;
mod progress;
mod ramp;
mod rest;
mod timing;
mod tolerance;
mod uv;

pub use diagnostic::{Diagnostic, Diagnostics};
pub use error_list::ErrorList;
pub use interval::Interval;
pub use motion::{AxisNode, AxisPath, AxisPiece, Block, Law, Schedule, SchedulePiece, Setpoint};
pub use path::{
    Geometry, Leg, Motion, Pass, PoseCoordinates, PoseCurve, PoseRates, Span, Station, ToolPath,
    ToolPiece, ToolPose,
};
pub use progress::{Cancelled, Progress, Silent, Stage};
pub use ramp::Stretch;
pub use rest::{Rest, RestReason};
pub use timing::Moment;
pub use tolerance::PoseTolerance;
pub use uv::Uv;

/// Number of machine axes: three linear and two rotary.
pub const AXES: usize = 5;

/// Axis coordinates in the order X, Y, Z, then the rotaries in chain order \[mm, mm, mm, rad, rad\].
///
/// Rotary entries are *unwound*: 370° stays 370°, so that differences are travel.
pub type AxisVector = nalgebra::SVector<f64, AXES>;

/// A triangle mesh \[mm\].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub vertices: Vec<nalgebra::Point3<f64>>,
    /// Corners of each triangle as indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The same in other coordinates.
    #[must_use]
    pub fn moved(mut self, to_from: &nalgebra::Isometry3<f64>) -> Self {
        // The identity would still round.
        if *to_from != nalgebra::Isometry3::identity() {
            for vertex in &mut self.vertices {
                *vertex = to_from * *vertex;
            }
        }
        self
    }
}
