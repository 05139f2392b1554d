//! Maps between joints, program words and tool poses, with a tool length in every call.

use crate::refusal::{Refusal, RefusalCode};
use trunnion::inverse::{Inverse, InverseError};
use trunnion::machine::{
    FIRST_ROTARY, Kinematics, Machine, RotaryPair, SECOND_ROTARY, Setup, TravelExcess,
};
use trunnion::nalgebra::{Point3, Vector3};
use trunnion::types::{AxisVector, ToolPose};

/// Kinematics of one machine, for any tool length.
///
/// Everything that depends on the machine alone is computed when it is made. A call allocates nothing, also
/// where it refuses a position.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineKinematics {
    /// With a tool of no length: the tip is the gauge point.
    bare: Inverse,
    /// Gauge point at zero \[mm\].
    gauge: Vector3<f64>,
}

/// Joints that were found for a position.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ReachedJoints {
    /// Joints \[mm, rad\].
    pub joints: AxisVector,
    /// Axis farthest outside its travel; `None` if all are inside.
    pub excess: Option<TravelExcess>,
}

impl MachineKinematics {
    /// Prepares the kinematics of a machine.
    ///
    /// # Errors
    ///
    /// [`InverseError::NotFinite`] if the machine cannot be inverted.
    pub fn new(machine: &Machine) -> Result<Self, InverseError> {
        let bare = Inverse::new(&Kinematics::new(machine, &Setup::default()))?;
        Ok(Self { bare, gauge: machine.gauge.coords })
    }

    /// Returns the machine.
    pub fn machine(&self) -> &Machine {
        self.bare.kinematics().machine()
    }

    /// Returns the inverse with a tool of no length.
    pub(crate) fn bare(&self) -> &Inverse {
        &self.bare
    }

    /// Returns the tool pose in the table frame: the tip \[mm\], and the tool axis from tip to spindle.
    ///
    /// `length` is from the gauge point to the tip \[mm\].
    pub fn pose(&self, length: f64, joints: &AxisVector) -> ToolPose {
        let gauge = self.bare.kinematics().forward(joints);
        ToolPose { tip: gauge.tip - gauge.axis.into_inner() * length, axis: gauge.axis }
    }

    /// Returns the joints for a pose in the table frame, inside travel, on the branch and turn nearest to `near`
    /// in rotary travel.
    ///
    /// # Errors
    ///
    /// [`RefusalCode::Unreachable`], [`RefusalCode::OutOfTravel`], [`RefusalCode::FlatSlides`],
    /// [`RefusalCode::NotFinite`].
    pub fn nearest(
        &self,
        length: f64,
        pose: &ToolPose,
        near: &AxisVector,
    ) -> Result<AxisVector, Refusal> {
        // The gauge point stands one tool length behind the tip.
        let gauge = ToolPose { tip: pose.tip + pose.axis.into_inner() * length, axis: pose.axis };
        if !finite(near) {
            return Err(Refusal::new(RefusalCode::NotFinite));
        }
        Ok(self.bare.continued_or_refused(&gauge, near)?.q)
    }

    /// Returns the words of a program for joints, with tool-centre-point control. Total.
    pub fn words(&self, length: f64, joints: &AxisVector) -> AxisVector {
        let tip = self.pose(length, joints).tip.coords;
        let xyz = tip - self.gauge + Vector3::z() * length;
        let mut words = *joints;
        words.fixed_rows_mut::<FIRST_ROTARY>(0).copy_from(&xyz);
        words
    }

    /// Returns the joints for the words of a program, with tool-centre-point control.
    ///
    /// Joints outside travel are returned, with the axis: the control decides on them.
    ///
    /// # Errors
    ///
    /// [`RefusalCode::FlatSlides`], [`RefusalCode::NotFinite`].
    pub fn joints(&self, length: f64, words: &AxisVector) -> Result<ReachedJoints, Refusal> {
        let rotaries = RotaryPair::new(words[FIRST_ROTARY], words[SECOND_ROTARY]);
        // The tool axis depends on the rotaries alone.
        let axis = self.bare.kinematics().forward(words).axis.into_inner();
        let xyz = Vector3::new(words[0], words[1], words[2]);
        let gauge = xyz + self.gauge + (axis - Vector3::z()) * length;
        let joints = self.bare.at_rotaries_or_refused(&Point3::from(gauge), rotaries)?;
        self.judged(joints)
    }

    /// Returns joints with the axis that is outside its travel.
    ///
    /// # Errors
    ///
    /// [`RefusalCode::NotFinite`].
    pub fn judged(&self, joints: AxisVector) -> Result<ReachedJoints, Refusal> {
        if !finite(&joints) {
            return Err(Refusal::new(RefusalCode::NotFinite));
        }
        Ok(ReachedJoints { joints, excess: self.machine().travel_excess(&joints) })
    }

    /// Returns the step that X, Y and Z make at `joints` where the tool becomes longer by `change` \[mm\].
    pub fn length_step(&self, change: f64, joints: &AxisVector) -> f64 {
        let axis = self.bare.kinematics().forward(joints).axis.into_inner();
        // Words count the length along z, the machine along the tool axis.
        ((axis - Vector3::z()) * change).norm()
    }
}

/// Every number is finite.
pub(crate) fn finite(joints: &AxisVector) -> bool {
    joints.iter().all(|value| value.is_finite())
}
