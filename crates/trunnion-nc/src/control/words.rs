//! Coordinates that a block's words lead to, and the length of its path.

use crate::math;
use crate::read::{Move, Way};
use crate::types::AxisVector;
use nalgebra::Vector3;

/// Longest travel with which X, Y, Z stand \[mm\], so that F counts the rotaries.
///
/// The coordinates of a block's start come from words up to 1e6 mm through a chain of rotations and back. Each of some
/// ten roundings is within 1.2e-10 mm.
pub const STANDING: f64 = 1e-8;

/// Returns coordinates with a block's words put in \[mm, rad\].
///
/// An absolute word replaces its coordinate by the word plus `shift`, an incremental one adds to it;
/// an axis without a word keeps its coordinate. `shift` leads from the words to the coordinates.
pub fn end_words(from: AxisVector, block: &Move, shift: &AxisVector) -> AxisVector {
    let mut to = from;
    for ((value, word), shift) in to.iter_mut().zip(block.words).zip(shift.iter()) {
        match word {
            Some(word) if block.incremental => *value += word,
            Some(word) => *value = word + shift,
            None => {}
        }
    }
    to
}

/// Returns the length of the path of X, Y, Z between the words of a block's two ends \[mm\]; 0 where they stand.
pub fn path_length(block: &Move, from: &AxisVector, to: &AxisVector) -> f64 {
    let change: Vector3<f64> = (to - from).fixed_rows::<3>(0).into();
    match block.way {
        Way::Line if change.norm() <= STANDING => 0.0,
        Way::Line => change.norm(),
        Way::Arc(arc) => {
            // A helix unrolls into a straight line: the arc on one side, its rise on the other.
            let rise: f64 =
                (0..3).filter(|axis| !arc.plane.contains(axis)).map(|axis| change[axis]).sum();
            math::hypot(arc.radius() * arc.sweep, rise)
        }
    }
}
