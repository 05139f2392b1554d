//! Results of trunnion as one self-contained HTML file.
//!
//! Fill a [`ReportData`], gather its samples over time with a [`Recorder`], and [`render`] it. The page
//! contains script, style and data, and loads nothing from anywhere.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

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
