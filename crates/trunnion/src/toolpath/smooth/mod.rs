//! A C3 path within tolerance of a polyline of cutter locations, in one pass over it.

mod bezier;
mod bound;
mod coordinates;
mod error;
mod fit;
mod knots;
mod normal_equations;
mod options;
mod report;
mod smoother;
mod span;
mod span_run;
mod whole;

pub use error::SmoothError;
pub use options::{SmoothOptions, SmoothReference};
pub use report::{PathDeviation, SmoothReport};
pub use smoother::{PathSmoother, SAME};
pub use span::SmoothSpan;
pub use whole::{SmoothedCurves, smooth};
