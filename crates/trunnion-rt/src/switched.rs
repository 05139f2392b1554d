//! Kinematics that a program switches: plain axes, or tool-centre-point control.

use crate::kinematics::{MachineKinematics, ReachedJoints, finite};
use crate::refusal::{Refusal, RefusalCode};
use trunnion::program_motion::BlockCoordinates;
use trunnion::types::AxisVector;

/// Kind of kinematics, with the number that a control switches by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum KinematicsMode {
    /// Words are joints.
    Axes = 0,
    /// X, Y and Z are the tool tip in the table frame.
    ToolCenterPoint = 1,
}

impl KinematicsMode {
    /// Returns the kind with a number.
    ///
    /// # Errors
    ///
    /// [`RefusalCode::UnknownMode`].
    pub fn from_number(number: i32) -> Result<Self, Refusal> {
        match number {
            0 => Ok(Self::Axes),
            1 => Ok(Self::ToolCenterPoint),
            _ => Err(Refusal::new(RefusalCode::UnknownMode)),
        }
    }
}

impl From<KinematicsMode> for BlockCoordinates {
    fn from(mode: KinematicsMode) -> Self {
        match mode {
            KinematicsMode::Axes => Self::Axes,
            KinematicsMode::ToolCenterPoint => Self::Tip,
        }
    }
}

/// Largest step of the linear axes at a change of the tool length that a machine follows without harm \[mm\]: in one
/// servo cycle of 1 ms it is 10 mm/s.
const LENGTH_STEP: f64 = 0.01;

/// Change of the tool length that waits for the control to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LengthChange {
    /// The length in use is the length of the tool.
    Settled,
    /// The tool has another length, and the linear axes would jump.
    Waiting,
    /// The control has the reason, and stops.
    Refused,
}

/// Kinematics of one machine with the switch between plain axes and tool-centre-point control.
///
/// The tool length may change at any time. While the tool stands along Z the new length is taken at once, because
/// no axis has to move for it. With the tool tilted the change is refused, and taken over when the control has
/// stopped: the next positions are then computed from where the joints stand.
///
/// # Example
///
/// ```
/// use trunnion_rt::{KinematicsMode, RefusalCode, SwitchedKinematics, machine_named};
///
/// let mut kinematics = SwitchedKinematics::new(machine_named("ac-trunnion")?);
/// let joints = [0.0, 0.0, -100.0, 0.5, 0.0].into();
/// // Plain axes at first: words are joints.
/// assert_eq!(kinematics.forward(80.0, &joints)?, joints);
/// kinematics.switch(KinematicsMode::ToolCenterPoint, 80.0)?;
/// let words = kinematics.forward(80.0, &joints)?;
/// assert!((kinematics.inverse(&words)?.joints - joints).amax() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SwitchedKinematics {
    machine: MachineKinematics,
    mode: KinematicsMode,
    /// Tool length in use \[mm\].
    length: f64,
    change: LengthChange,
}

impl SwitchedKinematics {
    /// Begins with plain axes.
    pub fn new(machine: MachineKinematics) -> Self {
        Self { machine, mode: KinematicsMode::Axes, length: 0.0, change: LengthChange::Settled }
    }

    /// Returns the kinematics of the machine.
    pub fn machine(&self) -> &MachineKinematics {
        &self.machine
    }

    /// Returns the kind in use.
    pub fn mode(&self) -> KinematicsMode {
        self.mode
    }

    /// Switches to a kind of kinematics, with a tool of `length` \[mm\].
    ///
    /// # Errors
    ///
    /// [`RefusalCode::NotFinite`] for the length; the kind in use stays.
    pub fn switch(&mut self, mode: KinematicsMode, length: f64) -> Result<(), Refusal> {
        if !length.is_finite() {
            return Err(Refusal::new(RefusalCode::NotFinite));
        }
        (self.mode, self.length, self.change) = (mode, length, LengthChange::Settled);
        Ok(())
    }

    /// Returns the words at which the machine stands, and takes a changed tool length over where it may.
    ///
    /// `joints` are those of the machine \[mm, rad\], `length` is that of the tool in the spindle \[mm\].
    ///
    /// # Errors
    ///
    /// [`RefusalCode::NotFinite`].
    pub fn forward(&mut self, length: f64, joints: &AxisVector) -> Result<AxisVector, Refusal> {
        if !(length.is_finite() && finite(joints)) {
            return Err(Refusal::new(RefusalCode::NotFinite));
        }
        self.take_length(length, joints);
        match self.mode {
            KinematicsMode::Axes => Ok(*joints),
            KinematicsMode::ToolCenterPoint => Ok(self.machine.words(self.length, joints)),
        }
    }

    /// Returns the joints for words, with the tool length that [`SwitchedKinematics::forward`] took over.
    ///
    /// # Errors
    ///
    /// [`RefusalCode::LengthChanged`], and as [`MachineKinematics::joints`].
    pub fn inverse(&mut self, words: &AxisVector) -> Result<ReachedJoints, Refusal> {
        match (self.mode, self.change) {
            (KinematicsMode::Axes, _) => self.machine.judged(*words),
            (KinematicsMode::ToolCenterPoint, LengthChange::Settled) => {
                self.machine.joints(self.length, words)
            }
            (KinematicsMode::ToolCenterPoint, _) => {
                self.change = LengthChange::Refused;
                Err(Refusal::new(RefusalCode::LengthChanged))
            }
        }
    }

    /// Takes a tool length over, unless the linear axes would jump and the control does not know of it yet.
    fn take_length(&mut self, length: f64, joints: &AxisVector) {
        let moves = self.mode == KinematicsMode::ToolCenterPoint
            && self.machine.length_step(length - self.length, joints) > LENGTH_STEP;
        if moves && self.change != LengthChange::Refused {
            self.change = LengthChange::Waiting;
            return;
        }
        (self.length, self.change) = (length, LengthChange::Settled);
    }
}
