//! Results of a setup search for scripts: the layout of `trunnion setup --json` (`trunnion-setup/1`).
//!
//! Lengths in mm, times in s, angles in degrees, as in every file.

use schemars::JsonSchema;
use serde::Serialize;

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-setup/1";

/// Result of a setup search.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SetupSummary {
    /// Layout of this file, with its version.
    #[schemars(extend("const" = LAYOUT))]
    pub schema: String,
    /// Name of the job.
    pub job: String,
    /// Name of the machine.
    pub machine: String,
    /// True if a setup within the bounds keeps the path inside travel.
    pub found: bool,
    /// Bounds of the search.
    pub bounds: SetupBounds,
    /// Setup of the job.
    pub before: SetupEntry,
    /// Best setup; absent if none fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<SetupEntry>,
    /// Assurance over all other rotations within the bounds.
    pub assurance: SetupAssurance,
    /// Distances of the machine's bodies; absent if the machine has none, or no setup fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies: Option<SetupBodies>,
    /// Height of links above the part, in mm, as in the job.
    pub clearance: f64,
    /// Number of rotations examined on the first grid.
    pub looked: usize,
    /// Number of these that need the tool-side rotary axis beyond its travel.
    pub leaning: usize,
    /// Other setups that were planned, best first.
    pub others: Vec<SetupEntry>,
    /// Warnings about the job.
    pub warnings: Vec<String>,
}

/// Distances of the machine's bodies in setups.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct SetupBodies {
    /// Number of better setups in which bodies, fixtures or stock come too near on every branch of the rotary axes.
    pub passed_over: usize,
    /// Rotary travel within which all keep clear in the best setup; null where they do on the quickest branch.
    pub branch: Option<String>,
    /// True if all keep clear in the best setup; if not, it is the best without regard to them.
    pub clear: bool,
}

/// Bounds of a search: smallest and largest angle, in degrees.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SetupBounds {
    /// Angle between the part's z and the machine's z.
    pub tilt: [f64; 2],
    /// Direction of the tilt, about the machine's z from x towards y.
    pub towards: [f64; 2],
    /// Rotation about the part's own z before it is tilted.
    pub turn: [f64; 2],
}

/// Assurance over all rotations within the bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SetupAssurance {
    /// True if it is shown that no setup within the bounds is better than the best by more than a tenth of a degree and
    /// the angle given up for less rotary travel; without a best setup, that none fits.
    pub shown: bool,
    /// Upper bound on the least angle of every setup that fits, in degrees; absent if it is shown that none fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// Radius of the exceptions, in degrees: the bound does not cover rotations closer than this to one whose axes could
    /// not be planned; 0 without exceptions.
    pub except: f64,
    /// Number of rotations examined for it.
    pub looked: usize,
    /// Number of rotations planned for it.
    pub planned: usize,
}

/// Setup with the results of its planning.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SetupEntry {
    /// Workpiece origin in machine coordinates with all axes at zero, in mm.
    pub origin: [f64; 3],
    /// Rotation about the fixed x, then y, then z, in degrees.
    pub rotation: [f64; 3],
    /// Tilt of the part as clamped, in degrees: angle between the part's z and the machine's z.
    pub tilt: f64,
    /// Direction of the tilt, in degrees about the machine's z from x towards y.
    pub towards: f64,
    /// Rotation about the part's own z before it is tilted, in degrees.
    pub turn: f64,
    /// Smallest angle between tool axis and singular directions, in degrees.
    pub least_angle: f64,
    /// True if the path is inside travel.
    pub fits: bool,
    /// Reason why it does not fit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_not: Option<String>,
    /// Travel of each rotary axis along the path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotary_travel: Option<Vec<RotaryTravel>>,
    /// Number of retracts to unwind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retracts: Option<usize>,
    /// Planned time, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// Travel of a rotary axis.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RotaryTravel {
    /// Name of the axis.
    pub axis: String,
    /// Sum of all its moves, in degrees.
    pub travel: f64,
}
