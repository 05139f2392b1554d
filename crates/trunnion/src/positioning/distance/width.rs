//! Width across the feed.

use crate::positioning::distance::probe::DistanceReading;
use nalgebra::Vector3;

/// Returns the distance across the feed between two ends of a strip, in the tangent plane of the first: the
/// second counts where its normal passes through that plane, as `P3` does over `P2`.
pub(crate) fn width_across(v: &Vector3<f64>, near: &DistanceReading, far: &DistanceReading) -> f64 {
    let up = near.normal();
    let out = far.foot.point - near.foot.point;
    // The ray P2 + s n2 meets the plane through P1 square to n1 at s = -(P2 - P1) . n1 / (n2 . n1).
    let lean = far.normal().dot(&up);
    // Normals at right angles pass through no such plane: the feet themselves count.
    let lift = if lean > 0.0 { -out.dot(&up) / lean } else { 0.0 };
    v.dot(&(out + far.normal().scale(lift)))
}
