//! An axis path, and a report of how it follows the tool path.

use crate::machine::RotaryPair;
use crate::types::{AxisPath, ToolPose};
use std::ops::Range;

/// Worst distance between axis path and tool path, at points between the nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct PathDeviation {
    /// Tip \[mm\].
    pub tip: f64,
    /// Tool axis \[rad\].
    pub axis: f64,
}

/// An axis path and how well it follows.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FollowedPath {
    /// The axes.
    pub path: AxisPath,
    /// The worst deviation found.
    pub deviation: PathDeviation,
    /// Weighted rotary travel of the whole path \[rad\] with the prices of retracts, the least of
    /// all choices of branch, turn and place of retracts.
    pub rotary_travel: f64,
    /// Retracts to unwind, in order.
    pub retracts: Vec<RetractMove>,
    /// Passages of a singular direction that differ from the tool path, within what
    /// `SingularOptions` allow.
    pub passages: Vec<SingularPassage>,
}

/// A retract that was needed: the tool leaves the part, the rotaries turn, and it comes back to the
/// very place it left, so that nothing is left uncut.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RetractMove {
    /// Index of the tool-path piece it interrupts, or that ends or starts there.
    pub source: usize,
    /// Parameter of that piece.
    pub u: f64,
    /// `true` if the tool cuts before and after.
    pub in_cut: bool,
    /// Pose at which the tool leaves and comes back.
    pub pose: ToolPose,
    /// Rotary positions when the tool leaves \[rad\].
    pub before: RotaryPair,
    /// Rotary positions when it comes back \[rad\].
    pub after: RotaryPair,
    /// Its pieces in the axis path.
    pub pieces: Range<usize>,
}

impl PathDeviation {
    /// Returns the larger deviation, of tip and axis separately.
    #[must_use]
    pub(crate) fn max(self, other: Self) -> Self {
        Self { tip: self.tip.max(other.tip), axis: self.axis.max(other.axis) }
    }
}

/// A passage of the singular cone that was changed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SingularPassage {
    /// Index of the tool-path piece.
    pub source: usize,
    /// Parameter at the closest approach.
    pub u: f64,
    /// Least angle of the tool path to the singular direction \[rad\].
    pub distance_before: f64,
    /// Least angle to the singular direction after the change \[rad\].
    pub distance_after: f64,
    /// Turn of the workpiece-side rotary inside the cone along the tool path \[rad\].
    pub turn_before: f64,
    /// Turn of the workpiece-side rotary inside the cone after the change \[rad\].
    pub turn_after: f64,
    /// Largest change of the tool axis \[rad\].
    pub tilt: f64,
}
