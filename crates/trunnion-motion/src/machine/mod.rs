//! The kinematic chain: forward map, travel, singular directions.
//!
//! A machine is data: three linear and two rotary axes in any order between workpiece and tool,
//! with any directions and offsets. Signs are ISO 841: every axis, table or head, is the motion of
//! the tool relative to the workpiece, so that for the chain in order workpiece -> tool
//!
//! ```text
//! tip_w = M1(q1) M2(q2) ... M5(q5) tip,   axis_w likewise
//! ```
//!
//! wherever the bed sits. Frames and signs are drawn in `docs/book/src/concepts/frames.md`.
//!
//! # Example
//!
//! Kinematics from a chain alone, without limits and program format:
//!
//! ```
//! use trunnion_motion::machine::{KinematicChain, Kinematics, Setup};
//! use trunnion_motion::types::AxisVector;
//!
//! let chain = KinematicChain::new()
//!     .rotary("C", [0.0, 0.0, 1.0], [0.0; 3])
//!     .rotary("A", [1.0, 0.0, 0.0], [0.0; 3])
//!     .bed()
//!     .linear("X", [1.0, 0.0, 0.0])
//!     .linear("Y", [0.0, 1.0, 0.0])
//!     .linear("Z", [0.0, 0.0, 1.0]);
//! let kinematics = Kinematics::from_chain(&chain, &Setup::default())?;
//!
//! // The table tilted by 90 degrees about A: the tool lies along -y of the workpiece.
//! let quarter = std::f64::consts::FRAC_PI_2;
//! let pose = kinematics.forward(&AxisVector::from([0.0, 0.0, 0.0, 0.0, quarter]));
//! assert!((pose.axis.y + 1.0).abs() < 1e-15);
//! # Ok::<(), trunnion_motion::machine::MachineErrors>(())
//! ```

mod body;
mod chain;
mod check;
mod checked;
mod describe;
mod error;
mod forward;
mod links;
mod picture;
mod rotary_pair;
mod settings;
mod spec;

pub use body::{BodyShape, MachineBody};
pub use chain::KinematicChain;
pub use checked::{Axis, FIRST_ROTARY, Machine, OutOfTravel, SECOND_ROTARY, TravelExcess};
pub use describe::{MachineKind, MovedBody, SignCheck};
pub use error::{MachineError, MachineErrors};
pub use forward::{ChainGeometry, Kinematics, RotaryJoint, Setup, TipLevers};
pub use links::{LINKS, joint_motion};
pub use picture::picture;
pub use rotary_pair::RotaryPair;
pub use settings::{
    AxisFormat, AxisInterpolation, ControlLimits, FeedMode, PreferredSign, ProgramFormat,
    RetractFrame, RetractPolicy, SingularPolicy, TurnFormat,
};
pub use spec::{AxisKind, AxisSpec, MachineSpec};

#[cfg(test)]
pub(crate) mod samples;
