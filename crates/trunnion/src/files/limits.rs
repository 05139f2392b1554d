//! The limits file (`trunnion-limits/1`): what the axes of a path table can do.

use super::document::Document;
use super::schema;
use crate::types::{Diagnostic, Diagnostics};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Name and version of the layout; the key `schema` may be left out.
pub const LAYOUT: &str = "trunnion-limits/1";

/// A trunnion limits file: units are those of the path table's columns, per second.
#[derive(Debug, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
#[expect(dead_code, reason = "read section by section; the whole describes the layout")]
pub(super) struct RawLimits {
    /// The layout of this file.
    #[serde(default)]
    #[schemars(extend("const" = LAYOUT))]
    schema: String,
    /// One table an axis: [axis.X], [axis.B], ...
    axis: BTreeMap<String, AxisLimits>,
    /// Limits along the path parameter s.
    #[serde(default)]
    path: PathLimits,
}

/// Limits of one axis, in both directions unless one is named towards minus.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct AxisLimits {
    /// Largest velocity, in the units of the column per second.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub vel: f64,
    /// Largest acceleration, per second squared.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub acc: f64,
    /// Largest velocity towards minus, where it differs from `vel`. Planning with jerk limits and the
    /// method `blocks` keep the smaller of both.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub vel_minus: Option<f64>,
    /// Largest acceleration towards minus, where it differs from `acc`; used as `vel_minus`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub acc_minus: Option<f64>,
    /// Largest jerk, per second cubed; needed by the method `jerk`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub jerk: Option<f64>,
    /// Largest distance of the motion from the straight line between two setpoints, in the units of the
    /// column: lowers `acc` to 8 chord / period².
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub chord: Option<f64>,
}

/// Limits along the path parameter, and its speed at both ends.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct PathLimits {
    /// Largest ds/dt.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub feed: Option<f64>,
    /// Largest change of ds/dt, per second squared.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub acc: Option<f64>,
    /// Largest change of that, per second cubed.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub jerk: Option<f64>,
    /// ds/dt at the start of the path.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub start: f64,
    /// ds/dt at the end of the path.
    #[serde(default)]
    #[schemars(range(min = 0))]
    pub end: f64,
}

/// A limits file that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitsFile {
    /// Limits by axis name, in order of names.
    pub axes: BTreeMap<String, AxisLimits>,
    /// Limits along the path.
    pub path: PathLimits,
}

/// Reads a limits file.
///
/// # Errors
///
/// Every fault that was found, in order of lines.
pub fn parse(text: &str) -> Result<LimitsFile, Diagnostics> {
    let mut doc = Document::open(text, LAYOUT, &schema::limits_value())?;
    let axes = doc.section::<BTreeMap<String, AxisLimits>>("axis");
    let path = doc.or_default("path");
    if axes.as_ref().is_some_and(BTreeMap::is_empty) {
        doc.fault("axis", "no axis has limits", "add a table for every axis, as [axis.X]");
    }
    doc.finish()?;
    match (axes, path) {
        (Some(axes), Some(path)) => Ok(LimitsFile { axes, path }),
        _ => Err(Diagnostic::whole("the limits file cannot be read").into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> String {
        let faults = parse(text).unwrap_err();
        faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn axes_and_path_are_read() {
        let text = "[axis.X]\nvel = 500\nacc = 5000\njerk = 1e5\n[axis.C]\nvel = 50\nacc = 500\n\
                    [path]\nfeed = 50\nstart = 2\n";
        let file = parse(text).unwrap();
        assert_eq!(file.axes.len(), 2);
        assert_eq!(
            file.axes["X"],
            AxisLimits { vel: 500.0, acc: 5000.0, jerk: Some(1e5), ..AxisLimits::default() }
        );
        assert_eq!(file.axes["C"].jerk, None);
        assert_eq!(file.path, PathLimits { feed: Some(50.0), start: 2.0, ..PathLimits::default() });
    }

    #[test]
    fn faults_have_a_place_and_a_remedy() {
        assert!(
            faults("[axis.X]\nvel = 0\nacc = 5\n")
                .contains("2:7: `axis.X.vel` = 0 must be above 0")
        );
        assert!(faults("[axis.X]\nvel = 1\n").contains("missing key `acc` in [axis.X]"));
        assert!(faults("[axis.X]\nvel = 1\nacc = nan\n").contains("3:7: `axis.X.acc` = nan"));
        assert!(faults("[axis.X]\nvel = 1\naccel = 1\n").contains("unknown key `accel`"));
        assert!(faults("[path]\nfeed = 1\n").contains("missing table [axis]"));
        assert!(faults("axis = {}\n").contains("no axis has limits"));
    }
}
