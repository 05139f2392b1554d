//! One reading of a sphere, as plain data.

use crate::types::AxisVector;
use nalgebra::Vector3;

/// Quantity that a reading states about tip and sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReadingKind {
    /// The tip is at the centre of the sphere, but for a deviation that was read.
    Center {
        /// Tip less sphere centre, workpiece frame \[mm\].
        deviation: Vector3<f64>,
    },
    /// The tip is at a distance from the centre: a ball bar.
    Radius {
        /// The distance \[mm\].
        radius: f64,
    },
}

/// Reading at one position of the axes.
///
/// The tip is the centre of the ball of a touch probe, of the sphere of an R-test, or of the spindle ball of a ball bar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereReading {
    /// Position of the axes \[mm, rad\].
    pub q: AxisVector,
    /// Gauge point to tip \[mm\].
    pub tool_length: f64,
    /// Number of the sphere, which stands still on the workpiece side; counted from 0.
    pub sphere: usize,
    /// Quantity that was read.
    pub kind: ReadingKind,
}

impl SphereReading {
    /// Creates a reading with the tip at the centre of a sphere.
    pub fn center(q: AxisVector, tool_length: f64, sphere: usize) -> Self {
        let kind = ReadingKind::Center { deviation: Vector3::zeros() };
        Self { q, tool_length, sphere, kind }
    }

    /// Creates a reading of a ball bar of `radius` \[mm\] about the centre of a sphere.
    pub fn radius(q: AxisVector, tool_length: f64, sphere: usize, radius: f64) -> Self {
        Self { q, tool_length, sphere, kind: ReadingKind::Radius { radius } }
    }

    /// Returns the numbers that the reading states: a place has three, a distance one.
    pub fn numbers(&self) -> usize {
        match self.kind {
            ReadingKind::Center { .. } => 3,
            ReadingKind::Radius { .. } => 1,
        }
    }
}
