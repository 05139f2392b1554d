//! Smooth curves through cutter locations; knows no surface and no machine.
//!
//! [`through`] turns the [`Leg`](crate::types::Leg)s of a job into a [`ToolPath`](crate::types::ToolPath): a C2 cubic spline of tip, tool axis
//! and contact point through every station of a cutting leg, straight leads with a fixed axis,
//! and links of which only the ends are prescribed. [`smooth`] lays a C3 path within tolerance of cutter
//! locations, somebody else's among them, in one pass over any number of them ([`PathSmoother`]);
//! [`smoothed`] does so with the cutting legs of a job. [`great_circle`] interpolates a tool axis alone.

mod densify;
mod deviation;
mod error;
mod interpolation;
mod options;
mod smooth;
mod smoothed;
mod through;

pub use crate::math::angle::great_circle;
pub use densify::{PathResolution, densify};
pub use deviation::{ChordDeviation, deviation};
pub use error::ToolPathError;
pub use interpolation::{GreatCircle, InterpolationError, local_cubic};
pub use options::ToolPathOptions;
pub use smooth::{
    PathDeviation, PathSmoother, SAME, SmoothError, SmoothOptions, SmoothReference, SmoothReport,
    SmoothSpan, SmoothedCurves, smooth,
};
pub use smoothed::{SmoothedPath, smoothed};
pub use through::through;
