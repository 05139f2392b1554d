//! Solids from which stock and fixtures are made.

use crate::types::Mesh;
use nalgebra::{Point3, Vector3};

/// Solid in the workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// Axis-parallel box \[mm\].
    Box {
        /// Lowest corner.
        low: Point3<f64>,
        /// Highest corner.
        high: Point3<f64>,
    },
    /// Upright cylinder \[mm\].
    Cylinder {
        /// Centre of the lower end.
        base: Point3<f64>,
        /// Radius.
        radius: f64,
        /// Height.
        height: f64,
    },
    /// Interior of closed meshes; the orientation of their triangles does not matter.
    Mesh(Mesh),
}

/// Default number of rays along the longest side.
const USUAL_RAYS: f64 = 400.0;

impl Solid {
    /// Returns the default ray spacing \[mm\]: a 400th of the longest side.
    ///
    /// # Example
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use trunnion::verify::Solid;
    ///
    /// let solid = Solid::Cylinder { base: Point3::origin(), radius: 40.0, height: 20.0 };
    /// assert_eq!(solid.usual_cell(), 0.2); // 80 mm / 400
    /// ```
    pub fn usual_cell(&self) -> f64 {
        self.bounds().map_or(1.0, |[low, high]| (high - low).amax()) / USUAL_RAYS
    }

    /// Returns the lowest and the highest corner of its box; `None` for a mesh without a triangle.
    pub fn bounds(&self) -> Option<[Point3<f64>; 2]> {
        match self {
            Self::Box { low, high } => Some([*low, *high]),
            Self::Cylinder { base, radius, height } => {
                let side = Vector3::new(*radius, *radius, 0.0);
                Some([base - side, base + side + Vector3::z() * *height])
            }
            Self::Mesh(mesh) => {
                let corners = mesh.triangles.iter().flatten();
                let mut points = corners.filter_map(|&corner| mesh.vertices.get(corner as usize));
                let first = *points.next()?;
                Some(points.fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]))
            }
        }
    }
}
