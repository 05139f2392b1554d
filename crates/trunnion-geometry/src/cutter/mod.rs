//! Cutters as profiles of revolution about the tool axis: flat, ball, bull nose, taper, barrel and lens.
//!
//! The tip of all is one shape: a circle of radius `R` (major) swept by a circle of radius `r` (minor).
//! A flat cutter has `r = 0`, a ball `R = 0`. The centre circle lies `r` above the tip. Tapered cutters go on with a
//! cone, barrels with an arc of larger radius, and a lens, whose tip arc is the large one, with its corner: see
//! [`TangentProfile`].
//! Coordinates of the profile are `[rho, z]`: distance from the axis, height above the tip \[mm\].
//!
//! # Example
//!
//! ```
//! use trunnion_geometry::cutter::{Cutter, CutterSpec};
//!
//! // A bull-nose end mill, diameter 32 mm with a corner radius of 6 mm, 90 mm long.
//! let cutter = Cutter::new(CutterSpec { length: 90.0, ..CutterSpec::bull(10.0, 6.0) })?;
//! assert_eq!(cutter.radius(), 16.0);
//! assert_eq!(cutter.cutting_height(), 6.0);
//! # Ok::<(), trunnion_geometry::cutter::CutterErrors>(())
//! ```

mod contact_arc;
mod error;
mod profile;
mod solid;
mod spec;
mod tangent;
mod validated;

pub use contact_arc::ContactArc;
pub use error::{CutterError, CutterErrors};
pub use profile::ProfilePiece;
pub use solid::{ConvexSolid, SignedDistance, ToolBody};
pub use spec::{CutterConstruction, CutterKind, CutterSide, CutterSpec};
pub use tangent::{ProfileDistance, TangentProfile};
pub use validated::Cutter;
