//! The strip that a pose leaves: the query and the result.

use crate::cutter::Cutter;
use crate::positioning::request::{StripSide, ToleranceBand};
use crate::positioning::surface_point::SurfacePoint;
use crate::surface::FaceIndex;
use crate::types::Uv;
use nalgebra::{Point3, Vector3};

/// Surface, cutter and tolerance band against which a pose is checked.
#[derive(Debug, Clone, Copy)]
pub struct CuttingContext<'a> {
    /// The surface.
    pub face: &'a FaceIndex,
    /// The cutter.
    pub cutter: &'a Cutter,
    /// Band in which the error has to lie.
    pub band: ToleranceBand,
}

/// Feed, side and contact for which the strip of a pose is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripQuery {
    /// Feed direction; its length does not count.
    pub feed: Vector3<f64>,
    /// Side of the feed on which the strip lies; it distinguishes the near end from the far one.
    pub strip: StripSide,
    /// Point near the middle of the strip \[mm\].
    pub contact: Point3<f64>,
    /// Parameters near it: where the search for its foot starts.
    pub uv: Uv,
}

/// The strip that a pose leaves: the connected part of the circle around the contact whose error
/// does not exceed the band.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct MeasuredStrip {
    /// Projection on the direction across the feed \[mm\]; 0 where the error is above the band
    /// everywhere.
    pub width: f64,
    /// End on the side where the strip begins.
    pub near: SurfacePoint,
    /// End on the strip's side.
    pub far: SurfacePoint,
    /// Largest error found between the ends \[mm\].
    pub front_max: f64,
    /// Upper bound on the error between the ends \[mm\].
    pub front_max_bound: f64,
    /// Least error found between the ends \[mm\]; below the band it is a gouge.
    pub front_min: f64,
    /// Least distance found from the rest of the circle and the disc to the surface \[mm\].
    pub rear_min: f64,
    /// Lower bound on the distance of circle and disc from the surface, strip included \[mm\].
    pub rear_min_bound: f64,
    /// Foot under the middle of the strip.
    pub contact: SurfacePoint,
    /// Closest-point queries spent.
    pub queries: u32,
}
