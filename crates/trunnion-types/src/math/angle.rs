//! Angles and great circles.

use crate::math;
use nalgebra::UnitVector3;
use std::f64::consts::{PI, TAU};

/// Returns the angle between two directions \[rad\], in `[0, π]`.
///
/// `2 atan2(|u - v|, |u + v|)`: full relative accuracy near 0 and π, where `acos` loses half of the
/// digits and the cross product all those below 1e-16 rad (Kahan, *Miscalculating Area and Angles of a
/// Needle-like Triangle*, §13).
pub fn angle_between(u: &UnitVector3<f64>, v: &UnitVector3<f64>) -> f64 {
    let (u, v) = (u.as_ref(), v.as_ref());
    2.0 * math::atan2((u - v).norm(), (u + v).norm())
}

/// Returns the point at `t` of the great circle from `u` (`t` = 0) to `v` (`t` = 1), at constant angular
/// speed; `None` for opposite vectors, whose plane is undefined.
pub fn great_circle(
    u: &UnitVector3<f64>,
    v: &UnitVector3<f64>,
    t: f64,
) -> Option<UnitVector3<f64>> {
    // Without a normal both are parallel: equal, or opposite.
    let Some(normal) = UnitVector3::try_new(u.cross(v), 0.0) else {
        return (u.dot(v) > 0.0).then_some(*u);
    };
    let turned = math::rotation_about(&normal, t * angle_between(u, v)) * u;
    Some(UnitVector3::new_normalize(*turned))
}

/// Returns `angle` plus the whole turns that bring it within half a turn of `near` \[rad\].
#[inline]
pub fn unwrap_near(angle: f64, near: f64) -> f64 {
    // The usual case: no division, and no rounding.
    if (near - angle).abs() < PI {
        return angle;
    }
    angle + TAU * ((near - angle) / TAU).round()
}

/// Returns `angle` plus the whole turns that bring it into `[-π, π)` \[rad\].
pub fn wrap(angle: f64) -> f64 {
    angle - TAU * (angle / TAU + 0.5).floor()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn small_angles_keep_their_digits() {
        let u = Vector3::z_axis();
        let v = UnitVector3::new_normalize(Vector3::new(1e-9, 0.0, 1.0));
        assert!((angle_between(&u, &v) - 1e-9).abs() < 1e-24);
        let back = UnitVector3::new_normalize(Vector3::new(1e-9, 0.0, -1.0));
        assert!((angle_between(&u, &back) - (PI - 1e-9)).abs() < 1e-15);
    }

    /// A difference of whole units in the last place is exact; the products of a cross product are rounded to
    /// as much as is left of them.
    #[test]
    fn angles_next_to_rounding_keep_their_digits() {
        let u = Vector3::new(0.6, 0.0, 0.8);
        let small = 2.0_f64.powi(-45);
        let v = u + Vector3::new(-4.0, 0.0, 3.0) * small;
        let [u, v] = [u, v].map(UnitVector3::new_unchecked);
        assert!((angle_between(&u, &v) / (5.0 * small) - 1.0).abs() < 1e-12);
        assert!((PI - angle_between(&u, &-v) - 5.0 * small).abs() < 1e-15);
    }

    #[test]
    fn the_middle_of_a_quarter_turn_is_the_diagonal() {
        let middle = great_circle(&Vector3::x_axis(), &Vector3::y_axis(), 0.5);
        let diagonal = UnitVector3::new_normalize(Vector3::new(1.0, 1.0, 0.0));
        assert!(middle.is_some_and(|middle| angle_between(&middle, &diagonal) < 1e-15));
        assert_eq!(great_circle(&Vector3::x_axis(), &-Vector3::x_axis(), 0.5), None);
        let still = great_circle(&Vector3::x_axis(), &Vector3::x_axis(), 0.5);
        assert_eq!(still, Some(Vector3::x_axis()));
    }

    #[test]
    fn unwinding_keeps_to_the_nearest_turn() {
        assert!((unwrap_near(0.1, 4.0 * PI) - (4.0 * PI + 0.1)).abs() < 1e-14);
        assert!((unwrap_near(-FRAC_PI_2, 3.0) - 1.5 * PI).abs() < 1e-15);
        assert!((wrap(PI) + PI).abs() < 1e-15);
        assert!((wrap(-7.0) - (TAU - 7.0)).abs() < 1e-15);
    }
}
