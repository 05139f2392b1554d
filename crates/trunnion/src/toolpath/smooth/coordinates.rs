//! Parts of the nine coordinates of a pose: tip, tool axis, contact.

use crate::types::PoseCoordinates;
use nalgebra::Vector3;

/// Returns the tool-axis vector of a row of coordinates.
pub(super) fn axis(row: &PoseCoordinates) -> Vector3<f64> {
    Vector3::new(row[3], row[4], row[5])
}

/// Returns the tip of a row of coordinates \[mm\].
pub(super) fn tip(row: &PoseCoordinates) -> Vector3<f64> {
    Vector3::new(row[0], row[1], row[2])
}

/// Returns the contact point of a row of coordinates \[mm\].
pub(super) fn contact(row: &PoseCoordinates) -> Vector3<f64> {
    Vector3::new(row[6], row[7], row[8])
}
