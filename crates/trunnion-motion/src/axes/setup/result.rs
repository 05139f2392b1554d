//! Results of the setup search.

use super::workpiece_tilt::WorkpieceTilt;
use crate::axes::error::AxesError;
use crate::axes::result::FollowedPath;
use crate::machine::{RotaryPair, Setup};

/// A setup and its evaluation.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct EvaluatedSetup {
    /// The setup. Its origin is the one asked for, unless the path only fits with another.
    pub setup: Setup,
    /// Its rotation about the fixed x, then y, then z \[rad\].
    pub angles: [f64; 3],
    /// The same as it is clamped.
    pub workpiece: WorkpieceTilt,
    /// Least angle between tool axis and singular directions \[rad\].
    pub least: f64,
    /// Verdict on the axes.
    pub verdict: SetupVerdict,
}

/// Verdict on the axes in a setup.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum SetupVerdict {
    /// The path is inside travel.
    Fits(PathTravel),
    /// The tool-side rotary would have to go beyond its travel: by this much \[rad\].
    BeyondTilt(f64),
    /// Linear travel is too short, wherever the origin is.
    Short {
        /// Missing travel \[mm\].
        by: f64,
        /// Names of the axes that are too short.
        axes: Vec<String>,
    },
    /// There is no axis path.
    Fails(AxesError),
}

/// Rotary travel of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PathTravel {
    /// Travel of each rotary \[rad\].
    pub rotary: RotaryPair,
    /// Weighted, with the prices of retracts \[rad\].
    pub weighted: f64,
    /// Retracts to unwind.
    pub retracts: usize,
}

/// Result of a setup search.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SetupSearch {
    /// The setup of the job.
    pub before: EvaluatedSetup,
    /// Its axes, if it fits.
    pub before_axes: Option<FollowedPath>,
    /// The best setup and its axes; `None` if none fits. It may be the one before.
    pub best: Option<(EvaluatedSetup, FollowedPath)>,
    /// Others that were planned, best first.
    pub others: Vec<EvaluatedSetup>,
    /// Rotations evaluated on the grid.
    pub evaluated: usize,
    /// Of these, how many need the tool-side rotary beyond its travel.
    pub beyond_tilt: usize,
    /// Bound on all other rotations.
    pub assurance: SearchAssurance,
}

/// Bound on all rotations within the search bounds.
///
/// Turning the workpiece by an angle changes the angle between tool axis and singular directions by
/// that angle at most, and bounds how far the rotaries move; so one rotation bounds all near it. The
/// bounds are halved until no part of them can hold a better rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SearchAssurance {
    /// Upper bound on the least angle of every rotation that fits \[rad\]; `None`: none fits.
    pub bound: Option<f64>,
    /// Radius \[rad\] of the exceptions: the bound does not cover rotations this near to one that did not fit
    /// for another reason than the ends of travel of the rotaries.
    pub except: f64,
    /// Rotations that were evaluated.
    pub evaluated: usize,
    /// Rotations whose axes were planned.
    pub planned: usize,
}

impl SetupVerdict {
    /// Returns the travel, if the path fits.
    pub fn fits(&self) -> Option<&PathTravel> {
        if let Self::Fits(travelled) = self { Some(travelled) } else { None }
    }

    /// Returns a rank that is smaller the nearer the setup is to fitting, and what is missing.
    pub(super) fn trouble(&self) -> (u8, f64) {
        match self {
            Self::Fits(_) => (0, 0.0),
            Self::Short { by, .. } => (1, *by),
            Self::BeyondTilt(by) => (2, *by),
            Self::Fails(_) => (3, 0.0),
        }
    }
}
