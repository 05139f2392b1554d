//! Layout of the job file, as written: mm, degrees, mm/min.
//!
//! Users read the documentation of the fields in `trunnion schema job` and in the remedies of
//! diagnostics. The walk over the schema refuses all unknown keys at once; serde need not.

mod solid;

pub(super) use solid::{RawFixture, RawSolid, RawSolidKind, RawStock};

use schemars::JsonSchema;
use serde::Deserialize;

/// Job file of trunnion.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read section by section; the whole describes the layout")]
pub(in super::super) struct RawJob {
    /// Layout of this file, with its version.
    #[schemars(extend("const" = super::layout::LAYOUT))]
    schema: String,
    /// Name of the job.
    #[schemars(length(min = 1))]
    name: String,
    /// Part to machine.
    part: RawPart,
    /// Position of the workpiece on the machine.
    setup: RawSetup,
    /// Raw material that the part is cut from. Without it, the program is not checked against stock.
    #[serde(default)]
    stock: Option<RawStock>,
    /// Fixtures that the tool must not touch, one table each. Passes and links are planned round them, and programs are
    /// checked against them.
    #[serde(default)]
    fixture: Option<Vec<RawFixture>>,
    /// Tool that cuts the part. May be left out if every operation has its own.
    #[serde(default)]
    tool: Option<RawTool>,
    /// Permitted deviation of the finished part.
    tolerance: RawTolerance,
    /// Arrangement of the passes on the faces.
    #[serde(default)]
    strategy: RawStrategy,
    /// Feed and spindle. May be left out if every operation has its own.
    #[serde(default)]
    cutting: Option<RawCutting>,
    /// Operations, one table each, in the order in which they are cut: each with its own tool, faces and method. What
    /// an operation leaves out is as in [tool], [part], [strategy] and [cutting]. Without any, the job is one operation.
    #[serde(default)]
    operation: Option<Vec<RawOperation>>,
    /// Machine that runs the programs.
    machine: RawMachineRef,
    /// Planning of the speed along the path.
    #[serde(default)]
    motion: RawMotion,
    /// Programs to write.
    #[serde(default)]
    output: RawOutput,
    /// Final check of the programs.
    #[serde(default)]
    verify: RawVerify,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawPart {
    /// Surface JSON or STEP file, relative to this file.
    #[schemars(length(min = 1))]
    pub(super) file: String,
    /// Rotation of the part about its fixed x, then y, then z, in degrees, as it is read: so z points up for a part that is
    /// drawn lying or upside down. The part turned this way is the workpiece: programs, stock, fixtures and `setup` are
    /// stated in its coordinates.
    #[serde(default)]
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub(super) rotation: [f64; 3],
    /// Faces to machine: "all", or a list of numbers from `trunnion inspect`.
    #[serde(default = "all")]
    pub(super) faces: RawFaces,
    /// Flips the faces: the cutter works on their other side.
    #[serde(default)]
    pub(super) flip: bool,
    /// Other faces of the part that the tool must not gouge: "all", or a list of numbers, which may be empty.
    #[serde(default = "all")]
    pub(super) avoid: RawFaces,
}

fn all() -> RawFaces {
    RawFaces::Word(RawAll::All)
}

/// Default of `max_axis_turn` \[deg/mm\]: with more freedom the tool axis swings to and fro for strips
/// that are hardly wider.
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
    /// Rotation of the workpiece about the machine's fixed x, then y, then z, in degrees.
    #[serde(default)]
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub(super) rotation: [f64; 3],
    /// Height of the clearance plane above part and stock, in mm: links travel there.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e5))]
    pub(super) clearance: f64,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(in super::super) struct RawTool {
    /// Name of the tool, as a library has it.
    #[schemars(length(min = 1))]
    pub(in super::super) name: Option<String>,
    /// Tool number in the magazine.
    pub(super) number: u32,
    /// Shape of the cutting end.
    pub(super) kind: RawToolKind,
    /// Radius R from the tool axis to the centre of the corner arc, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) major_radius: Option<f64>,
    /// Radius r of the corner arc, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) minor_radius: Option<f64>,
    /// Cutting diameter, in mm: 2 (R + r), given with `corner_radius` instead of R and r. For "taper" and "barrel" kinds
    /// and "lens" the diameter at which the side ends and the straight flank begins.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) diameter: Option<f64>,
    /// Radius of the corner arc, in mm; given with `diameter`. For "lens" the small arc beside the large one.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) corner_radius: Option<f64>,
    /// Radius of the arc at the tip, in mm; for "taper", "barrel", "conical-barrel", and "lens", whose tip arc is the
    /// large one.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) tip_radius: Option<f64>,
    /// Radius of the large arc beside the tip, in mm; for "barrel" and "conical-barrel".
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) barrel_radius: Option<f64>,
    /// Angle between the side and the tool axis, in degrees: half the angle of the cone of "taper", the angle at the
    /// upper end of the arc of "conical-barrel".
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 90.0))]
    pub(super) taper_angle: Option<f64>,
    /// Tool length from the gauge point to the tip, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) length: f64,
    /// Construction: "solid" cuts to the centre, "insert" only outside `inner_cutting_radius`.
    #[serde(default)]
    pub(super) construction: RawConstruction,
    /// Radius inside which nothing cuts, in mm; for construction = "insert".
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) inner_cutting_radius: Option<f64>,
    /// Profile above the cutting part: pairs [height above the tip, radius] in mm, from below up.
    #[serde(default)]
    pub(super) shank: Vec<[f64; 2]>,
    /// Profile of the holder: pairs as for `shank`.
    #[serde(default)]
    pub(super) holder: Vec<[f64; 2]>,
    /// STL file of the holder in mm, relative to this file, in place of `holder`. Its z is the tool axis, 0 at the gauge point,
    /// and rises to the spindle. It turns with the spindle: flats and slots count as round.
    pub(in super::super) holder_file: Option<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawToolKind {
    Flat,
    Ball,
    Bull,
    Taper,
    Barrel,
    ConicalBarrel,
    Lens,
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
pub(super) struct RawOperation {
    /// Name of the operation, for reports. Default: its number.
    #[schemars(length(min = 1))]
    pub(super) name: Option<String>,
    /// Tool: the number of one that is described elsewhere in the job, or its description, with the keys of [tool].
    /// Default: the tool of the job.
    pub(super) tool: Option<RawToolChoice>,
    /// Faces to machine, as in [part]. Default: those of the job.
    pub(super) faces: Option<RawFaces>,
    /// Placement of the tool, as strategy.method; "rest" cuts only what the operations before have left: corners and fillets,
    /// and all of a face that none of them cuts.
    pub(super) method: Option<RawMethod>,
    /// Keys of [strategy] that differ from those of the job.
    #[expect(dead_code, reason = "read together with the keys of the job")]
    strategy: Option<RawStrategy>,
    /// Keys of [cutting] that differ from those of the job.
    #[expect(dead_code, reason = "read together with the keys of the job")]
    cutting: Option<RawOwnCutting>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum RawToolChoice {
    /// Number of a tool that is described elsewhere in the job.
    Number(u32),
    /// Description of the tool.
    Tool(Box<RawTool>),
}

/// Keys of [cutting], of which an operation may have any.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "describes the layout; read together with the keys of the job")]
struct RawOwnCutting {
    /// Feed in mm/min.
    #[schemars(extend("minimum" = 0.01, "maximum" = 1e6))]
    feed: Option<f64>,
    /// Point that moves at the feed: cutter contact or tool tip.
    reference: Option<RawReference>,
    /// Spindle speed in rev/min.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e6))]
    spindle: Option<f64>,
    /// Switches the coolant on.
    coolant: Option<bool>,
}

#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawTolerance {
    /// Largest excess of the finished part, in mm: all errors together.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 100.0))]
    pub(super) total: f64,
    /// Deepest gouge of the finished part, in mm; at most `total`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) gouge: f64,
    /// Fixed shares of `total`; the program chooses those left out.
    #[serde(default)]
    pub(super) split: RawSplit,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawSplit {
    /// Share of the scallops between strips, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) strip: Option<f64>,
    /// Share of the curves through the cutter locations, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) path: Option<f64>,
    /// Share of the division into blocks, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) linearisation: Option<f64>,
    /// Share of the rounded numbers of the program, in mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) rounding: Option<f64>,
    /// Share of the control's own smoothing, in mm.
    #[schemars(extend("minimum" = 0.0))]
    pub(super) control: Option<f64>,
    /// Share of moving the tool axis where a cut passes a singular direction, in mm at the cutter; see [singular] of
    /// the machine file. Default: the tool axis is not moved.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) singular: Option<f64>,
    /// Share of smoothing, in mm at the cutter: passes become C3 curves that use one half at the tip and one half for
    /// the tool axis. Default: curves pass through the cutter locations.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) smoothing: Option<f64>,
}

#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawStrategy {
    /// Placement of the tool: "auto" cuts walls, cylinders, cones and other faces of straight lines with the flank of the tool, floors with its
    /// underside, and fillets and other round faces with an axis that holds still, where that finishes them, and other faces by "ball" for a ball cutter, by "widest" for others; "widest" finds the inclination with the widest
    /// strip; "fixed-tilt" keeps `lead_angle` and `tilt_angle`; "ball" is the same for a ball cutter;
    /// "flank" lays the side of the tool along the straight lines of every face, twisted ones too, in one pass each, or in pieces beside what is in the way; "rest" is "auto" for what the operations before have left, and cuts nothing else.
    #[serde(default)]
    pub(super) method: RawMethod,
    /// Lead angle of "fixed-tilt" and "ball": inclination forward along the feed, from the surface normal, in degrees.
    /// A ball needs none: it leans by 10, and the same way on the return pass, so that no axis turns round between passes.
    #[schemars(extend("minimum" = -80.0, "maximum" = 80.0))]
    pub(super) lead_angle: Option<f64>,
    /// Tilt angle of "fixed-tilt" and "ball": inclination sideways, towards the next pass, in degrees. Default: 0.
    #[schemars(extend("minimum" = -80.0, "maximum" = 80.0))]
    pub(super) tilt_angle: Option<f64>,
    /// Feed direction: "u" or "v" follows a parameter line; "curvature" follows the direction in which the face is
    /// least concave; "adaptive" searches the passes that take the machine least time, straight, curved or turned at
    /// the edges of the face, and plans a few times as long.
    #[serde(default)]
    pub(super) along: RawAlong,
    /// Cut pattern: in a zigzag every second pass runs back.
    #[serde(default)]
    pub(super) direction: RawDirection,
    /// Position of the contact arc along the feed, seen from the cutter centre. "behind" and "either" need a tool that
    /// cuts to its centre.
    #[serde(default)]
    pub(super) side: RawSide,
    /// Largest rotation of the tool axis along a pass, in degrees per mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    #[serde(default = "usual_turn")]
    pub(super) max_axis_turn: f64,
    /// Reports the cost of `max_axis_turn`: the run covers the faces once more without that limit. Default: only if it
    /// takes seconds.
    pub(super) turn_cost: Option<bool>,
    /// Lead-in and lead-out: along the tool axis, or tangential to the pass.
    #[serde(default)]
    pub(super) lead: RawLead,
    /// Links between passes: "hop" stays close to the part if that is faster and free of collisions, and steps along the face
    /// at the feed to a pass beside the last; "retract" always
    /// goes up to the clearance plane. With a stock of its own shape the tool always retracts.
    #[serde(default)]
    pub(super) links: RawLinks,
    /// Range of offset directions to search, from the side of the strip towards the feed, in degrees.
    #[schemars(inner(range(min = -89.0, max = 89.0)))]
    pub(super) offset_range: Option<[f64; 2]>,
}

impl Default for RawStrategy {
    fn default() -> Self {
        Self {
            method: RawMethod::default(),
            lead_angle: None,
            tilt_angle: None,
            along: RawAlong::default(),
            direction: RawDirection::default(),
            side: RawSide::default(),
            max_axis_turn: usual_turn(),
            turn_cost: None,
            lead: RawLead::default(),
            links: RawLinks::default(),
            offset_range: None,
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawMethod {
    #[default]
    Auto,
    Widest,
    FixedTilt,
    Ball,
    Flank,
    Rest,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawAlong {
    U,
    V,
    Curvature,
    #[default]
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
    /// Point that moves at the feed: cutter contact or tool tip.
    #[serde(default)]
    pub(super) reference: RawReference,
    /// Spindle speed in rev/min.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e6))]
    pub(super) spindle: f64,
    /// Switches the coolant on.
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
    /// Machine file, relative to this file, or name of a built-in machine.
    #[schemars(length(min = 1))]
    pub(super) file: String,
}

#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawMotion {
    /// Speed planner: "jerk" keeps velocity, acceleration and jerk limits; "optimal" velocity and acceleration limits;
    /// "blocks" is the classical look-ahead, for comparison.
    #[serde(default)]
    pub(super) method: RawMotionMethod,
    /// Servo period in s.
    #[serde(default = "servo_period")]
    #[schemars(extend("minimum" = 1e-5, "maximum" = 1.0))]
    pub(super) servo_period: f64,
    /// Largest distance of a linear axis from the straight line between two setpoints, in mm. It lowers accelerations
    /// to 8 chord / period². Default: no limit.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) chord: Option<f64>,
    /// Largest distance of a rotary axis from that line, in degrees. Default: no limit.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub(super) chord_angle: Option<f64>,
}

/// Default of `servo_period` \[s\]: that of most controls.
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
    /// Dialects of the programs to write.
    #[schemars(length(min = 1))]
    #[serde(default = "dialects")]
    pub(super) dialects: Vec<RawDialect>,
    /// "one": a job of several operations becomes one program with changes of tool. "each": beside it, each operation
    /// becomes a program of its own, with the same blocks.
    #[serde(default)]
    pub(super) programs: RawPrograms,
    /// Blocks of links between passes. "long": as few as stay within 1 mm of the path, for controls that look few blocks
    /// ahead. "short": so near to it that a control which looks far ahead rounds their corners at full speed.
    #[serde(default)]
    pub(super) link_blocks: RawLinkBlocks,
}

fn dialects() -> Vec<RawDialect> {
    vec![RawDialect::LinuxCnc, RawDialect::G93]
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawPrograms {
    #[default]
    One,
    Each,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawLinkBlocks {
    #[default]
    Long,
    Short,
}

impl Default for RawOutput {
    fn default() -> Self {
        Self { dialects: dialects(), programs: RawPrograms::One, link_blocks: RawLinkBlocks::Long }
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
    /// Largest distance between the rays that represent the stock, in mm. Default: 1/400 of its longest side.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) stock_cell: Option<f64>,
    /// Keep-off distance of every part of the tool from fixtures, in mm. Closer approaches fail the check; contact
    /// always does.
    #[serde(default)]
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e5))]
    pub(super) fixture_clearance: f64,
    /// Further tools for `trunnion check --job`, one table each. The programs of the job use its own tool.
    #[serde(default, skip_serializing)]
    pub(super) tool: Option<Vec<RawTool>>,
}

/// Default of `grid` \[mm\].
fn grid() -> f64 {
    0.2
}

impl Default for RawVerify {
    fn default() -> Self {
        Self { grid: grid(), stock_cell: None, fixture_clearance: 0.0, tool: None }
    }
}
