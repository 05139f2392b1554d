//! A kinematic chain without limits, control and program format.

use super::checked::Machine;
use super::error::MachineErrors;
use super::forward::{Kinematics, Setup};
use super::settings::{ControlLimits, ProgramFormat, RetractPolicy, SingularPolicy};
use super::spec::{AxisSpec, MachineSpec};

/// The axes of a machine in order from the workpiece to the tool: geometry alone.
///
/// Every axis is added at the end of the chain; [`KinematicChain::bed`] is between the axes that
/// move the workpiece and those that move the tool. Directions and points are in the machine frame with
/// all axes at zero; signs are ISO 841. Limits are the presets of [`AxisSpec::linear`] and
/// [`AxisSpec::rotary`].
///
/// For limits, home positions or a program format of your own, turn the chain into a
/// [`MachineSpec`] and change its fields.
///
/// # Example
///
/// ```
/// use trunnion_motion::machine::{KinematicChain, Machine, MachineSpec};
/// use trunnion_motion::types::Interval;
///
/// let chain = KinematicChain::new()
///     .linear("Y", [0.0, 1.0, 0.0])
///     .bed()
///     .linear("X", [1.0, 0.0, 0.0])
///     .linear("Z", [0.0, 0.0, 1.0])
///     .rotary("C", [0.0, 0.0, 1.0], [0.0; 3])
///     .rotary("B", [0.0, 1.0, 0.0], [0.0; 3]);
/// let mut spec = MachineSpec::from(chain);
/// spec.axes[0].limits = Some(Interval::new(-300.0, 300.0));
/// let machine = Machine::new(spec)?;
/// assert_eq!(machine.kind().name(), "head-head");
/// # Ok::<(), trunnion_motion::machine::MachineErrors>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct KinematicChain {
    /// Axis names and `b`, without `w` and `t`.
    words: Vec<String>,
    axes: Vec<AxisSpec>,
    tool_axis: [f64; 3],
    gauge: [f64; 3],
}

impl Default for KinematicChain {
    fn default() -> Self {
        Self::new()
    }
}

impl KinematicChain {
    /// Starts a chain at the workpiece, with the tool along z and the gauge point at the machine origin.
    pub fn new() -> Self {
        Self { words: Vec::new(), axes: Vec::new(), tool_axis: [0.0, 0.0, 1.0], gauge: [0.0; 3] }
    }

    /// Adds a linear axis along `direction`, of any length but zero.
    #[must_use]
    pub fn linear(self, name: &str, direction: [f64; 3]) -> Self {
        self.with(AxisSpec::linear(name, direction))
    }

    /// Adds a rotary axis about the line through `point` \[mm\] along `direction`.
    #[must_use]
    pub fn rotary(self, name: &str, direction: [f64; 3], point: [f64; 3]) -> Self {
        self.with(AxisSpec::rotary(name, direction, point))
    }

    /// Adds the bed: axes before it move the workpiece, axes after it the tool.
    #[must_use]
    pub fn bed(mut self) -> Self {
        self.words.push("b".to_owned());
        self
    }

    /// Sets the direction from tip to spindle, and the gauge point (spindle nose) \[mm\].
    #[must_use]
    pub fn tool(mut self, direction: [f64; 3], gauge: [f64; 3]) -> Self {
        // Both are at q = 0; the tool length comes with the setup.
        (self.tool_axis, self.gauge) = (direction, gauge);
        self
    }

    /// Adds an axis with limits of its own.
    #[must_use]
    pub fn with(mut self, axis: AxisSpec) -> Self {
        self.words.push(axis.name.clone());
        self.axes.push(axis);
        self
    }
}

impl From<KinematicChain> for MachineSpec {
    /// Adds the presets: no limits of the control, the standard policies, the format of `LinuxCNC`.
    fn from(chain: KinematicChain) -> Self {
        // The chain of a specification has the workpiece and the tool at its ends.
        let ends = |word: &str| std::iter::once(word.to_owned());
        Self {
            name: "machine".to_owned(),
            chain: ends("w").chain(chain.words).chain(ends("t")).collect(),
            tool_axis: chain.tool_axis,
            gauge: chain.gauge,
            axes: chain.axes,
            cycle: ControlLimits::default(),
            singular: SingularPolicy::STANDARD,
            retract: RetractPolicy::standard(),
            dialect: ProgramFormat::linuxcnc(),
            bodies: Vec::new(),
        }
    }
}

impl Kinematics {
    /// Creates the kinematics of a chain in a setup, without a machine description.
    ///
    /// # Errors
    ///
    /// All errors of the chain, as [`Machine::new`].
    pub fn from_chain(chain: &KinematicChain, setup: &Setup) -> Result<Self, MachineErrors> {
        Ok(Self::new(&Machine::new(chain.clone().into())?, setup))
    }
}
