//! Layout of the machine file, as written: lengths, angles and times in the units it states.

use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A trunnion machine file.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read section by section; the whole describes the layout")]
pub(in super::super) struct RawMachine {
    /// The layout of this file.
    #[schemars(extend("const" = super::layout::LAYOUT))]
    schema: String,
    /// Name of the machine.
    #[schemars(length(min = 1))]
    name: String,
    /// Units of every number in this file.
    #[serde(default)]
    units: RawUnits,
    /// From the workpiece "w" over the bed "b" to the tool "t", five axis names in between:
    /// three linear and two rotary, in any order.
    chain: Vec<String>,
    /// Direction from the tip to the spindle with all axes at zero, machine frame.
    tool_axis: [f64; 3],
    /// Gauge point (spindle nose) in machine coordinates with all axes at zero.
    gauge: [f64; 3],
    /// One table an axis: [axis.X], [axis.B], ...
    axis: BTreeMap<String, RawAxis>,
    /// What the control can do.
    #[serde(default)]
    cycle: RawCycle,
    /// Behaviour near a direction where a rotary axis is free.
    #[serde(default)]
    singular: RawSingular,
    /// How the tool leaves the part to unwind a rotary axis.
    #[serde(default)]
    retract: RawRetract,
    /// How programs are written.
    #[serde(default)]
    dialect: RawDialect,
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
    /// Unit of times, in speeds as well.
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

/// A machine axis.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawAxis {
    /// Linear or rotary.
    pub(super) kind: RawKind,
    /// Direction of the axis with all axes at zero, machine frame; any length but zero.
    pub(super) dir: [f64; 3],
    /// Any point of a rotary axis line with all axes at zero, machine coordinates.
    pub(super) point: Option<[f64; 3]>,
    /// Travel [low, high]; may be left out on a cyclic axis.
    pub(super) limits: Option<[f64; 2]>,
    /// Period of a rotary axis that turns without end: one turn.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) cyclic: Option<f64>,
    /// Largest velocity while cutting.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) vel: f64,
    /// Largest velocity of a rapid; vel if left out.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) rapid: Option<f64>,
    /// Largest acceleration.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) acc: f64,
    /// Largest jerk.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) jerk: f64,
    /// 1 for ISO 841, -1 if the control counts the other way.
    #[serde(default = "one")]
    pub(super) sense: f64,
    /// Start value, and value of an axis that is free.
    pub(super) home: Option<f64>,
    /// Sign to prefer where two branches are equally good.
    pub(super) prefer: Option<RawPrefer>,
    /// How a program writes the axis.
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
    /// Address letter; the axis name if left out.
    #[schemars(length(min = 1))]
    pub(super) letter: Option<String>,
    /// Digits behind the decimal point.
    #[schemars(extend("maximum" = 9))]
    pub(super) decimals: Option<u8>,
    /// How turns of a rotary axis are written: 370 deg, 10 deg, or -180 to 180 deg.
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
    /// How far the control's own smoothing may leave the programmed path.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) contour_tolerance: Option<f64>,
    /// The same for the tool axis, an angle.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) orientation_tolerance: Option<f64>,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawSingular {
    /// Half angle of the cone about the singular direction; 3 deg if left out.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) cone: Option<f64>,
    /// Rotary move below which nothing is changed; 10 deg if left out.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) min_rotary: Option<f64>,
    /// How far the tip may leave the path for it; 0.02 mm if left out.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub(super) tolerance: Option<f64>,
}

#[derive(Debug, Default, Deserialize, serde::Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(super) struct RawRetract {
    /// Whether a machine axis moves, or the tool along itself; "machine" if left out.
    pub(super) frame: Option<RawFrame>,
    /// Axis that retracts; "Z" if left out.
    #[schemars(length(min = 1))]
    pub(super) axis: Option<String>,
    /// Axis position, or distance along the tool; 0 if left out.
    pub(super) to: Option<f64>,
    /// Whether the linear move comes before the rotary one; true if left out.
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
    /// How the control moves the tool axis between two programmed positions.
    #[serde(default)]
    pub(super) interpolation: RawInterpolation,
    /// What a feed word means: speed of the tip, or one over the time of the block.
    #[serde(default)]
    pub(super) feed: RawFeed,
    #[serde(flatten)]
    pub(super) strings: BTreeMap<String, String>,
}

fn iso() -> String {
    "iso".to_owned()
}

/// What any control can run: all five axes in proportion, by time.
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
