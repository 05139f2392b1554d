//! Result of a run.

use super::fixtures::Fixtures;
use super::operations::PlannedOperation;
use super::program::{CheckedProgram, LeftOutProgram};
use crate::files::summary::Summary;

/// Everything that a run produces. Nothing is written to files.
#[derive(Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// Operations that cut something, in order; a job without `[[operation]]` tables has one.
    pub operations: Vec<PlannedOperation>,
    /// Programs as text, each with the results of its check.
    pub programs: Vec<CheckedProgram>,
    /// Programs that were not written, each with its reason.
    pub left_out: Vec<LeftOutProgram>,
    /// Fixtures that they were checked against; `None` without any.
    pub fixtures: Option<Fixtures>,
    /// Cutter locations as APT/CL text.
    pub cl: String,
    /// Setup sheet.
    pub setup: String,
    /// Summary of all numbers.
    pub summary: Summary,
}
