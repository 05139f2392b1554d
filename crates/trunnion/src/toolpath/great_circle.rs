//! Great-circle interpolation between two tool axes.

use nalgebra::UnitVector3;

/// Angle between two directions \[rad\], in `[0, π]`.
///
/// `atan2(|u × v|, u · v)`: full relative accuracy near 0 and π, where `acos` loses half the digits.
fn angle(u: &UnitVector3<f64>, v: &UnitVector3<f64>) -> f64 {
    u.cross(v).norm().atan2(u.dot(v))
}

/// Direction on the great circle from `from` (`t` = 0) to `to` (`t` = 1); `None` for opposite
/// directions, whose plane is undefined. Equal directions are returned exactly.
///
/// Turns `from` in the plane of both: `cos(t θ) from + sin(t θ) e`, `e` the unit part of `to`
/// square to `from`. The form `[sin((1-t)θ) a + sin(tθ) b]/sin θ` of eq. (8) is the same but loses
/// digits towards θ = 0 and π.
///
/// # Source
///
/// Eq. (8) of `docs/sources.md#003`, with the missing `1/|v1 × v2|` and the angle by `atan2`.
///
/// # Example
///
/// ```
/// use nalgebra::Vector3;
/// use trunnion::toolpath::great_circle;
///
/// let half = great_circle(&Vector3::z_axis(), &Vector3::y_axis(), 0.5).unwrap();
/// assert!((half.y - half.z).abs() < 1e-15);
/// assert!(great_circle(&Vector3::z_axis(), &-Vector3::z_axis(), 0.5).is_none());
/// ```
pub fn great_circle(
    from: &UnitVector3<f64>,
    to: &UnitVector3<f64>,
    t: f64,
) -> Option<UnitVector3<f64>> {
    let normal = from.cross(to);
    let Some(normal) = UnitVector3::try_new(normal, 0.0) else {
        return (from.dot(to) > 0.0).then_some(*from);
    };
    let sideways = normal.cross(from);
    let (sin, cos) = (t * angle(from, to)).sin_cos();
    UnitVector3::try_new(from.scale(cos) + sideways.scale(sin), 0.0)
}

/// Angle between two tool axes \[rad\].
pub(super) fn turn(from: &UnitVector3<f64>, to: &UnitVector3<f64>) -> f64 {
    angle(from, to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn ends_are_the_given_directions() {
        let [a, b] = [Vector3::new(0.1, 0.2, 1.0), Vector3::new(-0.4, 0.0, 0.7)]
            .map(UnitVector3::new_normalize);
        assert!((great_circle(&a, &b, 0.0).unwrap().into_inner() - *a).norm() < 1e-15);
        assert!((great_circle(&a, &b, 1.0).unwrap().into_inner() - *b).norm() < 1e-15);
        assert_eq!(great_circle(&a, &a, 0.3), Some(a));
    }
}
