//! State of the control while it cuts: spindle, tool length, smoothing.

mod audit;
mod finding;

pub(crate) use audit::{LengthUse, StateLimits, audit};
pub use finding::{
    ActiveSmoothing, AffectedCuts, CoolantDemand, PlannedCuts, StateFinding, StateReport,
};
