//! The strip a pose leaves: question and answer.

use crate::cutter::Cutter;
use crate::positioning::request::{StripSide, ToleranceBand};
use crate::surface::FaceIndex;
use nalgebra::{Point3, Vector3};

/// What a pose is checked against.
#[derive(Debug, Clone, Copy)]
pub struct CuttingContext<'a> {
    /// The surface.
    pub face: &'a FaceIndex,
    /// The cutter.
    pub cutter: &'a Cutter,
    /// Where the error has to lie.
    pub band: ToleranceBand,
}

/// Where on the cutter the strip is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StripQuery {
    /// Feed direction \[any length\].
    pub feed: Vector3<f64>,
    /// Side of the feed on which the strip lies: tells the near end from the far one.
    pub strip: StripSide,
    /// About where the strip's middle lies \[mm\].
    pub contact: Point3<f64>,
    /// About its parameters.
    pub uv: [f64; 2],
}

/// The strip a pose leaves: the connected part of the circle around the contact whose error does
/// not exceed the band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeasuredStrip {
    /// Projection on the direction across the feed \[mm\]; 0 where the error is above the band
    /// everywhere.
    pub width: f64,
    /// Parameters and point of the end on the side the strip begins.
    pub near: ([f64; 2], Point3<f64>),
    /// Parameters and point of the end on the strip's side.
    pub far: ([f64; 2], Point3<f64>),
    /// Largest error found between the ends \[mm\].
    pub front_max: f64,
    /// What no error between the ends exceeds \[mm\].
    pub front_max_bound: f64,
    /// Least error found between the ends \[mm\]; below the band it is a gouge.
    pub front_min: f64,
    /// Least distance found from the rest of the circle and the disc to the surface \[mm\].
    pub rear_min: f64,
    /// What the distance of circle and disc is at least, strip included \[mm\].
    pub rear_min_bound: f64,
    /// Foot under the middle of the strip: parameters and point.
    pub contact: ([f64; 2], Point3<f64>),
    /// Closest-point queries spent.
    pub queries: u32,
}
