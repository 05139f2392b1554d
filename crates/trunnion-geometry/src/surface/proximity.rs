//! Proximity of a surface to a convex solid.

use nalgebra::{Point3, Vector3};

/// Signed distance of a point from a convex solid \[mm\], negative inside, and its gradient of unit
/// length.
///
/// The bounds of [`FaceIndex::meets`](super::FaceIndex::meets) rest on the convexity of this
/// function.
pub type SolidDistance<'a> = &'a dyn Fn(&Point3<f64>) -> (f64, Vector3<f64>);

/// Answer to the question if a surface comes nearer to a solid than a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SolidProximity {
    /// This point of the surface is nearer.
    Nearer(Point3<f64>),
    /// No point of the surface is nearer.
    Clear,
    /// The distance is too close to the limit for a bounded number of steps.
    Undecided,
}
