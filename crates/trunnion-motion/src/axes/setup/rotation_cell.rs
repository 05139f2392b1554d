//! Boxes of rotations, and how far they reach.

use super::workpiece_tilt::{TiltBounds, WorkpieceTilt};
use crate::math;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Box of rotations about a centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RotationCell {
    pub(super) centre: WorkpieceTilt,
    /// Half widths in tilt, direction of the tilt and turn \[rad\].
    half: [f64; 3],
}

impl RotationCell {
    /// Creates the box of all rotations within bounds.
    pub(super) fn whole(bounds: &TiltBounds) -> Self {
        let ranges = bounds.all();
        let centre = WorkpieceTilt::from_angles(ranges.map(|range| range.middle()));
        Self { centre, half: ranges.map(|range| 0.5 * range.width()) }
    }

    /// Returns the largest turn of the workpiece by each angle \[rad\].
    ///
    /// On the straight way from the centre to a rotation of the cell the tilt turns about a line
    /// across both z, the turn about the workpiece's z, and the direction about the difference of the
    /// machine's z and the workpiece's, which is `2 sin(tilt / 2)` long.
    pub(super) fn turns(&self) -> [f64; 3] {
        let [tilt, towards, turn] = self.half;
        [tilt, towards * 2.0 * math::sin(0.5 * self.steepest()), turn]
    }

    /// Returns the largest angle of a rotation from the centre to another of the cell \[rad\]. The axis of the
    /// tilt is perpendicular to the axes of the other two, so that both parts add up by Pythagoras.
    pub(super) fn radius(&self) -> f64 {
        let [tilt, towards, turn] = self.turns();
        math::hypot(tilt, towards + turn).min(PI)
    }

    /// Returns the largest change of a machine direction by each angle, seen from the workpiece \[rad\]: as
    /// [`Self::turns`], but only across that direction.
    pub(super) fn moves(&self, direction: &Vector3<f64>) -> [f64; 3] {
        let [tilt, towards, turn] = self.half;
        let (steep, about) = math::sin_cos(self.centre.tilt);
        let (sin, cos) = math::sin_cos(self.centre.towards);
        let z = Vector3::new(steep * cos, steep * sin, about);
        // A turn by h about a unit vector a moves a direction d by |a x d| h at most. Along the cell the axes
        // a leave those at the centre by no more than the angle that the workpiece's z does.
        let off = tilt + towards * sine_up_to(self.steepest());
        let own = z.cross(direction);
        let between = Vector3::z().cross(direction) - own;
        let [_, most_towards, most_turn] = self.turns();
        [
            tilt,
            (towards * (between.norm() + off)).min(most_towards),
            (turn * (own.norm() + off)).min(most_turn),
        ]
    }

    /// Returns the largest tilt of the cell \[rad\].
    fn steepest(&self) -> f64 {
        (self.centre.tilt + self.half[0]).min(PI)
    }

    /// Halves the cell across the angle with the largest effect; `does` has the effect of each \[rad\].
    pub(super) fn halves(&self, does: [f64; 3]) -> [Self; 2] {
        let mut most = 0;
        for (index, share) in does.iter().enumerate() {
            if *share > does[most] {
                most = index;
            }
        }
        let mut half = self.half;
        half[most] *= 0.5;
        [-1.0, 1.0].map(|side| {
            let mut angles = self.centre.angles();
            angles[most] += side * half[most];
            Self { centre: WorkpieceTilt::from_angles(angles), half }
        })
    }
}

/// Returns the largest sine of all angles from 0 to `angle`, which is in `[0, π]`.
fn sine_up_to(angle: f64) -> f64 {
    if angle < FRAC_PI_2 { math::sin(angle) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::angle::angle_between;
    use crate::types::Interval;
    use nalgebra::UnitVector3;
    use proptest::prelude::*;

    proptest! {
        /// No rotation of a cell is farther than it says, and none moves a direction farther.
        #[test]
        fn a_cell_reaches_no_farther_than_it_says(
            tilt in prop::array::uniform2(0.0..PI),
            towards in prop::array::uniform2(-3.0..3.0f64),
            turn in prop::array::uniform2(-3.0..3.0f64),
            place in prop::array::uniform3(-1.0..1.0f64),
            direction in prop::array::uniform3(-1.0..1.0f64),
            scale in 0.01..1.0f64,
        ) {
            let range = |[a, b]: [f64; 2]| {
                let low = a.min(b);
                Interval::new(low, low + (a - b).abs() * scale)
            };
            let bounds = TiltBounds { tilt: range(tilt), towards: range(towards), turn: range(turn) };
            let cell = RotationCell::whole(&bounds);
            let mut angles = cell.centre.angles();
            for ((angle, half), place) in angles.iter_mut().zip(cell.half).zip(place) {
                *angle += place * half;
            }
            let [centre, other] = [cell.centre, WorkpieceTilt::from_angles(angles)].map(|workpiece| workpiece.rotation());
            prop_assert!(centre.angle_to(&other) <= cell.radius() + 1e-7);
            let direction = UnitVector3::new_normalize(Vector3::from(direction));
            let seen = |rotation: &nalgebra::Rotation3<f64>| rotation.inverse() * direction;
            let moved = angle_between(&seen(&centre), &seen(&other));
            let most: f64 = cell.moves(&direction).iter().sum();
            prop_assert!(moved <= most + 1e-12, "{moved} {most}");
        }
    }
}
