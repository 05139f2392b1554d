//! Bounds on the error that rounding a program's words causes at the tool.

use crate::machine::{Kinematics, TipLevers};
use crate::types::AxisVector;
use crate::words::AxisWords;
use nalgebra::Vector3;

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
/// A rotary error `e` moves a point by at most `e` times its distance from the axis. With TCP the tip is
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
            let TipLevers { linear, rotary: radius, .. } = kinematics.tip_levers(q);
            let tips = half[3] * radius[0] + half[4] * radius[1];
            farthest(&linear, &half) + tips + rotary * lever
        }
    }
}

/// Returns the distance of the farthest corner of the box that the linear roundings span \[mm\].
fn farthest(linear: &[Vector3<f64>; 3], half: &AxisVector) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis| linear[axis] * half[axis]);
    // The other four corners are these with opposite sign.
    let corners = [x + y + z, x + y - z, x - y + z, x - y - z];
    corners.iter().map(Vector3::norm).fold(0.0, f64::max)
}
