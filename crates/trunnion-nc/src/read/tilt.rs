//! Tilted planes, whatever a dialect calls them.

use super::control::{ActivePlane, ControlState, MoveTarget};
use super::log::ReadRemark;
use super::step::{Pace, Plane, Step, Turning, Way};
use crate::math;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};

/// Point that stands still while the rotary axes turn the tool to a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum HeldPoint {
    /// The tip: the linear axes compensate.
    Tip,
    /// The linear axes: the tip swings.
    LinearAxes,
}

/// Returns the rotation about an axis by an angle \[rad\].
pub(super) fn about(axis: UnitVector3<f64>, angle: f64) -> UnitQuaternion<f64> {
    math::quaternion_about(&axis, angle)
}

/// Returns the rotation of Euler angles about Z, the new X, the new Z \[rad\].
pub(super) fn euler([first, second, third]: [f64; 3]) -> UnitQuaternion<f64> {
    // Turns about axes that turn along multiply from left to right.
    about(Vector3::z_axis(), first)
        * about(Vector3::x_axis(), second)
        * about(Vector3::z_axis(), third)
}

impl ControlState {
    /// Returns the shift of absolute X Y Z outside of planes \[mm\].
    pub(super) fn linear_shift(&self) -> Vector3<f64> {
        // G52 and G92, or their like, add up.
        let of = |slot: usize| {
            self.local.get(slot).copied().unwrap_or(0.0)
                + self.set_by_92.get(slot).copied().unwrap_or(0.0)
        };
        let [x, y, z] = self.xyz;
        Vector3::new(of(x), of(y), of(z))
    }

    /// Begins a tilted plane, to whose normal the tool is still to be turned.
    pub(super) fn tilt(&mut self, line: u32, origin: Vector3<f64>, turn: UnitQuaternion<f64>) {
        let number = self.next_plane();
        // p_work = origin + turn * p_plane.
        let work_from_plane = Isometry3::from_parts(Translation3::from(origin), turn);
        self.steps.push_back(Step::Plane(Plane { line, number, work_from_plane }));
        // The third axis of the plane is the direction the tool is to take.
        let normal = turn * Vector3::z_axis();
        self.tilted = Some(ActivePlane { number, normal, ready: false });
        // The last X Y Z were in the coordinates outside of the plane.
        self.forget_linear();
    }

    /// Turns the tool to the normal of the plane by the rotary axes, while the other axes or the
    /// tip stand.
    pub(super) fn turn_to_plane(
        &mut self,
        line: u32,
        at: usize,
        held: HeldPoint,
    ) -> Result<(), ReadRemark> {
        let Some(tilted) = self.tilted.take() else {
            return Err(ReadRemark::new(
                at,
                "a turn to a plane that is not there",
                "define it before",
            ));
        };
        let mut target = MoveTarget::new(at, 1);
        // The goal is a tool axis: which rotary angles reach it is left to the consumer.
        target.axis = Some(tilted.normal);
        // The turn itself is of axes: the plane's coordinates take no part.
        // With the tip held this is a move with TCP that has no X Y Z; without, one of the rotaries
        // alone.
        let tcp = std::mem::replace(&mut self.tcp, held == HeldPoint::Tip);
        // PLANE, G53.1 and CYCLE800 move axes, whatever interpolation is active.
        let turning = self.turning.replace(Turning::Rotary);
        let done = self.go(line, target, Pace::Rapid, Way::Line);
        (self.tcp, self.turning) = (tcp, turning);
        self.tilted = Some(ActivePlane { ready: true, ..tilted });
        self.forget_linear();
        done
    }

    /// Ends a tilted plane: words are those of the work offset again.
    pub(super) fn untilt(&mut self) {
        if self.tilted.take().is_some() {
            self.forget_linear();
        }
    }
}
