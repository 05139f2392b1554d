//! One cutter location: the widest strip, and what gouges.
//!
//! At an end point `P1` the cutter is placed so that the error there is the upper end of the band;
//! the circle of the torus then passes over the strip to a second end point `P2`. [`widest_strip`] finds
//! the location whose strip is widest while the error on the strip stays in the band and nothing
//! else of the cutter comes closer than the band's lower end. [`with_lead`] does the same at a given
//! lead, for places where no wide strip fits. [`place`] is the one way in to these and to the methods
//! they are compared with. [`strip_of_pose`] looks at any pose, independently of how it was made.
//!
//! Frame at `P1`: `n` the normal on the cutter's side, `a` the feed, `v = a x n` (reversed for a
//! strip on the left). Angles: alpha from `v` towards `a`, theta about the chord; mm and rad.

mod ball;
mod body;
mod check;
mod circle;
mod constraints;
mod contact;
mod curve;
mod disc;
mod error;
mod gaps;
mod judge;
mod location;
mod method;
mod nested;
mod pair;
mod picture;
mod placement;
mod probe;
mod quadratic;
mod request;
mod solve;
mod starts;
mod swift;
mod widest;

pub use body::body_clear;
pub use check::CuttingContext;
pub use check::MeasuredStrip;
pub use check::StripQuery;
pub use check::strip_of_pose;
pub use curve::ErrorTrace;
pub use curve::TracePoint;
pub use curve::error_curve;
pub use curve::trace;
pub use error::PositioningError;
pub use method::PlacementMethod;
pub use method::place;
pub use nested::NestedGrid;
pub use picture::comparison_picture;
pub use picture::error_picture;
pub use request::ActiveConstraint;
pub use request::AxisCone;
pub use request::ContactSide;
pub use request::CutterLocation;
pub use request::LocationRequest;
pub use request::StripSide;
pub use request::ToleranceBand;
pub use request::ToolInclination;
pub use widest::widest_strip;
pub use widest::with_inclination;
pub use widest::with_lead;
