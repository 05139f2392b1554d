//! Layout of the machine file, as written: lengths, angles and times in the units that it states.

use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Machine file of trunnion.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read section by section; the whole describes the layout")]
pub(in super::super) struct RawMachine {
    /// Layout of this file, with its version.
    #[schemars(extend("const" = super::layout::LAYOUT))]
    schema: String,
    /// Name of the machine.
    #[schemars(length(min = 1))]
    name: String,
    /// Units of every number in this file.
    #[serde(default)]
    units: RawUnits,
    /// Kinematic chain from the workpiece "w" over the bed "b" to the tool "t", with five axis names in between: three
    /// linear and two rotary, in any order.
    chain: Vec<String>,
    /// Tool axis, from the tip to the spindle, with all axes at zero; machine frame.
    tool_axis: [f64; 3],
    /// Gauge point (spindle nose) in machine coordinates with all axes at zero.
    gauge: [f64; 3],
    /// Axes, one table each: [axis.X], [axis.B], ...
    axis: BTreeMap<String, RawAxis>,
    /// Servo period and limits of the control.
    #[serde(default)]
    cycle: RawCycle,
    /// Treatment of cuts that pass a singular direction, in which a rotary axis is free.
    #[serde(default)]
    singular: RawSingular,
    /// Retract before a rotary axis unwinds.
    #[serde(default)]
    retract: RawRetract,
    /// Format of programs.
    #[serde(default)]
    dialect: RawDialect,
    /// Bodies that must not collide, one table each: table, slides, column, head. Bodies of different links are checked
    /// against each other, and against the tool with its holder, stock and fixtures.
    #[serde(default)]
    body: Vec<RawBody>,
}

/// Body of the machine.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawBody {
    /// Name of the body in findings.
    #[schemars(length(min = 1))]
    pub(super) name: String,
    /// Link that the body moves with: an axis of the chain, "w", "b" or "t".
    pub(super) link: String,
    /// Kind of solid, which decides the other keys. box: min, max; cylinder: base, radius, height, optionally axis; stl: file,
    /// optionally origin, rotation; step: file, optionally chord, origin, rotation.
    pub(super) kind: RawBodyKind,
    /// Corner of the box with the smallest coordinates, in machine coordinates with all axes at zero.
    pub(super) min: Option<[f64; 3]>,
    /// Corner of the box with the largest coordinates.
    pub(super) max: Option<[f64; 3]>,
    /// Centre of the end of the cylinder from which it rises.
    pub(super) base: Option<[f64; 3]>,
    /// Direction in which the cylinder rises. Default: 0, 0, 1.
    pub(super) axis: Option<[f64; 3]>,
    /// Radius of the cylinder.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) radius: Option<f64>,
    /// Height of the cylinder.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) height: Option<f64>,
    /// STL file in mm, or STEP file, relative to this file.
    #[schemars(length(min = 1))]
    pub(super) file: Option<String>,
    /// Largest distance of the triangles that represent a STEP solid from its faces. Default: 0.1 mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) chord: Option<f64>,
    /// Position of the file's origin in machine coordinates. Default: 0, 0, 0.
    pub(super) origin: Option<[f64; 3]>,
    /// Rotation of the solid about the fixed x, then y, then z, before it is moved to `origin`. Default: 0, 0, 0.
    pub(super) rotation: Option<[f64; 3]>,
    /// Bodies that this one may touch, such as the ways of a slide.
    #[serde(default)]
    pub(super) touches: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawBodyKind {
    Box,
    Cylinder,
    Stl,
    Step,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawUnits {
    /// Unit of lengths.
    #[serde(default)]
    pub(super) length: RawLength,
    /// Unit of angles.
    #[serde(default)]
    pub(super) angle: RawAngle,
    /// Unit of time, in velocities, accelerations and jerks as well.
    #[serde(default)]
    pub(super) time: RawTime,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawLength {
    #[default]
    Mm,
    Inch,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawAngle {
    #[default]
    Deg,
    Rad,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawTime {
    #[default]
    S,
    Min,
}

/// Machine axis.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawAxis {
    /// Kind of axis: linear or rotary.
    pub(super) kind: RawKind,
    /// Direction of the axis with all axes at zero, machine frame; of any length above zero.
    pub(super) dir: [f64; 3],
    /// Pivot: any point of a rotary axis line with all axes at zero, in machine coordinates.
    pub(super) point: Option<[f64; 3]>,
    /// Travel [low, high]; optional for a cyclic axis.
    pub(super) limits: Option<[f64; 2]>,
    /// Period of a rotary axis that turns without end: one turn.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) cyclic: Option<f64>,
    /// Largest velocity while cutting.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) vel: f64,
    /// Largest velocity of a rapid move. Default: `vel`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) rapid: Option<f64>,
    /// Largest acceleration.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) acc: f64,
    /// Largest jerk.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) jerk: f64,
    /// Sense of rotation or travel: 1 for ISO 841, -1 if the control counts the other way.
    #[serde(default = "one")]
    pub(super) sense: f64,
    /// Home position: start of every program, and position of an axis that is free.
    pub(super) home: Option<f64>,
    /// Preferred sign if two branches are equally good.
    pub(super) prefer: Option<RawPrefer>,
    /// Format of the axis in programs.
    #[serde(default)]
    pub(super) output: RawOutput,
}

fn one() -> f64 {
    1.0
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawKind {
    Linear,
    Rotary,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawPrefer {
    Positive,
    Negative,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawOutput {
    /// Address letter. Default: the name of the axis.
    #[schemars(length(min = 1))]
    pub(super) letter: Option<String>,
    /// Digits after the decimal point.
    #[schemars(extend("maximum" = 9))]
    pub(super) decimals: Option<u8>,
    /// Full turns of a rotary axis: "unwound" keeps them (370 deg), "positive" writes 0 to 360 deg, "signed" -180 to
    /// 180 deg.
    #[serde(default)]
    pub(super) modulo: RawModulo,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawModulo {
    #[default]
    Unwound,
    Positive,
    Signed,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawCycle {
    /// Time between two setpoints.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) servo_period: Option<f64>,
    /// Largest speed of the tip.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) tip_speed_max: Option<f64>,
    /// Largest acceleration of the tip along its path.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) tip_acc_max: Option<f64>,
    /// Largest jerk of the tip along its path.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) tip_jerk_max: Option<f64>,
    /// Largest distance of the control's own smoothing from the programmed path.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) contour_tolerance: Option<f64>,
    /// Largest angle of the control's own smoothing from the programmed tool axis.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) orientation_tolerance: Option<f64>,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawSingular {
    /// Half angle of the cone about the singular direction. Default: 3 deg.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) cone: Option<f64>,
    /// Rotary move below which nothing is changed. Default: 10 deg.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) min_rotary: Option<f64>,
    /// Largest distance of the tip from its path for it. Default: 0.02 mm.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) tolerance: Option<f64>,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawRetract {
    /// Frame of the retract: "machine" moves a machine axis, "tool" moves along the tool. Default: "machine".
    pub(super) frame: Option<RawFrame>,
    /// Axis that retracts. Default: "Z".
    #[schemars(length(min = 1))]
    pub(super) axis: Option<String>,
    /// Position of the axis, or distance along the tool. Default: 0.
    pub(super) to: Option<f64>,
    /// Order of the retract: the linear move comes before the rotary one. Default: true.
    pub(super) first: Option<bool>,
}

#[derive(Debug, Clone, Copy, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawFrame {
    Machine,
    Tool,
}

/// Further keys are texts that a program writer uses, such as `tcp_on`.
#[derive(Debug, Deserialize, serde::Serialize, JsonSchema)]
pub(super) struct RawDialect {
    /// Name of the program format.
    #[serde(default = "iso")]
    #[schemars(length(min = 1))]
    pub(super) name: String,
    /// Interpolation of the tool axis between two programmed positions.
    #[serde(default)]
    pub(super) interpolation: RawInterpolation,
    /// Meaning of the feed word: speed of the tip, or inverse of the time of the block.
    #[serde(default)]
    pub(super) feed: RawFeed,
    #[serde(flatten)]
    pub(super) strings: BTreeMap<String, String>,
}

fn iso() -> String {
    "iso".to_owned()
}

/// Format that any control runs: all five axes in proportion, with inverse time.
impl Default for RawDialect {
    fn default() -> Self {
        Self {
            name: iso(),
            interpolation: RawInterpolation::Axes,
            feed: RawFeed::InverseTime,
            strings: BTreeMap::new(),
        }
    }
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawInterpolation {
    RotaryLinear,
    GreatCircle,
    #[default]
    Axes,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum RawFeed {
    Tip,
    #[default]
    InverseTime,
}
