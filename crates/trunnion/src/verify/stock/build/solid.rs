//! Solids from which stock and fixtures are made.

use crate::types::Mesh;
use nalgebra::{Point3, Vector3};

/// A solid, workpiece frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// A box parallel to the axes: lowest and highest corner \[mm\].
    Box {
        /// Lowest corner.
        low: Point3<f64>,
        /// Highest corner.
        high: Point3<f64>,
    },
    /// An upright cylinder \[mm\].
    Cylinder {
        /// Centre of the lower end.
        base: Point3<f64>,
        /// Radius.
        radius: f64,
        /// Height.
        height: f64,
    },
    /// What closed meshes enclose; which way their triangles turn does not matter.
    Mesh(Mesh),
}

/// Rays along the longest side where nothing is said.
const USUAL_RAYS: f64 = 400.0;

impl Solid {
    /// Distance of rays where nothing is said \[mm\]: its longest side has 400.
    pub fn usual_cell(&self) -> f64 {
        self.bounds().map_or(1.0, |[low, high]| (high - low).amax()) / USUAL_RAYS
    }

    /// Lowest and highest corner of its box; `None` for a mesh without a triangle.
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
