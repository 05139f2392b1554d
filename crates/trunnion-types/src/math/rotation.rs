//! Rotations by angles, with the functions of [`elementary`](super::sin): the same bits on every machine.

use super::elementary::{acos, asin, atan2, cos, sin_cos};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, UnitVector3, Vector3};
use std::f64::consts::FRAC_PI_2;

/// Length of the sum of two directions below which rounding alone decides where it points: some units in the last place of 1.
const OPPOSITE: f64 = 1e-15;

/// Distance from a whole number below which an entry of a rotation by stated angles is that number: sines and cosines of
/// three angles, each off by their rounding.
const SQUARE: f64 = 1e-15;

/// Returns the rotation about an axis by an angle \[rad\] (Rodrigues).
#[must_use]
pub fn rotation_about(axis: &UnitVector3<f64>, angle: f64) -> Rotation3<f64> {
    if angle == 0.0 {
        return Rotation3::identity();
    }
    let (sin, cos) = sin_cos(angle);
    let n = axis.as_ref();
    let along = n.map(|x| x * x);
    let [xy, xz, yz] = [n.x * n.y, n.x * n.z, n.y * n.z].map(|product| product * (1.0 - cos));
    let [x, y, z] = [n.x, n.y, n.z].map(|x| x * sin);
    let [xx, yy, zz] = [along.x, along.y, along.z].map(|x| x + (1.0 - x) * cos);
    Rotation3::from_matrix_unchecked(Matrix3::new(
        xx,
        xy - z,
        xz + y,
        xy + z,
        yy,
        yz - x,
        xz - y,
        yz + x,
        zz,
    ))
}

/// Returns the rotation about an axis by an angle \[rad\] as a quaternion.
#[must_use]
pub fn quaternion_about(axis: &UnitVector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    let (sin, cos) = sin_cos(angle / 2.0);
    UnitQuaternion::new_unchecked(Quaternion::from_parts(cos, axis.as_ref() * sin))
}

/// Returns the rotation about the fixed x axis, then y, then z, by angles \[rad\].
#[must_use]
pub fn rotation_of_xyz(angles: Vector3<f64>) -> Rotation3<f64> {
    let [(sx, cx), (sy, cy), (sz, cz)] = [angles.x, angles.y, angles.z].map(sin_cos);
    Rotation3::from_matrix_unchecked(Matrix3::new(
        cz * cy,
        cz * sy * sx - sz * cx,
        cz * sy * cx + sz * sx,
        sz * cy,
        sz * sy * sx + cz * cx,
        sz * sy * cx - cz * sx,
        -sy,
        cy * sx,
        cy * cx,
    ))
}

/// Returns the rotation about the fixed x axis, then y, then z, by angles \[rad\]. Entries that are a whole number but for
/// rounding are exact: a quarter turn leaves level planes level.
#[must_use]
pub fn exact_rotation_of_xyz(angles: Vector3<f64>) -> Rotation3<f64> {
    let exact =
        |entry: f64| if (entry - entry.round()).abs() < SQUARE { entry.round() } else { entry };
    Rotation3::from_matrix_unchecked(rotation_of_xyz(angles).matrix().map(exact))
}

/// Returns angles about the fixed x, y and z axes \[rad\] whose rotation this is. Where y stands at a quarter turn, x or z
/// alone says all, and z is 0.
#[must_use]
pub fn xyz_of_rotation(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let sine = -m[(2, 0)];
    if sine.abs() < 1.0 {
        let y = asin(sine);
        let cosine = cos(y);
        let x = atan2(m[(2, 1)] / cosine, m[(2, 2)] / cosine);
        let z = atan2(m[(1, 0)] / cosine, m[(0, 0)] / cosine);
        return Vector3::new(x, y, z);
    }
    let x = if sine > 0.0 { atan2(m[(0, 1)], m[(0, 2)]) } else { atan2(-m[(0, 1)], -m[(0, 2)]) };
    Vector3::new(x, FRAC_PI_2.copysign(sine), 0.0)
}

/// Returns the angle of a rotation \[rad\], in `[0, π]`.
#[must_use]
pub fn angle_of(rotation: &UnitQuaternion<f64>) -> f64 {
    let quaternion = rotation.quaternion();
    2.0 * atan2(quaternion.imag().norm(), quaternion.w.abs())
}

/// Returns the angle between two rotations \[rad\], in `[0, π]`.
#[must_use]
pub fn angle_apart(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    // The trace of a rotation is 1 + 2 cos(angle); that of a^T b is the sum of all products.
    let trace = a.matrix().dot(b.matrix());
    acos((0.5 * (trace - 1.0)).clamp(-1.0, 1.0))
}

/// Returns the angle between two vectors \[rad\], in `[0, π]`; 0 for a vector without length.
#[must_use]
pub fn angle_of_vectors(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    atan2(a.cross(b).norm(), a.dot(b))
}

/// Returns the smallest turn from one direction to another; for opposite ones, half a turn about an axis across both.
#[must_use]
pub fn quaternion_between(from: &UnitVector3<f64>, to: &UnitVector3<f64>) -> UnitQuaternion<f64> {
    // Half of the angle: the sum of the identity and of the turn by the whole angle points there.
    let double = Quaternion::from_parts(1.0 + from.dot(to), from.cross(to));
    let across = from.cross(&Vector3::ith(from.iamin(), 1.0));
    let opposite = || UnitQuaternion::new_normalize(Quaternion::from_parts(0.0, across));
    UnitQuaternion::try_new(double, OPPOSITE).unwrap_or_else(opposite)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rotations_are_those_of_the_algebra(
            x in -3.1..3.1_f64, y in -1.57..1.57_f64, z in -3.1..3.1_f64, angle in -7.0..7.0_f64,
        ) {
            let axis = UnitVector3::new_normalize(Vector3::new(x + 0.1, y, z));
            let close = |a: &Rotation3<f64>, b: &Rotation3<f64>| (a.matrix() - b.matrix()).norm() < 1e-14;
            let expected = Rotation3::from_axis_angle(&axis, angle);
            prop_assert!(close(&rotation_about(&axis, angle), &expected));
            prop_assert!(close(&quaternion_about(&axis, angle).to_rotation_matrix(), &expected));
            let turn = quaternion_about(&axis, angle);
            prop_assert!((angle_of(&turn) - turn.angle()).abs() < 1e-12);
            let rotation = rotation_of_xyz(Vector3::new(x, y, z));
            prop_assert!((angle_apart(&rotation, &expected) - rotation.angle_to(&expected)).abs() < 1e-7);
            let to = expected * UnitVector3::new_normalize(Vector3::new(y, 0.3, x));
            prop_assert!((quaternion_between(&axis, &to) * axis.as_ref() - to.as_ref()).norm() < 1e-14);
            prop_assert!((angle_of_vectors(&axis, &to) - axis.angle(&to)).abs() < 1e-7);
            prop_assert!(close(&rotation, &Rotation3::from_euler_angles(x, y, z)));
            let back = xyz_of_rotation(&rotation);
            prop_assert!((rotation_of_xyz(back).matrix() - rotation.matrix()).norm() < 1e-12);
        }
    }

    #[test]
    fn quarter_turns_are_exact() {
        let turn = |x: f64, y: f64, z: f64| {
            exact_rotation_of_xyz(Vector3::new(x, y, z).map(f64::to_radians))
        };
        assert_eq!(
            turn(90.0, 0.0, 0.0) * Vector3::new(1.0, 2.0, 3.0),
            Vector3::new(1.0, -3.0, 2.0)
        );
        assert_eq!(
            turn(180.0, 90.0, -270.0).matrix().map(f64::abs).sum().to_bits(),
            3.0_f64.to_bits()
        );
        let other = Vector3::new(0.1, 1.2, -0.4);
        assert_eq!(exact_rotation_of_xyz(other), rotation_of_xyz(other));
    }

    #[test]
    fn opposite_directions_have_half_a_turn_between_them() {
        for from in [
            Vector3::x_axis(),
            Vector3::z_axis(),
            UnitVector3::new_normalize(Vector3::new(1.0, 1.0, -2.0)),
        ] {
            let turn = quaternion_between(&from, &-from);
            assert!((turn * from.as_ref() + from.as_ref()).norm() < 1e-14, "{from:?}");
        }
        assert!(angle_of_vectors(&Vector3::zeros(), &Vector3::x()).abs() <= 0.0);
    }

    #[test]
    fn a_quarter_turn_about_y_has_angles() {
        for [x, y, z] in [[0.3, 1.0, 0.0], [0.3, -1.0, 0.2], [-2.0, 1.0, 1.1]] {
            let mut matrix = *rotation_of_xyz(Vector3::new(x, y * FRAC_PI_2, z)).matrix();
            matrix[(2, 0)] = -y;
            let rotation = Rotation3::from_matrix_unchecked(matrix);
            let back = rotation_of_xyz(xyz_of_rotation(&rotation));
            assert!((back.matrix() - rotation.matrix()).norm() < 1e-12, "{x} {y} {z}");
        }
    }
}
