//! Result of a check.

use super::axis_audit::Audit;
use super::deviation::Deviation;
use super::face_map::FaceMap;
use super::finding::Finding;
use crate::verify::replay::orient::Choices;
use crate::verify::replay::tables::Changes;

/// Result of a check: measured heights, audited axes, findings.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// Map of the heights over each face, in the order of the faces.
    pub maps: Vec<FaceMap>,
    /// Summary of the maps.
    pub deviation: Deviation,
    /// Axes against their limits; `None` where there is no machine.
    pub audit: Option<Audit>,
    /// Rotary positions that the program leaves to the control, and those assumed.
    pub choices: Choices,
    /// Moves that are unknown after tool changes; `None` without a tool change.
    pub changes: Option<Changes>,
    /// Everything that breaks a tolerance or a limit: gouges and excess region by region, the worst first; of all else the
    /// worst of its kind.
    pub findings: Vec<Finding>,
}

impl Report {
    /// Returns `true` if all tolerances and limits are kept.
    pub fn passed(&self) -> bool {
        self.findings.is_empty()
    }
}
