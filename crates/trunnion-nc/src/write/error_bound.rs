//! Bounds on the error that rounding a program's words causes at the tool.

use crate::machine::Kinematics;
use crate::types::AxisVector;
use crate::words::AxisWords;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Meaning of X Y Z in a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// The tip: TCP on.
    Tip,
    /// Axis positions: TCP off.
    Axes,
}

/// Returns a bound on how far rounding the words of `q` moves any point within `lever` \[mm\] of
/// the tip
/// \[mm\].
///
/// A rotary error `e` moves a point by at most `e` times its distance from the axis; the tip's
/// distance is half the way between its places at `q` and half a turn further. With TCP the tip is
/// written directly and a rotary error only turns the tool about it.
pub fn rounding(
    kinematics: &Kinematics,
    q: &AxisVector,
    words: &AxisWords,
    coordinates: Coordinates,
    lever: f64,
) -> f64 {
    // Half of the last digit of each word [mm, rad].
    let half = words.rounding();
    // Errors of both rotaries add up at worst: a turn by e moves a point at most e times its lever.
    let rotary = half[3] + half[4];
    match coordinates {
        // X Y Z are the tip: their box has the half diagonal |(hx, hy, hz)|.
        Coordinates::Tip => half.fixed_rows::<3>(0).norm() + rotary * lever,
        Coordinates::Axes => {
            // X Y Z are axes: a rotary error also swings the tip about the rotary axis.
            let tips: f64 =
                [3, 4].iter().map(|&axis| half[axis] * radius(kinematics, q, axis)).sum();
            linear(kinematics, q, &half) + tips + rotary * lever
        }
    }
}

/// Returns the distance of the tip from a rotary axis \[mm\].
fn radius(kinematics: &Kinematics, q: &AxisVector, axis: usize) -> f64 {
    let mut opposite = *q;
    // Half a turn takes the tip to the opposite point of its circle: the distance is the diameter.
    opposite[axis] += PI;
    0.5 * (kinematics.forward(&opposite).tip - kinematics.forward(q).tip).norm()
}

/// Returns the distance of the farthest corner of the box that the linear roundings span \[mm\].
fn linear(kinematics: &Kinematics, q: &AxisVector, half: &AxisVector) -> f64 {
    let tip = kinematics.forward(q).tip;
    let edge = |axis: usize| {
        let mut moved = *q;
        // The tip is affine in a linear axis, so a step of 1 mm is its exact derivative.
        moved[axis] += 1.0;
        (kinematics.forward(&moved).tip - tip) * half[axis]
    };
    let [x, y, z]: [Vector3<f64>; 3] = [edge(0), edge(1), edge(2)];
    // The other four corners are these with opposite sign.
    let corners = [x + y + z, x + y - z, x - y + z, x - y - z];
    corners.iter().map(Vector3::norm).fold(0.0, f64::max)
}
