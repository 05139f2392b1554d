//! Findings: broken tolerances and limits.

use super::broken_regions::{self, BrokenTolerance};
use super::deviation::measure::MeasuredHeights;
use super::options::CheckOptions;
use crate::verify::report::{Audit, Finding};

/// Most regions of gouges that are named, and as many of excess.
const MOST_NAMED: usize = 20;

/// Findings of broken tolerances.
pub(super) fn broken_tolerances(heights: &MeasuredHeights, options: &CheckOptions) -> Vec<Finding> {
    let MeasuredHeights { maps, deviation, between } = heights;
    let mut findings = Vec::new();
    for by in [BrokenTolerance::Gouge, BrokenTolerance::Excess] {
        let finding = match by {
            BrokenTolerance::Gouge => Finding::Gouge,
            BrokenTolerance::Excess => Finding::Excess,
        };
        let mut regions = broken_regions::broken(by, maps, between, options).into_iter();
        // Where the tool as a whole is too low or too high, no region is to blame: the worst is an example.
        if deviation.higher.is_some() {
            findings.extend(regions.next().map(finding));
            continue;
        }
        findings.extend(regions.by_ref().take(MOST_NAMED).map(finding));
        findings.extend(match (regions.len(), by) {
            (0, _) => None,
            (regions, BrokenTolerance::Gouge) => Some(Finding::FurtherGouges { regions }),
            (regions, BrokenTolerance::Excess) => Some(Finding::FurtherExcess { regions }),
        });
    }
    if let Some(higher) = deviation.higher {
        findings.push(Finding::Length { higher });
    }
    // One example suffices; numbers and area are those of all.
    let mut uncut = maps.iter().flat_map(|map| &map.samples).flatten();
    if let Some(sample) = uncut.find(|sample| sample.height.is_none() && !sample.rest) {
        let (points, area) = (deviation.uncut, deviation.uncut_area);
        findings.push(Finding::Uncut { points, area, point: sample.point });
    }
    findings.extend(deviation.rapid.map(|line| Finding::Rapid { line }));
    if deviation.unmeasured > 0 {
        findings.push(Finding::Unmeasured { points: deviation.unmeasured });
    }
    findings
}

/// Findings of broken axis limits.
pub(super) fn broken_limits(audit: &Audit) -> Vec<Finding> {
    let mut findings = Vec::new();
    for axis in &audit.axes {
        let name = || axis.name.clone();
        if let Some(worst) = axis.travel {
            findings.push(Finding::Travel { axis: name(), worst });
        }
        if axis.velocity.broken > 0 {
            findings.push(Finding::Velocity { axis: name(), worst: axis.velocity });
        }
        if axis.acceleration.broken > 0 {
            findings.push(Finding::Acceleration { axis: name(), worst: axis.acceleration });
        }
    }
    findings
}
