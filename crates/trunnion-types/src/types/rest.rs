//! What stays unfinished.

use nalgebra::Point3;
use std::fmt;

/// A connected part of a face that no pass finishes.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Number of the face.
    pub face: usize,
    /// Ranges of u and v that together hold it; neighbours share edges.
    pub cells: Vec<[[f64; 2]; 2]>,
    /// Area of the face in it \[mm²\]: at most a little more than what is unfinished.
    pub area: f64,
    /// Ranges of u and v of all of it.
    pub uv: [[f64; 2]; 2],
    /// Lowest and highest corner of the box around it \[mm\].
    pub bounds: [Point3<f64>; 2],
    /// Height of what is left over the face where most is left, of the places looked at \[mm\]: the distance from
    /// the nearest place any pass brings the tool to.
    pub depth: f64,
    /// That place, as `[u, v]`.
    pub deepest: [f64; 2],
    /// The same as a point \[mm\].
    pub point: Point3<f64>,
    /// Radius of the largest ball that touches the face there and goes into no face of the part \[mm\]; infinite where
    /// one many times the cutter fits.
    pub ball: f64,
    /// The least and the largest such radius of all places looked at \[mm\].
    pub balls: [f64; 2],
    /// Why it is left, at that place.
    pub reason: RestReason,
}

/// Why the tool does not finish a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RestReason {
    /// The corner of the cutter would go into the face itself: it is hollow there.
    Hollow,
    /// The corner of the cutter would go into this face.
    Neighbour(usize),
    /// However the tool leans, its flank, shank or holder, or the underside within the corner, would go into this
    /// face.
    Tool(usize),
    /// The tool fits there, but only where the machine does not get to.
    Machine,
    /// The tool fits there, but no pass gets to it.
    Passes,
}

impl Rest {
    /// Whether a place of the face lies in it.
    pub fn holds(&self, uv: [f64; 2]) -> bool {
        let within =
            |range: &[[f64; 2]; 2]| (0..2).all(|k| (range[k][0]..=range[k][1]).contains(&uv[k]));
        within(&self.uv) && self.cells.iter().any(within)
    }
}

impl fmt::Display for RestReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hollow => f.write_str("the face is hollow there, for the corner of the cutter"),
            Self::Neighbour(face) => {
                write!(f, "the corner of the cutter would go into face {face}")
            }
            Self::Tool(face) => write!(
                f,
                "however it leans, the tool beside or above its corner would go into face {face}"
            ),
            Self::Machine => f.write_str(
                "the tool fits there only where the machine does not get to: turn the setup",
            ),
            Self::Passes => f.write_str("the tool fits there, but no pass gets to it"),
        }
    }
}
