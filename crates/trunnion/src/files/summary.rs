//! Results of a run for scripts: the layout of `summary.json` (`trunnion-summary/1`).
//!
//! Lengths in mm, times in s, angles in degrees, as in every file.

use schemars::JsonSchema;
use serde::Serialize;

/// Name and version of the layout.
pub const LAYOUT: &str = "trunnion-summary/1";

/// Result of a run.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct Summary {
    /// Layout of this file, with its version.
    #[schemars(extend("const" = LAYOUT))]
    pub schema: String,
    /// Name and version of the program that wrote this file.
    pub generator: String,
    /// Name of the job.
    pub job: String,
    /// True if every tolerance and limit is kept.
    pub passed: bool,
    /// Broken tolerances and limits, one sentence each; empty if passed.
    pub failures: Vec<String>,
    /// Warnings to read before the program is used.
    pub warnings: Vec<String>,
    /// Tolerance and its shares.
    pub tolerance: ToleranceSummary,
    /// Passes over the faces.
    pub cover: CoverSummary,
    /// Motion of the machine.
    pub motion: MotionSummary,
    /// Time of the programs: planned, at least, and on a control; changes of tool not included.
    pub times: TimesSummary,
    /// Operations that cut something, in order; absent in a job of one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub operations: Vec<OperationSummary>,
    /// Chord tolerances of the triangles that represent STEP solids, stock and fixtures; absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub chords: Vec<ChordSummary>,
    /// Programs written.
    pub programs: Vec<ProgramSummary>,
    /// Other files written, relative to this file.
    pub files: Vec<String>,
}

/// One operation of a job.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct OperationSummary {
    /// Name.
    pub name: String,
    /// Number of its tool.
    pub tool: u32,
    /// Passes. Of an operation over a rest, `area` is that of the rest.
    pub cover: CoverSummary,
    /// Motion of the machine.
    pub motion: MotionSummary,
}

/// Times of a program, in s.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct TimesSummary {
    /// Time as planned or programmed, rapid moves included.
    pub planned: f64,
    /// Lower bound that no control can beat within the limits of the axes; null if none is known.
    pub certified_bound: Option<f64>,
    /// Time on `LinuxCNC` 2.9 by the model of its planner; null if it was not computed.
    pub linuxcnc: Option<f64>,
    /// Time on `LinuxCNC` with the planner of trunnion, which plans the program for it; left out if nobody asked for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linuxcnc_trunnion: Option<f64>,
}

/// Tolerance and its shares, in mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct ToleranceSummary {
    /// Largest excess of the finished part, in mm.
    pub total: f64,
    /// Deepest gouge of the finished part, in mm.
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
#[non_exhaustive]
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
    /// Cost of the limit on the rotation of the tool axis; null if it was not asked for or would take long.
    pub turn_limit: Option<TurnLimitSummary>,
    /// Area of the faces, in mm2.
    pub area: f64,
    /// Layout of each face: feed direction "u", "v", or "bent" to the face; "flank" for passes of the tool's side, "floor" for
    /// lines and borders on a plane and "fixed-axis" for lines on a round face, with an axis that holds still.
    pub along: Vec<String>,
    /// Layouts that were planned whole and compared, face by face; of faces with one layout only, nothing.
    pub layouts: Vec<LayoutSummary>,
    /// Regions without wide strips, where the tool keeps a fixed inclination instead, largest first.
    pub fixed: Vec<RegionSummary>,
    /// Parts of the faces that the tool does not finish, largest first.
    pub rest: Vec<RestSummary>,
}

/// Pass layout of a face, and those that it was compared with.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct LayoutSummary {
    /// Number of the face.
    pub face: usize,
    /// Layout that was chosen.
    pub chosen: LayoutTime,
    /// The others.
    pub others: Vec<LayoutTime>,
}

/// Time of a pass layout, estimated from the speeds of the axes.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct LayoutTime {
    /// Feed direction: "u", "v", or "bent" to the face; "flank" for passes of the tool's side, "floor" for
    /// lines and borders on a plane and "fixed-axis" for lines on a round face, with an axis that holds still.
    pub along: String,
    /// Time of passes and links, in s.
    pub seconds: f64,
    /// Area that the layout leaves unfinished, in mm2.
    pub rest: f64,
}

/// Passes under the limit on the rotation of the tool axis, compared with those of a free axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct TurnLimitSummary {
    /// Number of passes with the free axis.
    pub free_passes: usize,
    /// Their length along the cutter contact, in mm.
    pub free_length: f64,
    /// Relative increase of the cutting length by the limit; negative if it is shorter.
    pub length: f64,
    /// Relative increase of the time for passes and links by the limit, estimated from the speeds of the axes; negative
    /// if the axes follow the limited passes faster.
    pub time: f64,
}

/// Region of a face without wide strips.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct RegionSummary {
    /// Number of the face.
    pub face: usize,
    /// Ranges of u and v.
    pub uv: [[f64; 2]; 2],
    /// Approximate area, in mm2.
    pub area: f64,
    /// Share of the area of all faces, 0 to 1.
    pub share: f64,
    /// Reason.
    pub why: String,
}

/// Part of a face that stays unfinished.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct RestSummary {
    /// Number of the face.
    pub face: usize,
    /// Area, in mm2.
    pub area: f64,
    /// Ranges of u and v.
    pub uv: [[f64; 2]; 2],
    /// Lowest and highest corner of the box around it, in mm.
    pub bounds: [[f64; 3]; 2],
    /// Largest height of rest material over the face, in mm, as far as the tool comes near.
    pub depth: f64,
    /// Point with that height, in mm.
    pub deepest: [f64; 3],
    /// Radius of the largest ball that touches the face at that point and enters no face of the part, in mm; absent if
    /// one many times the cutter fits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball: Option<f64>,
    /// Smallest such radius of all points examined, in mm; absent likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_ball: Option<f64>,
    /// Reason why the tool does not finish it.
    pub why: String,
}

/// Motion of the machine.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct MotionSummary {
    /// Name of the machine.
    pub machine: String,
    /// Planner, with the limits that the schedule keeps.
    pub method: String,
    /// Planned time, in s.
    pub duration: f64,
    /// Part of the time spent cutting, in s.
    pub cutting: f64,
    /// Lower bound on the time of every schedule within the same velocity and acceleration limits, in s.
    pub lower_bound: f64,
    /// Largest ratio of an axis jerk to its limit between the rows of the schedule; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jerk_ratio: Option<f64>,
    /// Ranges and loads of the axes.
    pub axes: Vec<AxisSummary>,
    /// Retracts to unwind a rotary axis.
    pub retracts: Vec<RetractSummary>,
    /// Effect of moving the tool axis at singular directions; absent if none was moved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub singular: Option<SingularSummary>,
}

/// Passages of a singular direction at which the tool axis was moved.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct SingularSummary {
    /// Number of passages changed.
    pub passages: usize,
    /// Number that now go straight through; the others pass farther away.
    pub through: usize,
    /// Largest change of the tool axis, in degrees.
    pub tilt: f64,
    /// Rotary travel saved inside the cone, in degrees.
    pub turn_saved: f64,
    /// Planned time saved, in s.
    pub seconds_saved: f64,
}

/// Retract: the tool leaves the part, the rotaries unwind, and the tool returns to the same point.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct RetractSummary {
    /// Tool tip at which it leaves and returns, in the workpiece frame, in mm.
    pub tip: [f64; 3],
    /// True if it interrupts a pass.
    pub in_cut: bool,
    /// Axes that turn, with start, end and travel, in degrees.
    pub why: String,
    /// Time away from the part, in s.
    pub seconds: f64,
}

/// Range and load of one axis, in mm or degrees.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct AxisSummary {
    /// Name of the axis.
    pub name: String,
    /// Unit of positions: mm or deg.
    pub unit: String,
    /// Smallest and largest position.
    pub range: [f64; 2],
    /// Largest velocity as a fraction of its limit.
    pub velocity_ratio: f64,
    /// Largest acceleration as a fraction of its limit.
    pub acceleration_ratio: f64,
}

/// Program with the results of its check.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct ProgramSummary {
    /// Dialect.
    pub dialect: String,
    /// File, relative to this file.
    pub file: String,
    /// Number of blocks that move.
    pub blocks: usize,
    /// Time that `LinuxCNC` 2.9 takes for the program by the model of its planner, in s; absent for other dialects, and if
    /// `same_as` is present.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub linuxcnc_duration: Option<f64>,
    /// Dialect of the program with the same blocks, whose check applies here too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub same_as: Option<String>,
    /// Results of the check of this program; absent if `same_as` is present.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub check: Option<CheckSummary>,
    /// Stock after the program, with collisions; absent without stock or check.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stock: Option<StockSummary>,
    /// Distances to fixtures; absent without fixtures or check.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fixtures: Option<FixturesSummary>,
    /// Distances between the bodies of the machine; absent without bodies or check.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies: Option<BodiesSummary>,
    /// Programs of single operations with the same blocks; absent unless the job asks for them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<OperationProgramSummary>,
}

/// Program of one operation. The check of the program of all operations holds for it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct OperationProgramSummary {
    /// Operation.
    pub operation: String,
    /// File, relative to this file.
    pub file: String,
    /// Number of blocks that move.
    pub blocks: usize,
}

/// Distances between the bodies of the machine, the tool with its holder, stock and fixtures.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct BodiesSummary {
    /// Accuracy of the distances, in mm: no true distance is smaller by more than this, or than 1 % of what is beyond the
    /// clearance.
    pub tolerance: f64,
    /// Distance below which lines are reported, in mm.
    pub clearance: f64,
    /// Number of pairs that were compared.
    pub pairs: usize,
    /// Pairs that were not compared, as they may touch.
    pub left_out: Vec<BodyMeetingSummary>,
    /// Closest approach of the whole program.
    pub least: Option<BodyApproachSummary>,
    /// Closest of the lines below the clearance.
    pub near: Vec<BodyApproachSummary>,
    /// Lines below the clearance; null if there are none.
    pub lines: Option<LinesSummary>,
    /// Lines on which bodies touch; null if there are none.
    pub hits: Option<LinesSummary>,
}

/// Two bodies that may touch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct BodyMeetingSummary {
    /// Names of both.
    pub bodies: [String; 2],
    /// Reason why they are not compared.
    pub why: String,
}

/// Closest approach of two bodies on one line.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct BodyApproachSummary {
    /// Line of the program.
    pub line: u32,
    /// Names of both bodies, the one nearer to the workpiece first.
    pub bodies: [String; 2],
    /// Smallest distance, in mm; negative if they touch.
    pub distance: f64,
    /// Point between them, in machine coordinates in which the first body is where it is with all axes at zero.
    pub point: [f64; 3],
}

/// Distances between tool and fixtures.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct FixturesSummary {
    /// Accuracy of the distances, in mm: no true distance is smaller by more than this.
    pub tolerance: f64,
    /// Distance below which lines are reported, in mm.
    pub clearance: f64,
    /// Closest approach of the whole program.
    pub least: Option<ApproachSummary>,
    /// Closest of the lines below the clearance.
    pub near: Vec<ApproachSummary>,
    /// Lines below the clearance; null if there are none.
    pub lines: Option<LinesSummary>,
    /// Lines that run into a fixture; null if there are none.
    pub hits: Option<LinesSummary>,
}

/// Chord tolerance of the triangles that represent a STEP solid.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ChordSummary {
    /// Solid: "stock", or the name of a fixture.
    pub solid: String,
    /// Largest distance of the triangles from the faces, in mm.
    pub chord: f64,
}

/// Closest approach of the tool to fixtures on one line.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct ApproachSummary {
    /// Line of the program.
    pub line: u32,
    /// Name of the fixture.
    pub fixture: String,
    /// Smallest distance, in mm; negative by the depth to which the tool runs into the fixture.
    pub distance: f64,
    /// Point of the fixture that is nearest to the tool, or deepest in it, in mm.
    pub point: [f64; 3],
}

/// Stock after a program, and its collisions.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct StockSummary {
    /// Distance between the rays that represent it, along x, y and z, in mm.
    pub cell: [f64; 3],
    /// Volume removed, in mm3.
    pub removed: f64,
    /// Volume left, in mm3.
    pub left: f64,
    /// Worst collisions: for each line, the deepest point of each kind.
    pub collisions: Vec<CollisionSummary>,
    /// Number of colliding lines of each kind.
    pub collision_lines: Vec<KindSummary>,
    /// Deepest possible collision between rays that could not be excluded; usually null.
    pub undecided: Option<UndecidedSummary>,
}

/// Possible collision with the stock between two of its rays.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct UndecidedSummary {
    /// Kind as in `collisions`.
    pub kind: String,
    /// Line of the program.
    pub line: u32,
    /// Upper bound on its depth, in mm.
    pub depth: f64,
}

/// Colliding lines of one kind.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct KindSummary {
    /// Kind as in `collisions`.
    pub kind: String,
    /// Number and range of the lines.
    #[serde(flatten)]
    pub lines: LinesSummary,
}

/// Lines of a program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct LinesSummary {
    /// Number of lines; a line that runs again may count again.
    pub count: usize,
    /// First of them to run.
    pub first: u32,
    /// Last of them to run.
    pub last: u32,
}

/// Collision on one line of a program.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct CollisionSummary {
    /// "rapid": the cutting part is in the stock at rapid speed; "holder": shank or holder are in the stock; "fixture":
    /// any part of the tool is in a fixture.
    pub kind: String,
    /// Line of the program.
    pub line: u32,
    /// Depth on the rays that represent the stock, in mm.
    pub depth: f64,
    /// Middle of the deepest ray, or deepest point in a fixture, in mm.
    pub point: [f64; 3],
}

/// Results of the check of a program.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[non_exhaustive]
pub struct CheckSummary {
    /// Largest distance between measured points, in mm.
    pub grid: f64,
    /// Number of points measured.
    pub points: usize,
    /// Number of points in the rest material that the tool does not finish.
    pub rest: usize,
    /// Number of points not cut, outside the rest material.
    pub uncut: usize,
    /// Deepest gouge on the faces that are cut or avoided, in mm; 0 without any.
    pub gouge: f64,
    /// Largest excess at points that were cut, outside the rest material, in mm.
    pub excess: f64,
    /// Upper bound on gouges all over the cut faces, between the points as well, in mm; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gouge_bound: Option<f64>,
    /// Upper bound on excess all over the cut faces, outside the rest material, in mm; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub excess_bound: Option<f64>,
    /// Area of the cut faces without such bounds, in mm2.
    pub unbounded_area: f64,
    /// Number of points measured on other faces, for gouges alone.
    pub others: usize,
    /// Duration of the program, in s.
    pub duration: f64,
    /// Largest axis velocity as a fraction of its limit.
    pub velocity_ratio: f64,
    /// Largest axis acceleration as a fraction of its limit; absent if it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration_ratio: Option<f64>,
}
