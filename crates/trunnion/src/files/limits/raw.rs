//! Layout of the limits file, as written.

use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Name and version of the layout; the key `schema` may be left out.
pub const LAYOUT: &str = "trunnion-limits/1";

/// Limits file of trunnion. Units are those of the path table's columns, per second.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read section by section; the whole describes the layout")]
pub(in super::super) struct RawLimits {
    /// Layout of this file, with its version.
    #[serde(default)]
    #[schemars(extend("const" = LAYOUT))]
    schema: String,
    /// Limits of the axes, one table each: [axis.X], [axis.B], ...
    axis: BTreeMap<String, AxisLimits>,
    /// Limits along the path parameter s.
    #[serde(default)]
    path: PathLimits,
}

/// Limits of one axis; those towards minus are optional.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AxisLimits {
    /// Largest velocity, in the units of the column per second.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub vel: f64,
    /// Largest acceleration, per second squared.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub acc: f64,
    /// Largest velocity towards minus. Planning with jerk limits and the method `blocks` keep the smaller of both.
    /// Default: `vel`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub vel_minus: Option<f64>,
    /// Largest acceleration towards minus, used as `vel_minus` is. Default: `acc`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub acc_minus: Option<f64>,
    /// Largest jerk, per second cubed; required by the method `jerk`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub jerk: Option<f64>,
    /// Largest distance of the motion from the straight line between two setpoints, in the units of the column. It
    /// lowers `acc` to 8 chord / period².
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub chord: Option<f64>,
}

/// Limits along the path parameter, and its speed at both ends.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct PathLimits {
    /// Largest path velocity ds/dt.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub feed: Option<f64>,
    /// Largest path acceleration d²s/dt², per second squared.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub acc: Option<f64>,
    /// Largest path jerk d³s/dt³, per second cubed.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub jerk: Option<f64>,
    /// Path velocity ds/dt at the start.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub start: f64,
    /// Path velocity ds/dt at the end.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub end: f64,
}
