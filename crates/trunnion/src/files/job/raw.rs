//! Layout of the job file, as written: mm, degrees, mm/min. The doc lines are what users read in
//! `trunnion schema job` and in the remedies of faults. Unknown keys are refused by the walk over
//! the schema, all of them at once, so serde does not look at them.

mod solid;

pub(super) use solid::{RawFixture, RawSolid, RawSolidKind, RawStock};

use schemars::JsonSchema;
use serde::Deserialize;

/// A trunnion job file.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read section by section; the whole describes the layout")]
pub(in super::super) struct RawJob {
    /// The layout of this file.
    #[schemars(extend("const" = super::layout::LAYOUT))]
    schema: String,
    /// Name of the job.
    #[schemars(length(min = 1))]
    name: String,
    /// What to machine.
    part: RawPart,
    /// Where the workpiece stands on the machine.
    setup: RawSetup,
    /// What it is cut from.
    #[serde(default)]
    stock: Option<RawStock>,
    /// What the tool must not touch, a table each. Programs are checked against them; planning does not avoid them.
    #[serde(default)]
    fixture: Option<Vec<RawFixture>>,
    /// What cuts it.
    tool: RawTool,
    /// What the finished part may deviate.
    tolerance: RawTolerance,
    /// How the surface is covered.
    strategy: RawStrategy,
    /// Feed and spindle.
    cutting: RawCutting,
    /// The machine.
    machine: RawMachineRef,
    /// How the speed along the path is planned.
    #[serde(default)]
    motion: RawMotion,
    /// Programs to write.
    #[serde(default)]
    output: RawOutput,
    /// The final check.
    #[serde(default)]
    verify: RawVerify,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawPart {
    /// Surface JSON or STEP file, relative to this file.
    #[schemars(length(min = 1))]
    pub(super) file: String,
    /// "all", or a list of face numbers; `trunnion inspect` shows them.
    #[serde(default = "all")]
    pub(super) faces: RawFaces,
    /// Whether the cutter works on the other side of the faces.
    #[serde(default)]
    pub(super) flip: bool,
    /// Other faces of the part, that the tool keeps off: "all", or a list of face numbers, which may be empty.
    #[serde(default = "all")]
    pub(super) avoid: RawFaces,
}

fn all() -> RawFaces {
    RawFaces::Word(RawAll::All)
}

/// Free, the axis turns to and fro for strips that are hardly wider.
fn usual_turn() -> f64 {
    3.0
}

#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum RawFaces {
    Word(RawAll),
    Numbers(Vec<usize>),
}

#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawAll {
    All,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawSetup {
    /// Workpiece origin in machine coordinates with all axes at zero, x, y, z in mm.
    pub(super) origin: [f64; 3],
    /// Turns of the workpiece about the machine's fixed x, then y, then z, in degrees.
    #[serde(default)]
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub(super) rotation: [f64; 3],
    /// Height above part and stock at which links travel, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e5))]
    pub(super) clearance: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawTool {
    /// Number in the magazine.
    pub(super) number: u32,
    /// Form of the cutting end.
    pub(super) kind: RawToolKind,
    /// R, tool axis to the centre of the corner arc, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) major_radius: Option<f64>,
    /// r, radius of the corner arc, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) minor_radius: Option<f64>,
    /// Cutting diameter in mm, 2 (R + r); with `corner_radius` instead of R and r.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) diameter: Option<f64>,
    /// Radius of the corner arc in mm, with diameter.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) corner_radius: Option<f64>,
    /// From the gauge point to the tip, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) length: f64,
    /// "solid" cuts to the centre; "insert" only outside `inner_cutting_radius`.
    #[serde(default)]
    pub(super) construction: RawConstruction,
    /// Radius inside which nothing cuts, in mm; with construction = "insert".
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) inner_cutting_radius: Option<f64>,
    /// Profile above the cutting part: [height above the tip, radius] pairs in mm, going up.
    #[serde(default)]
    pub(super) shank: Vec<[f64; 2]>,
    /// Profile of the holder, in the same way.
    #[serde(default)]
    pub(super) holder: Vec<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawToolKind {
    Flat,
    Ball,
    Bull,
    Taper,
    Barrel,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawConstruction {
    #[default]
    Solid,
    Insert,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawTolerance {
    /// Most material left after everything, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 100.0))]
    pub(super) total: f64,
    /// Deepest gouge after everything, in mm; not above total.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) gouge: f64,
    /// Fixed shares of total; what is left out is shared out by the program.
    #[serde(default)]
    pub(super) split: RawSplit,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawSplit {
    /// Scallops between strips, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) strip: Option<f64>,
    /// Curves through the cutter locations, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) path: Option<f64>,
    /// Blocks of the program, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) linearisation: Option<f64>,
    /// Decimals of the program, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) rounding: Option<f64>,
    /// The control's own smoothing, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) control: Option<f64>,
    /// Moving the tool axis, in mm at the cutter, where a cut passes a direction in which a rotary
    /// axis is free; with the machine file's [singular]. Left out: the tool axis is not moved.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) singular: Option<f64>,
    /// Smoothing of the cutter locations, in mm at the cutter: passes become C3 curves within half of
    /// it at the tip, and half by turning the tool axis. Left out: curves through the locations.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) smoothing: Option<f64>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawStrategy {
    /// How the tool is placed: "widest" strips; "fixed-tilt", any tool, leaning by `lead_angle` and `tilt_angle`; "ball", the same
    /// for a ball.
    pub(super) method: RawMethod,
    /// How far the tool leans forward along the feed for fixed-tilt and ball, from the surface normal, in degrees;
    /// for a ball left out: 10.
    #[schemars(extend("minimum" = -80.0, "maximum" = 80.0))]
    pub(super) lead_angle: Option<f64>,
    /// How far it leans sideways, towards the next pass, in degrees. Left out: 0.
    #[schemars(extend("minimum" = -80.0, "maximum" = 80.0))]
    pub(super) tilt_angle: Option<f64>,
    /// What the passes follow: the parameter u or v; "curvature", the direction in which the face is bent least
    /// towards the cutter; or "adaptive", which looks for the passes that take the machine least time, straight, bent or
    /// turned at the rims of the face, and takes a few times as long to plan.
    pub(super) along: RawAlong,
    /// Whether every second pass runs back.
    #[serde(default)]
    pub(super) direction: RawDirection,
    /// Where the contact arc lies along the feed from the cutter centre; "behind" and "either" only
    /// for a tool that cuts to its centre.
    #[serde(default)]
    pub(super) side: RawSide,
    /// Most turn of the tool axis along a pass, in degrees per mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[serde(default = "usual_turn")]
    pub(super) max_axis_turn: f64,
    /// Whether a run covers the faces once more with the axis free to turn and tells what the limit costs. Unless said, where
    /// that takes seconds.
    pub(super) turn_cost: Option<bool>,
    /// How the tool comes down to a pass: along its axis or tangentially.
    #[serde(default)]
    pub(super) lead: RawLead,
    /// From pass to pass: "hop" goes over close to the part where that is quicker and free, "retract" always up to the
    /// clearance. With a stock of its own shape the tool always retracts.
    #[serde(default)]
    pub(super) links: RawLinks,
    /// Offset directions to search, from the strip side towards the feed, in degrees.
    #[schemars(inner(range(min = -89.0, max = 89.0)))]
    pub(super) offset_range: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawMethod {
    Widest,
    FixedTilt,
    Ball,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawAlong {
    U,
    V,
    Curvature,
    Adaptive,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawDirection {
    #[default]
    Zigzag,
    OneWay,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawSide {
    #[default]
    Ahead,
    Behind,
    Either,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawLead {
    #[default]
    Axis,
    Tangent,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawLinks {
    #[default]
    Hop,
    Retract,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawCutting {
    /// Feed in mm/min.
    #[schemars(extend("minimum" = 0.01, "maximum" = 1e6))]
    pub(super) feed: f64,
    /// The point that moves at the feed: the cutter contact or the tool tip.
    #[serde(default)]
    pub(super) reference: RawReference,
    /// Spindle speed in rev/min.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e6))]
    pub(super) spindle: f64,
    /// Whether coolant is on.
    #[serde(default)]
    pub(super) coolant: bool,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawReference {
    #[default]
    Contact,
    Tip,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawMachineRef {
    /// Machine file, relative to this file; or the name of a built-in machine.
    #[schemars(length(min = 1))]
    pub(super) file: String,
}

#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawMotion {
    /// Speed planner.
    #[serde(default)]
    pub(super) method: RawMotionMethod,
    /// Servo period in s.
    #[serde(default = "servo_period")]
    #[schemars(extend("minimum" = 1e-5, "maximum" = 1.0))]
    pub(super) servo_period: f64,
    /// Largest distance of a linear axis from the straight line between two setpoints, in mm; none unless
    /// given. Lowers accelerations to 8 chord / period².
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) chord: Option<f64>,
    /// The same of a rotary axis, in deg.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) chord_angle: Option<f64>,
}

/// One millisecond: what most controls have.
fn servo_period() -> f64 {
    0.001
}

impl Default for RawMotion {
    fn default() -> Self {
        Self {
            method: RawMotionMethod::Jerk,
            servo_period: servo_period(),
            chord: None,
            chord_angle: None,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawMotionMethod {
    Optimal,
    #[default]
    Jerk,
    Blocks,
    Given,
}

#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawOutput {
    /// Kinds of program to write.
    #[schemars(length(min = 1))]
    pub(super) dialects: Vec<RawDialect>,
}

impl Default for RawOutput {
    fn default() -> Self {
        Self { dialects: vec![RawDialect::LinuxCnc, RawDialect::G93] }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawDialect {
    #[serde(rename = "linuxcnc")]
    LinuxCnc,
    G93,
    Fanuc,
    FanucVector,
    Haas,
    Siemens,
    SiemensAxes,
    Heidenhain,
    HeidenhainAxes,
}

#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawVerify {
    /// Largest distance between two measured points, in mm.
    #[serde(default = "grid")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) grid: f64,
    /// Largest distance of the rays that stand for the stock, in mm; its longest side has 400 if left out.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) stock_cell: Option<f64>,
    /// How far any part of the tool must keep off fixtures, in mm; what comes nearer is told and not passed, what runs
    /// into one always is.
    #[serde(default)]
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e5))]
    pub(super) fixture_clearance: f64,
    /// Other tools of programs that `trunnion check --job` is given, a table each; the programs of the job have its own.
    #[serde(default, skip_serializing)]
    pub(super) tool: Option<Vec<RawTool>>,
}

/// As in the example.
fn grid() -> f64 {
    0.2
}

impl Default for RawVerify {
    fn default() -> Self {
        Self { grid: grid(), stock_cell: None, fixture_clearance: 0.0, tool: None }
    }
}
