//! Tilt of a workpiece as it is clamped: turn about its own z, tilt angle, and direction of the tilt.

use crate::axes::error::AxesError;
use crate::math;
use crate::math::angle::{unwrap_near, wrap};
use crate::types::Interval;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::{PI, TAU};

/// Sine of a tilt below which its direction is undetermined: the tilt that rounding gives an upright
/// workpiece.
const UPRIGHT: f64 = 1e-12;

/// A rotation of the workpiece in the machine, all axes at zero:
/// `Rz(towards) Ry(tilt) Rz(turn - towards)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorkpieceTilt {
    /// Angle between the workpiece's z and the machine's z \[rad\], in `[0, π]`.
    pub tilt: f64,
    /// Direction towards which the workpiece's z is tilted, about the machine's z from x towards y \[rad\].
    pub towards: f64,
    /// Turn of the workpiece about its own z, before it is tilted \[rad\].
    pub turn: f64,
}

/// Bounds of a [`WorkpieceTilt`] \[rad\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TiltBounds {
    /// Range of the tilt; inside `[0, π]`.
    pub tilt: Interval,
    /// Range of its direction; a whole turn at most.
    pub towards: Interval,
    /// Range of the turn about the workpiece's own z; a whole turn at most.
    pub turn: Interval,
}

impl WorkpieceTilt {
    /// Finds the tilt of a rotation `machine_from_workpiece`.
    pub fn of(rotation: &Rotation3<f64>) -> Self {
        // The third column is where the workpiece's z points: tilt and direction are its polar angle and
        // azimuth. What remains when both are undone is the turn about z.
        let z = rotation * Vector3::z();
        let across = math::hypot(z.x, z.y);
        let tilt = math::atan2(across, z.z);
        let towards = if across > UPRIGHT { math::atan2(z.y, z.x) } else { 0.0 };
        let upright = Self { tilt, towards, turn: 0.0 }.rotation().inverse() * rotation;
        let turn = math::atan2(upright[(1, 0)], upright[(0, 0)]);
        Self { tilt, towards, turn }
    }

    /// Returns the rotation `machine_from_workpiece`.
    pub fn rotation(&self) -> Rotation3<f64> {
        let about_z = |angle| math::rotation_about(&Vector3::z_axis(), angle);
        about_z(self.towards)
            * math::rotation_about(&Vector3::y_axis(), self.tilt)
            * about_z(self.turn - self.towards)
    }

    pub(super) fn angles(&self) -> [f64; 3] {
        [self.tilt, self.towards, self.turn]
    }

    pub(super) fn from_angles([tilt, towards, turn]: [f64; 3]) -> Self {
        Self { tilt, towards, turn }
    }

    /// Returns the nearest tilt in whole degrees.
    pub(super) fn whole_degrees(&self) -> Self {
        Self::from_angles(self.angles().map(|angle| angle.to_degrees().round().to_radians()))
    }

    /// Returns the tilt at a share of the way to another one nearby, angle by angle.
    pub(super) fn part_way(&self, to: &Self, share: f64) -> Self {
        let [from, to] = [self.angles(), to.angles()];
        Self::from_angles([0, 1, 2].map(|k| from[k] + share * (to[k] - from[k])))
    }
}

impl TiltBounds {
    pub(super) fn all(&self) -> [Interval; 3] {
        [self.tilt, self.towards, self.turn]
    }

    /// Checks that the bounds are finite and ascending, and cover each rotation once at most.
    ///
    /// # Errors
    ///
    /// [`AxesError::BadBounds`].
    pub fn check(&self) -> Result<(), AxesError> {
        let names = ["tilt", "towards", "turn"];
        for (what, Interval { low, high }) in names.into_iter().zip(self.all()) {
            let whole = if what == "tilt" {
                low >= 0.0 && high <= PI
            } else {
                // A whole turn in degrees, turned into radians, may be longer by rounding.
                high - low <= TAU * (1.0 + 4.0 * f64::EPSILON) && low.abs() <= 2.0 * TAU
            };
            if !(low <= high && whole) {
                return Err(AxesError::BadBounds { what, low, high });
            }
        }
        Ok(())
    }

    /// Returns `true` if a rotation is inside, to rounding.
    pub(super) fn holds(&self, workpiece: &WorkpieceTilt) -> bool {
        // Angles are compared modulo whole turns: the turn nearest to the middle is the one that counts.
        let turned = |value: f64, range: Interval| {
            let middle = range.middle();
            (unwrap_near(value, middle) - middle).abs() <= 0.5 * range.width() + ROUNDING
        };
        let Interval { low, high } = self.tilt;
        let tilt = low - ROUNDING <= workpiece.tilt && workpiece.tilt <= high + ROUNDING;
        // An upright workpiece has no direction of tilt.
        let towards =
            math::sin(workpiece.tilt) <= UPRIGHT || turned(workpiece.towards, self.towards);
        tilt && towards && turned(workpiece.turn, self.turn)
    }

    /// Returns rotations no more than `step` \[rad\] apart in each angle, ends included.
    pub(super) fn grid(&self, step: f64) -> Vec<WorkpieceTilt> {
        let [tilts, towards, turns] = self.all().map(|range| divided(range, step));
        let mut grid = Vec::new();
        for &tilt in &tilts {
            // Without a tilt all directions are one.
            let directions = if math::sin(tilt) > UPRIGHT { towards.len() } else { 1 };
            for &towards in towards.iter().take(directions) {
                grid.extend(turns.iter().map(|&turn| WorkpieceTilt { tilt, towards, turn }));
            }
        }
        grid
    }

    /// Returns rotations about `workpiece` that differ from it by up to `width` \[rad\] in each angle, kept inside.
    pub(super) fn around(
        &self,
        workpiece: &WorkpieceTilt,
        width: f64,
    ) -> impl Iterator<Item = WorkpieceTilt> + use<> {
        const SHARES: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
        let near = |centre: f64| SHARES.map(|share| centre + share * width);
        let tilts = near(workpiece.tilt).map(|tilt| tilt.clamp(self.tilt.low, self.tilt.high));
        let towards = near(workpiece.towards).map(|angle| inside_turn(angle, self.towards));
        let turns = near(workpiece.turn).map(|angle| inside_turn(angle, self.turn));
        tilts.into_iter().flat_map(move |tilt| {
            towards.into_iter().flat_map(move |towards| {
                turns.into_iter().map(move |turn| WorkpieceTilt { tilt, towards, turn })
            })
        })
    }
}

/// Rounding of angles converted from degrees and back \[rad\]: a few ulps of a turn.
const ROUNDING: f64 = 16.0 * f64::EPSILON * PI;

/// Returns the nearest angle inside; a range of a whole turn contains every angle.
fn inside_turn(value: f64, range: Interval) -> f64 {
    if range.width() >= TAU - ROUNDING { wrap(value) } else { value.clamp(range.low, range.high) }
}

/// Divides a range evenly into steps of at most `step`, ends included.
fn divided(Interval { low, high }: Interval, step: f64) -> Vec<f64> {
    let count = ((high - low) / step).ceil();
    let mut places = vec![low];
    let mut index = 1.0;
    while index <= count {
        places.push(low + (high - low) * index / count);
        index += 1.0;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_lean_is_what_it_says() {
        let workpiece = WorkpieceTilt { tilt: 0.3, towards: FRAC_PI_2, turn: 0.0 };
        // Leaning towards y is a turn about -x.
        let same = Rotation3::from_euler_angles(-0.3, 0.0, 0.0);
        assert!(workpiece.rotation().angle_to(&same) < 1e-15);
        let turned = Rotation3::from_euler_angles(0.0, 0.0, 0.7);
        let upright = WorkpieceTilt::of(&turned);
        assert!(upright.tilt < 1e-15 && (upright.turn - 0.7).abs() < 1e-15);
    }

    #[test]
    fn every_rotation_has_a_lean() {
        for x in [-3.0, -1.5, 0.0, 0.4, 2.0, PI] {
            for y in [-1.5, -0.2, 0.0, 1.0] {
                for z in [-2.0, 0.0, 0.9] {
                    let rotation = Rotation3::from_euler_angles(x, y, z);
                    let again = WorkpieceTilt::of(&rotation).rotation();
                    assert!((again.matrix() - rotation.matrix()).norm() < 1e-11, "{x} {y} {z}");
                }
            }
        }
    }

    #[test]
    fn bounds_hold_their_grid_and_nothing_beyond() {
        let bounds = TiltBounds {
            tilt: Interval::new(0.1, 0.5),
            towards: Interval::new(3.0, 3.5),
            turn: Interval::new(-PI, PI),
        };
        bounds.check().unwrap();
        let grid = bounds.grid(0.1);
        assert_eq!(grid.len(), 5 * 6 * 64);
        for workpiece in &grid {
            assert!(
                bounds.holds(workpiece) && bounds.holds(&WorkpieceTilt::of(&workpiece.rotation())),
                "{workpiece:?}"
            );
            assert!(bounds.around(workpiece, 0.3).all(|near| bounds.holds(&near)));
        }
        assert!(!bounds.holds(&WorkpieceTilt { tilt: 0.6, towards: 3.2, turn: 0.0 }));
        assert!(!bounds.holds(&WorkpieceTilt { tilt: 0.2, towards: 2.9, turn: 0.0 }));
        for bad in [[-0.1, 0.5], [0.5, 0.1], [0.0, 4.0], [f64::NAN, 1.0]] {
            assert!(TiltBounds { tilt: bad.into(), ..bounds }.check().is_err(), "{bad:?}");
        }
        assert!(TiltBounds { turn: Interval::new(0.0, 7.0), ..bounds }.check().is_err());
    }
}
