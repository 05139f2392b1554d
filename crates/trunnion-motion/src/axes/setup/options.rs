//! Options of the setup search.

use super::workpiece_tilt::{TiltBounds, WorkpieceTilt};
use crate::machine::{FIRST_ROTARY, Kinematics};
use crate::math;
use crate::types::Interval;
use std::f64::consts::{FRAC_PI_4, PI};

/// A workpiece-side rotary within this of the machine's z counts as upright \[rad\]: tilting the
/// workpiece then moves its direction every way, and turning it adds nothing.
const UPRIGHT: f64 = FRAC_PI_4;

/// Options of the setup search.
///
/// Begin with [`SetupOptions::within_bounds`] and change what matters by struct update. There is no
/// `Default`: the caller knows the fixture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetupOptions {
    /// Bounds on the clamping of the workpiece.
    pub bounds: TiltBounds,
    /// Distance of neighbours of the first grid \[rad\].
    pub grid: f64,
    /// Precision of the improved rotations, and spacing of the tool axes sampled from the path \[rad\].
    pub tolerance: f64,
    /// Rotations whose least angles differ by less than this are equally good \[rad\]; rotary travel
    /// decides.
    pub alike: f64,
    /// Number of rotations with nearly the largest least angle that are planned, and of others.
    pub batch: usize,
    /// Largest improvement over the best setup that the search may miss \[rad\].
    pub within: f64,
    /// Largest number of rotations evaluated to prove that. Where it is not enough, less is proved.
    pub most_evaluated: usize,
    /// Largest number of rotations whose axes are planned to prove that.
    pub most_planned: usize,
    /// Digit to which the origin of a setup is rounded \[mm\].
    pub origin_digit: f64,
    /// Digit to which the rotation of a setup is rounded \[deg\].
    pub rotation_digit: f64,
}

impl SetupOptions {
    /// Creates options for a search within bounds.
    ///
    /// Presets: a grid of 5 degrees, refined to 0.05 degrees; 1 degree of least angle may be given up for
    /// less rotary travel and 0.1 degrees may be missed; up to 400 000 rotations evaluated and 500
    /// planned, which takes some seconds; origins to 0.1 mm and rotations to 0.01 degrees.
    ///
    /// # Example
    ///
    /// ```
    /// use trunnion_motion::axes::{SetupOptions, TiltBounds};
    /// use trunnion_motion::types::Interval;
    ///
    /// let upright = Interval::point(0.0);
    /// let bounds = TiltBounds { tilt: Interval::new(0.0, 0.5), towards: upright, turn: upright };
    /// let thorough = SetupOptions { most_planned: 5_000, ..SetupOptions::within_bounds(bounds) };
    /// assert_eq!(thorough.bounds, bounds);
    /// ```
    #[must_use]
    pub const fn within_bounds(bounds: TiltBounds) -> Self {
        const DEGREE: f64 = PI / 180.0;
        Self {
            bounds,
            grid: 5.0 * DEGREE,
            tolerance: 0.05 * DEGREE,
            alike: DEGREE,
            batch: 8,
            within: 0.1 * DEGREE,
            most_evaluated: 400_000,
            most_planned: 500,
            origin_digit: 0.1,
            rotation_digit: 0.01,
        }
    }
}

impl TiltBounds {
    /// Returns the default bounds for a machine: a tilt of up to 45 degrees, or up to 45 degrees more or less
    /// than now, in any direction. The turn stays as it is, or is free where it can help: on a machine whose
    /// workpiece-side rotary is not upright, or has ends of travel.
    pub fn usual(kinematics: &Kinematics) -> Self {
        // An endless upright rotary turns the workpiece anyway, so that turning it in the fixture adds nothing.
        let now = WorkpieceTilt::of(&kinematics.setup().rotation);
        let (least, most) = (now.tilt - FRAC_PI_4, now.tilt + FRAC_PI_4);
        let tilt = if least > 0.0 {
            Interval::new(least, most.min(PI))
        } else {
            Interval::new(0.0, FRAC_PI_4)
        };
        let axis = kinematics.machine().axes.get(FIRST_ROTARY);
        let free = axis.is_some_and(|axis| {
            axis.dir.z.abs() > math::cos(UPRIGHT) && axis.limits == Interval::UNBOUNDED
        });
        let whole = Interval::new(-PI, PI);
        let turn = if free { Interval::point(now.turn) } else { whole };
        Self { tilt, towards: whole, turn }
    }
}
