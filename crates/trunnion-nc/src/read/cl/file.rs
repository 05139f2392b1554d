//! Contents of a CL file.

use super::path::ClPath;
use crate::types::{Diagnostic, ToolPose};
use nalgebra::Isometry3;

/// A CL file, in mm, rad, s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClFile {
    /// Cutter locations in order, all in the coordinates of the first `MSYS`.
    pub records: Vec<ClRecord>,
    /// The last `CUTTER` or `TLDATA`: diameter and corner radius \[mm\].
    pub cutter: Option<[f64; 2]>,
    /// Number of the last tool loaded.
    pub tool: Option<u32>,
    /// Tool of the locations, from each change on; empty if the file loads none before one.
    pub tools: Vec<ClTool>,
    /// Warnings: words kept but not understood, and likely slips.
    pub warnings: Vec<Diagnostic>,
}

/// A tool from a location on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClTool {
    /// Index of the first location.
    pub record: usize,
    /// Line of that location.
    pub line: u32,
    /// Number of the tool.
    pub number: u32,
}

/// One location: a `GOTO`, `GODLTA` or `TLON`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClRecord {
    /// Line, counted from 1.
    pub line: u32,
    /// Tip and tool axis.
    pub pose: ToolPose,
    /// Speed of the approach; of a hole, the feed in it.
    pub motion: ClMotion,
    /// On which way.
    pub way: ClPath,
}

/// Speed at which a cutter location is approached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClMotion {
    /// After `RAPID`, and to the first location of a file that states no feed before it.
    Rapid,
    /// At this tip speed \[mm/s\].
    Feed(f64),
}

/// Kind of a statement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ClItem {
    /// Moves the tool.
    Location(ClRecord),
    /// Decides how the next locations are reached: `RAPID`, `FEDRAT`, `CIRCLE`, `MOVARC`, `INDIRV`, `AUTOPS`.
    Manner,
    /// Concerns neither motion nor machine: a comment, an empty line, `PAINT`.
    Remark,
    /// Anything else, with its effect taken in where it has one: units, frames, tools, cycles, spindle.
    Words,
}

impl ClRecord {
    /// Transforms the location into other coordinates.
    #[must_use]
    pub fn moved(mut self, to_from: &Isometry3<f64>) -> Self {
        // The identity would still round.
        if *to_from == Isometry3::identity() {
            return self;
        }
        self.pose.tip = to_from * self.pose.tip;
        self.pose.axis = to_from.rotation * self.pose.axis;
        if let ClPath::Arc(arc) = &mut self.way {
            arc.start = to_from * arc.start;
            arc.center = to_from * arc.center;
            arc.normal = to_from.rotation * arc.normal;
        }
        self
    }
}
