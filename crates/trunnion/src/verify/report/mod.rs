//! Reports of verification: heights over faces, axes against limits, findings.

mod axis_audit;
mod deviation;
mod face_map;
mod finding;
mod summary;

pub use axis_audit::{
    Audit, AuditedMotion, AxisAudit, AxisRatio, LimitRatio, ModelAudit, ShortBlocks,
    SingularPassages, SlowBlocks, TravelOverrun, UnendedCut,
};
pub use deviation::{Deviation, ExtremeHeight, HeightBounds, HistogramBin, Sensitivity};
pub use face_map::{FaceMap, HeightSample};
pub use finding::Finding;
pub use summary::Report;
