//! Angles in radians or degrees.

use trunnion::machine::FIRST_ROTARY;
use trunnion::types::{AXES, AxisVector};

/// Unit of angles in arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AngleUnit {
    Radians,
    Degrees,
}

impl AngleUnit {
    pub(crate) fn of(deg: bool) -> Self {
        if deg { Self::Degrees } else { Self::Radians }
    }

    /// Returns an angle in radians.
    pub(crate) fn inside(self, angle: f64) -> f64 {
        if self == Self::Degrees { angle.to_radians() } else { angle }
    }

    /// Returns an angle of the library in this unit.
    pub(crate) fn outside(self, angle: f64) -> f64 {
        if self == Self::Degrees { angle.to_degrees() } else { angle }
    }

    /// Converts a row of axis values to mm and rad.
    pub(super) fn axes_inside(self, mut row: [f64; AXES]) -> AxisVector {
        row.iter_mut().skip(FIRST_ROTARY).for_each(|angle| *angle = self.inside(*angle));
        row.into()
    }

    /// Converts axis values, or their derivatives, to this unit.
    pub(crate) fn axes_outside(self, q: &AxisVector) -> [f64; AXES] {
        let mut row = <[f64; AXES]>::from(*q);
        row.iter_mut().skip(FIRST_ROTARY).for_each(|angle| *angle = self.outside(*angle));
        row
    }
}
