//! Sharp corners between faces.

use crate::cover::place::tool_fit::ContactPoint;
use crate::cover::prove::part_faces::KeepOff;
use nalgebra::{UnitVector3, Vector3};

/// Least sine of the slope of a face against the other one, from which they form a corner.
const SHARP: f64 = 0.03;

/// Point of a border at which a face rises from another one.
pub(crate) struct SharpCorner {
    /// Direction from the edge into the face, of unit length.
    pub(crate) inward: Vector3<f64>,
    /// Normal of the other face.
    pub(crate) other: UnitVector3<f64>,
}

impl SharpCorner {
    /// Finds the corner at a point on the border of the face that is cut, with another face within a distance \[mm\]; `None`
    /// for an edge that is free, bulges, or goes over smoothly.
    pub(crate) fn find(keep_off: &KeepOff<'_>, contact: &ContactPoint, near: f64) -> Option<Self> {
        // Step 1: square to the edge that both share, this face goes up or down along the normal of the other.
        let other = keep_off.neighbour_normal(&contact.point, near)?;
        let rise = other.into_inner() - contact.normal.scale(contact.normal.dot(&other));
        let inward = rise.try_normalize(SHARP)?;
        // Step 2: it goes up.
        let face = keep_off.own_face()?;
        let foot = face.closest(&(contact.point + inward * near)).ok()?;
        let is_inside = face.face().contains(foot.uv.u, foot.uv.v);
        is_inside.then_some(Self { inward, other })
    }
}
