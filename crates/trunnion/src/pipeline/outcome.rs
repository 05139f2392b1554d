//! Result of a run.

use super::fixtures::Fixtures;
use super::program::{CheckedProgram, LeftOutProgram};
use crate::axes::FollowedPath;
use crate::cover::Covering;
use crate::feed::FeedPlan;
use crate::files::summary::Summary;
use crate::toolpath::{PathDeviation, SmoothReport};
use crate::types::{Leg, ToolPath};

/// Everything that a run produces. Nothing is written to files.
#[derive(Debug)]
#[non_exhaustive]
pub struct Outcome {
    /// Passes over the faces.
    pub covering: Covering,
    /// Passes with leads and links, in the order they are run.
    pub legs: Vec<Leg>,
    /// Curves through the cutter locations.
    pub tool_path: ToolPath,
    /// Report of their smoothing, and deviations by path length \[mm\]; empty unless the job asks for smoothing.
    pub smoothing: (SmoothReport, Vec<(f64, PathDeviation)>),
    /// Axes of the machine along them.
    pub followed: FollowedPath,
    /// Speeds.
    pub plan: FeedPlan,
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
