//! From the layout to checked limits.

use super::super::document::Document;
use super::super::schema;
use super::raw::{AxisLimits, LAYOUT, PathLimits};
use crate::types::{Diagnostic, Diagnostics};
use std::collections::BTreeMap;

/// Limits file that was read.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
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
///
/// # Example
///
/// ```
/// use trunnion::files::limits::parse;
///
/// let file = parse("[axis.X]\nvel = 500\nacc = 5000\n")?;
/// assert_eq!(file.axes["X"].acc, 5000.0);
/// assert!(parse("[axis.X]\nvel = 500\n").unwrap_err()[0].message.contains("acc"));
/// # Ok::<(), trunnion::types::Diagnostics>(())
/// ```
pub fn parse(text: &str) -> Result<LimitsFile, Diagnostics> {
    let mut doc = Document::open(text, LAYOUT, &schema::limits_value())?;
    let axes = doc.section::<BTreeMap<String, AxisLimits>>("axis");
    // Both sections are read before either is missed, so that all faults come together.
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
