//! What a setup search found, for scripts: the layout of `trunnion setup --json` (`trunnion-setup/1`).
//!
//! Lengths in mm, times in s, angles in degrees, as in every file.

use schemars::JsonSchema;
use serde::Serialize;

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-setup/1";

/// Result of a setup search.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SetupSummary {
    /// The layout of this file.
    #[schemars(extend("const" = LAYOUT))]
    pub schema: String,
    /// Name of the job.
    pub job: String,
    /// Name of the machine.
    pub machine: String,
    /// Whether a setup was found within the bounds that keeps the path inside travel.
    pub found: bool,
    /// Where it was searched.
    pub bounds: SetupBounds,
    /// The setup of the job.
    pub before: SetupEntry,
    /// The best setup; left out if none fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<SetupEntry>,
    /// What is known of all other rotations within the bounds.
    pub assurance: SetupAssurance,
    /// Height of links above the part, in mm: as in the job.
    pub clearance: f64,
    /// Rotations looked at on the first grid.
    pub looked: usize,
    /// Of these, how many need the tool-side rotary axis beyond its travel.
    pub leaning: usize,
    /// Other setups that were planned, best first.
    pub others: Vec<SetupEntry>,
    /// What to know of the job.
    pub warnings: Vec<String>,
}

/// Bounds of a search, in degrees, least and largest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SetupBounds {
    /// Angle between the part's z and the machine's z.
    pub tilt: [f64; 2],
    /// Where to it leans, about the machine's z from x towards y.
    pub towards: [f64; 2],
    /// Turn about the part's own z before it is tilted.
    pub turn: [f64; 2],
}

/// What is known of all rotations within the bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SetupAssurance {
    /// Whether it is shown that no setup within the bounds is better than the best by more than a tenth of a degree
    /// and what the best gave up for less rotary travel; if none was found: that there is none.
    pub shown: bool,
    /// The least angle of no setup that fits is larger, in degrees; left out if it is shown that none fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<f64>,
    /// This does not hold for rotations nearer than this, in degrees, to one whose axes were planned in
    /// vain; 0 if it holds for all.
    pub except: f64,
    /// Rotations looked at for it.
    pub looked: usize,
    /// Rotations planned for it.
    pub planned: usize,
}

/// A setup and what came of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SetupEntry {
    /// Workpiece origin in machine coordinates with all axes at zero, in mm.
    pub origin: [f64; 3],
    /// Turns about the fixed x, then y, then z, in degrees.
    pub rotation: [f64; 3],
    /// The same as it is clamped, in degrees: angle between the part's z and the machine's z.
    pub tilt: f64,
    /// Where to it leans, in degrees about the machine's z from x towards y.
    pub towards: f64,
    /// Turn about the part's own z before it is tilted, in degrees.
    pub turn: f64,
    /// Least angle between tool axis and singular directions, in degrees.
    pub least_angle: f64,
    /// Whether the path is inside travel.
    pub fits: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_not: Option<String>,
    /// How far each rotary axis goes along the path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotary_travel: Option<Vec<RotaryTravel>>,
    /// Retracts to unwind.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub retracts: Option<usize>,
    /// Planned time, in s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
}

/// How far a rotary axis goes.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RotaryTravel {
    /// Its name.
    pub axis: String,
    /// Sum of all moves, in degrees.
    pub travel: f64,
}
