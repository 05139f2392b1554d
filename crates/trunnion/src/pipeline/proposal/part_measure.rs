//! Measures of a part.

use crate::import::inspect;
use crate::surface::FaceIndex;
use nalgebra::{Point3, Vector3};

/// Largest diameter, as a share of the second largest extent of the part: a larger cutter finishes it in a pass or
/// two, but hangs over its edges.
pub(super) const LARGEST: f64 = 0.5;

/// Distance of a wall from the bottom of the part, below which it stands where the part is held, as a share of the
/// part's height.
pub(super) const HELD: f64 = 0.01;

/// Box around a part.
pub(super) struct PartMeasure {
    low: Point3<f64>,
    high: Point3<f64>,
}

impl PartMeasure {
    pub(super) fn new(faces: &[FaceIndex]) -> Self {
        let boxes = faces.iter().map(|face| inspect::summary(face.face()).bounds);
        let [low, high] = boxes
            .reduce(|[a, b], [low, high]| [a.inf(&low), b.sup(&high)])
            .unwrap_or([Point3::origin(); 2]);
        Self { low, high }
    }

    pub(super) fn size(&self) -> Vector3<f64> {
        self.high - self.low
    }

    /// Middle of the bottom.
    pub(super) fn foot(&self) -> Point3<f64> {
        let middle = nalgebra::center(&self.low, &self.high);
        Point3::new(middle.x, middle.y, self.low.z)
    }

    /// Returns the height of the highest point \[mm\].
    pub(super) fn highest(&self) -> f64 {
        self.high.z
    }

    /// Returns `true` if a face whose lowest point has this height goes down to where the part is held.
    pub(super) fn holds_at(&self, height: f64) -> bool {
        height - self.low.z <= HELD * self.size().z
    }

    /// Height of links above the part \[mm\].
    pub(super) fn clearance(&self) -> f64 {
        (0.5 * self.size().z).clamp(10.0, 50.0).round()
    }

    /// Largest diameter of a cutter for the part \[mm\].
    pub(super) fn largest_diameter(&self) -> f64 {
        let mut extents: [f64; 3] = self.size().into();
        extents.sort_by(f64::total_cmp);
        LARGEST * extents[1]
    }
}
