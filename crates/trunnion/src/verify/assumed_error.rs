//! Errors of machine, tool and setup that the control does not know of.

use crate::cutter::{Cutter, CutterErrors, CutterKind, CutterSide, CutterSpec};
use crate::machine::{FIRST_ROTARY, Kinematics, Setup};
use nalgebra::Vector3;
use std::ops::Add;

/// Machine, tool and setup less what the control takes them to be.
///
/// The program runs with the control's values; the part is cut with the true ones.
///
/// # Example
///
/// ```
/// use trunnion::verify::AssumedError;
///
/// let longer = AssumedError { length: 0.01, ..AssumedError::NONE };
/// let smaller = AssumedError { radius: -0.02, ..AssumedError::NONE };
/// let both = longer + smaller;
/// assert_eq!((both.length, both.radius), (0.01, -0.02));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AssumedError {
    /// Error of the tool length \[mm\]: positive, the tip is farther from the gauge point.
    pub length: f64,
    /// Error of the corner radius, or of the radius of a flat end mill \[mm\]; the tip stays where it was measured.
    pub radius: f64,
    /// Errors of the positions of both rotary axes \[mm\], machine frame. The workpiece is taken to be set with the
    /// rotaries at zero.
    pub pivots: [Vector3<f64>; 2],
    /// Error of the position of the workpiece \[mm\], machine frame.
    pub origin: Vector3<f64>,
}

impl AssumedError {
    /// Everything is as the control takes it.
    pub const NONE: Self = Self {
        length: 0.0,
        radius: 0.0,
        pivots: [Vector3::new(0.0, 0.0, 0.0); 2],
        origin: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Returns the true kinematics where the control has `believed`.
    #[must_use]
    pub fn kinematics(&self, believed: &Kinematics) -> Kinematics {
        let mut machine = believed.machine().clone();
        for (axis, error) in machine.axes.iter_mut().skip(FIRST_ROTARY).zip(&self.pivots) {
            axis.point += *error;
        }
        let setup = believed.setup();
        let tool_length = setup.tool_length + self.length;
        let origin = setup.origin + self.origin;
        Kinematics::new(&machine, &Setup { tool_length, origin, ..*setup })
    }

    /// Returns the true cutter where the control has `believed`.
    ///
    /// # Errors
    ///
    /// [`CutterErrors`] if no cutter has such a radius.
    pub fn cutter(&self, believed: &Cutter) -> Result<Cutter, CutterErrors> {
        let spec = believed.spec().clone();
        let spec = match spec.kind {
            CutterKind::Flat => CutterSpec { major: spec.major + self.radius, ..spec },
            _ if spec.side != CutterSide::Straight => CutterSpec {
                minor: spec.minor + self.radius,
                side: spec.side.grown(self.radius),
                ..spec
            },
            _ => CutterSpec { minor: spec.minor + self.radius, ..spec },
        };
        Cutter::new(spec)
    }
}

impl Add for AssumedError {
    type Output = Self;

    /// Both errors together.
    fn add(self, other: Self) -> Self {
        let [a, b] = self.pivots;
        let [c, d] = other.pivots;
        Self {
            length: self.length + other.length,
            radius: self.radius + other.radius,
            pivots: [a + c, b + d],
            origin: self.origin + other.origin,
        }
    }
}
