//! Options of the setup search.

use super::workpiece_tilt::{TiltBounds, WorkpieceTilt};
use crate::machine::{FIRST_ROTARY, Kinematics};
use std::f64::consts::{FRAC_PI_4, PI};

/// A workpiece-side rotary within this of the machine's z counts as upright \[rad\]: tilting the
/// workpiece then moves its direction every way, and turning it adds nothing.
const UPRIGHT: f64 = FRAC_PI_4;

/// Options of the setup search. There is no `Default`: the caller knows the fixture.
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
    /// Rotations of about one least angle that are planned: so many of the best, and as many others.
    pub batch: usize,
    /// No rotation within bounds is to be better than the best by more than this \[rad\].
    pub within: f64,
    /// Rotations looked at and planned to show that, at most; where they do not suffice, what is shown
    /// is less.
    pub most: [usize; 2],
    /// Digit to which setups are rounded: of the origin \[mm\], of the rotation \[deg\].
    pub digits: [f64; 2],
}

impl TiltBounds {
    /// Returns the default bounds for a machine: the workpiece is tilted up to 45 degrees, or by up to 45
    /// degrees more or less than it does, any way. It is turned as it is; any way where that can help,
    /// which is on a machine whose workpiece-side rotary is not upright, or has ends of travel.
    pub fn usual(kinematics: &Kinematics) -> Self {
        let now = WorkpieceTilt::of(&kinematics.setup().rotation);
        let (least, most) = (now.tilt - FRAC_PI_4, now.tilt + FRAC_PI_4);
        let tilt = if least > 0.0 { [least, most.min(PI)] } else { [0.0, FRAC_PI_4] };
        let axis = kinematics.machine().axes.get(FIRST_ROTARY);
        let free = axis.is_some_and(|axis| {
            axis.dir.z.abs() > UPRIGHT.cos() && axis.limits.iter().all(|end| end.is_infinite())
        });
        let turn = if free { [now.turn; 2] } else { [-PI, PI] };
        Self { tilt, towards: [-PI, PI], turn }
    }
}
