//! Fit of the arc of a barrel to the curvature of a face at the contact.

use crate::cutter::ContactArc;
use crate::positioning::distance::probe::DistanceReading;
use crate::positioning::error::PositioningError;
use nalgebra::Vector3;

/// Checks that a barrel lies on its side of a face all round the contact.
///
/// In the tangent plane the cutter bends by `1 / R` along the arc and by `1 / rho` across it; the face, by
/// `k_m`, `k_q` and `k_mq` towards the cutter. The gap between them is a quadratic form, which has to be positive: `a =
/// 1 / rho - k_q > 0` and `1 / R - k_m > k_mq^2 / a`.
///
/// `along` is the unit tangent in the plane of tool axis and normal; `inclination` the angle between these \[rad\].
///
/// # Errors
///
/// [`PositioningError::ConcaveArc`].
pub(crate) fn fits(
    arc: &ContactArc,
    touch: &DistanceReading,
    along: &Vector3<f64>,
    inclination: f64,
) -> Result<(), PositioningError> {
    let across = touch.normal().cross(along);
    let [k_m, k_q] = [*along, across].map(|direction| touch.normal_curvature(&direction));
    // II(d, d) = (k_m + k_q) / 2 + k_mq halfway between both directions.
    let k_mq = touch.normal_curvature(&(along + across)) - 0.5 * (k_m + k_q);
    let refused = |curvature: f64, radius: f64| {
        let uv = touch.foot.uv;
        Err(PositioningError::ConcaveArc { uv, concave: curvature.recip(), radius })
    };
    let thin = arc.radius_across(inclination);
    let gap = thin.recip() - k_q;
    if gap <= 0.0 {
        return refused(k_q, thin);
    }
    let bend = k_m + k_mq * k_mq / gap;
    if bend * arc.radius >= 1.0 { refused(bend, arc.radius) } else { Ok(()) }
}
