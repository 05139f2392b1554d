//! Regions of a face that no pass finishes.

use super::uv::Uv;
use crate::math::Interval;
use nalgebra::Point3;
use std::fmt;

/// A connected part of a face that no pass finishes.
#[derive(Debug, Clone, PartialEq)]
pub struct UncutRegion {
    /// Number of the face.
    pub face: usize,
    /// Ranges of u and v that together cover the region; neighbours share edges.
    pub cells: Vec<[Interval; 2]>,
    /// Area of the cells \[mm²\]: at most a little more than the unfinished area.
    pub area: f64,
    /// Ranges of u and v of the whole region.
    pub uv: [Interval; 2],
    /// Lowest and highest corner of the bounding box \[mm\].
    pub bounds: [Point3<f64>; 2],
    /// Largest height of uncut material over the face among the sampled points \[mm\]: the distance to the
    /// nearest point that any pass brings the tool to.
    pub depth: f64,
    /// Parameters of that point.
    pub deepest: Uv,
    /// That point \[mm\].
    pub point: Point3<f64>,
    /// Radius of the largest ball that touches the face there and enters no face of the part \[mm\]; infinite if
    /// a ball many times the size of the cutter fits.
    pub ball: f64,
    /// Smallest and largest such radius of all sampled points \[mm\].
    pub balls: Interval,
    /// Reason at that point.
    pub reason: UncutReason,
}

/// Reason why the tool does not finish a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum UncutReason {
    /// The corner of the cutter would gouge the face itself: it is concave there.
    Hollow,
    /// The corner of the cutter would gouge this face.
    Neighbour(usize),
    /// At every inclination, the flank, shank or holder of the tool, or its underside within the corner, would
    /// gouge this face.
    Tool(usize),
    /// The tool fits there, but only in poses that the machine does not reach.
    Machine,
    /// The tool fits there, but no pass gets there.
    Passes,
}

impl UncutRegion {
    /// Returns `true` if the point at `uv` lies in the region.
    pub fn holds(&self, uv: Uv) -> bool {
        let within = |[u, v]: &[Interval; 2]| u.contains(uv.u) && v.contains(uv.v);
        // Cells are searched only where the ranges of the whole region hold the point.
        within(&self.uv) && self.cells.iter().any(within)
    }
}

impl fmt::Display for UncutReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hollow => {
                f.write_str("the face is too concave there for the corner of the cutter")
            }
            Self::Neighbour(face) => {
                write!(f, "the corner of the cutter would gouge face {face}")
            }
            Self::Tool(face) => write!(
                f,
                "at every inclination the tool beside or above its corner would gouge face {face}"
            ),
            Self::Machine => f.write_str(
                "the tool fits there only in poses that the machine does not reach: turn the setup",
            ),
            Self::Passes => f.write_str("the tool fits there, but no pass gets there"),
        }
    }
}
