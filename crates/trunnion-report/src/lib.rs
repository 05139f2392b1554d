//! Results of trunnion as one self-contained HTML file.
//!
//! Fill a [`ReportData`]; its samples over time are gathered by a [`Recorder`].

mod data;
mod record;

pub use data::{
    Axis, AxisBands, Band, Budget, Check, Histogram, Motion, MotionKind, Number, PathPiece,
    PathPoint, ReportData, Share, State, Surface, WorstPlace,
};
pub use record::{Recorder, Sample};
