//! One cutter location: the widest strip, and the check for gouges.
//!
//! At an end point `P1` the cutter is placed so that the error there is the upper end of the band.
//! The circle of the torus then passes over the strip to a second end point `P2`. [`widest_strip`]
//! finds the location whose strip is widest while the error on the strip stays in the band and
//! nothing else of the cutter comes closer than the band's lower end. [`with_lead`] and
//! [`with_inclination`] do the same at a given inclination, for points where no wide strip fits.
//!
//! [`place`] runs these and the methods they are compared with. [`strip_of_pose`] measures the strip
//! of any pose, independently of how the pose was made.
//!
//! Frame at `P1`: `n` the normal on the cutter's side, `a` the feed, `v = a x n` (reversed for a
//! strip on the left). Angles: alpha from `v` towards `a`, theta about the chord; mm and rad.
//!
//! Files, bottom to top: [`request`](LocationRequest), [`location`](CutterLocation) and
//! [`strip`](MeasuredStrip) are the data. `distance` reads signed distances of cutter points and
//! bounds them between samples, `solve` climbs to a local optimum, `check` measures and accepts
//! poses, `methods` combines them, `report` traces and draws error curves.

mod active;
mod check;
mod distance;
mod error;
mod location;
mod methods;
mod report;
mod request;
mod solve;
mod strip;
mod surface_point;

pub use active::ActiveConstraint;
pub use check::body::body_clear;
pub use check::strip_of_pose::strip_of_pose;
pub use distance::curve::{ErrorCurvePoint, error_curve};
pub use error::PositioningError;
pub use location::CutterLocation;
pub use methods::method::{PlacementMethod, place};
pub use methods::nested::NestedGrid;
pub use methods::widest::{widest_strip, with_inclination, with_lead};
pub(crate) use methods::widest::{widest_strip_counted, with_inclination_counted};
pub use report::picture::{comparison_picture, error_picture};
pub use report::trace::{ErrorTrace, TracePoint, trace};
pub use request::{
    AxisCone, ContactSide, LocationRequest, StripSide, ToleranceBand, ToolInclination,
};
pub use strip::{CuttingContext, MeasuredStrip, StripQuery};
pub use surface_point::SurfacePoint;
