//! Report of a face that no cutter fits.

use nalgebra::Point3;

/// Face that is more concave than every cutter that cuts it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TooConcave {
    /// Number of the face.
    pub face: usize,
    /// Share of it that is too concave.
    pub share: f64,
    /// Smallest concave radius there \[mm\].
    pub radius: f64,
    /// Place of that radius \[mm\].
    pub point: Point3<f64>,
    /// Smallest radius with which the cutters touch \[mm\]: of a corner, or of the large arc of a barrel.
    pub corner: f64,
    /// Name of that arc.
    pub arc: &'static str,
}

impl std::error::Error for TooConcave {}

impl std::fmt::Display for TooConcave {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { face, share, radius, point, corner, arc } = self;
        write!(
            f,
            "face {face}: {:.0} % of it is more concave than the cutter, whose {arc} has a radius of {corner} mm: down to \
             {radius:.3} mm, at X {:.3} Y {:.3} Z {:.3}, where the tool would gouge on either side",
            100.0 * share,
            point.x,
            point.y,
            point.z
        )
    }
}
