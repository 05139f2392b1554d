//! Errors of a machine description.

use super::spec::AxisKind;
use crate::types::ErrorList;

/// All errors of a machine description.
pub type MachineErrors = ErrorList<MachineError>;

/// Error of a machine description. [`MachineError::key`] names its place in a machine file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineError {
    /// A word of the chain is missing, doubled, or in the wrong place.
    #[error("chain {chain:?}: {what}")]
    Chain {
        /// The chain as written.
        chain: Vec<String>,
        /// Defect, and the correct form.
        what: String,
    },
    /// The chain names an axis that is not described.
    #[error("the chain names axis {name}, but there is no [axis.{name}]")]
    MissingAxis {
        /// Name of the axis.
        name: String,
    },
    /// An axis is described but the chain does not name it.
    #[error("axis {name} is described but is not in the chain")]
    UnusedAxis {
        /// Name of the axis.
        name: String,
    },
    /// Two axes have one name or one output letter.
    #[error("two axes are written with the letter {letter}: {first} and {second}")]
    DoubleLetter {
        /// The letter.
        letter: String,
        /// One axis.
        first: String,
        /// The other.
        second: String,
    },
    /// The chain does not have three linear and two rotary axes.
    #[error("the chain has {linear} linear and {rotary} rotary axes; it needs 3 and 2")]
    AxisCount {
        /// Linear axes in the chain.
        linear: usize,
        /// Rotary axes in the chain.
        rotary: usize,
    },
    /// A number is NaN, infinite, not positive where it must be, or otherwise meaningless.
    #[error("{key} = {value}: {must}")]
    Number {
        /// Its key, such as `axis.B.vel`.
        key: String,
        /// The number (mm, rad, s).
        value: f64,
        /// Condition that it breaks.
        must: &'static str,
    },
    /// A direction has no length.
    #[error("{key} is the zero vector; it needs a direction")]
    ZeroDirection {
        /// Its key.
        key: String,
    },
    /// A needed entry is left out.
    #[error("{key} is missing: {why}")]
    Missing {
        /// Key of the missing entry.
        key: String,
        /// Reason why it is needed.
        why: &'static str,
    },
    /// Travel with its ends in the wrong order, or of no length.
    #[error(
        "travel of axis {axis} is empty: from {} to {}; the lower end comes first",
        kind.format_value(*low), kind.format_value(*high)
    )]
    EmptyTravel {
        /// Name of the axis.
        axis: String,
        /// Linear or rotary.
        kind: AxisKind,
        /// First number \[mm or rad\].
        low: f64,
        /// Second number \[mm or rad\].
        high: f64,
    },
    /// The two rotary axes are parallel.
    #[error(
        "rotary axes {first} and {second} are parallel (angle {angle:.2e} rad): they turn the tool about one direction only"
    )]
    ParallelRotaries {
        /// Workpiece-side axis.
        first: String,
        /// Tool-side axis.
        second: String,
        /// Angle between their lines \[rad\].
        angle: f64,
    },
    /// The tool-side rotary axis is parallel to the tool.
    #[error(
        "rotary axis {axis} is parallel to the tool axis (angle {angle:.2e} rad): turning it leaves the tool direction where it is"
    )]
    SpindleParallel {
        /// Name of the axis.
        axis: String,
        /// Angle between the lines \[rad\].
        angle: f64,
    },
    /// A body that cannot be used.
    #[error("{what}")]
    Body {
        /// Its key, such as `body.2.link`.
        key: String,
        /// Defect.
        what: String,
        /// Change that mends it.
        remedy: String,
    },
    /// The three linear axes lie in one plane.
    #[error("linear axes {axes:?} lie in one plane (volume {volume:.2e} of the unit cube)")]
    CoplanarLinear {
        /// Their names.
        axes: [String; 3],
        /// Determinant of the three unit directions.
        volume: f64,
    },
}

impl MachineError {
    /// Returns what to change in the specification so that it can be used.
    pub fn remedy(&self) -> String {
        match self {
            Self::Chain { .. } | Self::AxisCount { .. } => {
                "for example chain = [\"w\", \"C\", \"B\", \"b\", \"X\", \"Y\", \"Z\", \"t\"]".into()
            }
            Self::MissingAxis { name } => format!("add [axis.{name}], or correct the name"),
            Self::UnusedAxis { name } => format!("put \"{name}\" into the chain, or remove it"),
            Self::DoubleLetter { .. } => "give one of them output.letter".into(),
            Self::ZeroDirection { .. } => "for example [0, 0, 1]".into(),
            Self::Missing { .. } => "add it".into(),
            Self::ParallelRotaries { .. } | Self::SpindleParallel { .. } => {
                "give the direction the axis has when all axes are at zero".into()
            }
            Self::CoplanarLinear { .. } => {
                "give three directions that are not in one plane, as they are when all axes are at zero".into()
            }
            Self::EmptyTravel { .. } => "write [low, high]".into(),
            Self::Body { remedy, .. } => remedy.clone(),
            // The only number with a choice of two values.
            Self::Number { key, .. } if key.rsplit('.').next() == Some("sense") => {
                "leave it out if the control counts by ISO 841".into()
            }
            Self::Number { .. } => "correct the number".into(),
        }
    }

    /// Returns the key of the error in a machine file: `chain`, `axis.B.limits`, `tool_axis`, ...
    pub fn key(&self) -> String {
        match self {
            Self::Chain { .. } | Self::AxisCount { .. } | Self::MissingAxis { .. } => {
                "chain".into()
            }
            Self::UnusedAxis { name } => format!("axis.{name}"),
            // Of two axes in conflict the second is named.
            Self::DoubleLetter { second, .. } => format!("axis.{second}.output.letter"),
            Self::Number { key, .. } | Self::ZeroDirection { key } | Self::Missing { key, .. } => {
                key.clone()
            }
            Self::EmptyTravel { axis, .. } => format!("axis.{axis}.limits"),
            Self::Body { key, .. } => key.clone(),
            Self::ParallelRotaries { second, .. } => format!("axis.{second}.dir"),
            Self::SpindleParallel { axis, .. } => format!("axis.{axis}.dir"),
            Self::CoplanarLinear { axes, .. } => format!("axis.{}.dir", axes[2]),
        }
    }
}
