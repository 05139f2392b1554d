//! Audits axis setpoints against the limits of a machine.

mod least;
mod motion_audit;
mod options;
mod rate;

pub use motion_audit::{MotionAudit, MotionError, MotionRow};
pub use options::MotionOptions;
pub use rate::{AxisMotion, MotionFinding, MotionReport, RowRatio, Unevenness};
