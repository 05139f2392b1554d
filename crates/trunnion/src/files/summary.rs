//! What a run found, for scripts: the layout of `summary.json` (`trunnion-summary/1`).
//!
//! Lengths in mm, times in s, angles in degrees, as in every file.

use schemars::JsonSchema;
use serde::Serialize;

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-summary/1";

/// Result of a run.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Summary {
    /// The layout of this file.
    #[schemars(extend("const" = LAYOUT))]
    pub schema: String,
    /// Name and version of the program that made it.
    pub generator: String,
    /// Name of the job.
    pub job: String,
    /// Whether every tolerance and limit is kept.
    pub passed: bool,
    /// Why not, one sentence each; empty if passed.
    pub failures: Vec<String>,
    /// What to know before using the program.
    pub warnings: Vec<String>,
    /// Tolerance and how it was shared out.
    pub tolerance: ToleranceSummary,
    /// Passes over the faces.
    pub cover: CoverSummary,
    /// Motion of the machine.
    pub motion: MotionSummary,
    /// How far the triangles that stand for STEP solids, stock and fixtures, may be off their faces; left out without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub chords: Vec<ChordSummary>,
    /// Programs that were written.
    pub programs: Vec<ProgramSummary>,
    /// Other files that were written, relative to this file.
    pub files: Vec<String>,
}

/// Tolerance and how it was shared out, in mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ToleranceSummary {
    /// Most material left after everything, in mm.
    pub total: f64,
    /// Deepest gouge after everything, in mm.
    pub gouge: f64,
    /// Least and largest error of a strip, in mm.
    pub strip: [f64; 2],
    /// Share of the curves through the cutter locations, in mm.
    pub path: f64,
    /// Share of the program's blocks, in mm.
    pub linearisation: f64,
    /// Share of the program's decimals, in mm.
    pub rounding: f64,
    /// Share of the control's own smoothing, in mm.
    pub control: f64,
    /// Share of moving the tool axis at singular directions, in mm.
    pub singular: f64,
    /// Share of smoothing the cutter locations, in mm.
    pub smoothing: f64,
}

/// Passes over the faces.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CoverSummary {
    /// Numbers of the faces.
    pub faces: Vec<usize>,
    /// Number of passes.
    pub passes: usize,
    /// Number of cutter locations.
    pub stations: usize,
    /// Length of all passes along the cutter contact, in mm.
    pub cutting_length: f64,
    /// Least, mean and largest strip width, in mm.
    pub strip_width: [f64; 3],
    /// What the limit of the axis's turn costs; null where that was not asked for or takes long to find out.
    pub turn_limit: Option<TurnLimitSummary>,
    /// Area of the faces, in mm2.
    pub area: f64,
    /// Which way the passes of each face run: "u", "v", or "bent" to the face.
    pub along: Vec<String>,
    /// Where wide strips did not fit and the tool was placed at a fixed lean instead, the largest first.
    pub fixed: Vec<RegionSummary>,
    /// Parts of the faces that the tool does not finish, the largest first.
    pub rest: Vec<RestSummary>,
}

/// Passes under the limit of the axis's turn, beside those of an axis that may turn freely.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct TurnLimitSummary {
    /// Passes of the free axis.
    pub free_passes: usize,
    /// Their length along the cutter contact, in mm.
    pub free_length: f64,
    /// Share by which the limit makes cutting longer; below 0: shorter.
    pub length: f64,
    /// Share by which it makes passes with the ways between them take longer, estimated from the speeds of the axes;
    /// below 0: the axes follow the limited passes sooner.
    pub time: f64,
}

/// Part of a face where wide strips did not fit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RegionSummary {
    /// Number of the face.
    pub face: usize,
    /// Ranges of u and v.
    pub uv: [[f64; 2]; 2],
    /// Its area, about, in mm2.
    pub area: f64,
    /// Share of the area of all faces, 0 to 1.
    pub share: f64,
    /// Why.
    pub why: String,
}

/// Part of a face that stays unfinished.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RestSummary {
    /// Number of the face.
    pub face: usize,
    /// Area, in mm2.
    pub area: f64,
    /// Ranges of u and v.
    pub uv: [[f64; 2]; 2],
    /// Lowest and highest corner of the box around it, in mm.
    pub bounds: [[f64; 3]; 2],
    /// What stands there at most over the face, in mm, as far as the tool comes near.
    pub depth: f64,
    /// That place, in mm.
    pub deepest: [f64; 3],
    /// Radius of the largest ball that touches the face at that place and goes into no face of the part, in mm; left out where
    /// one many times the cutter fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball: Option<f64>,
    /// The least such radius of all places looked at, in mm; left out as before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_ball: Option<f64>,
    /// Why the tool does not get there.
    pub why: String,
}

/// Motion of the machine.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MotionSummary {
    /// Machine.
    pub machine: String,
    /// Planner: which limits the schedule keeps.
    pub method: String,
    /// Planned time, in s.
    pub duration: f64,
    /// Of this, while cutting, in s.
    pub cutting: f64,
    /// Time that no schedule under the same limits of velocity and
    /// acceleration can beat, in s.
    pub lower_bound: f64,
    /// Largest axis jerk over its limit between the rows of the schedule; left out if not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jerk_ratio: Option<f64>,
    /// The axes.
    pub axes: Vec<AxisSummary>,
    /// Where the tool leaves the part to unwind a rotary axis.
    pub retracts: Vec<RetractSummary>,
    /// What moving the tool axis at singular directions did; left out if none was moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub singular: Option<SingularSummary>,
}

/// Cuts that pass a direction in which a rotary axis is free, with the tool axis moved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct SingularSummary {
    /// Passages that were changed.
    pub passages: usize,
    /// Of these, straight through; the others pass farther off.
    pub through: usize,
    /// Largest change of the tool axis, in deg.
    pub tilt: f64,
    /// Rotary turn inside the cone that is no longer needed, in deg.
    pub turn_saved: f64,
    /// Planned time that is saved, in s.
    pub seconds_saved: f64,
}

/// A retract: the tool leaves the part, rotaries unwind, and it comes back to the same place.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RetractSummary {
    /// Tool tip where it leaves and comes back, workpiece frame, in mm.
    pub tip: [f64; 3],
    /// Whether this interrupts a pass.
    pub in_cut: bool,
    /// Which axes turn, from where to where, and their travel, in deg.
    pub why: String,
    /// Time out of the part, in s.
    pub seconds: f64,
}

/// One axis, in mm or degrees.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AxisSummary {
    /// Name.
    pub name: String,
    /// Unit of positions: mm or deg.
    pub unit: String,
    /// Least and largest position.
    pub range: [f64; 2],
    /// Largest velocity as a fraction of its limit.
    pub velocity_ratio: f64,
    /// Largest acceleration as a fraction of its limit.
    pub acceleration_ratio: f64,
}

/// A program and what its check found.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ProgramSummary {
    /// Dialect.
    pub dialect: String,
    /// File, relative to this file.
    pub file: String,
    /// Number of blocks that move.
    pub blocks: usize,
    /// Dialect of the program with the same blocks, whose check holds for this one, too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub same_as: Option<String>,
    /// What the check of this very program found; left out where `same_as` is there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub check: Option<CheckSummary>,
    /// What it does to the stock; left out if none is known, or the program was not checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stock: Option<StockSummary>,
    /// How near it comes to fixtures; left out if there are none, or the program was not checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixtures: Option<FixturesSummary>,
}

/// How near the tool comes to fixtures.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FixturesSummary {
    /// Nowhere is it nearer than told by more than this, in mm.
    pub tolerance: f64,
    /// Lines nearer than this are told, in mm.
    pub clearance: f64,
    /// Where it is nearest in the whole program.
    pub least: Option<ApproachSummary>,
    /// Lines nearer than the clearance: the nearest of them.
    pub near: Vec<ApproachSummary>,
    /// How many there are; null where there are none.
    pub lines: Option<LinesSummary>,
    /// Of them, those that run into a fixture.
    pub hits: Option<LinesSummary>,
}

/// How well triangles stand for a STEP solid.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ChordSummary {
    /// The stock, or the name of a fixture.
    pub solid: String,
    /// How far they may be off its faces, in mm.
    pub chord: f64,
}

/// How near the tool comes to fixtures on one line.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ApproachSummary {
    /// Line of the program.
    pub line: u32,
    /// The fixture.
    pub fixture: String,
    /// Least distance, in mm; below 0 the tool runs into the fixture, so deep.
    pub distance: f64,
    /// Place of the fixture that is nearest, or deepest in the tool, in mm.
    pub point: [f64; 3],
}

/// What a program does to the stock.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StockSummary {
    /// Distance of the rays that stand for it, by x, y and z, in mm.
    pub cell: [f64; 3],
    /// Volume taken away, in mm3.
    pub removed: f64,
    /// Volume left, in mm3.
    pub left: f64,
    /// Lines that run into something, the deepest place of each kind on each; the worst of them.
    pub collisions: Vec<CollisionSummary>,
    /// How many there are of each kind.
    pub collision_lines: Vec<KindSummary>,
    /// Where it was not decided whether something runs into the stock between rays: the deepest. Null in the rule.
    pub undecided: Option<UndecidedSummary>,
}

/// Where something may run into the stock between two of its rays.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct UndecidedSummary {
    /// As in `collisions`.
    pub kind: String,
    /// Line of the program.
    pub line: u32,
    /// No deeper than this, in mm.
    pub depth: f64,
}

/// How many lines run into something.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct KindSummary {
    /// As in `collisions`.
    pub kind: String,
    /// Which lines.
    #[serde(flatten)]
    pub lines: LinesSummary,
}

/// Lines of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LinesSummary {
    /// How many; one to which the program comes back may count again.
    pub count: usize,
    /// The first that was run.
    pub first: u32,
    /// The last.
    pub last: u32,
}

/// A line of a program that runs into something.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CollisionSummary {
    /// "rapid": the cutting part is in the stock at rapid speed; "holder": shank or holder are in the stock; "fixture":
    /// any part of the tool is in a fixture.
    pub kind: String,
    /// Line of the program.
    pub line: u32,
    /// How deep, on the rays that stand for stock, in mm.
    pub depth: f64,
    /// In the middle of the deepest ray, in mm; in a fixture the deepest place.
    pub point: [f64; 3],
}

/// What the check of a program found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct CheckSummary {
    /// Largest distance between measured points, in mm.
    pub grid: f64,
    /// Points measured.
    pub points: usize,
    /// Of these, in the rest that the tool does not finish.
    pub rest: usize,
    /// Not cut, outside that rest.
    pub uncut: usize,
    /// Deepest gouge on any face of the part that is kept off or cut, in mm; 0 for none.
    pub gouge: f64,
    /// Most material left, in mm, at points that were cut, outside that rest.
    pub excess: f64,
    /// No place of the faces that are cut, between the points as at them, is gouged deeper than this, in mm; left out
    /// where there is no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gouge_bound: Option<f64>,
    /// On none is more left than this, in mm, outside the rest; left out where there is no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub excess_bound: Option<f64>,
    /// Area of the cut faces for which the bounds were not found, in mm2.
    pub unbounded_area: f64,
    /// Points measured on faces that are not cut: for gouges alone.
    pub others: usize,
    /// Time the program takes, in s.
    pub duration: f64,
    /// Largest axis velocity as a fraction of its limit.
    pub velocity_ratio: f64,
    /// Largest axis acceleration as a fraction of its limit; left out if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_ratio: Option<f64>,
}
