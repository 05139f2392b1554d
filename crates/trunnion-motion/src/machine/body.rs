//! Rigid parts of a machine that move with the links of its chain.

use crate::types::Mesh;
use nalgebra::{Isometry3, Point3};
use std::sync::Arc;

/// Part of a machine: table, slide, column or head.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineBody {
    /// Name in findings.
    pub name: String,
    /// Link that it moves with: an axis of the chain, `w`, `b` or `t`.
    pub link: String,
    /// Shape in the machine frame with all axes at zero.
    pub shape: BodyShape,
    /// Names of bodies that it may touch: a slide on its ways.
    pub touches: Vec<String>,
}

/// Shape of a body, in the machine frame with all axes at zero.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyShape {
    /// Box parallel to the machine frame.
    Box {
        /// Corner with the smallest coordinates \[mm\].
        min: Point3<f64>,
        /// Corner with the largest coordinates \[mm\].
        max: Point3<f64>,
    },
    /// Cylinder.
    Cylinder {
        /// Centre of the end from which it rises \[mm\].
        base: Point3<f64>,
        /// Direction in which it rises, of any length but zero.
        axis: [f64; 3],
        /// Radius \[mm\].
        radius: f64,
        /// Height \[mm\].
        height: f64,
    },
    /// Solid in a file that was not read yet.
    File {
        /// STL file in mm, or STEP file, as written in the machine file.
        file: String,
        /// The machine frame from the coordinates of the file.
        place: Isometry3<f64>,
        /// Largest distance of the triangles of a STEP solid from its faces \[mm\].
        chord: f64,
    },
    /// Interior of a closed mesh.
    Mesh {
        /// Triangles in the coordinates of the file they are from \[mm\].
        mesh: Arc<Mesh>,
        /// The machine frame from the coordinates of the triangles.
        place: Isometry3<f64>,
        /// Distance by which the real body may stand out beyond them \[mm\].
        allowance: f64,
    },
}

impl BodyShape {
    /// Returns the key and the defect of a shape without volume.
    pub(super) fn fault(&self) -> Option<(&'static str, &'static str)> {
        match self {
            Self::Box { min, max } => {
                (!(0..3).all(|k| min[k] < max[k])).then_some(("max", "the box is empty"))
            }
            Self::Cylinder { axis, radius, height, .. } => {
                let thin = !(*radius > 0.0 && *height > 0.0);
                let flat = !axis.iter().any(|x| x.abs() > 0.0);
                if thin {
                    Some(("radius", "radius and height must be above 0"))
                } else {
                    flat.then_some(("axis", "the axis has no direction"))
                }
            }
            Self::File { .. } | Self::Mesh { .. } => None,
        }
    }
}
