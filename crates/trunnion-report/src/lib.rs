//! Results of trunnion as one self-contained HTML file.
//!
//! Fill a [`ReportData`]; its samples over time are gathered by a [`Recorder`]; [`render`] it.
//! The page loads nothing from anywhere: script, style and data stand in it.

mod data;
mod page;
mod payload;
mod picture;
mod record;
mod thin;

pub use data::{
    Axis, AxisBands, Band, Budget, Check, Histogram, Motion, MotionKind, Number, PathPiece,
    PathPoint, ReportData, Share, Solid, State, Surface, SurfacePoint, WorstPlace,
};
pub use page::{ReportError, render};
pub use record::{Recorder, Sample};
